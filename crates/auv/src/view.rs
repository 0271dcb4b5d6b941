//! The motion of a vehicle as an axis of an autopilot has it.

use crate::lateral;
use crate::longitudinal::{self, Each, measured, state_of};
use crate::motion::dynamics::Motion;
use crate::motion::trim::Trim;
use crate::simulation::plant::State;
use crate::vehicle::Vehicle;
use signals::{Interface, Level, States};

/// A part of the motion: its table of states and signals, and how the signals follow from the motion.
#[derive(Debug)]
pub struct View {
    /// The states of its linear models and its signals.
    pub interface: &'static Interface,
    /// Returns the states of the linear models of a vehicle, where signals at some places are tracked or measured.
    pub states: fn(&Vehicle, &dyn Fn(usize) -> bool) -> States,
    /// Whether surge, heave and pitch are none of its states, and an axis alone flies while they are held at their
    /// trim.
    pub is_level_held: bool,
    /// Returns the signals, SI, in the order of the interface; angles are not wrapped.
    pub measured: fn(&State) -> Each<f64>,
    /// Returns the signals in level trim, SI.
    pub level: fn(&Trim) -> Each<f64>,
    /// Adds an offset, SI, to each signal of a state; an offset of 0 changes no bit.
    pub displaced: fn(State, Each<f64>) -> State,
}

/// Surge, heave and pitch. What is measured is the rate of pitch, not that about the axis of the body.
pub static LONGITUDINAL: View = View {
    interface: &longitudinal::INTERFACE,
    states: |vehicle, uses| vehicle.coefficients.surge.states(uses(longitudinal::DEPTH)),
    is_level_held: false,
    measured: |State { motion, depth, .. }| {
        measured([motion.u, motion.w, motion.turning()[1], motion.theta, *depth])
    },
    level: |trim| measured([trim.forward_speed, trim.heave, 0.0, trim.pitch, trim.depth]),
    displaced: |state, by| {
        let State { motion: Motion { u, w, q, theta, .. }, depth, .. } = state;
        let mut motion = [u, w, q, theta, depth];
        for (value, by) in motion.iter_mut().zip(state_of(by)).filter(|(_, by)| *by != 0.0) {
            *value += by;
        }
        let [u, w, q, theta, depth] = motion;
        State { motion: Motion::in_plane(u, w, q, theta), depth, ..state }
    },
};

/// Sway, roll and yaw.
pub static LATERAL: View = View {
    interface: &lateral::INTERFACE,
    states: |_, uses| lateral::states(uses(lateral::ROLL)),
    is_level_held: true,
    measured: |State { motion, heading, .. }| lateral::measured(motion, *heading),
    level: |trim| lateral::level(trim.forward_speed),
    displaced: |mut state, by| {
        let [heading, _, rate, roll, sway] = by;
        state.heading += heading;
        let motion = &mut state.motion;
        motion.phi += roll;
        motion.v += sway;
        // The rate of pitch is 0, that of heading r cos(phi)/cos(theta).
        motion.r += rate * motion.theta.cos() / motion.phi.cos();
        state
    },
};

/// Each view.
pub static VIEWS: [&View; 2] = [&LONGITUDINAL, &LATERAL];

impl View {
    /// Returns the view of some states of linear models; the first if there is none, as of another vehicle's.
    pub fn of_states(states: States) -> &'static Self {
        let has_all = |view: &&&Self| states.iter().all(|state| view.interface.states.contains(state));
        VIEWS.iter().find(has_all).copied().unwrap_or(&LONGITUDINAL)
    }

    /// Returns that of the axis for which a vehicle was prepared: one that leaves the vertical plane is flown in
    /// heading.
    pub fn of(vehicle: &Vehicle) -> &'static Self {
        if vehicle.coefficients.leaves_plane() { &LATERAL } else { &LONGITUDINAL }
    }

    /// Returns the signal from whose value at the start its references count, in a state: the depth, or the heading.
    pub fn origin(&self, start: &State) -> f64 {
        let place = self.interface.signals.iter().position(|signal| signal.level == Level::Start);
        place.map_or(0.0, |place| (self.measured)(start)[place])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A state that is displaced is measured so, in both views.
    #[test]
    fn an_offset_is_measured() {
        let state = State {
            motion: Motion::in_plane(1.5, 0.1, 0.0, -0.05),
            x: 1.0,
            depth: 8.0,
            heading: 0.4,
            east: 2.0,
        };
        let by = [0.01, 0.0, 0.02, 0.03, 0.04];
        for view in [&LONGITUDINAL, &LATERAL] {
            let (before, after) = ((view.measured)(&state), (view.measured)(&(view.displaced)(state, by)));
            for ((before, after), by) in before.iter().zip(after).zip(by) {
                assert!((after - before - by).abs() < 1e-15, "{before} {after} {by}");
            }
            assert_eq!((view.displaced)(state, [0.0; 5]), state);
        }
        assert_eq!((LONGITUDINAL.origin(&state), LATERAL.origin(&state)), (8.0, 0.4));
    }
}
