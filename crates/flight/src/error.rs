//! Why a flight could not be flown.

use thiserror::Error as ThisError;

/// Why a flight could not be flown.
#[derive(Debug, ThisError)]
#[allow(missing_docs, reason = "the message says what each field is")]
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
        reason: auv::TrimError,
    },
    /// A step of what the design has no reference of.
    #[error("the manoeuvre has a step of the {signal}, of which the design has no reference: leave it out")]
    NoReference { signal: &'static str },
    /// The sea cannot be.
    #[error(transparent)]
    Sea(#[from] squid_sea::SeaError),
    /// Waves, and a vehicle without size.
    #[error(
        "the vehicle file of {vehicle} has no [geometry], and the load of waves depends on it: add length and diameter \
            of the hull there, or leave [waves] out of the sea"
    )]
    NoGeometry { vehicle: String },
    /// A flight that begins at the surface.
    #[error(
        "at the depth of {depth} m where the flight begins, the hull is out of the water: it must begin deeper, by \
            `depth` of the sea"
    )]
    AtTheSurface { depth: f64 },
    /// The autopilot could not compute a tick.
    #[error(transparent)]
    Tick(#[from] scheduled::TickError),
    /// The vehicle could not be simulated.
    #[error(transparent)]
    Simulation(#[from] auv::SimulationError),
}
