//! The gain of a finished closed loop for every parameter trajectory in the unit box.
//!
//! Scaled bounded-real lemma with a constant Lyapunov matrix: P. Apkarian, P. Gahinet, IEEE Trans. Automatic
//! Control 40(5), 1995, lemma 3.1, with the skew scaling of G. Scorletti and L. El Ghaoui, 1998.

use crate::bounded_real::{bounded_real_compact, bounded_real_value, rows};
use crate::error::SynthesisError;
use crate::lmi::{Affine, Program};
use crate::matrix::{Mat, largest_eigenvalue, skew_part, symmetric_part};
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
    /// The largest eigenvalue of the bounded-real matrix, -X and -S, scaled to unit diagonals: negative, and
    /// how clearly.
    pub largest_eigenvalue: f64,
}

/// By how much the bound is relaxed above the least one, so that the inequality holds clearly.
const MARGIN: f64 = 0.01;

/// How far the inequality may be missed at the least bound, where it is tight.
const TIGHT: f64 = 1e-6;

const STAGE: &str = "analysis of the closed loop";

/// Tightens a bound of the gain of a closed loop.
///
/// The inequalities are solved in coordinates in which X and S of the bound given are the identity. The least
/// gamma is sought first; then, 1 % above it, the point at which the inequality holds most clearly. What comes
/// back holds by its eigenvalues in floating point: if no better bound does, the one given.
///
/// # Errors
/// [`SynthesisError::Numerical`] when neither a new bound nor the one given satisfies the inequality.
pub fn bounded_gain(closed: &ClosedLoop, shown: &GainBound) -> Result<GainBound, SynthesisError> {
    let unstable = crate::matrix::spectral_abscissa(&closed.a);
    if unstable.is_nan() || unstable >= 0.0 {
        return Err(SynthesisError::Numerical {
            stage: STAGE,
            diagnosis: format!("the closed loop has a mode with real part {unstable:.3e} at Theta = 0"),
        });
    }
    let given = GainBound {
        largest_eigenvalue: worst_eigenvalue(closed, &shown.x, &shown.s, &shown.t, shown.gamma),
        ..shown.clone()
    };
    let mut bases = vec![given.clone()];
    let mut least = f64::INFINITY;
    for _ in 0..2 {
        let Some(found) = bases.last().and_then(|base| search(closed, base, None).ok()) else { break };
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
    let mut clear = bases.iter().rev().filter_map(|base| search(closed, base, Some(least * (1.0 + MARGIN))).ok());
    let better = clear.find(|found| found.gamma.is_finite() && found.largest_eigenvalue < 0.0);
    let best = better.unwrap_or(given);
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

/// The least gamma, or the clearest point at a given gamma, sought where X and S of `base` are the identity.
fn search(closed: &ClosedLoop, base: &GainBound, gamma: Option<f64>) -> Result<GainBound, SynthesisError> {
    let (state, state_inverse) = whitening(&base.x, "X")?;
    let (channel, channel_inverse) = whitening(&base.s, "S")?;
    let seen = closed.in_coordinates((&state, &state_inverse), (&channel, &channel_inverse));
    let mut program = Program::new();
    let x = program.symmetric(seen.a.nrows());
    let s = program.symmetric_commuting(&seen.channels);
    let t = program.skew_commuting(&seen.channels);
    let level = match gamma {
        Some(g) => Affine::constant(Mat::from_element(1, 1, g)),
        None => program.scalar(),
    };
    program.positive("X", x.clone());
    program.positive("S", s.clone());
    program.negative("bounded real", bounded_real_compact(rows(&seen), &level, &x, &s, &t));
    if gamma.is_some() {
        let clear = program.scalar();
        program.tighten("bounded real", &clear);
        program.minimise_trace(&clear, -1.0);
    } else {
        program.minimise_trace(&level, 1.0);
    }
    let solution = solver::solve(&program, STAGE)?;
    let value = |e: &Affine| e.value(&program, &solution.x);
    let back = |m: Mat, inverse: &Mat| inverse.transpose() * m * inverse;
    let gamma = value(&level)[(0, 0)];
    let x = symmetric_part(&back(value(&x), &state_inverse));
    let s = symmetric_part(&back(value(&s), &channel_inverse));
    let t = skew_part(&back(value(&t), &channel_inverse));
    let largest_eigenvalue = worst_eigenvalue(closed, &x, &s, &t, gamma);
    Ok(GainBound { gamma, x, s, t, largest_eigenvalue })
}

/// The largest eigenvalue of the bounded-real matrix, -X and -S, each scaled to a unit diagonal: the sign does
/// not depend on the scaling, and rounding is seen in proportion.
fn worst_eigenvalue(closed: &ClosedLoop, x: &Mat, s: &Mat, t: &Mat, gamma: f64) -> f64 {
    let all = [bounded_real_value(closed, x, s, t, gamma), -x, -s];
    all.iter().map(scaled_largest_eigenvalue).fold(f64::NEG_INFINITY, f64::max)
}

fn scaled_largest_eigenvalue(m: &Mat) -> f64 {
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
fn whitening(m: &Mat, name: &str) -> Result<(Mat, Mat), SynthesisError> {
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
