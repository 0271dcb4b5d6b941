//! Longitudinal motion as seen by an axis of an autopilot: its states and its signals.

pub use crate::states::{LONGITUDINAL as STATES, longitudinal as states, turn_rate, turning};
use crate::view::sensed::{Sensed, signals_of};
use squid_signals::{Interface, LargestStep, Level, Reference, Signal, Unit};
use std::f64::consts::{FRAC_PI_2, PI};

const DEGREE: f64 = PI / 180.0;

/// Index of pitch in [`SIGNALS`].
pub const PITCH: usize = 0;

/// Index of speed in [`SIGNALS`].
pub const SPEED: usize = 1;

/// Index of depth in [`SIGNALS`].
pub const DEPTH: usize = 2;

/// Forward speed, the scheduled signal of every axis.
pub const SPEED_SIGNAL: Signal = Signal {
    name: "speed",
    unit: "m/s",
    units: &[Unit { name: "m/s", factor: 1.0 }],
    measured: "forward speed through the water, along the body axis",
    reference: Some(Reference {
        name: "speed_reference",
        description: "reference of the forward speed through the water, along the body axis",
    }),
    row: &[("u", 1.0)],
    level: Level::Scheduled,
    range: None,
    circular: false,
    largest_step: LargestStep::Range,
    nominal: 1.0,
    error: 0.3,
};

/// Speed with its sensor, common to all views.
pub(crate) const SPEED_SENSED: Sensed = Sensed {
    signal: SPEED_SIGNAL,
    value: |state| state.motion.u,
    displace: |state, by| state.motion.u += by,
};

/// Index of altitude in [`SIGNALS`].
pub const ALTITUDE: usize = 5;

/// Signals that an autopilot can measure, first those that it can track. `pitch_rate` is the rate of the pitch angle,
/// not the angular velocity about the body axis.
pub(crate) const SENSED: [Sensed; 6] = [
    Sensed {
        signal: Signal {
            name: "pitch",
            unit: "rad",
            units: &[Unit { name: "deg", factor: DEGREE }, Unit { name: "rad", factor: 1.0 }],
            measured: "pitch angle",
            reference: Some(Reference { name: "pitch_reference", description: "pitch reference" }),
            row: &[("theta", 1.0)],
            level: Level::Trim,
            range: Some([-FRAC_PI_2, FRAC_PI_2]),
            circular: false,
            largest_step: LargestStep::Of(PI / 6.0),
            nominal: 0.1,
            error: 5.0 * DEGREE,
        },
        value: |state| state.motion.theta,
        displace: |state, by| state.motion.theta += by,
    },
    SPEED_SENSED,
    Sensed {
        signal: Signal {
            name: "depth",
            unit: "m",
            units: &[Unit { name: "m", factor: 1.0 }],
            measured: "depth below the surface, downwards",
            reference: Some(Reference { name: "depth_reference", description: "depth reference" }),
            row: &[("z", 1.0)],
            level: Level::Start,
            range: None,
            circular: false,
            largest_step: LargestStep::Depth,
            nominal: 10.0,
            error: 1.0,
        },
        value: |state| state.depth,
        displace: |state, by| state.depth += by,
    },
    Sensed {
        signal: Signal {
            name: "pitch_rate",
            unit: "rad/s",
            units: &[Unit { name: "deg/s", factor: DEGREE }, Unit { name: "rad/s", factor: 1.0 }],
            measured: "pitch rate",
            reference: None,
            row: &[("q", 1.0)],
            level: Level::Zero,
            range: None,
            circular: false,
            largest_step: LargestStep::Range,
            nominal: 0.1,
            error: 10.0 * DEGREE,
        },
        value: |state| state.motion.turning()[1],
        displace: |state, by| state.motion.q += by,
    },
    Sensed {
        signal: Signal {
            name: "heave",
            unit: "m/s",
            units: &[Unit { name: "m/s", factor: 1.0 }],
            measured: "speed through the water, along the body z axis",
            reference: None,
            row: &[("w", 1.0)],
            level: Level::Trim,
            range: None,
            circular: false,
            largest_step: LargestStep::Range,
            nominal: 0.1,
            error: 0.3,
        },
        value: |state| state.motion.w,
        displace: |state, by| state.motion.w += by,
    },
    Sensed {
        signal: Signal {
            name: "altitude",
            unit: "m",
            units: &[Unit { name: "m", factor: 1.0 }],
            measured: "height above the bottom",
            reference: None,
            row: &[("z", -1.0)],
            level: Level::Start,
            range: None,
            circular: false,
            largest_step: LargestStep::Range,
            nominal: 10.0,
            error: 1.0,
        },
        value: |state| state.bottom - state.depth,
        displace: |state, by| state.bottom += by,
    },
];

/// Signals of the view, in order.
pub static SIGNALS: [Signal; SENSED.len()] = signals_of(&SENSED);

/// Interface of the longitudinal motion.
pub static INTERFACE: Interface = Interface { states: &STATES, signals: &SIGNALS };

/// Returns the index of a signal in [`SIGNALS`].
pub fn index(name: &str) -> Option<usize> {
    INTERFACE.index(name)
}

/// Returns every signal that can be tracked, with its reference, in the order of [`SIGNALS`].
pub fn tracked() -> impl Iterator<Item = (&'static Signal, Reference)> {
    INTERFACE.tracked()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn table_is_consistent() {
        assert_eq!(
            ["pitch", "speed", "depth", "altitude", "yaw"].map(index),
            [Some(PITCH), Some(SPEED), Some(DEPTH), Some(ALTITUDE), None]
        );
        assert_eq!(INTERFACE.scheduled(), Some(SPEED));
        for (index, signal) in SIGNALS.iter().enumerate() {
            assert_eq!(signal.reference.is_some(), index < 3, "{}", signal.name);
            let state = STATES.iter().find(|state| state.symbol == signal.state()).unwrap();
            assert_eq!(state.unit, signal.unit, "{}", signal.name);
            assert!(signal.units.iter().any(|unit| unit.name == signal.unit && unit.factor == 1.0));
        }
        for (signal, reference) in tracked() {
            assert_eq!(reference.name, format!("{}_reference", signal.name));
        }
    }
}
