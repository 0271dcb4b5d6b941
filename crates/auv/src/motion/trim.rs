//! Level trim: the incidence and the actuator outputs at which nothing accelerates.
//!
//! Level flight has theta = alpha, u = V cos alpha, w = V sin alpha, q = 0, so that the depth is constant; astern V is
//! negative. The unknowns are the outputs, and alpha where the pitch is not held; the equations are u' = w' = q' = 0.
//! They are solved by Newton's method. With more unknowns than equations, the outputs have the least Euclidean norm,
//! each divided by its [`Actuator::reach`].

use std::sync::Arc;

use thiserror::Error;

use crate::motion::balance::{Attempt, Balance};
use crate::motion::dynamics::{Dynamics, Motion};
use crate::scalar::Scalar;
use crate::vehicle::Vehicle;
use crate::vehicle::actuator::Actuator;
use crate::vehicle::coefficients::CoefficientError;
use crate::words::Rounded;

/// The speed at which to trim.
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
        Motion { u, w, q: D::from(0.0), theta: incidence }
    }
}

/// What becomes of the pitch in level trim.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Pitch {
    /// It is that of the least effort.
    #[default]
    Free,
    /// It is held at an angle \[rad\], 0 for a level hull: the actuators balance surge, heave and pitch.
    Held(f64),
    /// It is free, on one branch of the trims of least effort, from which Newton's method starts.
    Followed(Branch),
}

/// Pitch \[rad\] over speed V \[m/s\] along a branch of trims, in rising order of speed.
#[derive(Clone, Debug, PartialEq)]
pub struct Branch(pub(crate) Arc<[(f64, f64)]>);

impl Branch {
    /// Returns the pitch at a speed \[m/s\] by linear interpolation, held beyond the ends.
    pub(crate) fn pitch_at(&self, speed: f64) -> f64 {
        let above = self.0.partition_point(|(at, _)| *at <= speed);
        match (above.checked_sub(1).and_then(|below| self.0.get(below)), self.0.get(above)) {
            (Some((v0, p0)), Some((v1, p1))) => p0 + (p1 - p0) * (speed - v0) / (v1 - v0),
            (Some((_, pitch)), None) | (None, Some((_, pitch))) => *pitch,
            (None, None) => 0.0,
        }
    }
}

/// A level, steady motion and the actuator outputs that balance it.
#[derive(Clone, Debug, PartialEq)]
pub struct Trim {
    /// Speed along the path through the water, V \[m/s\]; negative astern.
    pub speed: f64,
    /// Surge velocity, u \[m/s\].
    pub forward_speed: f64,
    /// Heave velocity, w \[m/s\].
    pub heave: f64,
    /// Incidence atan(w / u) \[rad\].
    pub incidence: f64,
    /// Pitch \[rad\], equal to the incidence.
    pub pitch: f64,
    /// What became of the pitch.
    pub rule: Pitch,
    /// Depth \[m\].
    pub depth: f64,
    /// Output of each actuator \[N or rad\].
    pub actuators: Vec<f64>,
    /// Largest remaining |u'|, |w'| \[m/s2\] or |q'| \[rad/s2\].
    pub residual: f64,
}

impl Trim {
    /// Returns the trimmed motion.
    pub fn motion(&self) -> Motion {
        Motion { u: self.forward_speed, w: self.heave, q: 0.0, theta: self.pitch }
    }
}

/// Why there is no trim.
#[derive(Clone, Debug, Error, PartialEq)]
#[allow(missing_docs, reason = "the message says what each field is")]
pub enum TrimError {
    /// The coefficients are not allowed.
    #[error(transparent)]
    Coefficients(#[from] CoefficientError),
    /// The speed is not a number.
    #[error("the trim speed is {} m/s, and must be a finite number", Rounded(*speed))]
    SpeedNotFinite { speed: f64 },
    /// The depth is not a number.
    #[error("the trim depth is {} m, and must be a finite number", Rounded(*depth))]
    DepthNotFinite { depth: f64 },
    /// No incidence and outputs balance the forces.
    #[error(
        "no level trim at {} m/s and {} m: lift and actuators do not balance a weight of {} N, a buoyancy of \
            {} N and the moments (nearest at an incidence of {incidence_deg:.1} deg, with {} m/s2 or rad/s2 \
            left)",
        Rounded(*speed), Rounded(*depth), Rounded(*weight), Rounded(*buoyancy), Rounded(*residual)
    )]
    NotFound {
        /// The speed asked for \[m/s\].
        speed: f64,
        /// The depth asked for \[m\].
        depth: f64,
        /// The weight \[N\].
        weight: f64,
        /// The buoyancy at that depth \[N\].
        buoyancy: f64,
        /// The last incidence tried \[deg\].
        incidence_deg: f64,
        /// The largest remaining acceleration \[m/s2 or rad/s2\].
        residual: f64,
    },
    /// No outputs balance the forces at the pitch that is held.
    #[error(
        "no trim at {} m/s and {} m with the pitch held at {} deg: at best {} N of surge force, {} N of heave force and \
            {} N.m of pitching moment are left, which no actuator takes up; set 'trim.pitch' to \"free\" in the design \
            file, or add a thruster that pushes there",
        Rounded(*speed), Rounded(*depth), Rounded(*pitch_deg), part(*surge, [*heave, *moment]),
        part(*heave, [*surge, *moment]), part(*moment, [*surge, *heave])
    )]
    NotHeld {
        /// The speed asked for \[m/s\].
        speed: f64,
        /// The depth asked for \[m\].
        depth: f64,
        /// The pitch that is held \[deg\].
        pitch_deg: f64,
        /// The remaining surge force \[N\].
        surge: f64,
        /// The remaining heave force \[N\].
        heave: f64,
        /// The remaining pitching moment \[N.m\].
        moment: f64,
    },
    /// Trims at neighbouring speeds lie on different branches.
    #[error(
        "the level trim jumps at {} m/s: {quantity} goes from {} to {} {unit} at once, however close the speeds; hold the pitch by 'trim.pitch' in the design file (\"level\", or an angle), or choose a range of \
            speeds to one side of the jump",
        Rounded(*speed), Rounded(*before), Rounded(*after)
    )]
    Jump {
        /// Where \[m/s\].
        speed: f64,
        /// `pitch`, or the name of an actuator.
        quantity: String,
        /// On one side \[deg or N\].
        before: f64,
        /// On the other side.
        after: f64,
        unit: &'static str,
    },
    /// The forward speed, by which an autopilot looks up the trim, does not rise with the speed along the path.
    #[error(
        "between {} and {} m/s along the path the forward speed in level trim falls, because the pitch goes from {} to \
            {} deg; an autopilot that knows the forward speed cannot tell these trims apart: hold the pitch by \
            'trim.pitch' in the design file (\"level\", or an angle), or choose another range of speeds",
        Rounded(*speed), Rounded(*to_speed), Rounded(pitch_deg[0]), Rounded(pitch_deg[1])
    )]
    ForwardSpeedFalls { speed: f64, to_speed: f64, pitch_deg: [f64; 2] },
    /// The trim needs an output beyond the limits of an actuator.
    #[error(
        "level trim at {} m/s and {} m needs {} {unit} of {actuator}, {} {unit} beyond its limits {} .. {} {unit}",
        Rounded(*speed), Rounded(*depth), Rounded(*needed), Rounded(*excess), Rounded(*min), Rounded(*max)
    )]
    BeyondLimits {
        /// The speed asked for \[m/s\].
        speed: f64,
        /// The depth asked for \[m\].
        depth: f64,
        actuator: String,
        needed: f64,
        excess: f64,
        min: f64,
        max: f64,
        unit: &'static str,
    },
}

/// A part of a remaining force, without what is rounding beside the other two.
fn part(value: f64, others: [f64; 2]) -> Rounded {
    let largest = others.into_iter().fold(value.abs(), |most, other| most.max(other.abs()));
    Rounded(if value.abs() < ROUNDING * largest { 0.0 } else { value })
}

/// A part of a force smaller than this beside the others is not shown.
const ROUNDING: f64 = 1e-9;

/// Solves `[u' w' q'] = 0` for level trim of least effort at a speed \[m/s\] and a depth \[m\].
///
/// # Errors
/// As [`trim_with`].
pub fn trim(vehicle: &Vehicle, speed: Speed, depth: f64) -> Result<Trim, TrimError> {
    trim_with(vehicle, speed, depth, &Pitch::Free)
}

/// Solves `[u' w' q'] = 0` for level trim at a speed \[m/s\], negative astern, and a depth \[m\].
///
/// # Errors
/// [`TrimError`]: coefficients, speed or depth that are not allowed, no solution, or an actuator beyond its limits.
pub fn trim_with(vehicle: &Vehicle, speed: Speed, depth: f64, pitch: &Pitch) -> Result<Trim, TrimError> {
    if !speed.value().is_finite() {
        return Err(TrimError::SpeedNotFinite { speed: speed.value() });
    }
    if !depth.is_finite() {
        return Err(TrimError::DepthNotFinite { depth });
    }
    let balance = Balance { dynamics: Dynamics::new(&vehicle.coefficients)?, vehicle, speed, depth, pitch };
    let Attempt { incidence, outputs: actuators, residual, .. } = balance.solve()?;
    let motion = speed.level_motion(incidence);
    let path_speed = match speed {
        Speed::Path(speed) => speed,
        Speed::Forward(speed) => motion.u.hypot(motion.w).copysign(speed),
    };
    let trim = Trim {
        speed: path_speed,
        forward_speed: motion.u,
        heave: motion.w,
        incidence,
        pitch: incidence,
        rule: pitch.clone(),
        depth,
        actuators,
        residual,
    };
    check_limits(vehicle, &trim)?;
    Ok(trim)
}

/// Refuses a trim beyond the limits of an actuator; the error names the actuator that exceeds them most.
fn check_limits(vehicle: &Vehicle, trim: &Trim) -> Result<(), TrimError> {
    let excess = |(actuator, &output): (&Actuator, &f64)| (output - actuator.max).max(actuator.min - output);
    let pairs = || vehicle.actuators.iter().zip(&trim.actuators);
    let worst = pairs().max_by(|a, b| (excess(*a) / a.0.reach()).total_cmp(&(excess(*b) / b.0.reach())));
    match worst {
        Some((actuator, &needed)) if excess((actuator, &needed)) > 0.0 => Err(TrimError::BeyondLimits {
            speed: trim.speed,
            depth: trim.depth,
            actuator: actuator.name.clone(),
            needed,
            excess: excess((actuator, &needed)),
            min: actuator.min,
            max: actuator.max,
            unit: actuator.unit(),
        }),
        _ => Ok(()),
    }
}
