//! Errors in the input files of a design.

use strum::IntoStaticStr;
use thiserror::Error;

/// Error in the input files of a design.
#[derive(Debug, Error, IntoStaticStr)]
#[strum(serialize_all = "snake_case")]
#[allow(missing_docs, reason = "the message says what each field is")]
pub enum InputError {
    /// The vehicle's directory does not exist.
    #[error("{directory}: there is no such directory; name one that contains vehicle.toml and design.toml")]
    NoVehicle { directory: String },
    /// There is no design of that name.
    #[error(
        "{path}: there is no such file; `squid tune {directory} --design {name}` begins one from the vehicle alone"
    )]
    NoDesign { path: String, directory: String, name: String },
    /// The vehicle file or the design file is wrong.
    #[error(transparent)]
    File(#[from] squid_auv::FileError),
    /// The vehicle file or the design file cannot be read.
    #[error(transparent)]
    #[strum(transparent)]
    Unreadable(#[from] squid_base::files::Error),
    /// A bandwidth on the command line is out of range.
    #[error("--bandwidth is {}; it must be {}", squid_auv::number(*found), crate::inputs::design_file::BANDWIDTH.words)]
    Bandwidth { found: f64 },
    /// A design cannot be judged with the weights of another.
    #[error("{design} cannot be judged in the weights of {weights}: {why}")]
    Weights { design: String, weights: String, why: &'static str },
    /// An actuator's name is that of another variable of the FMUs.
    #[error(
        "{file}: an actuator cannot be called '{actuator}', because '{name}' is the name of another variable of \
            the FMUs; give it another 'name'"
    )]
    ActuatorName { file: String, actuator: String, name: String },
    /// A design has waves, but the hull has no dimensions.
    #[error(
        "{file}: [sea] needs the size of the hull, for what waves do to it; the vehicle file has no [geometry]: give \
            it length and diameter there, or leave [sea] out"
    )]
    NoGeometry { file: String },
    /// The design has no given controller.
    #[error("{file} has no [controller] of kind \"pid\"; give one there, or in a file by --controller")]
    NoController { file: String },
    /// The request needs another controller than the one given by the design file.
    #[error(
        "{file}: [controller] gives the controller, so that {what}; leave [controller] out, or ask for nothing else"
    )]
    GivenController { file: String, what: &'static str },
    /// The requested axis is not in the file.
    #[error("--axis is {found}; {file} has {axes}")]
    NoAxis { file: String, found: String, axes: String },
    /// The file has several axes, and none is selected.
    #[error("{file} has the axes {axes}; name one of them with --axis")]
    SeveralAxes { file: String, axes: String },
    /// Two axes command the same actuator.
    #[error(
        "{file}: the axes of {one} and {other} both command '{actuator}'; put what shares actuators into one [[axis]]"
    )]
    SharedActuator { file: String, actuator: String, one: &'static str, other: &'static str },
    /// Two axes differ in a property of their common vehicle.
    #[error("{file}: '{key}' is {values}; it must be the same for each axis: give it outside of [[axis]]")]
    AxesDiffer { file: String, key: &'static str, values: String },
    /// The axes have no common speed.
    #[error("{file}: no speed is in the range of every axis: {ranges}")]
    NoCommonSpeed { file: String, ranges: String },
    /// A requirement concerns the speed of a vehicle with a given speed.
    #[error(
        "{file}: '{key}' must be left out, because the vehicle file says [surge] speed = \"given\": no actuator acts \
            on the speed, and the autopilot gets it in any case"
    )]
    GivenSpeed { file: String, key: String },
    /// A design tracks heading, but the vehicle does not turn.
    #[error(
        "{design} tracks {tracked}, but the vehicle of {vehicle} moves in the vertical plane alone: give it \
         'mass.I_xx' and the numbers of sway, roll and yaw that a message then asks for"
    )]
    NoLateral { design: String, tracked: &'static str, vehicle: String },
    /// The vehicle has no actuator that acts on the axis.
    #[error("{design} tracks {tracked}, but {vehicle} has no actuator that {missing}")]
    NothingActs { design: String, tracked: &'static str, vehicle: String, missing: &'static str },
}
