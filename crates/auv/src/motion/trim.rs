//! Level trim: incidence and actuator outputs without acceleration.
//!
//! Level flight has theta = alpha, u = V cos alpha, w = V sin alpha, q = 0, so that the depth is constant; V is
//! negative astern. The unknowns are the outputs, and alpha unless the pitch is held; the equations are u' = w' = q' =
//! 0, solved by Newton's method. With more unknowns than equations, the outputs have the least Euclidean norm, each
//! divided by its [`Actuator::reach`].

use crate::motion::balance::{Attempt, Balance};
use crate::motion::dynamics::{Dynamics, Motion};
use crate::motion::level::{Pitch, Speed};
use crate::motion::trim_error::TrimError;
use crate::text::readable;
use crate::vehicle::Vehicle;
use crate::vehicle::actuator::Actuator;

/// Steady motion and the actuator outputs that balance it: level, except for a [`climb`].
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
    /// Pitch \[rad\], equal to the incidence in level flight.
    pub pitch: f64,
    /// Pitch rule.
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
        Motion::in_plane(self.forward_speed, self.heave, 0.0, self.pitch)
    }
}

/// Solves `[u' w' q'] = 0` for level trim of least effort at a speed \[m/s\] and a depth \[m\].
///
/// # Errors
/// Errors of [`trim_with`].
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
    let dynamics = Dynamics::new(&vehicle.coefficients)?;
    let trim = solve(&Balance { dynamics, vehicle, speed, depth, pitch, climb: None })?;
    check_limits(vehicle, &trim)?;
    Ok(trim)
}

/// Solves `[u' w' q'] = 0` for the steady climb or dive nearest to another trim, at its forward speed and depth, with
/// the hull at a pitch \[rad\]. Outputs may exceed the limits of the actuators. The unknowns are the outputs, of least
/// norm if there are several solutions, and the incidence; if the trim holds the incidence and the outputs can hold it
/// in the climb too, it is fixed. The path rises at pitch minus incidence.
///
/// # Errors
/// [`TrimError`]: coefficients or a pitch that are not allowed, no solution.
pub fn climb(vehicle: &Vehicle, near: &Trim, pitch: f64) -> Result<Trim, TrimError> {
    if !pitch.is_finite() {
        return Err(TrimError::PitchNotFinite { pitch });
    }
    let dynamics = Dynamics::new(&vehicle.coefficients)?;
    let (speed, depth) = (Speed::Forward(near.forward_speed), near.depth);
    let solve_with = |rule: &Pitch| {
        solve(&Balance { dynamics: dynamics.clone(), vehicle, speed, depth, pitch: rule, climb: Some(pitch) })
    };
    let free = Pitch::Followed([(near.forward_speed, near.incidence)].into_iter().collect());
    match near.rule {
        // Outputs that hold an incidence in level flight may not be able to hold it in a climb.
        Pitch::Held(_) => solve_with(&Pitch::Held(near.incidence)).or_else(|_| solve_with(&free)),
        _ => solve_with(&free),
    }
}

fn solve(balance: &Balance<'_>) -> Result<Trim, TrimError> {
    let Attempt { incidence, outputs: actuators, residual, .. } = balance.solve()?;
    let motion = balance.speed.level_motion(incidence);
    let speed = match balance.speed {
        Speed::Path(speed) => speed,
        Speed::Forward(speed) => motion.u.hypot(motion.w).copysign(speed),
    };
    Ok(Trim {
        speed,
        forward_speed: motion.u,
        heave: motion.w,
        incidence,
        pitch: balance.climb.unwrap_or(incidence),
        rule: balance.pitch.clone(),
        depth: balance.depth,
        actuators,
        residual,
    })
}

/// Refuses a trim beyond the limits of an actuator; the error names the actuator that exceeds them most.
fn check_limits(vehicle: &Vehicle, trim: &Trim) -> Result<(), TrimError> {
    let excess = |(actuator, &output): (&Actuator, &f64)| (output - actuator.max).max(actuator.min - output);
    let pairs = || vehicle.actuators.iter().zip(&trim.actuators);
    let worst = pairs().max_by(|a, b| (excess(*a) / a.0.reach()).total_cmp(&(excess(*b) / b.0.reach())));
    match worst {
        Some((actuator, output)) if excess((actuator, output)) > 0.0 => {
            let (factor, unit) = readable(actuator.unit());
            Err(TrimError::BeyondLimits {
                speed: trim.speed,
                depth: trim.depth,
                actuator: actuator.name.clone(),
                needed: factor * output,
                excess: factor * excess((actuator, output)),
                min: factor * actuator.min,
                max: factor * actuator.max,
                unit,
            })
        }
        _ => Ok(()),
    }
}
