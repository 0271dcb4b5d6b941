//! The signals of an autopilot, measured and tracked: one table, from the states of the linear model to the inputs of
//! the FMU.
//!
//! A new signal is a row of [`SIGNALS`]. Its scale depends on the design and is in the design file.

use std::f64::consts::PI;

/// A state of the linear model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct State {
    /// The usual symbol.
    pub symbol: &'static str,
    /// SI unit.
    pub unit: &'static str,
}

/// The states of the linear model, x = \[u w q theta\], in their order.
pub const STATES: [State; 4] = [
    State { symbol: "u", unit: "m/s" },
    State { symbol: "w", unit: "m/s" },
    State { symbol: "q", unit: "rad/s" },
    State { symbol: "theta", unit: "rad" },
];

/// The values that a signal can take.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Values {
    /// Angles between -pi/2 and pi/2.
    Inclination,
    /// Speeds; a reference is in the range of the design.
    ForwardSpeed,
}

/// A unit besides SI, with its value in SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unit {
    /// Its name in files and plots.
    pub name: &'static str,
    /// Its value in SI.
    pub factor: f64,
}

/// A row of [`SIGNALS`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Signal {
    /// Its name in design files, frozen designs and FMUs; its reference is `NAME_reference`.
    pub name: &'static str,
    /// The name of the reference.
    pub reference: &'static str,
    /// SI unit.
    pub unit: &'static str,
    /// The units in which a design file may give its scale.
    pub units: &'static [Unit],
    /// What the sensor measures.
    pub measured: &'static str,
    /// What the reference prescribes.
    pub wanted: &'static str,
    /// Index of its state in [`STATES`]: the output equation is `y = x[state]`.
    pub state: usize,
    /// The values that it can take.
    pub values: Values,
    /// A typical size, SI.
    pub nominal: f64,
}

impl Signal {
    /// Its row of the output equation `y = C x`: 1 at its own state.
    pub fn output(&self, state: usize) -> f64 {
        if self.state == state { 1.0 } else { 0.0 }
    }
}

/// The index of pitch in [`SIGNALS`].
pub const PITCH: usize = 0;

/// The index of speed in [`SIGNALS`].
pub const SPEED: usize = 1;

/// Every signal that an autopilot can measure and track.
pub static SIGNALS: [Signal; 2] = [
    Signal {
        name: "pitch",
        reference: "pitch_reference",
        unit: "rad",
        units: &[Unit { name: "deg", factor: PI / 180.0 }, Unit { name: "rad", factor: 1.0 }],
        measured: "pitch angle",
        wanted: "wanted pitch angle",
        state: 3,
        values: Values::Inclination,
        nominal: 0.1,
    },
    Signal {
        name: "speed",
        reference: "speed_reference",
        unit: "m/s",
        units: &[Unit { name: "m/s", factor: 1.0 }],
        measured: "forward speed through the water, along the body axis",
        wanted: "wanted forward speed through the water",
        state: 0,
        values: Values::ForwardSpeed,
        nominal: 1.0,
    },
];

/// The names, for messages.
pub const NAMES: &str = "'pitch' or 'speed'";

/// A value for each row of [`SIGNALS`].
pub type Each<T> = [T; SIGNALS.len()];

/// The index of a signal in [`SIGNALS`].
pub fn place(name: &str) -> Option<usize> {
    SIGNALS.iter().position(|signal| signal.name == name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_fits_together() {
        assert_eq!((place("pitch"), place("speed"), place("depth")), (Some(PITCH), Some(SPEED), None));
        assert_eq!(NAMES, SIGNALS.map(|signal| format!("'{}'", signal.name)).join(" or "));
        for signal in SIGNALS {
            assert_eq!(signal.reference, format!("{}_reference", signal.name));
            assert_eq!(STATES[signal.state].unit, signal.unit, "{}", signal.name);
            assert!(signal.units.iter().any(|unit| unit.name == signal.unit && unit.factor == 1.0));
        }
    }
}
