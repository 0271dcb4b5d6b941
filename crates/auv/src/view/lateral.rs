//! Motion in sway, roll and yaw as seen by an axis of an autopilot: its states and its signals.

use squid_signals::{Interface, LargestStep, Level, Reference, Signal, Unit};
use std::f64::consts::PI;

pub use crate::states::{LATERAL as STATES, lateral as states};
use crate::view::longitudinal::SPEED_SENSED;
use crate::view::sensed::{Sensed, signals_of};

const DEGREE: f64 = PI / 180.0;

/// Index of heading in [`SIGNALS`].
pub const HEADING: usize = 0;

/// Index of the rate of heading in [`SIGNALS`].
pub const HEADING_RATE: usize = 2;

/// Index of roll in [`SIGNALS`].
pub const ROLL: usize = 3;

/// Signals of an axis of heading; the heading is unwrapped.
pub(crate) const SENSED: [Sensed; 5] = [
    Sensed {
        signal: Signal {
            name: "heading",
            unit: "rad",
            units: &[Unit { name: "deg", factor: DEGREE }, Unit { name: "rad", factor: 1.0 }],
            measured: "heading, clockwise from north",
            reference: Some(Reference { name: "heading_reference", description: "heading reference" }),
            row: &[("psi", 1.0)],
            level: Level::Start,
            range: None,
            circular: true,
            largest_step: LargestStep::Of(PI),
            nominal: 1.0,
            error: 15.0 * DEGREE,
        },
        value: |state| state.heading,
        displace: |state, by| state.heading += by,
    },
    SPEED_SENSED,
    Sensed {
        signal: Signal {
            name: "heading_rate",
            unit: "rad/s",
            units: &[Unit { name: "deg/s", factor: DEGREE }, Unit { name: "rad/s", factor: 1.0 }],
            measured: "heading rate",
            reference: None,
            row: &[("r", 1.0)],
            level: Level::Zero,
            range: None,
            circular: false,
            largest_step: LargestStep::Range,
            nominal: 0.1,
            error: 10.0 * DEGREE,
        },
        value: |state| state.motion.turning()[2],
        displace: |state, by| {
            // The rate of pitch is 0, that of heading r cos(phi)/cos(theta).
            let motion = &mut state.motion;
            motion.r += by * motion.theta.cos() / motion.phi.cos();
        },
    },
    Sensed {
        signal: Signal {
            name: "roll",
            unit: "rad",
            units: &[Unit { name: "deg", factor: DEGREE }, Unit { name: "rad", factor: 1.0 }],
            measured: "roll angle",
            reference: None,
            row: &[("phi", 1.0)],
            level: Level::Zero,
            range: None,
            circular: false,
            largest_step: LargestStep::Range,
            nominal: 0.1,
            error: 15.0 * DEGREE,
        },
        value: |state| state.motion.phi,
        displace: |state, by| state.motion.phi += by,
    },
    Sensed {
        signal: Signal {
            name: "sway",
            unit: "m/s",
            units: &[Unit { name: "m/s", factor: 1.0 }],
            measured: "speed through the water, along the body y axis",
            reference: None,
            row: &[("v", 1.0)],
            level: Level::Zero,
            range: None,
            circular: false,
            largest_step: LargestStep::Range,
            nominal: 0.1,
            error: 0.3,
        },
        value: |state| state.motion.v,
        displace: |state, by| state.motion.v += by,
    },
];

/// Signals of the view, in order.
pub static SIGNALS: [Signal; SENSED.len()] = signals_of(&SENSED);

/// Interface of an axis of heading.
pub static INTERFACE: Interface = Interface { states: &STATES, signals: &SIGNALS };

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn table_is_consistent() {
        assert_eq!(INTERFACE.scheduled(), Some(crate::view::longitudinal::SPEED));
        assert_eq!(
            ["heading", "heading_rate", "roll"].map(|name| INTERFACE.index(name)),
            [Some(HEADING), Some(HEADING_RATE), Some(ROLL)]
        );
        for signal in SIGNALS.iter().filter(|signal| signal.name != "speed") {
            let state = STATES.iter().find(|state| state.symbol == signal.state()).unwrap();
            assert_eq!(state.unit, signal.unit, "{}", signal.name);
            assert_eq!(signal.is_among(states(false)), signal.name != "roll", "{}", signal.name);
            assert!(signal.is_among(states(true)));
        }
        assert!(crate::states::are_lateral(states(false)));
    }
}
