//! The gain of a loop with a sampled controller, including the behaviour between samples.
//!
//! ```text
//! x' = A x + B1 w + B2 u,   z = C1 x + D11 w + D12 u        in continuous time
//! y_k = C2 x(k T) + D21 w(k T)                             sampled
//! xk_(k+1) = Ak xk_k + Bk y_k,   u = Ck xk_k + Dk y_k      u held from k T to (k + 1) T
//! ```
//!
//! A component of w that reaches y without passing a state (a nonzero column of D21) would have an infinite gain: it
//! could act at the ticks only, at no cost. Such components are held between ticks, like references and the noise of
//! samples; all others are any function of finite energy, or held as well. Signals faster than half the sampling rate
//! are aliased: if slow errors have a large weight, [`Exogenous::Any`] has a larger gain than [`Exogenous::Held`] at
//! any sample time.
//!
//! At a level above the gain between two ticks the loop is equivalent to a discrete-time system (`lifted.rs`): the loop
//! is stable with a gain below the level exactly if that system is stable and has a norm below 1. The level is found by
//! search.
//!
//! Sources: B. Bamieh, J. B. Pearson, IEEE Trans. Automatic Control 37(4), 1992; T. Chen, B. A. Francis, Optimal
//! Sampled-Data Control Systems, 1995, chapter 13.

use crate::analysis::lifted::Lifted;
use crate::error::SystemError;
use crate::matrix::{Mat, block, eigenvalues, largest, largest_singular_value};
use crate::stop;
use crate::system::Group::{U, Y};
use crate::system::{GeneralisedPlant, HinfNorm, StateSpace};

/// Bounds on a gain, to rounding: both infinite for an unstable loop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SampledGain {
    /// Lower bound of the gain.
    pub lower: f64,
    /// Upper bound of the gain.
    pub upper: f64,
}

/// The class of exogenous inputs w.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Exogenous {
    /// Any function of finite energy; components that reach y without passing a state are held between ticks.
    Any,
    /// All components are held between ticks.
    Held,
}

/// The relative tolerance of the bounds.
const TOLERANCE: f64 = 1e-5;

/// The largest number of levels. Every fourth level bisects.
const MOST_LEVELS: usize = 200;

/// The least gain distinguished from 0, relative to the size of the matrices.
const LEAST: f64 = 1e-9;

/// Returns the L2 gain from w to z of a plant without parameters, closed by a discrete-time controller with the sample
/// time T (s), to a relative accuracy of `1e-5`.
///
/// The controller is `(xk_(k+1), u_k) = K(xk_k, y_k)`; its `b` and `d` have one column per row of y. A gain below
/// `1e-9` of the size of B1, C1 and D11 has the lower bound 0. Source: see the module.
///
/// # Errors
/// Returns [`SystemError`].
pub fn sampled_gain(
    plant: &GeneralisedPlant,
    controller: &StateSpace,
    sample_time: f64,
    w: Exogenous,
) -> Result<SampledGain, SystemError> {
    sampled_gain_near(plant, controller, sample_time, w, f64::NAN)
}

/// Computes [`sampled_gain`] with the search started at a `guess` of the gain, such as that of the loop in continuous
/// time; a guess that is not positive and finite is ignored.
///
/// # Errors
/// Errors of [`sampled_gain`].
pub fn sampled_gain_near(
    plant: &GeneralisedPlant,
    controller: &StateSpace,
    sample_time: f64,
    w: Exogenous,
    guess: f64,
) -> Result<SampledGain, SystemError> {
    let parts = SampledLoop::new(plant, controller, sample_time, w)?;
    if !parts.is_stable() {
        return Ok(SampledGain { lower: f64::INFINITY, upper: f64::INFINITY });
    }
    let size = plant.d11().norm() + plant.c1().norm().max(1.0) * plant.b1().norm().max(1.0);
    // Fast inputs act on z through D11 only.
    let (mut lower, mut upper) = (largest_singular_value(&parts.between.d), f64::INFINITY);
    let (mut level, mut near) = (if guess > 0.0 && guess.is_finite() { guess } else { size }, None);
    for tried in 0..MOST_LEVELS {
        stop::check();
        let peak = parts.norm(level, near)?;
        let norm = peak.value;
        // The peak moves little from level to level.
        near = Some(peak.frequency).filter(|omega| norm.is_finite() && omega.is_finite()).or(near);
        if norm >= 1.0 {
            lower = level;
        } else {
            upper = level;
        }
        if upper <= lower * (1.0 + TOLERANCE) || upper <= size * LEAST {
            break;
        }
        let halved = match (lower > 0.0, upper.is_finite()) {
            (true, true) => (lower * upper).sqrt(),
            (true, false) => 2.0 * lower,
            (false, _) => 0.5 * upper,
        };
        // The level at which the norm would be 1 if it fell in proportion, and a little beyond.
        let beyond = if norm >= 1.0 { 0.3 * TOLERANCE } else { -0.3 * TOLERANCE };
        let expected = level * norm * (1.0 + beyond);
        level = if expected.is_finite() && expected > 0.0 && tried % 4 < 3 {
            expected.max(lower * (1.0 + 0.5 * TOLERANCE)).min(upper * (1.0 - 0.5 * TOLERANCE))
        } else {
            halved
        };
    }
    Ok(SampledGain { lower, upper })
}

/// A loop prepared for lifting.
struct SampledLoop<'a> {
    /// The system from the continuous part of w to z, with the states (x, u, held part of w).
    between: StateSpace,
    /// The columns of D21 of the held part of w.
    held: Mat,
    /// The matrix C2.
    measured: Mat,
    controller: &'a StateSpace,
    sample_time: f64,
}

impl<'a> SampledLoop<'a> {
    fn new(
        plant: &GeneralisedPlant,
        controller: &'a StateSpace,
        sample_time: f64,
        w: Exogenous,
    ) -> Result<Self, SystemError> {
        let sizes = plant.sizes();
        if sizes.t > 0 {
            return Err(SystemError::Scheduled { channels: sizes.t });
        }
        if !(sample_time > 0.0 && sample_time.is_finite()) {
            return Err(SystemError::SampleTime { found: sample_time });
        }
        if plant.parts.block(Y, U).iter().any(|v| *v != 0.0) {
            return Err(SystemError::DirectPath);
        }
        let n = controller.a.nrows();
        let shapes = [
            ("A of the controller", &controller.a, (n, n)),
            ("B of the controller", &controller.b, (n, sizes.y)),
            ("C of the controller", &controller.c, (sizes.u, n)),
            ("D of the controller", &controller.d, (sizes.u, sizes.y)),
        ];
        for (name, found, expected) in shapes.map(|(name, m, expected)| (name, m.shape(), expected)) {
            if found != expected {
                return Err(SystemError::Shape { name, found, expected });
            }
        }
        let d21 = plant.d21();
        let at_ticks = |j: &usize| w == Exogenous::Held || d21.column(*j).iter().any(|v| *v != 0.0);
        let (held, continuous): (Vec<usize>, Vec<usize>) = (0..sizes.w).partition(at_ticks);
        let (b1, d11) = (plant.b1(), plant.d11());
        let constant = sizes.u + held.len();
        let zero = Mat::zeros;
        let between = StateSpace {
            a: block(&[
                &[&plant.a(), &plant.b2(), &b1.select_columns(&held)],
                &[&zero(constant, sizes.x), &zero(constant, sizes.u), &zero(constant, held.len())],
            ]),
            b: block(&[&[&b1.select_columns(&continuous)], &[&zero(constant, continuous.len())]]),
            c: block(&[&[&plant.c1(), &plant.d12(), &d11.select_columns(&held)]]),
            d: d11.select_columns(&continuous),
        };
        Ok(Self { between, held: d21.select_columns(&held), measured: plant.c2(), controller, sample_time })
    }

    /// Returns `true` if all modes of the discrete-time loop are inside the unit circle.
    fn is_stable(&self) -> bool {
        let transition = (&self.between.a * self.sample_time).exp();
        let modes = eigenvalues(&self.tick_to_tick(&transition, 1.0).a);
        largest(0.0, modes.iter().map(|v| v.norm())) < 1.0
    }

    /// Returns the norm of the discrete-time system that is below 1 if the gain is below the level; infinite if the
    /// level is not above the gain between two ticks. The search starts near a frequency (rad/s, on the axis).
    fn norm(&self, level: f64, near: Option<f64>) -> Result<HinfNorm, SystemError> {
        let none = HinfNorm { value: f64::INFINITY, frequency: f64::INFINITY };
        let Some(lifted) = Lifted::over(&self.between, self.sample_time, level)? else {
            return Ok(none);
        };
        let StateSpace { a, b, c, .. } = lifted.system();
        // The energy of a held component is T times that of its value at the tick.
        let ticks = self.tick_to_tick(&a, 1.0 / (level * self.sample_time.sqrt()));
        let (n, x) = (ticks.a.nrows(), self.measured.ncols());
        let enters = block(&[&[&b.rows(0, x).into_owned()], &[&Mat::zeros(n - x, b.ncols())]]);
        let seen = StateSpace {
            b: block(&[&[&ticks.b, &enters]]),
            d: block(&[&[&(&c * &ticks.d), &Mat::zeros(c.nrows(), b.ncols())]]),
            c: &c * &ticks.c,
            a: ticks.a,
        };
        let peak =
            |axis: StateSpace| near.map_or_else(|| axis.hinf_norm(), |omega| axis.hinf_norm_near(omega));
        Ok(seen.from_circle_to_axis().map_or(none, peak))
    }

    /// Returns the loop from tick to tick for a transition of (x, u, held), from the held components in units of `unit`
    /// to the value of (x, u, held) at the start of a sample. States (x, xk).
    fn tick_to_tick(&self, transition: &Mat, unit: f64) -> StateSpace {
        let StateSpace { a, b, c, d } = self.controller;
        let (x, held, n) = (self.measured.ncols(), &self.held * unit, a.nrows());
        let (zero, h) = (Mat::zeros, held.ncols());
        let begin = block(&[
            &[&Mat::identity(x, x), &zero(x, n)],
            &[&(d * &self.measured), c],
            &[&zero(h, x), &zero(h, n)],
        ]);
        let held_begin = block(&[&[&zero(x, h)], &[&(d * &held)], &[&(Mat::identity(h, h) * unit)]]);
        let moved = transition.rows(0, x);
        StateSpace {
            a: block(&[&[&(moved * &begin)], &[&block(&[&[&(b * &self.measured), a]])]]),
            b: block(&[&[&(moved * &held_begin)], &[&(b * &held)]]),
            c: begin,
            d: held_begin,
        }
    }
}
