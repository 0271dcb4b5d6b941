//! Conditions of level flight: its speed and its pitch rule.

use std::sync::Arc;

use crate::motion::dynamics::Motion;
use crate::scalar::Scalar;

/// Speed at which to trim.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Speed {
    /// Speed along the path through the water, V \[m/s\]; negative astern.
    Path(f64),
    /// Surge velocity, u \[m/s\].
    Forward(f64),
}

impl Speed {
    pub(crate) fn value(self) -> f64 {
        match self {
            Self::Path(speed) | Self::Forward(speed) => speed,
        }
    }

    /// Returns level motion at an incidence.
    pub(crate) fn level_motion<D: Scalar>(self, incidence: D) -> Motion<D> {
        let (sin, cos) = incidence.sin_cos();
        let (u, w) = match self {
            Self::Path(speed) => (cos * speed, sin * speed),
            Self::Forward(speed) => (D::from(speed), sin / cos * speed),
        };
        Motion::in_plane(u, w, D::from(0.0), incidence)
    }
}

/// Pitch rule of level trim.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Pitch {
    /// Pitch of least effort.
    #[default]
    Free,
    /// Pitch held at an angle \[rad\], 0 for a level hull: the actuators balance surge, heave and pitch.
    Held(f64),
    /// Free pitch on one branch of the trims of least effort, used as the start of Newton's method.
    Followed(Branch),
}

/// Pitch \[rad\] over speed V \[m/s\] along a branch of trims, by increasing speed.
#[derive(Clone, Debug, PartialEq)]
pub struct Branch(pub(crate) Arc<[(f64, f64)]>);

impl Branch {
    /// Returns the pitch at a speed \[m/s\] by linear interpolation, constant beyond the ends.
    pub(crate) fn pitch_at(&self, speed: f64) -> f64 {
        let above = self.0.partition_point(|(at, _)| *at <= speed);
        match (above.checked_sub(1).and_then(|below| self.0.get(below)), self.0.get(above)) {
            (Some((v0, p0)), Some((v1, p1))) => p0 + (p1 - p0) * (speed - v0) / (v1 - v0),
            (Some((_, pitch)), None) | (None, Some((_, pitch))) => *pitch,
            (None, None) => 0.0,
        }
    }
}

impl FromIterator<(f64, f64)> for Branch {
    fn from_iter<I: IntoIterator<Item = (f64, f64)>>(points: I) -> Self {
        Self(points.into_iter().collect::<Arc<[_]>>())
    }
}
