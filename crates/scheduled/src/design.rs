//! The frozen controller design, as in its JSON file.

use serde::{Deserialize, Serialize};
use signals::{Curve, DEPTH, Force, PITCH, SPEED, Status, place};

/// A matrix as a list of rows.
pub type Rows = Vec<Vec<f64>>;

/// The largest delay of a command in ticks. A loop with a longer delay should have a longer sample time.
pub const MAX_DELAY_TICKS: usize = 10;

/// The file format that is written and read.
pub const CONTROLLER_FORMAT: &str = "squid-controller/1";

/// Everything that the autopilot needs; SI units, radians.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ControllerDesign {
    /// [`CONTROLLER_FORMAT`].
    pub format: String,
    /// The vehicle.
    pub vehicle: VehicleName,
    /// Name of the design among the designs of the vehicle.
    pub design: String,
    /// Time between two ticks in s.
    pub sample_time: f64,
    /// Delay of the commands in ticks, for computation and network; at most [`MAX_DELAY_TICKS`].
    #[serde(default, skip_serializing_if = "is_default")]
    pub delay_ticks: usize,
    /// The scheduling parameter.
    pub scheduling: Scheduling,
    /// The controller inputs, in the order of `y`.
    pub controller_inputs: Vec<ControllerInput>,
    /// Bandwidth w_r of the filter of the speed reference in rad/s; `None` without filter.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reference_filter: Option<f64>,
    /// Whether the speed is imposed on the vehicle from outside: it has no reference, and the trim follows the measured
    /// speed.
    #[serde(default, skip_serializing_if = "is_default")]
    pub speed_given: bool,
    /// The commanded actuators, in the order of `u`.
    pub actuators: Vec<Actuator>,
    /// The controller in continuous time.
    pub lft: LftMatrices,
    /// Anti-windup gain E, one row per controller state, one column per actuator: `E phi` is added to the state
    /// derivatives, where phi is the excess of u over the limits. Without it the states evolve as if unsaturated.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub anti_windup: Option<Rows>,
    /// Level trim over speed.
    pub trim: TrimTable,
    /// Depth of the trims in m, the initial depth reference; 0 without one.
    #[serde(default, skip_serializing_if = "is_default")]
    pub depth: f64,
    /// The achieved performance level.
    pub gamma: Gamma,
    /// Hashes of the files that the design was computed from.
    pub inputs: InputHashes,
}

/// Whether a key is omitted.
pub(crate) fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

/// The vehicle of the design.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct VehicleName {
    /// Name of the vehicle.
    pub name: String,
    /// How well its coefficients are known.
    pub status: Status,
}

/// `rho = (V - centre)/half_range`, V the speed along the path in trim.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scheduling {
    /// The scheduling quantity; always `speed`.
    pub quantity: String,
    /// V at rho = -1, in m/s.
    pub minimum: f64,
    /// V at rho = 1, in m/s.
    pub maximum: f64,
    /// V at rho = 0, in m/s.
    pub centre: f64,
    /// Change of V per unit of rho, in m/s.
    pub half_range: f64,
}

/// Kind of a controller input; y0 is the signal in level flight at the filtered speed reference V_r.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// `y_i = (reference - measured)/scale`.
    Error,
    /// `y_i = (reference - y0(V_r))/scale`.
    Reference,
    /// `y_i = (measured - y0(V_r))/scale`.
    Measurement,
}

/// One controller input.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ControllerInput {
    /// Name of the signal in [`signals::SIGNALS`].
    pub signal: String,
    /// How the input is formed from the signal.
    pub kind: Kind,
    /// Unit of the signal.
    pub unit: String,
    /// Difference at which y_i = 1.
    pub scale: f64,
}

impl ControllerInput {
    /// Whether the input uses the measured value of the signal.
    pub fn is_measured(&self) -> bool {
        self.kind != Kind::Reference
    }

    /// Whether the input uses the reference of the signal.
    pub fn is_reference(&self) -> bool {
        self.kind != Kind::Measurement
    }
}

impl ControllerDesign {
    /// Whether the autopilot measures the signal at a place in [`signals::SIGNALS`]; it always measures the speed, for
    /// rho.
    pub fn measures(&self, signal: usize) -> bool {
        signal == SPEED || self.has_input(signal, ControllerInput::is_measured)
    }

    /// Whether flights have a reference of the signal at a place in [`signals::SIGNALS`]: of each signal that the
    /// autopilot tracks, always of the speed, and of the pitch unless the depth is tracked instead.
    pub fn has_reference(&self, signal: usize) -> bool {
        signal == SPEED || self.follows(signal) || (signal == PITCH && !self.follows(DEPTH))
    }

    /// The tracked signals besides the speed, in words: pitch, depth, or both.
    pub fn steered(&self) -> &'static str {
        match (self.has_reference(PITCH), self.has_reference(DEPTH)) {
            (true, true) => "pitch and depth",
            (false, true) => "depth",
            _ => "pitch",
        }
    }

    /// Whether the autopilot uses a reference of the signal at a place in [`signals::SIGNALS`]; always that of the
    /// speed, for the trim, unless the speed is imposed.
    pub fn follows(&self, signal: usize) -> bool {
        (signal == SPEED && !self.speed_given) || self.has_input(signal, ControllerInput::is_reference)
    }

    fn has_input(&self, signal: usize, kind: fn(&ControllerInput) -> bool) -> bool {
        self.controller_inputs.iter().any(|input| kind(input) && place(&input.signal) == Some(signal))
    }
}

/// One actuator: `command = clamp(trim + scale u_i, minimum, maximum)`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Actuator {
    /// Name, also that of the FMU's output.
    pub name: String,
    /// Unit of the command, `N` for a thruster, `rad` for a control surface.
    pub unit: String,
    /// Command at which u_i = 1.
    pub scale: f64,
    /// Minimum command.
    pub minimum: f64,
    /// Maximum command.
    pub maximum: f64,
    /// Curve from a thruster's input to its thrust; `None` if its input is the command itself.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub curve: Option<Curve>,
    /// The force that a command causes, for the documentation only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub force: Option<Force>,
}

impl Actuator {
    /// The effect of a positive command, in words.
    pub fn sign_in_words(&self) -> Option<String> {
        self.force.and_then(|force| signals::sign_in_words(force, &self.unit))
    }

    /// Unit of the actuator's input.
    pub fn taken_unit(&self) -> &str {
        self.curve.as_ref().map_or(&self.unit, Curve::unit)
    }

    /// The actuator's input for a command, by the inverse of its curve, and the slope; see [`Curve::command`].
    pub fn taken(&self, command: f64) -> (f64, f64) {
        self.curve.as_ref().map_or((command, 1.0), |curve| curve.command(command))
    }
}

/// The controller's LFT in continuous time; see the crate's documentation for the partition.
///
/// With n states, p inputs, m actuators and r channels, `Bt` is n x r, and so on. A matrix without columns is a list of
/// empty rows.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "PascalCase")]
#[allow(missing_docs)]
pub struct LftMatrices {
    /// Repetitions of each scheduling parameter.
    #[serde(rename = "blocks")]
    pub blocks: Vec<usize>,
    pub a: Rows,
    pub by: Rows,
    pub bt: Rows,
    pub cu: Rows,
    pub duy: Rows,
    pub dut: Rows,
    pub ct: Rows,
    pub dty: Rows,
    pub dtt: Rows,
}

/// Level trim on a grid of speeds.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrimTable {
    /// Speed V along the path in m/s, increasing.
    pub speed: Vec<f64>,
    /// Forward speed u in body axes in m/s, increasing.
    pub forward_speed: Vec<f64>,
    /// Pitch angle in rad.
    pub pitch: Vec<f64>,
    /// Commands, one row per speed, in the order of the actuators.
    pub actuators: Rows,
}

/// The achieved performance level.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Gamma {
    /// Lowest level that the solver found.
    pub optimum: f64,
    /// Level guaranteed by the controller in this file.
    pub bound: f64,
    /// Factor by which the level was relaxed from the optimum.
    pub back_off: f64,
    /// Whether the level was proved in exact arithmetic.
    pub certified: bool,
}

/// SHA-256 of the files that the design was computed from, in hexadecimal.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct InputHashes {
    /// Hash of the vehicle file.
    pub vehicle_sha256: String,
    /// Hash of the design file.
    pub design_sha256: String,
}
