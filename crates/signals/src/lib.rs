//! What passes between a vehicle and its autopilot.
//!
//! An [`Interface`] is a table: the states of a linear model and its outputs, the [`Signal`]s. Every signal can be
//! measured; those with a reference can be tracked. Each vehicle model has its own; a frozen design copies the rows, so
//! that FMUs, C and Python take every name, unit and range from it. The scale of a signal depends on the design and is
//! in the design file.
//!
//! The commands are outputs of the actuators, or what a thruster takes instead: its [`Curve`] says which.
//! [`sign_in_words`] says what a positive output does.

mod curve;
mod force;

pub use curve::{COMMAND_UNITS, Curve, CurveError, Law, POINTS};
pub use force::{Force, sign_in_words};

use serde::{Deserialize, Serialize};

/// How well the coefficients of a vehicle are known.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Status {
    /// Derived from geometry and general formulae: no number of the real vehicle.
    Surrogate,
    /// Published by others, with a source.
    Published,
    /// Identified from trials of the vehicle itself.
    Measured,
}

impl Status {
    /// Every status.
    pub const ALL: [Self; 3] = [Self::Surrogate, Self::Published, Self::Measured];

    /// Its name in files.
    pub fn word(self) -> &'static str {
        match self {
            Self::Surrogate => "surrogate",
            Self::Published => "published",
            Self::Measured => "measured",
        }
    }
}

/// A state of a linear model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct State {
    /// The usual symbol.
    pub symbol: &'static str,
    /// SI unit.
    pub unit: &'static str,
    /// Its name in messages.
    pub name: &'static str,
    /// What would act on it, for messages.
    pub acts: &'static str,
    /// What would measure it, for messages.
    pub shows: &'static str,
}

/// The states of a linear model, in their order.
pub type States = &'static [State];

/// A unit besides SI, with its value in SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unit {
    /// Its name in files and plots.
    pub name: &'static str,
    /// Its value in SI.
    pub factor: f64,
}

/// The reference of a signal that can be tracked.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Reference {
    /// Its name in FMUs, `NAME_reference`.
    pub name: &'static str,
    /// What it prescribes.
    pub wanted: &'static str,
}

/// The value y0 of a signal in trim, from which the controller's inputs are deviations.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Level {
    /// The filtered reference V_r of the signal that is scheduled on.
    Scheduled,
    /// A column of the trim table, a function of V_r.
    Trim,
    /// The measured value at initialisation: the dynamics do not depend on it.
    Start,
    /// Zero.
    Zero,
}

/// The largest step of a reference for which anti-windup is designed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LargestStep {
    /// A step of this size, SI.
    Of(f64),
    /// Up to the surface.
    Depth,
    /// Over the range of the scheduled speed.
    Range,
}

/// A row of an [`Interface`]: an output of the linear model, y = C x.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Signal {
    /// Its name in design files, frozen designs and FMUs: an output of the plant, an input of the controller.
    pub name: &'static str,
    /// SI unit.
    pub unit: &'static str,
    /// The units in which a design file may give its scale.
    pub units: &'static [Unit],
    /// What the sensor measures.
    pub measured: &'static str,
    /// Its reference, if it can be tracked.
    pub reference: Option<Reference>,
    /// Its row of the output equation `y = C x`: the entries that are not 0, by the symbols of their states. First
    /// comes the state that it is named after.
    pub row: &'static [(&'static str, f64)],
    /// Its value in trim.
    pub level: Level,
    /// The values that it can take; any without.
    pub range: Option<[f64; 2]>,
    /// Whether it is an angle that comes back to itself after a turn.
    pub circular: bool,
    /// The largest step of its reference.
    pub largest_step: LargestStep,
    /// A typical size, SI.
    pub nominal: f64,
    /// The largest change between two readings of a sensor that works, of what does not move, SI.
    pub error: f64,
}

impl Signal {
    /// The entry of a state in its row of the output equation.
    pub fn output(&self, state: &State) -> f64 {
        self.row.iter().find(|(symbol, _)| *symbol == state.symbol).map_or(0.0, |(_, entry)| *entry)
    }

    /// The symbol of the first state of its row.
    pub fn state(&self) -> &'static str {
        self.row.first().map_or("", |(symbol, _)| symbol)
    }

    /// Whether it follows from the states of a linear model.
    pub fn is_among(&self, states: States) -> bool {
        self.row.iter().all(|(symbol, _)| states.iter().any(|state| state.symbol == *symbol))
    }
}

/// States and signals of a vehicle model. First come the signals that can be tracked.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interface {
    /// All states that its linear models can have, in their order.
    pub states: States,
    /// Its signals.
    pub signals: &'static [Signal],
}

impl Interface {
    /// The index of a signal.
    pub fn index(&self, name: &str) -> Option<usize> {
        self.signals.iter().position(|signal| signal.name == name)
    }

    /// The index of the signal that is scheduled on.
    pub fn scheduled(&self) -> Option<usize> {
        self.signals.iter().position(|signal| signal.level == Level::Scheduled)
    }

    /// Every signal that can be tracked, with its reference.
    pub fn tracked(&self) -> impl Iterator<Item = (&'static Signal, Reference)> + use<> {
        self.signals.iter().filter_map(|signal| Some((signal, signal.reference?)))
    }
}
