//! Integration by the Runge-Kutta method from one instant to the next, with adaptive step size.
//!
//! Source of the step size control: Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I (1993),
//! section II.4.

mod runge_kutta;

use thiserror::Error;

use crate::motion::dynamics::Motion;
use crate::simulation::integrator::runge_kutta::{Step, step};
use crate::text::Rounded;

/// Relative tolerance of the estimated error of a step; the error of the state is far smaller, and the motion is
/// damped.
const RELATIVE_TOLERANCE: f64 = 1e-10;
const ABSOLUTE_TOLERANCE: f64 = 1e-11;
/// Initial step size \[s\].
const FIRST_STEP: f64 = 1e-3;
/// Largest step size \[s\], the usual sample time of an autopilot: two corners of one switch are hardly closer
/// together, and steps of this size meet the tolerances during most of a flight.
const LARGEST_STEP: f64 = 0.02;
const SMALLEST_STEP: f64 = 1e-12;
/// Safety factor of the next step, relative to the longest that would have met the tolerance.
const SAFETY: f64 = 0.9;
/// Least and greatest ratio of the next step to the last.
const CHANGES: [f64; 2] = [0.2, 5.0];
/// Step size \[s\] down to which a step across a corner is repeated ten times shorter: the error estimate can miss a
/// corner late in a step.
const CORNER_STEP: f64 = 1e-5;
/// Change of a switch below which its corner does not matter.
const LEAST_SWING: f64 = 1e-6;
/// Length of an interval \[s\] below which one step of Euler's method crosses it, with an error of second order.
const SHORTEST_INTERVAL: f64 = 1e-11;
/// Number of steps allowed per interval, in addition to those of [`SMALLEST_MEAN_STEP`].
const FREE_STEPS: usize = 1000;
const SMALLEST_MEAN_STEP: f64 = 1e-5;
/// Greatest speed of any vehicle through the water \[m/s\].
const FASTEST: f64 = 100.0;
/// Greatest angular velocity of any vehicle \[rad/s\].
const FASTEST_TURN: f64 = 100.0;

/// State: u, w, q, theta, and the distance since the start of the interval: x, depth.
pub(crate) type Body = [f64; 6];

/// Equations of motion with corners: smooth as long as no switch changes sign.
pub(crate) trait Equations<const N: usize> {
    /// Returns the rate of the state at a time \[s\] after the start of the interval.
    fn rate(&self, time: f64, body: &[f64; N]) -> [f64; N];

    /// Returns the quantities whose signs select a branch of the equations.
    fn switches(&self, body: &[f64; N]) -> [f64; SWITCHES];

    /// Returns the motion through the water; its angles may belong to another chart.
    fn motion(&self, body: &[f64; N]) -> Motion;

    /// Returns the state in another chart of the attitude, used by the equations from then on, if the present chart
    /// ends here.
    fn rechart(&mut self, _body: &[f64; N]) -> Option<[f64; N]> {
        None
    }
}

/// Number of switches.
pub(crate) const SWITCHES: usize = 7;

/// Reason why the equations of motion could not be integrated.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
#[allow(missing_docs, reason = "the message says what each field is")]
pub enum IntegrationError {
    /// No step is small enough: the motion diverges.
    #[error("no step size above {SMALLEST_STEP} s is accurate enough")]
    StepTooSmall,
    /// The interval takes too many steps: the motion is too fast.
    #[error("more than {steps} integration steps are needed: the motion is too fast for a vehicle")]
    TooManySteps { steps: usize },
    /// A speed or a rate is not finite, or larger than that of any vehicle.
    #[error(
        "{state} is {} {unit}; its magnitude must be at most {most} {unit}",
        Rounded(*found)
    )]
    Impossible { state: &'static str, found: f64, most: f64, unit: &'static str },
}

/// Integrator with the size of the next step.
#[derive(Clone)]
pub(crate) struct Integrator {
    step: f64,
}

impl Integrator {
    pub(crate) fn new() -> Self {
        Self { step: FIRST_STEP }
    }

    /// Returns the proposed step size \[s\], the only memory between intervals.
    pub(crate) fn step(&self) -> f64 {
        self.step
    }

    /// Sets the first step size \[s\].
    pub(crate) fn set_step(&mut self, step: f64) {
        self.step = step;
    }

    /// Returns the state at a time `duration` \[s\] after `start`; the time of the equations counts from `start`.
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
        let mut state = equations.rechart(start).unwrap_or(*start);
        let (mut time, mut rate) = (0.0, equations.rate(0.0, &state));
        let most_steps = FREE_STEPS + (duration / SMALLEST_MEAN_STEP) as usize;
        for _ in 0..most_steps {
            let remaining = duration - time;
            if remaining < SHORTEST_INTERVAL {
                return check_speeds(equations, std::array::from_fn(|i| state[i] + remaining * rate[i]));
            }
            let proposed = self.step.clamp(SMALLEST_STEP, LARGEST_STEP);
            let h = proposed.min(remaining);
            let next = step(|since, state| equations.rate(time + since, state), &state, &rate, h);
            let step_ratio = step_ratio(&state, &next);
            let Some(growth) = step_ratio.filter(|step_ratio| *step_ratio >= SAFETY) else {
                if h <= SMALLEST_STEP {
                    return Err(IntegrationError::StepTooSmall);
                }
                self.step = h * step_ratio.unwrap_or(CHANGES[0]);
                continue;
            };
            if h > CORNER_STEP && crosses(&equations.switches(&state), &equations.switches(&next.state)) {
                self.step = 0.1 * h;
                continue;
            }
            self.step = if h < proposed { proposed.max(h * growth) } else { h * growth };
            time += h;
            (state, rate) = (check_speeds(equations, next.state)?, next.rate);
            if duration - time >= SHORTEST_INTERVAL
                && let Some(recharted) = equations.rechart(&state)
            {
                (state, rate) = (recharted, equations.rate(time, &recharted));
            }
        }
        Err(IntegrationError::TooManySteps { steps: most_steps })
    }
}

/// Returns the ratio of the next step size to the last; below [`SAFETY`] the step does not meet the tolerances. `None`
/// if the end of the step is not finite.
fn step_ratio<const N: usize>(from: &[f64; N], Step { state, error, .. }: &Step<N>) -> Option<f64> {
    let part =
        |i: usize| error[i] / (ABSOLUTE_TOLERANCE + RELATIVE_TOLERANCE * from[i].abs().max(state[i].abs()));
    let size = ((0..N).map(|i| part(i) * part(i)).sum::<f64>() / N as f64).sqrt();
    size.is_finite().then(|| (SAFETY * size.powf(-1.0 / 6.0)).clamp(CHANGES[0], CHANGES[1]))
}

/// Returns `true` if a switch changes sign from one state to the next.
fn crosses(from: &[f64; SWITCHES], to: &[f64; SWITCHES]) -> bool {
    from.iter().zip(to).any(|(from, to)| from * to < 0.0 && (to - from).abs() > LEAST_SWING)
}

/// Refuses a state with a speed or a rate that no vehicle reaches.
fn check_speeds<const N: usize, F: Equations<N>>(
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
