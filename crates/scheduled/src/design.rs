//! Frozen controller design, as in its JSON file.

use serde::{Deserialize, Serialize};
use squid_signals::{Curve, Force, Level, Signal, Status};
use std::collections::BTreeMap;
use std::f64::consts::TAU;

/// Matrix as a list of rows.
pub type Rows = Vec<Vec<f64>>;

/// Largest delay of a command in ticks. A loop with a longer delay should have a longer sample time.
pub const MAX_DELAY_TICKS: usize = 10;

/// File format of a design.
pub const CONTROLLER_FORMAT: &str = "squid-controller/1";

/// Complete data of an autopilot; SI units, radians.
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
    /// Signals of the vehicle model that can be measured or tracked; those with a reference come first.
    pub signals: Vec<Port>,
    /// The scheduling parameter.
    pub scheduling: Scheduling,
    /// The controller inputs, in the order of `y`.
    pub controller_inputs: Vec<ControllerInput>,
    /// Bandwidth w_r of the filter of the speed reference in rad/s; `None` without filter.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reference_filter: Option<f64>,
    /// `true` if the speed is imposed on the vehicle from outside: it has no reference, and the trim follows the
    /// measured speed.
    #[serde(default, skip_serializing_if = "is_default")]
    pub speed_given: bool,
    /// The commanded actuators, in the order of `u`.
    pub actuators: Vec<Actuator>,
    /// The controller in continuous time.
    pub lft: LftMatrices,
    /// Gains from which the controller was built, if it was given and not synthesised; for documentation only.
    #[serde(default, skip_serializing_if = "is_default")]
    pub gains: Vec<Gain>,
    /// Anti-windup gain E, one row per controller state, one column per actuator: `E phi` is added to the state
    /// derivatives, where phi is the excess of u over the limits. Without it the states evolve as if unsaturated.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub anti_windup: Option<Rows>,
    /// Gains F of [`Autopilot::follow`](crate::Autopilot::follow) at values of rho from -1 to 1, evenly spaced: each
    /// has one row per state of the controller in discrete time, and one column per actuator.
    #[serde(default, skip_serializing_if = "is_default")]
    pub follow: Vec<Rows>,
    /// Level trim over speed.
    pub trim: TrimTable,
    /// Limits of the references upstream of the controller, by the name of their signal.
    #[serde(default, skip_serializing_if = "is_default")]
    pub envelope: BTreeMap<String, ReferenceLimits>,
    /// Handling of lost sensors; `None` uses all measurements unchecked.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub failsafe: Option<Failsafe>,
    /// Achieved performance level.
    pub gamma: Gamma,
    /// Hashes of the files from which the design was computed.
    pub inputs: InputHashes,
}

/// Default name of a design.
pub const DEFAULT_DESIGN: &str = "design";

/// Returns `true` if a key is omitted in the file.
pub(crate) fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

/// The vehicle of the design.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct VehicleName {
    /// Name of the vehicle.
    pub name: String,
    /// Status of its coefficients.
    pub status: Status,
}

/// A signal between the vehicle and the autopilot: a row of [`squid_signals::Interface`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Port {
    /// Name, also that of the FMU's input.
    pub name: String,
    /// SI unit.
    pub unit: String,
    /// Measured quantity.
    pub measured: String,
    /// Reference, if the signal can be tracked.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reference: Option<Reference>,
    /// Kind of its value in trim.
    pub level: Level,
    /// Default initial value, for a signal with [`Level::Start`].
    #[serde(default, skip_serializing_if = "is_default")]
    pub start: f64,
    /// Smallest and largest possible value; `None` for any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub range: Option<[f64; 2]>,
    /// `true` for an angle with a period of one turn.
    #[serde(default, skip_serializing_if = "is_default")]
    pub circular: bool,
    /// Nominal size.
    pub nominal: f64,
}

impl Port {
    /// Returns the value; for a circular angle, shifted by whole turns to be nearest to `to`.
    pub fn nearest(&self, value: f64, to: f64) -> f64 {
        let turns = (value - to) / TAU;
        // Larger values and NaN are not angles.
        if !(self.circular && turns.abs() < MOST_TURNS) {
            return value;
        }
        value - TAU * (if turns < 0.0 { turns - 0.5 } else { turns + 0.5 }).trunc()
    }
}

impl Port {
    /// Returns the range allowed for a measurement or a reference at the first tick, `None` for any: angles within a
    /// turn, rates within a turn per second, depths (positive downwards) within those of the ocean.
    pub fn first(&self, is_reference: bool) -> Option<[f64; 2]> {
        match self.unit.as_str() {
            "rad" if is_reference => Some([-TAU, TAU]),
            "rad" | "rad/s" => self.range.or(Some([-TAU, TAU])),
            "m" if self.level == Level::Start => self.range.or(Some(DEPTHS)),
            _ => self.range,
        }
    }
}

/// Depths from the crest of a wave to below the deepest sea floor, m.
const DEPTHS: [f64; 2] = [-5.0, 12_000.0];

/// Number of turns from which a value is not treated as an angle.
const MOST_TURNS: f64 = 1e9;

/// Reference of a signal.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Reference {
    /// Name, also that of the FMU's input.
    pub name: String,
    /// Prescribed quantity.
    pub description: String,
    /// Time by which the signal lags behind a ramp of the reference by design, s.
    #[serde(default, skip_serializing_if = "is_default")]
    pub lag: f64,
}

impl From<&Signal> for Port {
    fn from(signal: &Signal) -> Self {
        Self {
            name: signal.name.into(),
            unit: signal.unit.into(),
            measured: signal.measured.into(),
            reference: signal.reference.map(|one| Reference {
                name: one.name.into(),
                description: one.description.into(),
                lag: 0.0,
            }),
            level: signal.level,
            start: 0.0,
            range: signal.range,
            circular: signal.circular,
            nominal: signal.nominal,
        }
    }
}

/// `rho = (V - centre)/half_range`, V the speed along the path in trim.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scheduling {
    /// Scheduling signal, the one whose level is [`Level::Scheduled`].
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
    /// Name of the signal.
    pub signal: String,
    /// Kind of the input.
    pub kind: Kind,
    /// Unit of the signal.
    pub unit: String,
    /// Difference at which y_i = 1.
    pub scale: f64,
}

impl ControllerInput {
    /// Returns `true` if the input uses the measured value of the signal.
    pub fn is_measured(&self) -> bool {
        self.kind != Kind::Reference
    }

    /// Returns `true` if the input uses the reference of the signal.
    pub fn is_reference(&self) -> bool {
        self.kind != Kind::Measurement
    }
}

impl ControllerDesign {
    /// Returns the index of a signal.
    pub fn index(&self, name: &str) -> Option<usize> {
        self.signals.iter().position(|signal| signal.name == name)
    }

    /// Returns the index of the scheduling signal.
    pub fn scheduled(&self) -> Option<usize> {
        self.signals.iter().position(|signal| signal.level == Level::Scheduled)
    }

    /// Returns the signals that can be tracked, each with its reference; their indices are those of the signals.
    pub fn references(&self) -> impl Iterator<Item = (&Port, &Reference)> {
        self.signals.iter().map_while(|signal| Some((signal, signal.reference.as_ref()?)))
    }

    /// Returns the indices of the signals with a trim that can be tracked: their trim is an output of the autopilot.
    pub fn trimmed(&self) -> impl Iterator<Item = usize> {
        let trimmed = |(index, (signal, _)): (usize, (&Port, &Reference))| {
            (signal.level == Level::Trim).then_some(index)
        };
        self.references().enumerate().filter_map(trimmed)
    }

    /// Returns `true` if the autopilot measures a signal; it always measures the scheduling signal.
    pub fn measures(&self, signal: usize) -> bool {
        Some(signal) == self.scheduled() || self.has_input(signal, ControllerInput::is_measured)
    }

    /// Returns `true` if flights have a reference of a signal: of each tracked signal, of the scheduling signal in any
    /// case, and of the first signal if no other is tracked.
    pub fn has_reference(&self, signal: usize) -> bool {
        let steered = |index: usize| Some(index) != self.scheduled() && self.follows(index);
        let none = || !(0..self.references().count()).any(steered);
        Some(signal) == self.scheduled() || self.follows(signal) || (signal == 0 && none())
    }

    /// Returns the names of the tracked signals except the scheduling signal, for messages: pitch, depth, or both.
    pub fn steered_signal(&self) -> String {
        let others = (0..self.references().count()).filter(|one| Some(*one) != self.scheduled());
        let names = others.filter(|one| self.has_reference(*one)).map(|one| self.signals[one].name.as_str());
        names.collect::<Vec<_>>().join(" and ")
    }

    /// Returns `true` if the autopilot uses a reference of a signal; it uses that of the scheduling signal for the trim
    /// in any case, unless the speed is imposed.
    pub fn follows(&self, signal: usize) -> bool {
        (Some(signal) == self.scheduled() && !self.speed_given)
            || self.has_input(signal, ControllerInput::is_reference)
    }

    /// Fallback for a lost signal.
    pub fn without(&self, signal: usize) -> Without {
        match self.signals[signal].level {
            Level::Scheduled => Without::Speed,
            _ if self.source(signal).is_some_and(|source| source.signal().is_some()) => Without::Reckoned,
            _ => Without::Nothing,
        }
    }

    /// Returns the source of the rate of a signal; `None` if that source is not measured.
    pub fn source(&self, signal: usize) -> Option<&Source> {
        let source = self.failsafe.as_ref()?.sensors.get(&self.signals[signal].name)?.from.as_ref()?;
        let is_known = |name: &str| self.index(name).is_some_and(|from| self.measures(from));
        source.signal().is_none_or(is_known).then_some(source)
    }

    /// Returns the smallest and the largest reference of a signal over all speeds, if they are limited.
    pub fn widest(&self, signal: &Port) -> Option<[f64; 2]> {
        let [least, most] = self.envelope.get(&signal.name)?.range.as_ref()?;
        let rows = 0..self.trim.speed.len();
        let least = rows.clone().map(|row| least.at(row)).fold(f64::INFINITY, f64::min);
        Some([least, rows.map(|row| most.at(row)).fold(f64::NEG_INFINITY, f64::max)])
    }

    fn has_input(&self, signal: usize, kind: fn(&ControllerInput) -> bool) -> bool {
        let name = self.signals.get(signal).map(|signal| &signal.name);
        self.controller_inputs.iter().any(|input| kind(input) && Some(&input.signal) == name)
    }
}

/// Largest accepted applied command, as a multiple of the limits of the actuator.
const LARGEST_APPLIED: f64 = 10.0;

/// Actuator: `command = clamp(trim + scale u_i, minimum, maximum)`.
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
    /// Names of the signals that it steers: while it stays at its limit, their references move towards the measured
    /// values.
    #[serde(default, skip_serializing_if = "is_default")]
    pub steers: Vec<String>,
    /// Force per unit of command, \[X Z M\]. X gives the direction in which a thruster that does not steer pushes; Z
    /// and M are for documentation only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub force: Option<Force>,
    /// Lateral force per unit of command, \[Y K N\]; for documentation only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lateral_force: Option<Force>,
}

impl Actuator {
    /// Describes the effect of a positive command.
    pub fn effect_of_sign(&self) -> Option<String> {
        let forces = [self.force, self.lateral_force].map(Option::unwrap_or_default);
        squid_signals::effect_of_sign(forces[0], forces[1], &self.unit)
    }

    /// Returns the force X along the hull per unit of command for a thruster that does not steer; 0 for all others.
    pub fn pushes(&self) -> f64 {
        if self.steers.is_empty() { self.force.unwrap_or_default()[0] } else { 0.0 }
    }

    /// Returns the largest magnitude accepted as an applied command; larger values are taken for input errors.
    pub fn largest_applied(&self) -> f64 {
        LARGEST_APPLIED * self.minimum.abs().max(self.maximum.abs())
    }

    /// Unit of the actuator's input.
    pub fn input_unit(&self) -> &str {
        self.curve.as_ref().map_or(&self.unit, Curve::unit)
    }

    /// Returns the command for an actuator input, by the curve.
    pub fn given(&self, taken: f64) -> f64 {
        self.curve.as_ref().map_or(taken, |curve| curve.thrust(taken).0)
    }

    /// Returns the actuator input for a command, by the inverse of the curve, and its slope; see [`Curve::command`].
    pub fn input_for(&self, command: f64) -> (f64, f64) {
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
    /// The signals whose level is [`Level::Trim`], each a column, SI.
    pub signals: BTreeMap<String, Vec<f64>>,
    /// Commands, one row per speed, in the order of the actuators.
    pub actuators: Rows,
}

/// Constant, or a column with one value per row of the trim table; in a file, a list with one value or one per row.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(from = "Vec<f64>", into = "Vec<f64>")]
pub enum OverSpeed {
    /// Constant over speed.
    Constant(f64),
    /// One value per row of the trim table.
    Table(Vec<f64>),
}

impl OverSpeed {
    /// Returns the value in a row of the trim table.
    ///
    /// # Panics
    /// If a table has no such row.
    pub fn at(&self, row: usize) -> f64 {
        match self {
            Self::Constant(value) => *value,
            Self::Table(column) => column[row],
        }
    }
}

impl From<Vec<f64>> for OverSpeed {
    /// Gives a constant if all entries of a column are the same.
    fn from(column: Vec<f64>) -> Self {
        match column.first() {
            Some(&first) if column.iter().all(|one| *one == first) => Self::Constant(first),
            _ => Self::Table(column),
        }
    }
}

impl From<OverSpeed> for Vec<f64> {
    fn from(number: OverSpeed) -> Self {
        match number {
            OverSpeed::Constant(value) => vec![value],
            OverSpeed::Table(column) => column,
        }
    }
}

/// Limits of a reference; those of the speed are constant.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ReferenceLimits {
    /// Smallest and largest reference, SI.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub range: Option<[OverSpeed; 2]>,
    /// Smallest (at most 0) and largest (at least 0) rate of the reference, SI per second.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rate: Option<[OverSpeed; 2]>,
}

/// Limits for the detection of lost sensors, and the fallback commands; see [`Supervisor`](crate::Supervisor).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Failsafe {
    /// Time for which a measurement may stay the same although it should have moved, s; 0 disables the check.
    pub stale_after: f64,
    /// Safe commands for a vehicle that cannot be controlled, in the order of the actuators.
    pub safe: Vec<f64>,
    /// Limits of each measured signal, by its name.
    pub sensors: BTreeMap<String, Sensor>,
}

/// Limits of the motion and the errors of a measured signal.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sensor {
    /// Largest change between two readings caused by noise and rounding, SI.
    pub error: f64,
    /// Largest rate of change caused by the motion of the vehicle, SI per second.
    pub rate: f64,
    /// Largest rate at which the signal departs from its estimate while the sensor is lost, SI per second.
    pub drift: f64,
    /// Resolution, SI; 0 for a sensor with noise above its resolution, whose value never stays the same.
    #[serde(default, skip_serializing_if = "is_default")]
    pub resolution: f64,
    /// Longest time between two values, s; 0 for a sensor with a new value at each tick.
    #[serde(default, skip_serializing_if = "is_default")]
    pub period: f64,
    /// Source of its rate independent of the sensor.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub from: Option<Source>,
}

/// Source of the rate of a measured signal.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "lowercase")]
pub enum Source {
    /// Measured signal that is the rate, as for heading.
    Rate(String),
    /// Pitch signal, as for depth: `rate = -V (signal - trim)`, V the measured speed.
    Path(String),
    /// Commands, as for speed: the change m of the signal since the commands were u0 follows
    /// `m' = sum over j of gains_j (u_j - u0_j) - m/time`.
    Commands {
        /// Gains, SI per second and unit of the command.
        gains: Vec<f64>,
        /// Time constant, s.
        time: f64,
    },
}

impl Source {
    /// Returns the name of the source signal; `None` for commands.
    pub fn signal(&self) -> Option<&str> {
        match self {
            Self::Rate(signal) | Self::Path(signal) => Some(signal),
            Self::Commands { .. } => None,
        }
    }
}

/// Fallback for a lost signal.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Without {
    /// Scheduling signal: estimated to return to V_r, so that its loop is open.
    Speed,
    /// Signal whose rate follows from other measured signals: integrated from its last value (dead reckoning).
    Reckoned,
    /// Any other signal: the commands of [`Failsafe::safe`].
    Nothing,
}

/// Gain of a given controller, a polynomial in rho.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Gain {
    /// Name, for instance `pitch.kp`.
    pub name: String,
    /// SI unit.
    pub unit: String,
    /// Coefficients of 1, rho, rho^2.
    pub coefficients: Vec<f64>,
}

/// Achieved performance level.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Gamma {
    /// Lowest level that the solver found.
    pub optimum: f64,
    /// Level guaranteed by the controller in this file.
    pub bound: f64,
    /// Factor by which the level was relaxed from the optimum; 0 for a given controller.
    pub back_off: f64,
    /// `true` if the level was proved in exact arithmetic.
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

/// Returns a time in ticks, rounded up, at least two.
pub fn ticks(time: f64, sample_time: f64) -> u32 {
    ((time / sample_time).ceil() as u32).max(2)
}
