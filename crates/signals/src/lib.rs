//! Signals between a vehicle and its autopilot.
//!
//! An [`Interface`] is a table: the states of a linear model and its outputs, the [`Signal`]s. Every signal can be
//! measured; those with a reference can be tracked. Each vehicle model has its own interface; a frozen design copies
//! the rows, so that FMUs, C and Python take every name, unit and range from it. The scaling of a signal depends on the
//! design and is in the design file.
//!
//! A command is the output of an actuator, or the input of a thruster with a [`Curve`]. [`effect_of_sign`] describes
//! the effect of a positive output.

mod curve;
mod force;

pub use curve::{COMMAND_UNITS, Curve, CurveError, Law, POINTS};
pub use force::{Force, effect_of_sign};

use serde::{Deserialize, Serialize};

/// Origin of the coefficients of a vehicle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Status {
    /// Derived from geometry and general formulae: nothing measured on the real vehicle.
    Surrogate,
    /// Published by others, with a source.
    Published,
    /// Identified from trials of the vehicle itself.
    Measured,
}

impl Status {
    /// All statuses.
    pub const ALL: [Self; 3] = [Self::Surrogate, Self::Published, Self::Measured];

    /// Name in files.
    pub fn word(self) -> &'static str {
        match self {
            Self::Surrogate => "surrogate",
            Self::Published => "published",
            Self::Measured => "measured",
        }
    }
}

/// State of a linear model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct State {
    /// Usual symbol.
    pub symbol: &'static str,
    /// SI unit.
    pub unit: &'static str,
    /// Name in messages.
    pub name: &'static str,
    /// Actuation that would affect the state, for messages.
    pub actuation_hint: &'static str,
    /// Sensor that would measure the state, for messages.
    pub measurement_hint: &'static str,
}

/// States of a linear model, in order.
pub type States = &'static [State];

/// Unit besides SI, with its value in SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unit {
    /// Name in files and plots.
    pub name: &'static str,
    /// Value in SI.
    pub factor: f64,
}

/// Reference of a signal that can be tracked.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Reference {
    /// Name in FMUs, `NAME_reference`.
    pub name: &'static str,
    /// Description of the prescribed quantity.
    pub description: &'static str,
}

/// Trim value y0 of a signal: the controller inputs are deviations from it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Level {
    /// Filtered reference V_r of the scheduled signal.
    Scheduled,
    /// Column of the trim table, a function of V_r.
    Trim,
    /// Measurement at initialisation: the dynamics do not depend on it.
    Start,
    /// Zero.
    Zero,
}

/// Largest step of a reference for which anti-windup is designed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LargestStep {
    /// Step of this size, SI.
    Of(f64),
    /// Step up to the surface.
    Depth,
    /// Step over the range of the scheduled speed.
    Range,
}

/// Row of an [`Interface`]: an output of the linear model, y = C x.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Signal {
    /// Name in design files, frozen designs and FMUs: an output of the plant, an input of the controller.
    pub name: &'static str,
    /// SI unit.
    pub unit: &'static str,
    /// Units in which a design file may give the scaling.
    pub units: &'static [Unit],
    /// Measured quantity, in text.
    pub measured: &'static str,
    /// Reference, if the signal can be tracked.
    pub reference: Option<Reference>,
    /// Row of the output equation `y = C x`: the nonzero entries, by the symbols of their states. The first entry is
    /// the state that gives the signal its name.
    pub row: &'static [(&'static str, f64)],
    /// Source of the trim value.
    pub level: Level,
    /// Range of its values; `None` if unbounded.
    pub range: Option<[f64; 2]>,
    /// `true` for an angle that wraps around.
    pub circular: bool,
    /// Largest step of the reference.
    pub largest_step: LargestStep,
    /// Typical size, SI.
    pub nominal: f64,
    /// Largest change between two readings of a working sensor at a constant value, SI.
    pub error: f64,
}

impl Signal {
    /// Returns the entry of a state in the row of the output equation.
    pub fn output(&self, state: &State) -> f64 {
        self.row.iter().find(|(symbol, _)| *symbol == state.symbol).map_or(0.0, |(_, entry)| *entry)
    }

    /// Returns the symbol of the first state of the row.
    pub fn state(&self) -> &'static str {
        self.row.first().map_or("", |(symbol, _)| symbol)
    }

    /// Returns `true` if all states of the row are among `states`.
    pub fn is_among(&self, states: States) -> bool {
        self.row.iter().all(|(symbol, _)| states.iter().any(|state| state.symbol == *symbol))
    }
}

/// States and signals of a vehicle model; the signals that can be tracked come first.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interface {
    /// All states that the linear models can have, in order.
    pub states: States,
    /// Signals, in order.
    pub signals: &'static [Signal],
}

impl Interface {
    /// Returns the index of a signal.
    pub fn index(&self, name: &str) -> Option<usize> {
        self.signals.iter().position(|signal| signal.name == name)
    }

    /// Returns the index of the scheduled signal.
    pub fn scheduled(&self) -> Option<usize> {
        self.signals.iter().position(|signal| signal.level == Level::Scheduled)
    }

    /// Returns every signal that can be tracked, with its reference.
    pub fn tracked(&self) -> impl Iterator<Item = (&'static Signal, Reference)> + use<> {
        self.signals.iter().filter_map(|signal| Some((signal, signal.reference?)))
    }
}

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
