//! Drives the eighth-order Dormand-Prince method of `differential-equations` from one instant to the next.
//!
//! Source: Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I (1993), section II.5, DOP853.

use differential_equations::error::Error;
use differential_equations::methods::{DormandPrince, ExplicitRungeKutta, Ordinary};
use differential_equations::ode::{ODE, OrdinaryNumericalMethod};
use thiserror::Error;

use crate::motion::dynamics::Motion;
use crate::words::Rounded;

/// Close to rounding, so that the result hardly depends on how an interval is divided.
const RELATIVE_TOLERANCE: f64 = 1e-13;
const ABSOLUTE_TOLERANCE: f64 = 1e-14;
/// Step sizes \[s\].
const FIRST_STEP: f64 = 1e-3;
/// The usual sample time of an autopilot: two corners of one switch are hardly closer together, and the tolerances are
/// met by steps of this length in most of a flight.
const LARGEST_STEP: f64 = 0.02;
const SMALLEST_STEP: f64 = 1e-12;
/// A step across a corner is repeated ten times shorter, down to this length \[s\]: the error estimate can miss a
/// corner late in a step.
const CORNER_STEP: f64 = 1e-4;
/// A switch that moves less than this makes no corner that matters.
const LEAST_SWING: f64 = 1e-6;
/// An interval shorter than this \[s\] is crossed by one step of Euler's method, whose error is its square.
const SHORTEST_INTERVAL: f64 = 1e-11;
/// An interval may take this many steps, and as many more as steps of [`SMALLEST_MEAN_STEP`] would.
const FREE_STEPS: usize = 1000;
const SMALLEST_MEAN_STEP: f64 = 1e-5;
/// No vehicle moves faster through the water \[m/s\] ...
const FASTEST: f64 = 100.0;
/// ... or turns faster \[rad/s\].
const FASTEST_TURN: f64 = 100.0;

/// u, w, q, theta, and the way made since the start of the interval: x, depth.
pub(crate) type Body = [f64; 6];

/// Equations of motion with corners: each is smooth where none of its switches changes sign.
pub(crate) trait Equations<const N: usize>: ODE<f64, [f64; N]> {
    /// Returns the quantities whose sign picks a branch of the equations.
    fn switches(&self, body: &[f64; N]) -> [f64; SWITCHES];

    /// Returns the motion through the water; its angles may be those of another chart.
    fn motion(&self, body: &[f64; N]) -> Motion;

    /// Returns the state in another chart of the attitude, in which the equations hold from then on, if this one ends
    /// here.
    fn rechart(&mut self, _body: &[f64; N]) -> Option<[f64; N]> {
        None
    }
}

/// The number of switches.
pub(crate) const SWITCHES: usize = 7;

type Dop853<const N: usize> = ExplicitRungeKutta<Ordinary, DormandPrince, f64, [f64; N], 8, 12, 16>;

/// Why the equations of motion could not be integrated.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
#[allow(missing_docs, reason = "the message says what each field is")]
pub enum IntegrationError {
    /// No step is small enough: the motion diverges.
    #[error("no step above {SMALLEST_STEP} s is accurate enough")]
    StepTooSmall,
    /// The motion is too fast: the interval would take too many steps.
    #[error("more than {steps} steps are needed: the motion is too fast for a vehicle")]
    TooManySteps { steps: usize },
    /// A speed or a rate is not a number, or one that no vehicle has.
    #[error(
        "{state} is {} {unit}, and must be at most {most} {unit} in size, which no vehicle exceeds",
        Rounded(*found)
    )]
    Impossible { state: &'static str, found: f64, most: f64, unit: &'static str },
}

/// The step size that the method last proposed.
///
/// The method itself lives only while it integrates: its tables are 8 kB, which every copy of a plant would carry.
#[derive(Clone)]
pub(crate) struct Integrator {
    step: f64,
}

impl Integrator {
    pub(crate) fn new() -> Self {
        Self { step: FIRST_STEP }
    }

    /// The step size that it last proposed \[s\], its only memory from one interval to the next.
    pub(crate) fn step(&self) -> f64 {
        self.step
    }

    /// Sets the first step size \[s\].
    pub(crate) fn set_step(&mut self, step: f64) {
        self.step = step;
    }

    /// Returns the state a time `duration` \[s\] after it was `start`; the equations see the time since then.
    pub(crate) fn advance<const N: usize, F: Equations<N>>(
        &mut self,
        equations: &mut F,
        start: &[f64; N],
        duration: f64,
    ) -> Result<[f64; N], IntegrationError> {
        let end = self.integrate(equations, start, duration);
        if end.is_err() {
            self.step = FIRST_STEP;
        }
        end
    }

    fn integrate<const N: usize, F: Equations<N>>(
        &mut self,
        equations: &mut F,
        start: &[f64; N],
        duration: f64,
    ) -> Result<[f64; N], IntegrationError> {
        let start = &equations.rechart(start).unwrap_or(*start);
        if duration < SHORTEST_INTERVAL {
            return possible(equations, euler(equations, 0.0, start, duration));
        }
        // The method counts steps and signs of stiffness across intervals; a new one makes the result depend on the
        // state alone.
        let mut method = method();
        self.restart(&mut method, equations, 0.0, duration, start)?;
        let most_steps = FREE_STEPS + (duration / SMALLEST_MEAN_STEP) as usize;
        let mut steps = 0;
        loop {
            let remaining = duration - method.t();
            if remaining < SHORTEST_INTERVAL {
                return possible(equations, euler(equations, method.t(), method.y(), remaining));
            }
            if steps == most_steps {
                return Err(IntegrationError::TooManySteps { steps });
            }
            steps += 1;
            let proposed = method.h();
            let clipped = proposed > remaining;
            if clipped {
                method.set_h(remaining);
            }
            let (before, body) = (method.t(), *method.y());
            if let Err(error) = method.step(equations) {
                self.recover(&mut method, equations, duration, &error)?;
                continue;
            }
            let taken = method.t() - before;
            let accepted = taken > 0.0;
            if taken > CORNER_STEP && crosses(&equations.switches(&body), &equations.switches(method.y())) {
                self.step = 0.1 * taken;
                self.restart(&mut method, equations, before, duration, &body)?;
                continue;
            }
            self.step = if clipped && accepted { proposed.max(method.h()) } else { method.h() };
            if !accepted && self.step < SMALLEST_STEP {
                return Err(IntegrationError::StepTooSmall);
            }
            method.set_h(self.step);
            let reached = possible(equations, *method.y())?;
            let now = method.t();
            if duration - now >= SHORTEST_INTERVAL
                && let Some(recharted) = equations.rechart(&reached)
            {
                self.restart(&mut method, equations, now, duration, &recharted)?;
            }
        }
    }

    fn restart<const N: usize, F: Equations<N>>(
        &self,
        method: &mut Dop853<N>,
        equations: &F,
        time: f64,
        end: f64,
        state: &[f64; N],
    ) -> Result<(), IntegrationError> {
        method.h0 = self.step.clamp(SMALLEST_STEP, LARGEST_STEP).min(end - time);
        match method.init(equations, time, end, state) {
            Ok(_) => Ok(()),
            Err(_) => Err(IntegrationError::StepTooSmall),
        }
    }

    /// The method gives up after fifteen signs of stiffness, however slowly they come; that is no reason to stop.
    fn recover<const N: usize, F: Equations<N>>(
        &self,
        method: &mut Dop853<N>,
        equations: &F,
        duration: f64,
        error: &Error<f64, [f64; N]>,
    ) -> Result<(), IntegrationError> {
        match *error {
            Error::Stiffness { t, y } => self.restart(method, equations, t, duration, &y),
            _ => Err(IntegrationError::StepTooSmall),
        }
    }
}

fn method<const N: usize>() -> Dop853<N> {
    Dop853::<N>::dop853()
        .rtol(RELATIVE_TOLERANCE)
        .atol(ABSOLUTE_TOLERANCE)
        .h_max(LARGEST_STEP)
        .max_steps(usize::MAX)
}

/// Returns whether a switch changes sign from one state to the next.
fn crosses(from: &[f64; SWITCHES], to: &[f64; SWITCHES]) -> bool {
    from.iter().zip(to).any(|(from, to)| from * to < 0.0 && (to - from).abs() > LEAST_SWING)
}

fn euler<const N: usize, F: Equations<N>>(equations: &F, time: f64, body: &[f64; N], step: f64) -> [f64; N] {
    let mut rate = [0.0; N];
    equations.diff(time, body, &mut rate);
    std::array::from_fn(|i| body[i] + step * rate[i])
}

/// Refuses a state with a speed or a rate that no vehicle has.
fn possible<const N: usize, F: Equations<N>>(
    equations: &F,
    body: [f64; N],
) -> Result<[f64; N], IntegrationError> {
    let Motion { u, v, w, p, q, r, .. } = equations.motion(&body);
    let speeds = [("the surge speed u", u), ("the sway speed v", v), ("the heave speed w", w)];
    let turns = [
        ("the angular velocity p about x", p),
        ("the angular velocity q about y", q),
        ("the angular velocity r about z", r),
    ];
    for (states, most, unit) in [(speeds, FASTEST, "m/s"), (turns, FASTEST_TURN, "rad/s")] {
        if let Some((state, found)) = states.into_iter().find(|(_, one)| one.is_nan() || one.abs() > most) {
            return Err(IntegrationError::Impossible { state, found, most, unit });
        }
    }
    Ok(body)
}
