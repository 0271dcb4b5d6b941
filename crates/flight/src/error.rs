//! Errors of a flight simulation.

use strum::IntoStaticStr;
use thiserror::Error as ThisError;

/// Why a flight could not be simulated.
#[derive(Debug, ThisError, IntoStaticStr)]
#[strum(serialize_all = "snake_case")]
#[allow(missing_docs, reason = "the message says what each field is")]
pub enum Error {
    /// The frozen controller is invalid.
    #[error(transparent)]
    ControllerDesign(#[from] squid_scheduled::DesignError),
    /// A coefficient of the vehicle is not allowed.
    #[error(transparent)]
    Coefficient(#[from] squid_auv::CoefficientError),
    /// The vehicle has no trim at the start of the flight.
    #[error("{reason}")]
    Trim {
        /// Speed along the path, m/s.
        speed: f64,
        reason: squid_auv::TrimError,
    },
    /// A step in a signal without a reference in the design.
    #[error("the manoeuvre cannot be flown: {0}")]
    Manoeuvre(#[from] squid_scheduled::ManoeuvreError),
    /// The sea is not possible.
    #[error(transparent)]
    Sea(#[from] squid_sea::SeaError),
    /// Waves, but a vehicle file without the size of the hull.
    #[error(
        "the vehicle file of {vehicle} has no [geometry], which the wave loads need: add length and diameter of the \
            hull there, or leave [waves] out of the sea"
    )]
    NoGeometry { vehicle: String },
    /// A sea for a design of heading alone.
    #[error(
        "a design of heading of {vehicle} is flown alone with surge, heave and pitch held, and so in still water: fly \
            it in a sea beside one of pitch or depth (simulate --design NAME --heading NAME --sea FILE)"
    )]
    SeaOfHeading { vehicle: String },
    /// An autopilot of another vehicle.
    #[error("the autopilot commands {name}, which the vehicle does not have")]
    NoSuchActuator { name: String },
    /// An autopilot of signals that no view of the motion has.
    #[error("the autopilot of {signals} is of no axis that a vehicle has")]
    NoSuchView { signals: String },
    /// Autopilots that do not share a clock.
    #[error("the autopilots of one flight must have the same sample time; they have {one} and {other} s")]
    OtherSampleTime { one: f64, other: f64 },
    /// A flight that starts at the surface.
    #[error(
        "at {depth} m, the depth at the start of the flight, the hull is out of the water: set a larger `depth` in the \
            sea file"
    )]
    AtTheSurface { depth: f64 },
    /// The autopilot could not compute a tick.
    #[error(transparent)]
    Tick(#[from] squid_scheduled::TickError),
    /// The vehicle could not be simulated.
    #[error(transparent)]
    Simulation(#[from] squid_auv::SimulationError),
}
