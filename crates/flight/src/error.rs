//! Errors of a flight simulation.

use strum::IntoStaticStr;
use thiserror::Error as ThisError;

/// Reason why a flight could not be simulated.
#[derive(Debug, ThisError, IntoStaticStr)]
#[strum(serialize_all = "snake_case")]
#[allow(missing_docs, reason = "the message says what each field is")]
pub enum Error {
    /// Invalid frozen controller.
    #[error(transparent)]
    ControllerDesign(#[from] squid_scheduled::DesignError),
    /// A coefficient of the vehicle that is not allowed.
    #[error(transparent)]
    Coefficient(#[from] squid_auv::CoefficientError),
    /// No trim of the vehicle at the start of the flight.
    #[error("{reason}")]
    Trim {
        /// Speed along the path, m/s.
        speed: f64,
        reason: squid_auv::TrimError,
    },
    /// A step of a signal without a reference in the design.
    #[error("the manoeuvre cannot be simulated: {0}")]
    Manoeuvre(#[from] squid_scheduled::ManoeuvreError),
    /// An invalid sea.
    #[error(transparent)]
    Sea(#[from] squid_sea::SeaError),
    /// Waves with a vehicle file that lacks the size of the hull.
    #[error(
        "the vehicle file of {vehicle} has no [geometry], which the wave loads require; add length and diameter of \
            the hull there, or remove [waves] from the sea file"
    )]
    NoGeometry { vehicle: String },
    /// A sea with a design of heading only.
    #[error(
        "a heading axis alone is simulated with surge, heave and pitch of {vehicle} held at trim, which requires \
            still water; in a sea, simulate a design file that also has an [[axis]] of pitch or depth, without \
            --axis"
    )]
    SeaOfHeading { vehicle: String },
    /// An actuator of the autopilot that the vehicle does not have.
    #[error("the autopilot commands {name}, which the vehicle does not have")]
    NoSuchActuator { name: String },
    /// An autopilot whose signals match no axis of the vehicle.
    #[error("no axis of a vehicle has the signals of the autopilot, {signals}")]
    NoSuchView { signals: String },
    /// Autopilots with different sample times.
    #[error("the sample times of the autopilots are {one} and {other} s; they must be equal")]
    OtherSampleTime { one: f64, other: f64 },
    /// A flight that starts out of the water.
    #[error(
        "at the initial depth of {depth} m the hull is out of the water; set a larger `depth` in the sea file"
    )]
    AtTheSurface { depth: f64 },
    /// Failure of the autopilot to compute a tick.
    #[error(transparent)]
    Tick(#[from] squid_scheduled::TickError),
    /// Failure of the vehicle simulation.
    #[error(transparent)]
    Simulation(#[from] squid_auv::SimulationError),
}
