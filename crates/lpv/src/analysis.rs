//! The gain of a finished closed loop for every parameter trajectory in the unit box.
//!
//! Scaled bounded-real lemma with a constant Lyapunov matrix: P. Apkarian, P. Gahinet, IEEE Trans. Automatic
//! Control 40(5), 1995, lemma 3.1, with the skew scaling of G. Scorletti and L. El Ghaoui, 1998.

use crate::bounded_real::{Multipliers, bounded_real_compact, bounded_real_value};
use crate::error::SynthesisError;
use crate::lmi::{Affine, Program};
use crate::matrix::{Mat, largest_eigenvalue, skew_part, symmetric_part};
use crate::model_error::LoopError;
use crate::plant::ClosedLoop;
use crate::solver;

/// A bound on the gain with the matrices that show it.
#[derive(Debug, Clone, PartialEq)]
pub struct GainBound {
    /// The bound: for every measurable trajectory Theta(t) in the unit box the loop is exponentially stable
    /// and its L2 gain from w to z is below this.
    pub gamma: f64,
    /// The Lyapunov matrix, ordered plant's states, then controller's.
    pub x: Mat,
    /// The symmetric scaling, ordered plant's channels, then controller's.
    pub s: Mat,
    /// The skew scaling.
    pub t: Mat,
    /// The multiplier of the model error; 0 when there is none.
    pub lambda: f64,
    /// The largest eigenvalue of the bounded-real matrix, -X and -S, scaled to unit diagonals: negative, and
    /// how clearly.
    pub largest_eigenvalue: f64,
}

/// By how much the bound is relaxed above the least one, so that the inequality holds clearly.
const MARGIN: f64 = 0.01;

/// How far the inequality may be missed at the least bound, where it is tight.
const TIGHT: f64 = 1e-6;

const STAGE: &str = "analysis of the closed loop";

/// Tightens a bound of the gain of a closed loop, with or without model error.
///
/// The inequalities are solved in coordinates in which X and S of the bound given are the identity. The least
/// gamma is sought first; then, 1 % above it, the point at which the inequality holds most clearly. What comes
/// back holds by its eigenvalues in floating point: if no better bound does, the one given. A loop too large for
/// the solver ([`TIGHTENED_SIZE`]) keeps the bound given, if that holds.
///
/// # Errors
/// [`SynthesisError::Numerical`] when neither a new bound nor the one given satisfies the inequality.
pub fn bounded_gain(
    closed: &ClosedLoop,
    error: &LoopError,
    shown: &GainBound,
) -> Result<GainBound, SynthesisError> {
    let unstable = crate::matrix::spectral_abscissa(&closed.a);
    if unstable.is_nan() || unstable >= 0.0 {
        return Err(SynthesisError::Numerical {
            stage: STAGE,
            diagnosis: format!("the closed loop has a mode with real part {unstable:.3e} at Theta = 0"),
        });
    }
    // Changes of coordinates leave a rounding in what must be exactly symmetric or skew.
    let mut given = GainBound {
        x: symmetric_part(&shown.x),
        s: symmetric_part(&shown.s),
        t: skew_part(&shown.t),
        ..shown.clone()
    };
    given.largest_eigenvalue = worst_eigenvalue(closed, error, &given);
    if size_of(closed) > TIGHTENED_SIZE && given.largest_eigenvalue < 0.0 {
        return Ok(given);
    }
    let best = tightened(closed, error, &given).unwrap_or(given);
    if best.largest_eigenvalue < 0.0 {
        Ok(best)
    } else {
        Err(SynthesisError::Numerical {
            stage: STAGE,
            diagnosis: format!(
                "at gamma = {:.4} an eigenvalue of the inequalities has the wrong sign, {:.1e}",
                best.gamma, best.largest_eigenvalue
            ),
        })
    }
}

/// Loops with more states, channels, inputs and outputs together than this keep the bound of the synthesis.
pub const TIGHTENED_SIZE: usize = 56;

/// Loops larger than this, counted alike, are searched once for the least bound; smaller ones once more, in the better
/// coordinates that the first search gives.
const TWICE_SIZE: usize = 48;

/// States, channels, inputs and outputs together.
fn size_of(closed: &ClosedLoop) -> usize {
    closed.a.nrows() + closed.channels.len() + closed.b1.ncols() + closed.c1.nrows()
}

/// The clearest point a little above the least gamma; `None` when no search led to one that holds.
fn tightened(closed: &ClosedLoop, error: &LoopError, given: &GainBound) -> Option<GainBound> {
    let mut bases = vec![given.clone()];
    let mut least = f64::INFINITY;
    let rounds = if size_of(closed) > TWICE_SIZE { 1 } else { 2 };
    for _ in 0..rounds {
        let Some(found) = bases.last().and_then(|base| search(closed, error, base, None).ok()) else { break };
        if found.largest_eigenvalue > TIGHT {
            break;
        }
        let settled = found.gamma > least * (1.0 - 1e-4);
        least = least.min(found.gamma);
        bases.push(found);
        if settled {
            break;
        }
    }
    let level = least * (1.0 + MARGIN);
    let mut clear = bases.iter().rev().filter_map(|base| search(closed, error, base, Some(level)).ok());
    clear.find(|found| found.gamma.is_finite() && found.largest_eigenvalue < 0.0)
}

/// The least gamma, or the clearest point at a given gamma, sought where X and S of `base` are the identity.
fn search(
    closed: &ClosedLoop,
    error: &LoopError,
    base: &GainBound,
    gamma: Option<f64>,
) -> Result<GainBound, SynthesisError> {
    let (state, state_inverse) = whitening(&base.x, "X")?;
    let (channel, channel_inverse) = whitening(&base.s, "S")?;
    let seen = closed.in_coordinates((&state, &state_inverse), (&channel, &channel_inverse));
    let seen_error = error.in_coordinates((&state, &state_inverse), &channel);
    let mut program = Program::new();
    let scalar = |value: f64| Affine::constant(Mat::from_element(1, 1, value));
    let m = Multipliers {
        x: program.symmetric(seen.a.nrows()),
        s: program.symmetric_commuting(&seen.channels),
        t: program.skew_commuting(&seen.channels),
        gamma: gamma.map_or_else(|| program.scalar(), scalar),
        lambda: if error.is_none() { scalar(0.0) } else { program.scalar() },
    };
    program.positive("X", m.x.clone());
    program.positive("S", m.s.clone());
    program.negative("bounded real", bounded_real_compact(&seen, &seen_error, &m));
    if gamma.is_some() {
        let clear = program.scalar();
        program.tighten("bounded real", &clear);
        program.minimise_trace(&clear, -1.0);
    } else {
        program.minimise_trace(&m.gamma, 1.0);
    }
    let solution = solver::solve(&program, STAGE)?;
    let value = |e: &Affine| e.value(&program, &solution.x);
    let back = |m: Mat, inverse: &Mat| inverse.transpose() * m * inverse;
    let mut found = GainBound {
        gamma: value(&m.gamma)[(0, 0)],
        x: symmetric_part(&back(value(&m.x), &state_inverse)),
        s: symmetric_part(&back(value(&m.s), &channel_inverse)),
        t: skew_part(&back(value(&m.t), &channel_inverse)),
        lambda: value(&m.lambda)[(0, 0)],
        largest_eigenvalue: f64::NAN,
    };
    found.largest_eigenvalue = worst_eigenvalue(closed, error, &found);
    Ok(found)
}

/// The largest eigenvalue of the bounded-real matrix, -X and -S, each scaled to a unit diagonal: the sign does
/// not depend on the scaling, and rounding is seen in proportion.
fn worst_eigenvalue(closed: &ClosedLoop, error: &LoopError, bound: &GainBound) -> f64 {
    let all = [bounded_real_value(closed, error, bound), -&bound.x, -&bound.s];
    all.iter().map(scaled_largest_eigenvalue).fold(f64::NEG_INFINITY, f64::max)
}

pub(crate) fn scaled_largest_eigenvalue(m: &Mat) -> f64 {
    if m.iter().any(|v| !v.is_finite()) {
        return f64::INFINITY;
    }
    if let Some(wrong) = m.diagonal().iter().copied().find(|d| *d >= 0.0) {
        return wrong.max(f64::MIN_POSITIVE);
    }
    let scale = Mat::from_diagonal(&m.diagonal().map(|d| 1.0 / (-d).sqrt()));
    largest_eigenvalue(&(&scale * m * &scale))
}

/// T and its inverse with `T' M T = I`.
pub(crate) fn whitening(m: &Mat, name: &str) -> Result<(Mat, Mat), SynthesisError> {
    if m.is_empty() {
        return Ok((m.clone(), m.clone()));
    }
    let inverse = m.clone().cholesky().map(|c| c.l().transpose());
    inverse.and_then(|inverse| Some((inverse.clone().try_inverse()?, inverse))).ok_or_else(|| {
        SynthesisError::Numerical {
            stage: STAGE,
            diagnosis: format!("the guess at {name} is not positive definite"),
        }
    })
}
