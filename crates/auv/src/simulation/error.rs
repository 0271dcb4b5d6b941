//! Errors of a simulation.

use thiserror::Error;

use crate::simulation::integrator::IntegrationError;

/// Invalid input, or failure of the integration.
#[derive(Clone, Debug, Error, PartialEq)]
#[allow(missing_docs, reason = "the message says what each field is")]
pub enum SimulationError {
    /// An input that is not finite.
    #[error("the input {input} is {found:?}; it must be a finite number")]
    InputNotFinite { input: &'static str, found: f64 },
    /// An actuator that does not exist.
    #[error("there is no actuator {index}: the vehicle has {actuators}, numbered from 0")]
    NoSuchActuator { index: usize, actuators: usize },
    /// A trim with another number of actuators than the vehicle.
    #[error("the number of actuators in the trim is {found}; the vehicle has {expected}")]
    TrimActuators { found: usize, expected: usize },
    /// Selection of the LPV model of a plant without one.
    #[error("the plant has no LPV model")]
    NoLpvModel,
    /// A target time before the present one.
    #[error("time cannot run backwards from {from:?} s to {to:?} s")]
    Backwards { from: f64, to: f64 },
    /// Failure of the integration; the plant keeps its previous state.
    #[error("between {from:?} s and {to:?} s: {source}")]
    Integration { from: f64, to: f64, source: IntegrationError },
}

/// Refuses an input that is not finite.
pub(crate) fn finite(input: &'static str, found: f64) -> Result<(), SimulationError> {
    if found.is_finite() { Ok(()) } else { Err(SimulationError::InputNotFinite { input, found }) }
}
