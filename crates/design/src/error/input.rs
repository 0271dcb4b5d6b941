//! Errors in the input files of a design.

use strum::IntoStaticStr;
use thiserror::Error;

/// Error in the input files of a design.
#[derive(Debug, Error, IntoStaticStr)]
#[strum(serialize_all = "snake_case")]
#[allow(missing_docs, reason = "the message says what each field is")]
pub enum InputError {
    /// The vehicle's directory does not exist.
    #[error("{directory}: directory not found; give one that contains vehicle.toml and design.toml")]
    NoVehicle { directory: String },
    /// There is no design of that name.
    #[error("{path}: file not found; `squid tune {directory} --design {name}` creates one from the vehicle")]
    NoDesign { path: String, directory: String, name: String },
    /// The vehicle file or the design file is wrong.
    #[error(transparent)]
    File(#[from] squid_auv::FileError),
    /// The vehicle file or the design file cannot be read.
    #[error(transparent)]
    #[strum(transparent)]
    Unreadable(#[from] squid_base::files::Error),
    /// A bandwidth on the command line is out of range.
    #[error("--bandwidth is {}; it must be {}", squid_auv::number(*found), crate::inputs::design_file::BANDWIDTH.text)]
    Bandwidth { found: f64 },
    /// A design cannot be judged with the weights of another.
    #[error("{design} cannot be evaluated with the weights of {weights}: {why}")]
    Weights { design: String, weights: String, why: &'static str },
    /// An actuator's name is that of another variable of the FMUs.
    #[error(
        "{file}: the actuator name '{actuator}' would give two variables of the FMUs the name '{name}'{}; rename the \
            actuator",
        other.as_ref().map(|other| format!(", as does the actuator '{other}'")).unwrap_or_default()
    )]
    ActuatorName { file: String, actuator: String, name: String, other: Option<String> },
    /// A design has waves, but the hull has no dimensions.
    #[error(
        "{file}: [sea] requires the dimensions of the hull for the wave loads; add [geometry] with length and \
            diameter to the vehicle file, or remove [sea]"
    )]
    NoGeometry { file: String },
    /// The design has no given controller.
    #[error("{file} has no [controller] of kind \"pid\"; add one there, or give a file with --controller")]
    NoController { file: String },
    /// The request needs another controller than the one given by the design file.
    #[error(
        "{file}: [controller] already gives the controller, so {what}; remove [controller] or this request"
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
        "{file}: the axes of {one} and {other} both command '{actuator}'; combine axes that share actuators into one \
            [[axis]]"
    )]
    SharedActuator { file: String, actuator: String, one: &'static str, other: &'static str },
    /// Two axes differ in a property of their common vehicle.
    #[error("{file}: '{key}' is {values}; it must be the same for all axes: set it outside [[axis]]")]
    AxesDiffer { file: String, key: &'static str, values: String },
    /// The axes have no common speed.
    #[error("{file}: the speed ranges of the axes have no speed in common: {ranges}")]
    NoCommonSpeed { file: String, ranges: String },
    /// A requirement concerns the speed of a vehicle with a given speed.
    #[error(
        "{file}: '{key}' must be omitted: the vehicle file has [surge] speed = \"given\", so that no actuator acts \
            on the speed, which the autopilot receives in any case"
    )]
    GivenSpeed { file: String, key: String },
    /// A design tracks heading, but the vehicle does not turn.
    #[error(
        "{design} tracks {tracked}, but {vehicle} describes motion in the vertical plane only; add 'mass.I_xx' and \
         the coefficients that are then reported as missing"
    )]
    NoLateral { design: String, tracked: &'static str, vehicle: String },
    /// The vehicle has no actuator that acts on the axis.
    #[error("{design} tracks {tracked}, but the vehicle of {vehicle} has no actuator that {missing}")]
    NothingActs { design: String, tracked: &'static str, vehicle: String, missing: &'static str },
}
