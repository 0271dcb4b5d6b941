//! The gain of a finished closed loop for every parameter trajectory in the unit box.
//!
//! Scaled bounded-real lemma with a constant Lyapunov matrix: P. Apkarian, P. Gahinet, IEEE Trans. Automatic
//! Control 40(5), 1995, lemma 3.1, with the skew scaling of G. Scorletti and L. El Ghaoui, 1998.

use crate::error::SynthesisError;
use crate::lmi::{Affine, Program};
use crate::matrix::{Mat, largest_eigenvalue, skew_part, symmetric_part};
use crate::plant::ClosedLoop;
use crate::reconstruct::bounded_real_value;
use crate::solver;
use crate::synthesis::bounded_real;

/// A bound on the gain with the matrices that show it.
#[derive(Debug, Clone, PartialEq)]
pub struct Certified {
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

/// By how much the bound is relaxed above the optimum, so that the inequality holds strictly.
const MARGIN: f64 = 0.01;

const STAGE: &str = "analysis of the closed loop";

/// A guess at X and S, of which only the size in each direction matters: the inequalities are solved in
/// coordinates in which it is the identity.
#[derive(Debug, Clone, PartialEq)]
pub struct Guess {
    /// Symmetric positive definite, of the size of the loop's states.
    pub x: Mat,
    /// Symmetric positive definite, commuting with Theta.
    pub s: Mat,
}

impl Guess {
    /// No knowledge: the identity.
    pub fn none(closed: &ClosedLoop) -> Self {
        let (n, r) = (closed.a.nrows(), closed.channels.len());
        Self { x: Mat::identity(n, n), s: Mat::identity(r, r) }
    }
}

/// Bounds the gain of a closed loop.
///
/// The least bound is sought first; then, [`MARGIN`] above it, the point at which the inequality holds most
/// clearly. Each point found serves as the next guess. The matrices returned satisfy the inequality by their
/// eigenvalues in floating point.
///
/// # Errors
/// [`SynthesisError::Infeasible`] when no bound exists, [`SynthesisError::Numerical`] when the point found does not
/// satisfy the inequality.
pub fn bounded_gain(closed: &ClosedLoop, guess: &Guess) -> Result<Certified, SynthesisError> {
    let unstable = crate::matrix::spectral_abscissa(&closed.a);
    if unstable.is_nan() || unstable >= 0.0 {
        return Err(SynthesisError::Numerical {
            stage: STAGE,
            diagnosis: format!("the closed loop has a mode with real part {unstable:.3e} at Theta = 0"),
        });
    }
    let first = search(closed, guess, None)?;
    let better = Guess { x: first.x.clone(), s: first.s.clone() };
    let least = match search(closed, &better, None) {
        Ok(second) if second.gamma < first.gamma => second.gamma,
        _ => first.gamma,
    };
    let mut best: Option<Certified> = None;
    for guess in [guess, &better] {
        let Ok(found) = search(closed, guess, Some(least * (1.0 + MARGIN))) else { continue };
        if best.as_ref().is_none_or(|b| found.largest_eigenvalue < b.largest_eigenvalue) {
            best = Some(found);
        }
    }
    match best {
        Some(found) if found.largest_eigenvalue < 0.0 => Ok(found),
        Some(found) => Err(SynthesisError::Numerical {
            stage: STAGE,
            diagnosis: format!(
                "at gamma = {:.4} an eigenvalue of the inequalities has the wrong sign, {:.1e}",
                found.gamma, found.largest_eigenvalue
            ),
        }),
        None => Err(SynthesisError::Numerical {
            stage: STAGE,
            diagnosis: format!("no point found above the least bound {least:.4}"),
        }),
    }
}

/// The least gamma, or the clearest point at a given gamma, sought where the guess is the identity.
fn search(closed: &ClosedLoop, guess: &Guess, gamma: Option<f64>) -> Result<Certified, SynthesisError> {
    let (state, state_inverse) = whitening(&guess.x, "X")?;
    let (channel, channel_inverse) = whitening(&guess.s, "S")?;
    let seen = closed.in_coordinates((&state, &state_inverse), (&channel, &channel_inverse));
    let mut program = Program::new();
    let x = program.symmetric(seen.a.nrows());
    let s = program.symmetric_commuting(&seen.channels);
    let t = program.skew_commuting(&seen.channels);
    let level = match gamma {
        Some(g) => Affine::constant(Mat::from_element(1, 1, g)),
        None => program.scalar(),
    };
    let l = &seen;
    let lmi = bounded_real(
        [[&l.a, &l.bt, &l.b1], [&l.ct, &l.dtt, &l.dt1], [&l.c1, &l.d1t, &l.d11]],
        &level,
        &x,
        &s,
        &t,
    );
    program.positive("X", x.clone());
    program.positive("S", s.clone());
    program.negative("bounded real", lmi);
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
    Ok(Certified { gamma, x, s, t, largest_eigenvalue })
}

/// The largest eigenvalue of the bounded-real matrix, -X and -S, each scaled to a unit diagonal: the sign does
/// not depend on the scaling, and rounding is seen in proportion.
fn worst_eigenvalue(closed: &ClosedLoop, x: &Mat, s: &Mat, t: &Mat, gamma: f64) -> f64 {
    [bounded_real_value(closed, x, s, t, gamma), -x, -s]
        .iter()
        .map(scaled_largest_eigenvalue)
        .fold(f64::MIN, f64::max)
}

fn scaled_largest_eigenvalue(m: &Mat) -> f64 {
    if m.is_empty() {
        return f64::MIN;
    }
    if let Some(wrong) = m.diagonal().iter().copied().find(|d| d.is_nan() || *d >= 0.0) {
        return wrong.abs().max(f64::MIN_POSITIVE);
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
