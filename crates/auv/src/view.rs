//! Motion of a vehicle as seen by an axis of an autopilot.

pub mod lateral;
pub mod longitudinal;
pub mod roll;
pub(crate) mod sensed;

use crate::simulation::plant::State;
use crate::vehicle::Vehicle;
use crate::vehicle::actuator::Actuator;
pub use sensed::Sensed;
use squid_signals::{Interface, Level, Signal, States};

/// Largest number of signals of a view.
pub const MOST_SIGNALS: usize = {
    let counts = [longitudinal::SENSED.len(), lateral::SENSED.len(), roll::SENSED.len()];
    let (mut most, mut index) = (0, 0);
    while index < counts.len() {
        if counts[index] > most {
            most = counts[index];
        }
        index += 1;
    }
    most
};

/// Number of signals that can be tracked; they are the first of [`longitudinal::SIGNALS`].
pub const TRACKED: usize = 3;

/// Value for each signal of an axis, in the order of its view; a view with fewer signals leaves the rest unused.
pub type PerSignal<T> = [T; MOST_SIGNALS];

/// Value for each row of [`longitudinal::SIGNALS`] that can be tracked.
pub type PerReference<T> = [T; TRACKED];

/// Number of [`references`].
pub const REFERENCES: usize = {
    const fn own(table: &[Sensed]) -> usize {
        let (mut count, mut index) = (0, 0);
        while index < table.len() {
            let Signal { reference, level, .. } = &table[index].signal;
            if reference.is_some() && !matches!(level, Level::Scheduled) {
                count += 1;
            }
            index += 1;
        }
        count
    }
    1 + own(&longitudinal::SENSED) + own(&lateral::SENSED) + own(&roll::SENSED)
};

/// Returns every signal that can be tracked, with the index of its view and its index there; the speed, common to all
/// views, is listed with the first.
pub fn references() -> impl Iterator<Item = (usize, usize, &'static Signal)> {
    VIEWS.iter().enumerate().flat_map(|(index, view)| {
        let is_own = move |signal: &Signal| index == 0 || signal.level != Level::Scheduled;
        let all = view.interface.signals.iter().enumerate();
        let own = all.filter(move |(_, signal)| signal.reference.is_some() && is_own(signal));
        own.map(move |(signal_index, signal)| (index, signal_index, signal))
    })
}

/// View of the motion: a table of its states, its signals and its actuators.
#[derive(Debug)]
pub struct View {
    /// Name of the motion, in text.
    pub name: &'static str,
    /// States of the linear models and signals.
    pub interface: &'static Interface,
    /// Signals with their sensors, in the order of the interface.
    pub sensed: &'static [Sensed],
    /// Returns the states of the linear models of a vehicle; the function is `true` for the indices of signals tracked
    /// or measured.
    pub states: fn(&Vehicle, &dyn Fn(usize) -> bool) -> States,
    /// `true` if surge, heave and pitch are held at trim when an axis of this view flies alone.
    pub is_level_held: bool,
    /// Returns `true` if an axis of this view commands an actuator.
    pub commands: fn(&Actuator) -> bool,
    /// Message for a missing actuator: its effect, and its keys in the vehicle file.
    pub missing_actuator: &'static str,
    /// Index in a [`Load`](crate::Load) of the moment of this view.
    pub moment: usize,
}

/// View of surge, heave and pitch.
pub static LONGITUDINAL: View = View {
    name: "surge, heave and pitch",
    interface: &longitudinal::INTERFACE,
    sensed: &longitudinal::SENSED,
    states: |vehicle, uses| {
        let z = [longitudinal::DEPTH, longitudinal::ALTITUDE].into_iter().any(uses);
        vehicle.coefficients.surge.states(z)
    },
    is_level_held: false,
    commands: Actuator::acts_in_plane,
    missing_actuator: "moves it in the vertical plane: add a thruster, or stern planes (M_uu_delta)",
    moment: 4,
};

/// View of sway, roll and yaw.
pub static LATERAL: View = View {
    name: "sway, roll and yaw",
    interface: &lateral::INTERFACE,
    sensed: &lateral::SENSED,
    states: |_, uses| lateral::states(uses(lateral::ROLL)),
    is_level_held: true,
    commands: Actuator::yaws_alone,
    missing_actuator: "yaws it without effect in the vertical plane: add a rudder (N_uu_delta), or a thruster group \
            with N_T",
    moment: 5,
};

/// View of roll, for actuators that only roll the vehicle.
pub static ROLL: View = View {
    name: "roll",
    interface: &roll::INTERFACE,
    sensed: &roll::SENSED,
    states: |_, _| &roll::STATES,
    is_level_held: true,
    commands: Actuator::rolls_alone,
    missing_actuator: "rolls it without other effects: add differential fins (K_uu_delta), or a thruster group with \
            K_T",
    moment: 3,
};

/// All views.
pub static VIEWS: [&View; 3] = [&LONGITUDINAL, &LATERAL, &ROLL];

impl View {
    /// Returns the smallest view that has all these states of linear models; the first if there is none.
    pub fn of_states(states: States) -> &'static Self {
        let has_all = |view: &&&Self| states.iter().all(|state| view.interface.states.contains(state));
        let own = VIEWS.iter().filter(has_all).min_by_key(|view| view.interface.states.len());
        own.copied().unwrap_or(&LONGITUDINAL)
    }

    /// Returns `true` if the first signals have these names; a design may lack signals that were added later.
    pub fn has_signals<'a>(&self, names: impl IntoIterator<Item = &'a str>) -> bool {
        let own = self.interface.signals.iter().map(|one| Some(one.name)).chain(std::iter::repeat(None));
        names.into_iter().map(Some).zip(own).all(|(name, own)| name == own)
    }

    /// Returns the measurements in a state, SI, in the order of the interface.
    pub fn measured(&self, state: &State) -> PerSignal<f64> {
        let mut all = [0.0; MOST_SIGNALS];
        all.iter_mut().zip(self.sensed).for_each(|(value, one)| *value = (one.value)(state));
        all
    }

    /// Returns a state with an offset, SI, of each signal; an offset of 0 changes no bit.
    #[must_use]
    pub fn with_offset(&self, mut state: State, by: PerSignal<f64>) -> State {
        let shifted = self.sensed.iter().zip(by).filter(|(_, by)| *by != 0.0);
        shifted.for_each(|(one, by)| (one.displace)(&mut state, by));
        state
    }

    /// Returns the vehicle for an axis of this view: in the vertical plane, or with the actuators of this view, while
    /// the others keep level flight.
    #[must_use]
    pub fn vehicle(&self, whole: &Vehicle) -> Vehicle {
        if !self.is_level_held {
            return whole.in_plane();
        }
        let (actuators, rest): (Vec<_>, Vec<_>) =
            whole.actuators.iter().cloned().partition(|one| (self.commands)(one));
        let others = whole.others.iter().cloned().chain(rest).collect();
        Vehicle { actuators, others, ..whole.clone() }
    }

    /// Returns the signal, in the initial state, from which its references count: depth or heading; 0 if there is none.
    pub fn origin(&self, start: &State) -> f64 {
        let own = self.sensed.iter().find(|one| one.signal.level == Level::Start);
        own.map_or(0.0, |one| (one.value)(start))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::dynamics::Motion;

    fn sample_state() -> State {
        State {
            motion: Motion::in_plane(1.5, 0.1, 0.0, -0.05),
            x: 1.0,
            depth: 8.0,
            heading: 0.4,
            east: 2.0,
            bottom: 60.0,
        }
    }

    /// The measurement of an offset signal shows the offset, in each view.
    #[test]
    fn offset_signal_shows_the_offset() {
        let state = sample_state();
        for view in VIEWS {
            for index in 0..view.sensed.len() {
                let mut by = [0.0; MOST_SIGNALS];
                by[index] = 0.03;
                let (before, after) = (view.measured(&state), view.measured(&view.with_offset(state, by)));
                let name = view.sensed[index].signal.name;
                assert!((after[index] - before[index] - 0.03).abs() < 1e-13, "{name}: {before:?} {after:?}");
            }
            assert_eq!(view.with_offset(state, [0.0; MOST_SIGNALS]), state);
        }
        assert_eq!(VIEWS.map(|view| view.origin(&state)), [8.0, 0.4, 0.0]);
    }

    /// Signals that a view has in addition to those of a design are its last.
    #[test]
    fn recognises_the_signals_of_a_view() {
        assert!(LONGITUDINAL.has_signals(["pitch", "speed", "depth"]) && ROLL.has_signals(["roll"]));
        assert!(
            !LONGITUDINAL.has_signals(["speed"]) && !ROLL.has_signals(["roll", "speed", "roll_rate", "sway"])
        );
        for (index, view) in VIEWS.iter().enumerate() {
            let names = || view.interface.signals.iter().map(|one| one.name);
            assert_eq!(VIEWS.iter().position(|other| other.has_signals(names())), Some(index));
        }
    }

    #[test]
    fn each_reference_belongs_to_one_view() {
        let names: Vec<_> = references().map(|(.., signal)| signal.name).collect();
        assert_eq!(names, ["pitch", "speed", "depth", "heading", "roll"]);
        assert_eq!(names.len(), REFERENCES);
    }

    /// The output equation `y = C x` of each view has the slopes of its signals about straight flight.
    #[test]
    fn output_equation_matches_the_signals() {
        let start = sample_state();
        let step = 1e-6;
        for view in VIEWS {
            for state in view.interface.states {
                // In straight flight psi' is r/cos(theta); the state r of an axis is psi'.
                let cos = start.motion.theta.cos();
                let shifted = |by: f64| {
                    let mut to = start;
                    let motion = &mut to.motion;
                    match state.symbol {
                        "u" => motion.u += by,
                        "w" => motion.w += by,
                        "q" => motion.q += by,
                        "theta" => motion.theta += by,
                        "z" => to.depth += by,
                        "p" => motion.p += by,
                        "phi" => motion.phi += by,
                        "v" => motion.v += by,
                        "r" => motion.r += by * cos,
                        "psi" => to.heading += by,
                        other => panic!("{other}"),
                    }
                    view.measured(&to)
                };
                let (high, low) = (shifted(step), shifted(-step));
                for (index, signal) in view.interface.signals.iter().enumerate() {
                    let slope = (high[index] - low[index]) / (2.0 * step);
                    let row = signal.output(state);
                    assert!((slope - row).abs() < 1e-8, "{} by {}: {slope}", signal.name, state.symbol);
                }
            }
        }
    }
}
