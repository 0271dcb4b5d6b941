//! Errors of the loop, one sentence each.

use squid_fmi2::ResourceError;
use squid_fmu_controller::{ControllerError, RESOURCE as CONTROLLER_RESOURCE, of_axis};
use squid_fmu_plant::PlantError;

use squid_scheduled::{MANOEUVRE_RESOURCE, ManoeuvreError};

/// Errors of the loop.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs, reason = "the message says what each field is")]
pub enum ClosedLoopError {
    /// A resource cannot be read.
    #[error(transparent)]
    Resource(#[from] ResourceError),
    /// The design is invalid, or the autopilot failed.
    #[error(transparent)]
    Controller(#[from] ControllerError),
    /// The plant cannot be built, started or advanced.
    #[error(transparent)]
    Plant(#[from] PlantError),
    /// The manoeuvre file is invalid.
    #[error("resources/{MANOEUVRE_RESOURCE}: {0}")]
    ManoeuvreFile(#[source] ManoeuvreError),
    /// The parameters of the manoeuvre are invalid.
    #[error("the manoeuvre cannot be simulated: {0}")]
    Manoeuvre(#[from] ManoeuvreError),
    /// A vehicle in six degrees of freedom has only the axis of level flight, or one in the vertical plane has more.
    #[error(
        "resources/{} must contain the design of another axis if the vehicle has coefficients of sway, roll and yaw, \
         and be absent otherwise",
        of_axis(CONTROLLER_RESOURCE, 1)
    )]
    OtherAxes,
    /// The axes have different sample times.
    #[error("the sample times of the designs are {one} s and {other} s; they must be equal")]
    OtherSampleTime { one: f64, other: f64 },
    /// The controller belongs to another vehicle.
    #[error("resources/{file} is a design for '{found}', but the vehicle is '{expected}'")]
    OtherVehicle { file: String, found: String, expected: String },
    /// The controller has other signals than the vehicle.
    #[error(
        "resources/{file} has the signals {}, but those of the vehicle are {}",
        found.join(", "),
        expected.join("; or ")
    )]
    OtherSignals { file: String, found: Vec<String>, expected: Vec<String> },
    /// The controller commands other actuators than those of the vehicle.
    #[error(
        "the autopilot in resources commands {}, but the actuators of the vehicle are {}",
        found.join(", "),
        expected.join(", ")
    )]
    OtherActuators { found: Vec<String>, expected: Vec<String> },
}
