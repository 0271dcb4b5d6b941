//! The longitudinal vehicle: its states, its signals, and its linear model as an axis of an autopilot has it.

use crate::view::{Sensed, signals_of};
use signals::{Interface, LargestStep, Level, Reference, Signal, State, States, Unit};
use std::f64::consts::{FRAC_PI_2, PI};

const DEGREE: f64 = PI / 180.0;

/// The states of the linear model, x = \[u w q theta z\], in their order.
pub const STATES: [State; 5] = [
    State {
        symbol: "u",
        unit: "m/s",
        name: "surge speed",
        acts: "a thruster that pushes along the hull, or drag (X_uu, drag_area)",
        shows: "measure 'speed'",
    },
    State {
        symbol: "w",
        unit: "m/s",
        name: "heave speed",
        acts: "a thruster that pushes vertically, or damping (Z_w, Z_uw)",
        shows: "measure 'heave', or give the vehicle damping (Z_w, Z_uw)",
    },
    State {
        symbol: "q",
        unit: "rad/s",
        name: "pitch rate",
        acts: "an actuator with a pitching moment, or damping (M_q, M_uq)",
        shows: "measure 'pitch_rate' or 'pitch'",
    },
    State {
        symbol: "theta",
        unit: "rad",
        name: "pitch",
        acts: "an actuator with a pitching moment (control surfaces have none at rest: a higher model.speed_min), or \
               a centre of gravity farther below that of buoyancy (z_G)",
        shows: "measure 'pitch'",
    },
    State { symbol: "z", unit: "m", name: "depth", acts: "a speed other than 0", shows: "measure 'depth'" },
];

/// The states of the linear model of a vehicle: \[w q theta\], with u unless its speed is given from outside, and with
/// the depth z for a design that has to do with it.
pub fn states(speed_given: bool, depth: bool) -> States {
    static ALL: [State; 5] = STATES;
    &ALL[usize::from(speed_given)..ALL.len() - usize::from(!depth)]
}

/// The places of w, q and theta among states, or of v, r and psi: these stand one after the other.
pub fn turning(states: States) -> [usize; 3] {
    let across = states.iter().position(|state| ["w", "v"].contains(&state.symbol)).unwrap_or(0);
    [across, across + 1, across + 2]
}

/// The place among states of the rate of turn of an axis: q, r, or p of roll alone.
pub fn turn_rate(states: States) -> usize {
    let place = |symbol| states.iter().position(|state| state.symbol == symbol);
    ["q", "r", "p"].into_iter().find_map(place).unwrap_or(0)
}

/// The index of pitch in [`SIGNALS`].
pub const PITCH: usize = 0;

/// The index of speed in [`SIGNALS`].
pub const SPEED: usize = 1;

/// The index of depth in [`SIGNALS`].
pub const DEPTH: usize = 2;

/// The forward speed, on which every axis is scheduled.
pub const SPEED_SIGNAL: Signal = Signal {
    name: "speed",
    unit: "m/s",
    units: &[Unit { name: "m/s", factor: 1.0 }],
    measured: "forward speed through the water, along the body axis",
    reference: Some(Reference {
        name: "speed_reference",
        wanted: "wanted forward speed through the water, along the body axis",
    }),
    row: &[("u", 1.0)],
    level: Level::Scheduled,
    range: None,
    circular: false,
    largest_step: LargestStep::Range,
    nominal: 1.0,
    error: 0.3,
};

/// The speed, as every view has it.
pub(crate) const SPEED_SENSED: Sensed = Sensed {
    signal: SPEED_SIGNAL,
    value: |state| state.motion.u,
    displace: |state, by| state.motion.u += by,
};

/// The index of altitude in [`SIGNALS`].
pub const ALTITUDE: usize = 5;

/// Every signal that an autopilot can measure; first those that it can track. What is measured is the rate of pitch,
/// not that about the axis of the body.
pub(crate) const SENSED: [Sensed; 6] = [
    Sensed {
        signal: Signal {
            name: "pitch",
            unit: "rad",
            units: &[Unit { name: "deg", factor: DEGREE }, Unit { name: "rad", factor: 1.0 }],
            measured: "pitch angle",
            reference: Some(Reference { name: "pitch_reference", wanted: "wanted pitch angle" }),
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
            reference: Some(Reference { name: "depth_reference", wanted: "wanted depth" }),
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
            measured: "rate of pitch",
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

/// The signals of [`SENSED`], in their order.
pub static SIGNALS: [Signal; SENSED.len()] = signals_of(&SENSED);

/// The interface of the longitudinal vehicle.
pub static INTERFACE: Interface = Interface { states: &STATES, signals: &SIGNALS };

/// How many signals can be tracked; they are the first of [`SIGNALS`].
pub const TRACKED: usize = 3;

/// A value for each signal of an axis, in the order of its view; the rest of one with fewer signals is not used.
pub type Each<T> = [T; crate::view::MOST_SIGNALS];

/// A value for each row of [`SIGNALS`] that can be tracked.
pub type EachTracked<T> = [T; TRACKED];

/// A value for the signal at a place in [`SIGNALS`], and 0 for the others that can be tracked.
pub fn only(place: usize, value: f64) -> EachTracked<f64> {
    std::array::from_fn(|one| if one == place { value } else { 0.0 })
}

/// The index of a signal in [`SIGNALS`].
pub fn place(name: &str) -> Option<usize> {
    INTERFACE.place(name)
}

/// Every signal that can be tracked, with its reference, in the order of [`SIGNALS`].
pub fn tracked() -> impl Iterator<Item = (&'static Signal, Reference)> {
    INTERFACE.tracked()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_fits_together() {
        assert_eq!(
            ["pitch", "speed", "depth", "altitude", "yaw"].map(place),
            [Some(PITCH), Some(SPEED), Some(DEPTH), Some(ALTITUDE), None]
        );
        assert_eq!(INTERFACE.scheduled(), Some(SPEED));
        for (place, signal) in SIGNALS.iter().enumerate() {
            assert_eq!(signal.reference.is_some(), place < TRACKED, "{}", signal.name);
            let state = STATES.iter().find(|state| state.symbol == signal.state()).unwrap();
            assert_eq!(state.unit, signal.unit, "{}", signal.name);
            assert!(signal.units.iter().any(|unit| unit.name == signal.unit && unit.factor == 1.0));
        }
        for (signal, reference) in tracked() {
            assert_eq!(reference.name, format!("{}_reference", signal.name));
        }
    }
}
