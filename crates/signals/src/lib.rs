//! What passes between a vehicle and its autopilot.
//!
//! The signals are one table, from the states of the linear model to the inputs of the FMU. Every signal can be
//! measured; those with a reference can be tracked. A new signal is a row of [`SIGNALS`]. Its scale depends on the
//! design and is in the design file.
//!
//! The commands are outputs of the actuators, or what a thruster takes instead: its [`Curve`] says which.
//! [`sign_in_words`] says what a positive output does.

mod curve;
mod force;

pub use curve::{COMMAND_UNITS, Curve, CurveError, Law, POINTS};
pub use force::{Force, sign_in_words};

use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

const DEGREE: f64 = PI / 180.0;

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

/// A state of the linear model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct State {
    /// The usual symbol.
    pub symbol: &'static str,
    /// SI unit.
    pub unit: &'static str,
}

/// The states of the linear model, x = \[u w q theta z\], in their order.
pub const STATES: [State; 5] = [
    State { symbol: "u", unit: "m/s" },
    State { symbol: "w", unit: "m/s" },
    State { symbol: "q", unit: "rad/s" },
    State { symbol: "theta", unit: "rad" },
    State { symbol: "z", unit: "m" },
];

/// The states of a linear model: some of [`STATES`], in their order.
pub type States = &'static [State];

/// The states of the linear model of a vehicle: \[w q theta\], with u unless its speed is given from outside, and with
/// the depth z for a design that has to do with it.
pub fn states(speed_given: bool, depth: bool) -> States {
    &STATES[usize::from(speed_given)..STATES.len() - usize::from(!depth)]
}

/// The values that a signal can take.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Values {
    /// Angles between -pi/2 and pi/2.
    Inclination,
    /// Speeds; a reference is in the range of the design.
    ForwardSpeed,
    /// Any number.
    Any,
}

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

/// A row of [`SIGNALS`].
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
    /// Index of its state in [`STATES`]: the output equation is `y = x[state]`.
    pub state: usize,
    /// The values that it can take.
    pub values: Values,
    /// A typical size, SI.
    pub nominal: f64,
}

impl Signal {
    /// Its row of the output equation `y = C x`: 1 at its own state.
    pub fn output(&self, state: &State) -> f64 {
        if STATES[self.state] == *state { 1.0 } else { 0.0 }
    }

    /// Whether it follows from the states of a linear model.
    pub fn is_among(&self, states: States) -> bool {
        states.contains(&STATES[self.state])
    }
}

/// The index of pitch in [`SIGNALS`].
pub const PITCH: usize = 0;

/// The index of speed in [`SIGNALS`].
pub const SPEED: usize = 1;

/// The index of depth in [`SIGNALS`].
pub const DEPTH: usize = 2;

/// Every signal that an autopilot can measure; first those that it can track.
pub static SIGNALS: [Signal; 5] = [
    Signal {
        name: "pitch",
        unit: "rad",
        units: &[Unit { name: "deg", factor: DEGREE }, Unit { name: "rad", factor: 1.0 }],
        measured: "pitch angle",
        reference: Some(Reference { name: "pitch_reference", wanted: "wanted pitch angle" }),
        state: 3,
        values: Values::Inclination,
        nominal: 0.1,
    },
    Signal {
        name: "speed",
        unit: "m/s",
        units: &[Unit { name: "m/s", factor: 1.0 }],
        measured: "forward speed through the water, along the body axis",
        reference: Some(Reference {
            name: "speed_reference",
            wanted: "wanted forward speed through the water, along the body axis",
        }),
        state: 0,
        values: Values::ForwardSpeed,
        nominal: 1.0,
    },
    Signal {
        name: "depth",
        unit: "m",
        units: &[Unit { name: "m", factor: 1.0 }],
        measured: "depth below the surface, downwards",
        reference: Some(Reference { name: "depth_reference", wanted: "wanted depth" }),
        state: 4,
        values: Values::Any,
        nominal: 10.0,
    },
    Signal {
        name: "pitch_rate",
        unit: "rad/s",
        units: &[Unit { name: "deg/s", factor: DEGREE }, Unit { name: "rad/s", factor: 1.0 }],
        measured: "rate of pitch",
        reference: None,
        state: 2,
        values: Values::Any,
        nominal: 0.1,
    },
    Signal {
        name: "heave",
        unit: "m/s",
        units: &[Unit { name: "m/s", factor: 1.0 }],
        measured: "speed through the water, along the body z axis",
        reference: None,
        state: 1,
        values: Values::Any,
        nominal: 0.1,
    },
];

/// The names, for messages.
pub const NAMES: &str = "'pitch', 'speed', 'depth', 'pitch_rate' or 'heave'";

/// The names of those that can be tracked, for messages.
pub const TRACKED_NAMES: &str = "'pitch', 'speed' or 'depth'";

/// How many signals can be tracked; they are the first of [`SIGNALS`].
pub const TRACKED: usize = 3;

/// A value for each row of [`SIGNALS`].
pub type Each<T> = [T; SIGNALS.len()];

/// A value for each row of [`SIGNALS`] that can be tracked.
pub type EachTracked<T> = [T; TRACKED];

/// A value for the signal at a place in [`SIGNALS`], and 0 for the others that can be tracked.
pub fn only(place: usize, value: f64) -> EachTracked<f64> {
    std::array::from_fn(|one| if one == place { value } else { 0.0 })
}

/// The index of a signal in [`SIGNALS`].
pub fn place(name: &str) -> Option<usize> {
    SIGNALS.iter().position(|signal| signal.name == name)
}

/// Every signal that can be tracked, with its reference, in the order of [`SIGNALS`].
pub fn tracked() -> impl Iterator<Item = (&'static Signal, Reference)> {
    SIGNALS.iter().filter_map(|signal| Some((signal, signal.reference?)))
}

/// The signals in a state `x`, in the order and units of [`STATES`]: y = C x.
pub fn measured(x: [f64; STATES.len()]) -> Each<f64> {
    SIGNALS.each_ref().map(|signal| x[signal.state])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn listed(names: &[&str]) -> String {
        let (last, others) = names.split_last().unwrap();
        format!("'{}' or '{last}'", others.join("', '"))
    }

    #[test]
    fn the_table_fits_together() {
        assert_eq!(
            ["pitch", "speed", "depth", "yaw"].map(place),
            [Some(PITCH), Some(SPEED), Some(DEPTH), None]
        );
        assert_eq!(NAMES, listed(&SIGNALS.each_ref().map(|signal| signal.name)));
        assert_eq!(TRACKED_NAMES, listed(&tracked().map(|(signal, _)| signal.name).collect::<Vec<_>>()));
        for (place, signal) in SIGNALS.iter().enumerate() {
            assert_eq!(signal.reference.is_some(), place < TRACKED, "{}", signal.name);
            assert_eq!(STATES[signal.state].unit, signal.unit, "{}", signal.name);
            assert!(signal.units.iter().any(|unit| unit.name == signal.unit && unit.factor == 1.0));
        }
        for (signal, reference) in tracked() {
            assert_eq!(reference.name, format!("{}_reference", signal.name));
        }
    }

    #[test]
    fn a_signal_is_the_row_of_its_state() {
        let x = [1.0, 2.0, 3.0, 4.0, 5.0];
        for (signal, value) in SIGNALS.iter().zip(measured(x)) {
            let row: f64 = STATES.iter().zip(x).map(|(state, x)| signal.output(state) * x).sum();
            assert_eq!(value, row, "{}", signal.name);
            assert_eq!(signal.is_among(states(true, true)), signal.name != "speed", "{}", signal.name);
            assert_eq!(signal.is_among(states(false, false)), signal.name != "depth", "{}", signal.name);
        }
    }
}
