//! Motion in roll only: its states and its signals. Sway and yaw belong to another axis, or are uncontrolled.

use crate::view::lateral;
use crate::view::longitudinal::SPEED_SENSED;
use crate::view::sensed::{Sensed, signals_of};
use squid_signals::{Interface, LargestStep, Level, Reference, Signal, State, Unit};
use std::f64::consts::PI;

const DEGREE: f64 = PI / 180.0;

/// States of the linear model, x = \[p phi\]: the first of [`lateral::STATES`].
pub static STATES: [State; 2] = [lateral::STATES[0], lateral::STATES[1]];

const ROLL: Sensed = lateral::SENSED[lateral::ROLL];

/// Signals of an axis of roll.
pub(crate) const SENSED: [Sensed; 3] = [
    Sensed {
        signal: Signal {
            reference: Some(Reference { name: "roll_reference", description: "roll reference" }),
            range: Some([-PI / 2.0, PI / 2.0]),
            largest_step: LargestStep::Of(PI / 6.0),
            ..ROLL.signal
        },
        ..ROLL
    },
    SPEED_SENSED,
    Sensed {
        signal: Signal {
            name: "roll_rate",
            unit: "rad/s",
            units: &[Unit { name: "deg/s", factor: DEGREE }, Unit { name: "rad/s", factor: 1.0 }],
            measured: "roll rate",
            reference: None,
            row: &[("p", 1.0)],
            level: Level::Zero,
            range: None,
            circular: false,
            largest_step: LargestStep::Range,
            nominal: 0.1,
            error: 20.0 * DEGREE,
        },
        value: |state| state.motion.turning()[0],
        displace: |state, by| state.motion.p += by,
    },
];

/// Signals of the view, in order.
pub static SIGNALS: [Signal; SENSED.len()] = signals_of(&SENSED);

/// Interface of an axis of roll.
pub static INTERFACE: Interface = Interface { states: &STATES, signals: &SIGNALS };
