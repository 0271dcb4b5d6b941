//! Trims over the range of speed, and the linear model at each.

use crate::error::ModelError;
use auv::{Actuator, Linearisation, Speed, Vehicle, linearise, trim};
use lpv::matrix::{Mat, block};

/// The number of states of the linear model; see [`signals::STATES`].
pub const STATES: usize = signals::STATES.len();

/// Linearises the vehicle about level trim at a speed V along the path \[m/s\] and a depth \[m\]: `x' = A x + B u`,
/// with the states of [`signals::STATES`] in SI units and one input per actuator, as deviations from the trim.
///
/// # Errors
/// [`ModelError::Trim`] with the speed and the reason.
pub fn linearise_at(vehicle: &Vehicle, depth: f64, speed: f64) -> Result<Linearisation, ModelError> {
    let level =
        trim(vehicle, Speed::Path(speed), depth).map_err(|reason| ModelError::Trim { speed, reason })?;
    Ok(linearise(vehicle, &level)?)
}

/// [`Linearisation::trim_slope`] as a matrix with one column.
pub fn trim_slope(l: &Linearisation, actuators: &[Actuator]) -> Mat {
    let slope = l.trim_slope(actuators);
    Mat::from_column_slice(slope.len(), 1, slope.as_slice())
}

/// `[A B]` of a linearisation.
pub fn stacked(l: &Linearisation) -> Mat {
    block(&[&[&l.a, &l.b]])
}

/// `[A B]` with inputs in units of their reach.
pub fn scaled(actuators: &[Actuator], mut stacked: Mat) -> Mat {
    for (j, actuator) in actuators.iter().enumerate() {
        stacked.column_mut(STATES + j).scale_mut(actuator.reach());
    }
    stacked
}
