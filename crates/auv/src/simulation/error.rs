//! Why a simulation refuses an input or cannot go on.

use thiserror::Error;

use crate::simulation::integrator::IntegrationError;

/// A wrong input, or a failure of the integration.
#[derive(Clone, Debug, Error, PartialEq)]
#[allow(missing_docs, reason = "the message says what each field is")]
pub enum SimulationError {
    /// An input is not a finite number.
    #[error("the input {input} is {found}, and must be a finite number")]
    InputNotFinite { input: &'static str, found: f64 },
    /// There is no such actuator.
    #[error("there is no actuator {index}: the vehicle has {actuators}, counted from 0")]
    NoSuchActuator { index: usize, actuators: usize },
    /// A trim has another number of actuators than the vehicle.
    #[error("the trim is for {found} actuators, and the vehicle has {expected}")]
    TrimActuators { found: usize, expected: usize },
    /// The LPV model is selected but the plant has none.
    #[error("the plant has no LPV model")]
    NoLpvModel,
    /// The time to advance to is before the present one.
    #[error("cannot go from {from} s back to {to} s")]
    Backwards { from: f64, to: f64 },
    /// The equations could not be integrated; the plant stays where it was.
    #[error("between {from} s and {to} s: {source}")]
    Integration { from: f64, to: f64, source: IntegrationError },
}

/// Refuses an input that is not a finite number.
pub(crate) fn finite(input: &'static str, found: f64) -> Result<(), SimulationError> {
    if found.is_finite() { Ok(()) } else { Err(SimulationError::InputNotFinite { input, found }) }
}
