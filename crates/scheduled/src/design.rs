//! The frozen design of a controller, as in its JSON file.

use crate::json::is_default;
use serde::{Deserialize, Serialize};
use signals::{Curve, DEPTH, Force, PITCH, SPEED, Status, place};

/// A matrix as a list of rows.
pub type Rows = Vec<Vec<f64>>;

/// A command may come this many ticks late. A loop that waits longer should be sampled less often.
pub const MOST_DELAY_TICKS: usize = 10;

/// The format that is written and read.
pub const CONTROLLER_FORMAT: &str = "squid-controller/1";

/// Everything that the autopilot needs; SI units, radians.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ControllerDesign {
    /// [`CONTROLLER_FORMAT`].
    pub format: String,
    /// The vehicle.
    pub vehicle: VehicleName,
    /// Name of the design among those of the vehicle.
    pub design: String,
    /// Time between two ticks in s.
    pub sample_time: f64,
    /// Ticks by which a command comes late: the time of computation and network, at most [`MOST_DELAY_TICKS`].
    #[serde(default, skip_serializing_if = "is_default")]
    pub delay_ticks: usize,
    /// The scheduling parameter.
    pub scheduling: Scheduling,
    /// The inputs of the controller, in the order of `y`.
    pub controller_inputs: Vec<ControllerInput>,
    /// Bandwidth w_r of the filter of the speed reference in rad/s; `None` without filter.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reference_filter: Option<f64>,
    /// Whether the speed is given to the vehicle from outside: there is no reference of it, and the trim follows what
    /// is measured.
    #[serde(default, skip_serializing_if = "is_default")]
    pub speed_given: bool,
    /// The commanded actuators, in the order of `u`.
    pub actuators: Vec<Actuator>,
    /// The controller in continuous time.
    pub lft: LftMatrices,
    /// Anti-windup, E, a row a state of the controller and a column an actuator: the states move by `E phi` faster, phi
    /// the part of u that the limits cut off. Without it they continue as if the command had been carried out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub anti_windup: Option<Rows>,
    /// Level trim over speed.
    pub trim: TrimTable,
    /// Depth of the trims in m, with which a reference of the depth begins; 0 where there is none.
    #[serde(default, skip_serializing_if = "is_default")]
    pub depth: f64,
    /// The performance level achieved.
    pub gamma: Gamma,
    /// Hashes of the files that the design was computed from.
    pub inputs: InputHashes,
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
    /// Quantity that rho depends on; always `speed`.
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

/// What an input of the controller is; y0 is the signal in level flight at the filtered speed reference V_r.
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

/// One input of the controller.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ControllerInput {
    /// Name of the signal in [`signals::SIGNALS`].
    pub signal: String,
    /// What is taken of the signal.
    pub kind: Kind,
    /// Unit of the signal.
    pub unit: String,
    /// Difference at which y_i = 1.
    pub scale: f64,
}

impl ControllerInput {
    /// Whether it takes the measured value of the signal.
    pub fn is_measured(&self) -> bool {
        self.kind != Kind::Reference
    }

    /// Whether it takes the reference of the signal.
    pub fn is_wanted(&self) -> bool {
        self.kind != Kind::Measurement
    }
}

impl ControllerDesign {
    /// Whether the autopilot measures the signal at a place in [`signals::SIGNALS`]: the speed always, for rho.
    pub fn measures(&self, signal: usize) -> bool {
        signal == SPEED || self.takes(signal, ControllerInput::is_measured)
    }

    /// Whether flights have a reference of the signal at a place in [`signals::SIGNALS`]: of what the autopilot
    /// follows, of the speed always, and of the pitch unless the depth is followed in its place.
    pub fn has_reference(&self, signal: usize) -> bool {
        signal == SPEED || self.follows(signal) || (signal == PITCH && !self.follows(DEPTH))
    }

    /// What it steers besides the speed, in words: pitch, depth, or both.
    pub fn steered(&self) -> &'static str {
        match (self.has_reference(PITCH), self.has_reference(DEPTH)) {
            (true, true) => "pitch and depth",
            (false, true) => "depth",
            _ => "pitch",
        }
    }

    /// Whether the autopilot follows a reference of the signal at a place in [`signals::SIGNALS`]: of a speed that is
    /// not given always, for the trim.
    pub fn follows(&self, signal: usize) -> bool {
        (signal == SPEED && !self.speed_given) || self.takes(signal, ControllerInput::is_wanted)
    }

    fn takes(&self, signal: usize, part: fn(&ControllerInput) -> bool) -> bool {
        self.controller_inputs.iter().any(|input| part(input) && place(&input.signal) == Some(signal))
    }
}

/// One actuator: `command = clamp(trim + scale u_i, minimum, maximum)`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Actuator {
    /// Name, also of the FMU's output.
    pub name: String,
    /// Unit of the command, `N` for a thruster, `rad` for a control surface.
    pub unit: String,
    /// Command at which u_i = 1.
    pub scale: f64,
    /// Least command.
    pub minimum: f64,
    /// Greatest command.
    pub maximum: f64,
    /// From what a thruster takes to its thrust; `None` where it takes the command itself.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub curve: Option<Curve>,
    /// What a command does to the vehicle, for the documentation alone.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub force: Option<Force>,
}

impl Actuator {
    /// What a positive command does, in words.
    pub fn sign_in_words(&self) -> Option<String> {
        self.force.and_then(|force| signals::sign_in_words(force, &self.unit))
    }

    /// Unit of what it takes.
    pub fn taken_unit(&self) -> &str {
        self.curve.as_ref().map_or(&self.unit, Curve::unit)
    }

    /// What it takes for a command, by the inverse of its curve, and the slope as [`Curve::command`] does.
    pub fn taken(&self, command: f64) -> (f64, f64) {
        self.curve.as_ref().map_or((command, 1.0), |curve| curve.command(command))
    }
}

/// The controller's LFT in continuous time; see the crate's documentation for the partition.
///
/// With n states, p inputs, m actuators and r channels, `Bt` is n x r, and so on. A matrix with rows but
/// no columns is a list of empty rows.
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

/// The performance level that was achieved.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Gamma {
    /// Least level that the solver reached.
    pub optimum: f64,
    /// Level that the controller in this file guarantees.
    pub bound: f64,
    /// Factor by which the design was relaxed from the optimum.
    pub back_off: f64,
    /// Whether the level was proved in exact arithmetic.
    pub certified: bool,
}

/// SHA-256 of the files that the design was computed from, in hexadecimal.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct InputHashes {
    /// Of the vehicle file.
    pub vehicle_sha256: String,
    /// Of the design file.
    pub design_sha256: String,
}
