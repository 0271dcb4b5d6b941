//! Trims over the range of speed, and the linear model at each.

use crate::error::ModelError;
use crate::inputs::Inputs;
use auv::{Linearisation, Speed, linearise, trim};
use lpv::matrix::{Mat, block};

/// The number of states of the linear model; see [`signals::STATES`].
pub const STATES: usize = signals::STATES.len();

/// Speeds, evenly spread over the range and as many as asked for.
pub fn speeds(inputs: &Inputs, count: usize) -> Vec<f64> {
    let (low, high) = (inputs.design.speed_min, inputs.design.speed_max);
    (0..count).map(|i| low + (high - low) * i as f64 / (count - 1) as f64).collect()
}

/// Trims and linearises at one speed.
///
/// # Errors
/// [`ModelError::Trim`] with the speed and the reason.
pub fn linearise_at(inputs: &Inputs, speed: f64) -> Result<Linearisation, ModelError> {
    let trimmed = trim(&inputs.vehicle, Speed::Path(speed), inputs.design.depth)
        .map_err(|reason| ModelError::Trim { speed, reason })?;
    Ok(linearise(&inputs.vehicle, &trimmed)?)
}

/// `[A B]` of a linearisation.
pub fn stacked(l: &Linearisation) -> Mat {
    block(&[&[&l.a, &l.b]])
}
