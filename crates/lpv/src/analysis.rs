//! The gain of a finished closed loop for every parameter trajectory in the unit box.
//!
//! Scaled bounded-real lemma with a constant Lyapunov matrix: P. Apkarian, P. Gahinet, IEEE Trans. Automatic
//! Control 40(5), 1995, lemma 3.1, with the skew scaling of G. Scorletti and L. El Ghaoui, 1998.

use crate::bounded_real::{Multipliers, bounded_real_compact, bounded_real_value};
use crate::error::SynthesisError;
use crate::lmi::{Affine, Program};
use crate::matrix::{Mat, scaled_largest_eigenvalue, skew_part, symmetric_part};
use crate::model_error::LoopError;
use crate::plant::ClosedLoop;
use crate::solver::{self, Search};

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

/// How close to the least bound the one sought is, relative to itself and the one it starts from. Closer ones are tight, and hold less clearly.
const TIGHT: f64 = 0.01;

/// How often the search begins again, in the better coordinates that its last point gives.
const ROUNDS: usize = 3;

const STAGE: &str = "analysis of the closed loop";

/// Tightens a bound of the gain of a closed loop, with or without model error.
///
/// The inequalities are solved in coordinates in which X and S of the bound given are the identity, until gamma is within 1 %
/// of the least: there the inequality still holds clearly. What comes back holds by its eigenvalues in floating point: if
/// no better bound does, the one given.
///
/// # Errors
/// [`SynthesisError::Numerical`] when neither a new bound nor the one given satisfies the inequality.
pub fn bounded_gain(
    closed: &ClosedLoop,
    error: &LoopError,
    shown: &GainBound,
) -> Result<GainBound, SynthesisError> {
    // Changes of coordinates leave a rounding in what must be exactly symmetric or skew.
    let mut given = GainBound {
        x: symmetric_part(&shown.x),
        s: symmetric_part(&shown.s),
        t: skew_part(&shown.t),
        ..shown.clone()
    };
    given.largest_eigenvalue = worst_eigenvalue(closed, error, &given);
    let best = tightened(closed, error, &given).unwrap_or(given);
    if best.largest_eigenvalue < 0.0 {
        return Ok(best);
    }
    let slowest = crate::matrix::spectral_abscissa(&closed.a);
    let why = if slowest >= 0.0 {
        format!("; a mode has real part {slowest:.1e} at Theta = 0")
    } else {
        String::new()
    };
    Err(SynthesisError::Numerical {
        stage: STAGE,
        diagnosis: format!(
            "at gamma = {:.4e} an eigenvalue of the inequalities has the wrong sign, {:.1e}{why}",
            best.gamma, best.largest_eigenvalue
        ),
    })
}

/// A bound close to the least; `None` when no search led to one that holds and is better.
fn tightened(closed: &ClosedLoop, error: &LoopError, given: &GainBound) -> Option<GainBound> {
    let mut best: Option<GainBound> = None;
    for _ in 0..ROUNDS {
        let base = best.as_ref().unwrap_or(given);
        let Ok((found, gap)) = search(closed, error, base) else { break };
        if found.largest_eigenvalue >= 0.0 {
            break;
        }
        let better = base.largest_eigenvalue >= 0.0 || found.gamma < base.gamma;
        if better {
            best = Some(found);
        }
        if !better || gap <= TIGHT {
            break;
        }
    }
    best
}

/// A gamma close to the least, sought where X and S of `base` are the identity, and how close.
fn search(
    closed: &ClosedLoop,
    error: &LoopError,
    base: &GainBound,
) -> Result<(GainBound, f64), SynthesisError> {
    let (state, state_inverse) = whitening(&base.x, "X")?;
    let (channel, channel_inverse) = whitening(&base.s, "S")?;
    let seen = closed.in_coordinates((&state, &state_inverse), (&channel, &channel_inverse));
    let seen = seen.in_units_of(base.gamma);
    let seen_error = error.in_coordinates((&state, &state_inverse), &channel).in_units_of(base.gamma);
    let mut program = Program::new();
    let scalar = |value: f64| Affine::constant(Mat::from_element(1, 1, value));
    let m = Multipliers {
        x: program.symmetric(seen.a.nrows()),
        s: program.symmetric_commuting(&seen.channels),
        t: program.skew_commuting(&seen.channels),
        gamma: program.scalar(),
        lambda: if error.is_none() { scalar(0.0) } else { program.scalar() },
    };
    program.positive("X", m.x.clone());
    program.positive("S", m.s.clone());
    program.negative("bounded real", bounded_real_compact(&seen, &seen_error, &m));
    program.minimise_trace(&m.gamma, 1.0);
    let mut start = vec![0.0; program.unknowns()];
    let unit = |n: usize| Mat::identity(n, n);
    program.set(&mut start, &m.x, &unit(seen.a.nrows()));
    program.set(&mut start, &m.s, &unit(seen.channels.len()));
    program.set(&mut start, &m.t, &(channel.transpose() * &base.t * &channel));
    program.set(&mut start, &m.gamma, &Mat::from_element(1, 1, 1.0));
    program.set(&mut start, &m.lambda, &Mat::from_element(1, 1, base.lambda));
    let solution = solver::solve(&program, STAGE, Search { start: Some(&start), ..Search::within(TIGHT) })?;
    let value = |e: &Affine| e.value(&program, &solution.x);
    let back = |m: Mat, inverse: &Mat| inverse.transpose() * m * inverse;
    let mut found = GainBound {
        gamma: base.gamma * value(&m.gamma)[(0, 0)],
        x: symmetric_part(&back(value(&m.x), &state_inverse)),
        s: symmetric_part(&back(value(&m.s), &channel_inverse)),
        t: skew_part(&back(value(&m.t), &channel_inverse)),
        lambda: value(&m.lambda)[(0, 0)],
        largest_eigenvalue: f64::NAN,
    };
    found.largest_eigenvalue = worst_eigenvalue(closed, error, &found);
    Ok((found, solution.gap))
}

/// The largest eigenvalue of the bounded-real matrix, -X and -S, each scaled to a unit diagonal: the sign does
/// not depend on the scaling, and rounding is seen in proportion.
fn worst_eigenvalue(closed: &ClosedLoop, error: &LoopError, bound: &GainBound) -> f64 {
    let all = [bounded_real_value(closed, error, bound), -&bound.x, -&bound.s];
    all.iter().map(scaled_largest_eigenvalue).fold(f64::NEG_INFINITY, f64::max)
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
