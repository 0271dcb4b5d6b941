//! Trims over a range of speeds on one branch.
//!
//! The trim equations may have several solutions at a speed. Solutions at neighbouring speeds are on the same branch if
//! the step between the trims is small, or agrees with the step predicted from their derivatives by the trapezoidal
//! rule. Otherwise the interval is halved: on a continuous branch, however steep, the step shrinks with the interval;
//! at a jump it does not. The result thus does not depend on the spacing of the speeds.

use nalgebra::DVector;

use crate::motion::level::{Pitch, Speed};
use crate::motion::linearise::linearise;
use crate::motion::trim::{Trim, trim_with};
use crate::motion::trim_error::TrimError;
use crate::text::readable;
use crate::vehicle::Vehicle;
use crate::vehicle::actuator::Actuator;

/// Small step of the pitch \[rad\] or of an output in units of its reach: 0.6 deg, or 1 %.
const SMALL: f64 = 0.01;

/// Number of halvings of an interval, down to a millionth of it.
const HALVINGS: usize = 20;

/// Vehicle, depth and speeds of a series of trims.
struct Range<'a> {
    vehicle: &'a Vehicle,
    depth: f64,
    speeds: &'a [f64],
}

impl Pitch {
    /// Returns the pitch rule over a range of increasing speeds \[m/s\], with the branch to follow if the trims of
    /// least effort jump. Without a requested rule the pitch is held level if thrusters alone can do so at every speed,
    /// and is free otherwise.
    #[must_use]
    pub fn over(vehicle: &Vehicle, depth: f64, speeds: &[f64], requested: Option<&Self>) -> Self {
        match requested {
            None if thrusters_hold_level(vehicle, depth, speeds) => return Self::Held(0.0),
            None | Some(Self::Free) => {}
            Some(requested) => return requested.clone(),
        }
        let range = Range { vehicle, depth, speeds };
        if range.trims(&Self::Free).is_ok() {
            return Self::Free;
        }
        let branch = [true, false].into_iter().find_map(|downwards| range.follow_branch(downwards).ok());
        branch.map_or(Self::Free, |trims| Self::Followed(trims.iter().map(|t| (t.speed, t.pitch)).collect()))
    }
}

/// Returns trims at increasing speeds \[m/s\] on one branch.
///
/// # Errors
/// All those of [`trim_with`]; [`TrimError::Jump`], [`TrimError::ForwardSpeedFalls`].
pub fn trims(vehicle: &Vehicle, depth: f64, speeds: &[f64], pitch: &Pitch) -> Result<Vec<Trim>, TrimError> {
    Range { vehicle, depth, speeds }.trims(pitch)
}

/// Returns `true` if the vehicle without control surfaces, whose forces vanish with the speed, trims at pitch zero.
fn thrusters_hold_level(vehicle: &Vehicle, depth: f64, speeds: &[f64]) -> bool {
    let mut bare = vehicle.clone();
    bare.actuators.retain(|actuator| actuator.effect.works_at_rest());
    let holds = |speed: &f64| trim_with(&bare, Speed::Path(*speed), depth, &Pitch::Held(0.0)).is_ok();
    !bare.actuators.is_empty() && speeds.iter().all(holds)
}

impl Range<'_> {
    fn trims(&self, pitch: &Pitch) -> Result<Vec<Trim>, TrimError> {
        let at = |speed: f64, _: f64| trim_with(self.vehicle, Speed::Path(speed), self.depth, pitch);
        let trims = self.speeds.iter().map(|speed| at(*speed, 0.0)).collect::<Result<Vec<_>, _>>()?;
        for pair in trims.windows(2) {
            self.follow(&pair[0], pair[1].clone(), &at, HALVINGS)?;
        }
        Ok(trims)
    }

    /// Follows the branch of least effort that contains the trim at one end of the range to the other end.
    fn follow_branch(&self, downwards: bool) -> Result<Vec<Trim>, TrimError> {
        let solve_near = |speed: f64, pitch: f64| {
            let here = Pitch::Followed([(speed, pitch)].into_iter().collect());
            trim_with(self.vehicle, Speed::Path(speed), self.depth, &here)
        };
        let mut speeds = self.speeds.to_vec();
        if downwards {
            speeds.reverse();
        }
        let Some((first, others)) = speeds.split_first() else { return Ok(Vec::new()) };
        let mut trims = vec![trim_with(self.vehicle, Speed::Path(*first), self.depth, &Pitch::Free)?];
        for speed in others {
            let last = &trims[trims.len() - 1];
            let next = self.follow(last, solve_near(*speed, last.pitch)?, &solve_near, HALVINGS)?;
            trims.push(next);
        }
        if downwards {
            trims.reverse();
        }
        Ok(trims)
    }

    /// Follows the branch of `from` to the speed of `candidate`, by steps as long as the branch allows; `solve_near`
    /// returns a trim at a speed, starting from the pitch of the previous one.
    fn follow(
        &self,
        from: &Trim,
        candidate: Trim,
        solve_near: &impl Fn(f64, f64) -> Result<Trim, TrimError>,
        halvings: usize,
    ) -> Result<Trim, TrimError> {
        match self.check_same_branch(from, &candidate) {
            Ok(()) => Ok(candidate),
            Err(jump) if halvings == 0 => Err(jump),
            Err(_) => {
                let middle = solve_near(0.5 * (from.speed + candidate.speed), from.pitch)?;
                let middle = self.follow(from, middle, solve_near, halvings - 1)?;
                let end = solve_near(candidate.speed, middle.pitch)?;
                self.follow(&middle, end, solve_near, halvings - 1)
            }
        }
    }

    /// Checks that the step between two trims is small, or agrees with the prediction from their derivatives.
    fn check_same_branch(&self, from: &Trim, to: &Trim) -> Result<(), TrimError> {
        let rise = to.forward_speed - from.forward_speed;
        if (rise > 0.0) != (to.speed > from.speed) {
            let (speed, pitch_deg) = (from.speed, from.pitch.to_degrees());
            return Err(TrimError::ForwardSpeedFalls { speed, pitch_deg });
        }
        let slopes = [self.slope(from)?, self.slope(to)?];
        // Pitch is the last of the states, followed by the outputs.
        let pitch = slopes[0].len() - self.vehicle.actuators.len() - 1;
        for (index, (name, unit)) in self.quantities().into_iter().enumerate() {
            let values = [from, to].map(|t| if index == 0 { t.pitch } else { t.actuators[index - 1] });
            let unit_size = if index == 0 { 1.0 } else { self.vehicle.actuators[index - 1].reach() };
            let step = values[1] - values[0];
            let predicted = 0.5 * (slopes[0][pitch + index] + slopes[1][pitch + index]) * rise;
            let is_small = |v: f64| v.abs() <= SMALL * unit_size;
            if !is_small(step) && !is_small(step - predicted) {
                let speed = from.speed;
                let (factor, unit) = readable(unit);
                let (before, after) = (factor * values[0], factor * values[1]);
                return Err(TrimError::Jump { speed, quantity: name, before, after, unit });
            }
        }
        Ok(())
    }

    fn slope(&self, trim: &Trim) -> Result<DVector<f64>, TrimError> {
        Ok(linearise(self.vehicle, trim)?.trim_slope(&self.vehicle.actuators))
    }

    /// Returns name and unit of the pitch and of each output.
    fn quantities(&self) -> Vec<(String, &'static str)> {
        let outputs = self.vehicle.actuators.iter().map(|a: &Actuator| (a.name.clone(), a.unit()));
        std::iter::once(("pitch".to_owned(), "rad")).chain(outputs).collect()
    }
}
