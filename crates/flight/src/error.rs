//! Why a flight could not be flown.

use thiserror::Error as ThisError;

/// Why a flight could not be flown.
#[derive(Debug, ThisError)]
pub enum Error {
    /// The frozen controller is wrong.
    #[error(transparent)]
    ControllerDesign(#[from] scheduled::DesignError),
    /// A coefficient of the vehicle is not allowed.
    #[error(transparent)]
    Coefficient(#[from] auv::CoefficientError),
    /// The vehicle does not trim where the flight begins.
    #[error("{reason}")]
    Trim {
        /// Speed along the path, m/s.
        speed: f64,
        /// Why.
        reason: auv::TrimError,
    },
    /// The autopilot could not compute a tick.
    #[error(transparent)]
    Tick(#[from] scheduled::TickError),
    /// The vehicle could not be simulated.
    #[error(transparent)]
    Simulation(#[from] auv::SimulationError),
}
