//! Reference governor: motion of a reference that differs from the request.
//!
//! ```text
//! used   = (1 - share) target + share start,   target: request within its range; then rate limit
//! share  = (1 + t/1 s) exp(-t/1 s),   t after the transition began
//! start' = rate exp(-t/1 s)
//! ```
//!
//! [`Autopilot::follow`](crate::Autopilot::follow) begins a transition at the measured value, with the measured rate
//! where a sensor gives it, within the rate limit of the reference. While an actuator that steers the signal is at its
//! limit, after [`HELD`] there, the reference yields, and its transition restarts at its current value, at rest:
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

/// Time at its limit after which an actuator makes references yield, s.
pub const HELD: f64 = 1.0;

/// Time constant with which a reference yields to the measured value, s.
const YIELDING: f64 = 0.3;

/// Both time constants with which a reference returns to the request, s.
pub const RETURNING: f64 = 1.0;

/// Difference, as a fraction of the nominal size of a signal, below which a transition ends.
const NO_DIFFERENCE: f64 = 1e-4;

/// Constants of the governor for a design.
#[derive(Debug)]
pub(crate) struct Governor {
    /// [`HELD`] in ticks.
    held: u32,
    /// Fraction of the distance to the measured value by which a reference yields per tick.
    yielding: f64,
    /// Factor of the lag of a transition per tick.
    decay: f64,
    sample_time: f64,
    /// Difference of each reference from its target that counts as zero.
    negligible: Vec<f64>,
    /// Actuators that steer each signal with a reference; empty for a signal that is not measured or not tracked.
    steered_by: Vec<Vec<usize>>,
    /// `true` for each actuator that steers.
    steers: Vec<bool>,
    /// Force along the hull per unit of command, for each actuator that does not steer.
    pushes: Vec<f64>,
}

/// Transition of a reference from a start to its target.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Transition {
    /// Start of the transition, moved on by its rate, SI.
    pub start: f64,
    /// Initial rate, SI per second.
    pub rate: f64,
    /// Weight of the start in the reference, from 0 to 1; 0 without a transition.
    pub share: f64,
    /// exp(-t/1 s), at the time t after the beginning.
    pub lag: f64,
}

impl Transition {
    /// Creates a transition that begins at rest.
    pub(crate) fn from(start: f64) -> Self {
        Self { start, rate: 0.0, share: 1.0, lag: 1.0 }
    }

    /// Returns the reference in transition to a target.
    pub(crate) fn to(self, target: f64) -> f64 {
        if self.share == 0.0 { target } else { (1.0 - self.share) * target + self.share * self.start }
    }

    /// Returns the target for which a reference keeps its value.
    pub(crate) fn target_of(self, reference: f64) -> f64 {
        if self.share < 1.0 { (reference - self.share * self.start) / (1.0 - self.share) } else { reference }
    }
}

/// Saturation of an actuator.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Saturation {
    /// `true` if the last tick computed a command beyond a limit.
    pub now: bool,
    /// Count of saturated ticks, up to [`HELD`], less the unsaturated ones since.
    pub ticks: u32,
}

impl Governor {
    #[inline]
    pub(crate) fn new(design: &ControllerDesign) -> Self {
        let per_tick = |time: f64| design.sample_time / time;
        let steered_by = |(index, (signal, _)): (usize, (&Port, _))| {
            let yields = design.measures(index) && design.follows(index);
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

    /// Returns `true` if an actuator steers a signal with a reference.
    pub(crate) fn steers(&self, actuator: usize) -> bool {
        self.steers[actuator]
    }

    /// Returns the force along the hull per unit of command of an actuator, 0 for one that steers.
    pub(crate) fn pushes(&self, actuator: usize) -> f64 {
        self.pushes[actuator]
    }

    /// [`HELD`] in ticks.
    pub(crate) fn held(&self) -> u32 {
        self.held
    }

    /// Fraction of the distance to the measured value by which a reference yields per tick.
    pub(crate) fn yielding(&self) -> f64 {
        self.yielding
    }

    /// Returns the factor of the lag per tick, and the difference of a reference from its target that counts as zero.
    pub(crate) fn returning(&self, reference: usize) -> (f64, f64) {
        (self.decay, self.negligible[reference])
    }

    /// Returns `true` if a reference yields.
    pub(crate) fn yields(&self, reference: usize, saturation: &[Saturation]) -> bool {
        self.steered_by[reference]
            .iter()
            .any(|one| saturation[*one].now && saturation[*one].ticks >= self.held)
    }

    /// Returns the next value of a reference that yields to a measured value.
    pub(crate) fn yielded(&self, last: f64, measured: f64) -> f64 {
        last + self.yielding * (measured - last)
    }

    /// Counts a tick of an actuator, saturated if `now`.
    pub(crate) fn count(&self, saturation: &mut Saturation, now: bool) {
        saturation.now = now;
        saturation.ticks =
            if now { (saturation.ticks + 1).min(self.held) } else { saturation.ticks.saturating_sub(1) };
    }

    /// Advances the transition of a reference to a `target` by a tick. It ends when the remaining difference and the
    /// remaining rate are negligible.
    pub(crate) fn advance(&self, reference: usize, transition: &mut Transition, target: f64) {
        let Transition { start, rate, share, lag } = transition;
        *start += self.sample_time * *rate * *lag;
        *share = self.decay * (*share + self.sample_time / RETURNING * *lag);
        *lag *= self.decay;
        let remaining = [transition.to(target) - target, RETURNING * transition.rate * transition.lag];
        if remaining.iter().all(|one| one.abs() <= self.negligible[reference]) {
            transition.share = 0.0;
        }
    }
}
