//! The frozen controller design, as in its JSON file.

use serde::{Deserialize, Serialize};
use squid_signals::{Curve, Force, Level, Signal, Status};
use std::collections::BTreeMap;
use std::f64::consts::TAU;

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
    /// What can be measured and tracked: the signals of the vehicle model, first those with a reference.
    pub signals: Vec<Port>,
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
    /// The gains from which the controller was made, if it was given; nothing is computed from them.
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
    /// What references are limited to before they reach the controller, by the name of their signal.
    #[serde(default, skip_serializing_if = "is_default")]
    pub envelope: BTreeMap<String, ReferenceLimits>,
    /// What is flown without sensors that are lost; without it measurements are taken as they come.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub failsafe: Option<Failsafe>,
    /// The achieved performance level.
    pub gamma: Gamma,
    /// Hashes of the files that the design was computed from.
    pub inputs: InputHashes,
}

/// The name of the design that is meant where none is named.
pub const DEFAULT_DESIGN: &str = "design";

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

/// A signal between the vehicle and the autopilot: a row of [`squid_signals::Interface`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Port {
    /// Its name, also that of the FMU's input.
    pub name: String,
    /// SI unit.
    pub unit: String,
    /// What the sensor measures.
    pub measured: String,
    /// Its reference, if it can be tracked.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reference: Option<Reference>,
    /// Its value in trim.
    pub level: Level,
    /// Where flights start by default, of a signal that is measured from its value at the start.
    #[serde(default, skip_serializing_if = "is_default")]
    pub start: f64,
    /// The values that it can take; any without.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub range: Option<[f64; 2]>,
    /// Whether it is an angle that comes back to itself after a turn.
    #[serde(default, skip_serializing_if = "is_default")]
    pub circular: bool,
    /// A typical size.
    pub nominal: f64,
}

impl Port {
    /// A value of the signal, of an angle that comes back to itself the one nearest to another.
    pub fn nearest(&self, value: f64, to: f64) -> f64 {
        let turns = (value - to) / TAU;
        // So many turns are no angle, and neither is what is not a number.
        if !(self.circular && turns.abs() < MOST_TURNS) {
            return value;
        }
        value - TAU * (if turns < 0.0 { turns - 0.5 } else { turns + 0.5 }).trunc()
    }
}

impl Port {
    /// The values that a measurement or a reference can have at the first tick, any without: an angle in radians is
    /// within a turn, a vehicle does not turn faster than once a second, and a depth is in an ocean, downwards.
    pub fn first(&self, is_reference: bool) -> Option<[f64; 2]> {
        match self.unit.as_str() {
            "rad" if is_reference => Some([-TAU, TAU]),
            "rad" | "rad/s" => self.range.or(Some([-TAU, TAU])),
            "m" if self.level == Level::Start => self.range.or(Some(DEPTHS)),
            _ => self.range,
        }
    }
}

/// From the crest of a wave to below the deepest sea floor, m.
const DEPTHS: [f64; 2] = [-5.0, 12_000.0];

/// The turns of an angle are counted in a whole number.
const MOST_TURNS: f64 = 1e9;

/// The reference of a signal.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Reference {
    /// Its name, also that of the FMU's input.
    pub name: String,
    /// What it prescribes.
    pub wanted: String,
    /// The time by which the signal is to lag behind a reference that moves steadily, s.
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
                wanted: one.wanted.into(),
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
    /// The signal that is scheduled on, the one whose level is [`Level::Scheduled`].
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
    /// The index of a signal.
    pub fn index(&self, name: &str) -> Option<usize> {
        self.signals.iter().position(|signal| signal.name == name)
    }

    /// The index of the signal that is scheduled on.
    pub fn scheduled(&self) -> Option<usize> {
        self.signals.iter().position(|signal| signal.level == Level::Scheduled)
    }

    /// The signals that can be tracked, each with its reference; their indices are those of the signals.
    pub fn references(&self) -> impl Iterator<Item = (&Port, &Reference)> {
        self.signals.iter().map_while(|signal| Some((signal, signal.reference.as_ref()?)))
    }

    /// The indices of the signals with a trim that can be tracked: the autopilot puts their trim out.
    pub fn trimmed(&self) -> impl Iterator<Item = usize> {
        let trimmed = |(place, (signal, _)): (usize, (&Port, &Reference))| {
            (signal.level == Level::Trim).then_some(place)
        };
        self.references().enumerate().filter_map(trimmed)
    }

    /// Whether the autopilot measures a signal; it always measures the one that is scheduled on, for rho.
    pub fn measures(&self, signal: usize) -> bool {
        Some(signal) == self.scheduled() || self.has_input(signal, ControllerInput::is_measured)
    }

    /// Whether flights have a reference of a signal: of each that the autopilot tracks, always of the one that is
    /// scheduled on, and of the first if it tracks none besides.
    pub fn has_reference(&self, signal: usize) -> bool {
        let steered = |index: usize| Some(index) != self.scheduled() && self.follows(index);
        let none = || !(0..self.references().count()).any(steered);
        Some(signal) == self.scheduled() || self.follows(signal) || (signal == 0 && none())
    }

    /// The tracked signals besides the one that is scheduled on, in words: pitch, depth, or both.
    pub fn steered(&self) -> String {
        let others = (0..self.references().count()).filter(|one| Some(*one) != self.scheduled());
        let names = others.filter(|one| self.has_reference(*one)).map(|one| self.signals[one].name.as_str());
        names.collect::<Vec<_>>().join(" and ")
    }

    /// Whether the autopilot uses a reference of a signal; always that of the one that is scheduled on, for the trim,
    /// unless the speed is imposed.
    pub fn follows(&self, signal: usize) -> bool {
        (Some(signal) == self.scheduled() && !self.speed_given)
            || self.has_input(signal, ControllerInput::is_reference)
    }

    /// What is flown without a signal.
    pub fn without(&self, signal: usize) -> Without {
        match self.signals[signal].level {
            Level::Scheduled => Without::Speed,
            _ if self.source(signal).is_some_and(|source| source.signal().is_some()) => Without::Reckoned,
            _ => Without::Nothing,
        }
    }

    /// What the rate of a signal follows from, if that is measured.
    pub fn source(&self, signal: usize) -> Option<&Source> {
        let source = self.failsafe.as_ref()?.sensors.get(&self.signals[signal].name)?.from.as_ref()?;
        let is_known = |name: &str| self.index(name).is_some_and(|from| self.measures(from));
        source.signal().is_none_or(is_known).then_some(source)
    }

    /// The least and the largest reference of a signal at any speed, if they are limited.
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

/// What an actuator is told to have got is at most so many times its limits.
const LARGEST_APPLIED: f64 = 10.0;

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
    /// The names of the signals that it steers: while it stays at its limit their references yield to what is measured.
    #[serde(default, skip_serializing_if = "is_default")]
    pub steers: Vec<String>,
    /// The force that a command causes, \[X Z M\]. That along the hull says which way a thruster pushes that does not
    /// steer; all else is for the documentation only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub force: Option<Force>,
    /// That across the vertical plane, \[Y K N\], of an axis that it moves there.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lateral_force: Option<Force>,
}

impl Actuator {
    /// The effect of a positive command, in words.
    pub fn sign_in_words(&self) -> Option<String> {
        let forces = [self.force, self.lateral_force].map(Option::unwrap_or_default);
        squid_signals::sign_in_words(forces[0], forces[1], &self.unit)
    }

    /// The force along the hull per command of a thruster that does not steer; 0 of all others.
    pub fn pushes(&self) -> f64 {
        if self.steers.is_empty() { self.force.unwrap_or_default()[0] } else { 0.0 }
    }

    /// The largest command, in size, that it can be told to have got: beyond this the number is a mistake.
    pub fn largest_applied(&self) -> f64 {
        LARGEST_APPLIED * self.minimum.abs().max(self.maximum.abs())
    }

    /// Unit of the actuator's input.
    pub fn taken_unit(&self) -> &str {
        self.curve.as_ref().map_or(&self.unit, Curve::unit)
    }

    /// The command for an actuator's input, by its curve.
    pub fn given(&self, taken: f64) -> f64 {
        self.curve.as_ref().map_or(taken, |curve| curve.thrust(taken).0)
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
    /// The signals whose level is [`Level::Trim`], each a column, SI.
    pub signals: BTreeMap<String, Vec<f64>>,
    /// Commands, one row per speed, in the order of the actuators.
    pub actuators: Rows,
}

/// A number, or one for each row of the trim table; in a file a list of one number, or of as many as the table
/// has rows.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(from = "Vec<f64>", into = "Vec<f64>")]
pub enum OverSpeed {
    /// The same at each speed.
    Constant(f64),
    /// A column beside those of the trim table.
    Table(Vec<f64>),
}

impl OverSpeed {
    /// The number in a row of the trim table.
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
    /// A constant if the numbers of a column are the same.
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

/// What a reference is limited to; that of the speed is constant.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ReferenceLimits {
    /// The least and the largest reference, SI.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub range: Option<[OverSpeed; 2]>,
    /// The least and the largest rate of the reference, SI per second: not above and not below 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rate: Option<[OverSpeed; 2]>,
}

/// When a sensor is lost, and what the actuators get without it; see [`Supervisor`](crate::Supervisor).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Failsafe {
    /// A measurement that is the same for this long, and should have moved, is lost, s; 0 if it never is for that.
    pub stale_after: f64,
    /// The commands where the vehicle cannot be controlled, in the order of the actuators.
    pub safe: Vec<f64>,
    /// How each measured signal moves, by its name.
    pub sensors: BTreeMap<String, Sensor>,
}

/// How a measured signal moves.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sensor {
    /// The largest change between two readings for noise and rounding, SI.
    pub error: f64,
    /// The largest rate at which the vehicle changes it, SI per second.
    pub rate: f64,
    /// The largest rate at which it leaves what is expected of it while it is lost, SI per second.
    pub drift: f64,
    /// The steps of its values, SI; 0 of a sensor with noise beyond its steps, whose value never stays the same.
    #[serde(default, skip_serializing_if = "is_default")]
    pub resolution: f64,
    /// The longest time between two values, s; 0 of a sensor with a value at each tick.
    #[serde(default, skip_serializing_if = "is_default")]
    pub period: f64,
    /// What else knows its rate.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub from: Option<Source>,
}

/// What the rate of a measured signal follows from.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "lowercase")]
pub enum Source {
    /// Another measured signal: it is the rate, as that of heading.
    Rate(String),
    /// The signal of the pitch, as that of depth: `rate = -V (signal - trim)`, V the measured speed.
    Path(String),
    /// The commands, as that of speed: after they were u0 the signal has changed by m,
    /// `m' = sum over j of gains_j (u_j - u0_j) - m/time`.
    Commands {
        /// SI per second and unit of the command.
        gains: Vec<f64>,
        /// Time constant, s.
        time: f64,
    },
}

impl Source {
    /// The signal, if it is one.
    pub fn signal(&self) -> Option<&str> {
        match self {
            Self::Rate(signal) | Self::Path(signal) => Some(signal),
            Self::Commands { .. } => None,
        }
    }
}

/// What is flown without a signal.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Without {
    /// The signal that is scheduled on: it is taken to go to V_r, so that its loop is open.
    Speed,
    /// A signal whose rate follows from others that are measured: it is reckoned from its last value.
    Reckoned,
    /// Another: the commands of [`Failsafe::safe`].
    Nothing,
}

/// A gain of a controller that was given: a polynomial in rho.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Gain {
    /// Its name, for instance `pitch.kp`.
    pub name: String,
    /// Its SI unit.
    pub unit: String,
    /// The coefficients of 1, rho, rho^2.
    pub coefficients: Vec<f64>,
}

/// The achieved performance level.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Gamma {
    /// Lowest level that the solver found.
    pub optimum: f64,
    /// Level guaranteed by the controller in this file.
    pub bound: f64,
    /// Factor by which the level was relaxed from the optimum; 0 for a controller that was given, not computed.
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

/// A time in ticks, rounded up: two at least.
pub fn ticks(time: f64, sample_time: f64) -> u32 {
    ((time / sample_time).ceil() as u32).max(2)
}
