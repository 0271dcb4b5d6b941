//! The reference governor: how a reference moves that is not used as it is asked.
//!
//! ```text
//! used   = (1 - share) target + share start,   target: what is asked, within its range; then within its rate
//! share  = (1 + t/1 s) exp(-t/1 s),   t after the transition began
//! start' = rate exp(-t/1 s)
//! ```
//!
//! A reference that [`Autopilot::follow`](crate::Autopilot::follow) sets begins at the measured value, and with the
//! rate of that, where a sensor knows it, within its own. One that yields begins where it is, at rest: while an
//! actuator that steers its signal has been at its limit for [`HELD`],
//!
//! ```text
//! start <- start + (1 - exp(-Ts/0.3 s)) (measured - start), within its range;   used = start, at any rate
//! ```
//!
//! A reference that cannot be reached would wind up the integrals of all tracked signals, and a controller with several
//! commands would trade them for one another. E. Garone, S. Di Cairano, I. Kolmanovsky, "Reference and command
//! governors for systems with constraints", Automatica 75, 2017; the reference at which a command is just within its
//! limits: R. Hanus, M. Kinnaert, J.-L. Henrotte, "Conditioning technique, a general anti-windup and bumpless transfer
//! method", Automatica 23(6), 1987.

use crate::{ControllerDesign, Port, ticks};

/// Time for which an actuator stays at its limit before references yield, s.
pub const HELD: f64 = 1.0;

/// Time constant with which a reference yields to the measured value, s.
const YIELDING: f64 = 0.3;

/// Each of the two time constants with which a reference returns to what is asked, s.
pub const RETURNING: f64 = 1.0;

/// Differences below this part of a signal's nominal size count as zero.
const NO_DIFFERENCE: f64 = 1e-4;

/// The constants of the governor for a design.
#[derive(Debug)]
pub(crate) struct Governor {
    /// [`HELD`] in ticks.
    held: u32,
    /// Part of the way to the measured value that a reference yields in a tick.
    yielding: f64,
    /// Factor of the lag of a transition in a tick.
    decay: f64,
    sample_time: f64,
    /// The difference of each reference from its target that is taken for none.
    negligible: Vec<f64>,
    /// The actuators that steer each signal with a reference; none of one that is not measured.
    steered_by: Vec<Vec<usize>>,
    /// Whether each actuator steers.
    steers: Vec<bool>,
    /// The force along the hull per command of each actuator that does not steer.
    pushes: Vec<f64>,
}

/// The transition of a reference from a start to its target.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Transition {
    /// Where it began, moved on by its rate, SI.
    pub start: f64,
    /// The rate at which it began, SI per second.
    pub rate: f64,
    /// The share of the start in the reference, from 0 to 1; 0 without a transition.
    pub share: f64,
    /// exp(-t/1 s), t after it began.
    pub lag: f64,
}

impl Transition {
    /// A transition that begins at rest.
    pub(crate) fn from(start: f64) -> Self {
        Self { start, rate: 0.0, share: 1.0, lag: 1.0 }
    }

    /// The reference on the way to a target.
    pub(crate) fn to(self, target: f64) -> f64 {
        if self.share == 0.0 { target } else { (1.0 - self.share) * target + self.share * self.start }
    }

    /// The target for which a reference stays where it is.
    pub(crate) fn target_of(self, reference: f64) -> f64 {
        if self.share < 1.0 { (reference - self.share * self.start) / (1.0 - self.share) } else { reference }
    }
}

/// The saturation of an actuator.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Saturation {
    /// Whether the last tick computed a command beyond a limit.
    pub now: bool,
    /// For how many ticks it did, up to [`HELD`], less those in which it did not since.
    pub ticks: u32,
}

impl Governor {
    #[inline]
    pub(crate) fn new(design: &ControllerDesign) -> Self {
        let per_tick = |time: f64| design.sample_time / time;
        let steered_by = |(place, (signal, _)): (usize, (&Port, _))| {
            let yields = design.measures(place) && design.follows(place);
            let all =
                design.actuators.iter().enumerate().filter(|(_, one)| one.steers.contains(&signal.name));
            all.map(|(index, _)| index).filter(|_| yields).collect()
        };
        let steered_by: Vec<Vec<usize>> = design.references().enumerate().map(steered_by).collect();
        Self {
            held: ticks(HELD, design.sample_time),
            yielding: -(-per_tick(YIELDING)).exp_m1(),
            decay: (-per_tick(RETURNING)).exp(),
            sample_time: design.sample_time,
            negligible: design.references().map(|(signal, _)| NO_DIFFERENCE * signal.nominal).collect(),
            steers: (0..design.actuators.len())
                .map(|one| steered_by.iter().flatten().any(|by| *by == one))
                .collect(),
            steered_by,
            pushes: design.actuators.iter().map(crate::Actuator::pushes).collect(),
        }
    }

    /// Whether an actuator steers a signal with a reference.
    pub(crate) fn steers(&self, actuator: usize) -> bool {
        self.steers[actuator]
    }

    /// The force along the hull per command of an actuator, 0 of one that steers.
    pub(crate) fn pushes(&self, actuator: usize) -> f64 {
        self.pushes[actuator]
    }

    /// [`HELD`] in ticks.
    pub(crate) fn held(&self) -> u32 {
        self.held
    }

    /// Part of the way to the measured value that a reference yields in a tick.
    pub(crate) fn yielding(&self) -> f64 {
        self.yielding
    }

    /// Factor of the lag in a tick, and the difference of a reference from its target that is taken for none.
    pub(crate) fn returning(&self, reference: usize) -> (f64, f64) {
        (self.decay, self.negligible[reference])
    }

    /// Whether a reference yields.
    pub(crate) fn yields(&self, reference: usize, saturation: &[Saturation]) -> bool {
        self.steered_by[reference]
            .iter()
            .any(|one| saturation[*one].now && saturation[*one].ticks >= self.held)
    }

    /// Where a reference goes that yields to a measured value.
    pub(crate) fn yielded(&self, last: f64, measured: f64) -> f64 {
        last + self.yielding * (measured - last)
    }

    /// Counts a tick of an actuator.
    pub(crate) fn count(&self, saturation: &mut Saturation, now: bool) {
        saturation.now = now;
        saturation.ticks =
            if now { (saturation.ticks + 1).min(self.held) } else { saturation.ticks.saturating_sub(1) };
    }

    /// Moves the transition of a reference to a `target` on by a tick. It ends where what is left of it and of its rate
    /// is negligible.
    pub(crate) fn advance(&self, reference: usize, transition: &mut Transition, target: f64) {
        let Transition { start, rate, share, lag } = transition;
        *start += self.sample_time * *rate * *lag;
        *share = self.decay * (*share + self.sample_time / RETURNING * *lag);
        *lag *= self.decay;
        let left = [transition.to(target) - target, RETURNING * transition.rate * transition.lag];
        if left.iter().all(|one| one.abs() <= self.negligible[reference]) {
            transition.share = 0.0;
        }
    }
}
