//! What can go wrong in the plant, each as one sentence.

use auv::{CoefficientError, LpvModelError, SimulationError, TrimError, VehicleJsonError};
use fmi2::ResourceError;

use crate::resources::LPV_RESOURCE;

/// What can go wrong in the plant.
#[derive(Debug, thiserror::Error)]
pub enum PlantError {
    /// A resource cannot be read.
    #[error(transparent)]
    Resource(#[from] ResourceError),
    /// The vehicle makes no sense.
    #[error(transparent)]
    Vehicle(#[from] VehicleJsonError),
    /// The LPV model makes no sense, or belongs to another number of actuators.
    #[error("{}", in_file(.0))]
    Lpv(#[from] LpvModelError),
    /// The LPV model is that of another vehicle.
    #[error("resources/{LPV_RESOURCE} is the LPV model of '{found}', and the vehicle is '{expected}'")]
    OtherVehicle {
        /// The vehicle of the LPV model.
        found: String,
        /// The vehicle itself.
        expected: String,
    },
    /// A coefficient is not allowed.
    #[error("the vehicle cannot start: {0}")]
    Coefficients(#[from] CoefficientError),
    /// The start lies above the water.
    #[error("the vehicle cannot start: initial_depth is {depth} m, and must be zero (the surface) or more")]
    AboveSurface {
        /// The depth asked for \[m\].
        depth: f64,
    },
    /// There is no level trim to start from.
    #[error("the vehicle cannot start: {0}")]
    Trim(#[from] TrimError),
    /// The motion cannot be computed.
    #[error(transparent)]
    Simulation(#[from] SimulationError),
    /// The plant's clock shows another time than the flight has come to, as only a state that was tampered with can
    /// have it.
    #[error("the plant's clock shows {clock} s, and the flight has come to {time} s")]
    OtherTime {
        /// The plant's time in s.
        clock: f64,
        /// The time reached in s.
        time: f64,
    },
}

/// Names the file, which only the complaint about bad JSON does by itself.
fn in_file(error: &LpvModelError) -> String {
    match error {
        LpvModelError::NotJson { .. } => error.to_string(),
        _ => format!("resources/{LPV_RESOURCE}: {error}"),
    }
}
