//! The gain of a system with a bounded parameter rate, on a grid of parameter values.
//!
//! F. Wu, X. H. Yang, A. Packard, G. Becker, "Induced L2-norm control for LPV systems with bounded parameter
//! variation rates", Int. J. Robust Nonlinear Control 6, 1996: `x' = A(theta) x + B(theta) w, z = C(theta) x +
//! D(theta) w` with `|theta'| <= nu` is exponentially stable with an L2 gain below gamma if for every theta and
//! both signs `X(theta) > 0` and
//!
//! ```text
//! [ A'X + XA +- nu dX/dtheta   XB         C'       ]
//! [         *                 -gamma I    D'       ]  < 0,     X(theta) = X_0 + s X_1 + ... + s^d X_d
//! [         *                    *       -gamma I  ]
//! ```
//!
//! with s the parameter mapped to [-1, 1]. The rate enters affinely, so its two extremes suffice. The parameter does
//! not: the inequality is imposed at some samples and checked at all of them, and **between the samples nothing is
//! proved**. [`crate::analysis::bounded_gain()`] proves a bound for parameters of any rate.

use crate::analysis::lyapunov_polynomial::LyapunovPolynomial;
pub use crate::analysis::rate_program::RateOptions;
use crate::analysis::rate_program::{Grid, RateAim, RateSolution, Start, missed, without_signals};
pub use crate::error::RateError;
use crate::error::{SynthesisError, SystemError};
use crate::matrix::{Mat, spectral_abscissa};
use crate::system::StateSpace;

/// The Lyapunov function found, and the margin of the inequality.
#[derive(Debug, Clone, PartialEq)]
pub struct RateProof {
    /// The polynomial X(theta).
    pub lyapunov: LyapunovPolynomial,
    /// The parameter values at which the inequality was imposed.
    pub grid: Vec<f64>,
    /// The largest eigenvalue of the inequality and of -X over all samples, scaled to unit diagonals: negative.
    pub largest_eigenvalue: f64,
}

/// A gain that holds at all samples.
#[derive(Debug, Clone, PartialEq)]
pub struct RateBound {
    /// The gain: 0.1 % (or, if that fails, 1 %) above the least one found, so that the inequality holds strictly.
    pub gamma: f64,
    /// The bound nu on `|theta'|`; infinite for parameters of any rate.
    pub rate: f64,
    /// The Lyapunov function that proves it at the samples.
    pub proof: RateProof,
}

/// Bounds the L2 gain of a system given by samples `(theta, system)`, for `|theta'| <= rate`.
///
/// `rate` is in units of theta per unit of time; 0 means a frozen parameter, infinity a constant X.
///
/// # Errors
/// Returns [`RateError::Unstable`] and [`SynthesisError::Infeasible`] if no gain is finite, the latter for Lyapunov
/// functions of this order; [`SynthesisError::Numerical`] if nothing was decided; the others for invalid input.
pub fn rate_bounded_gain(
    samples: &[(f64, StateSpace)],
    rate: f64,
    options: RateOptions,
) -> Result<RateBound, RateError> {
    rate_bounded_gain_from(samples, rate, options, None)
}

/// Computes [`rate_bounded_gain`] from a constant Lyapunov matrix that proves a known gain: in its coordinates the
/// inequality is well conditioned.
///
/// # Errors
/// Errors of [`rate_bounded_gain`].
pub fn rate_bounded_gain_from(
    samples: &[(f64, StateSpace)],
    rate: f64,
    options: RateOptions,
    known: Option<(&Mat, f64)>,
) -> Result<RateBound, RateError> {
    match least_gain(samples, rate, options, known) {
        // The problem of stability alone is easier to refute if the solver is stuck on an infeasible problem.
        Err(stuck @ RateError::Inequality(SynthesisError::Numerical { .. })) if known.is_none() => {
            match rate_bounded_stability(samples, rate, options) {
                Err(none @ RateError::Inequality(SynthesisError::Infeasible { .. })) => Err(none),
                _ => Err(stuck),
            }
        }
        other => other,
    }
}

fn least_gain(
    samples: &[(f64, StateSpace)],
    rate: f64,
    options: RateOptions,
    known: Option<(&Mat, f64)>,
) -> Result<RateBound, RateError> {
    let system = Grid::new(checked(samples, rate)?, rate, options);
    let mut base = match known {
        Some((x, gamma)) => Start { x: x.clone(), gamma, shows: true },
        None => system.start()?,
    };
    let points = points(&system, options.stride);
    let (gamma, proof) = refine(&system, points, |points| system.least(points, &mut base))?;
    Ok(RateBound { gamma, rate, proof })
}

/// Returns the gain raised by a fraction, with a Lyapunov function of the largest margin: that of the least gain may
/// hold with almost no margin in directions that the gain does not affect.
///
/// # Errors
/// Errors of [`rate_bounded_gain`].
pub(crate) fn with_raised_gamma(
    samples: &[(f64, StateSpace)],
    options: RateOptions,
    found: &RateBound,
    raise: f64,
) -> Result<RateBound, RateError> {
    let system = Grid::new(samples, found.rate, options);
    let values = samples.iter().map(|(theta, _)| found.proof.lyapunov.value(*theta));
    let x = values.sum::<Mat>() / samples.len() as f64;
    let base = Start { x, gamma: (1.0 + raise) * found.gamma, shows: false };
    let points = samples.iter().enumerate().filter(|(_, (theta, _))| found.proof.grid.contains(theta));
    let points = points.map(|(i, _)| i).collect();
    let (gamma, proof) =
        refine(&system, points, |points| Ok(system.search(points, &base, RateAim::Margin)?.0))?;
    Ok(RateBound { gamma, rate: found.rate, proof })
}

/// Finds a Lyapunov function that proves stability for `|theta'| <= rate` at the samples; inputs and outputs do not
/// matter.
///
/// # Errors
/// Errors of [`rate_bounded_gain`].
pub fn rate_bounded_stability(
    samples: &[(f64, StateSpace)],
    rate: f64,
    options: RateOptions,
) -> Result<RateProof, RateError> {
    let free: Vec<(f64, StateSpace)> =
        samples.iter().map(|(theta, s)| (*theta, without_signals(s))).collect();
    let system = Grid::new(checked(&free, rate)?, rate, options);
    let base = system.start()?;
    let points = points(&system, options.stride);
    Ok(refine(&system, points, |points| Ok(system.search(points, &base, RateAim::Stability)?.0))?.1)
}

/// Returns the samples, if they are in order, of one shape and stable.
fn checked(samples: &[(f64, StateSpace)], rate: f64) -> Result<&[(f64, StateSpace)], RateError> {
    let Some((_, like)) = samples.first() else { return Err(RateError::NoSamples) };
    if rate.is_nan() || rate < 0.0 {
        return Err(RateError::NegativeRate { rate });
    }
    let mut before = f64::NEG_INFINITY;
    for (theta, system) in samples {
        let theta = *theta;
        if !theta.is_finite() || theta <= before {
            return Err(RateError::NotAscending { theta });
        }
        before = theta;
        check_shapes(system, like).map_err(|source| RateError::Shape { theta, source })?;
        let re = spectral_abscissa(&system.a);
        if re.is_nan() || re >= 0.0 {
            return Err(RateError::Unstable { theta, re });
        }
    }
    Ok(samples)
}

/// Checks that the matrices fit together and have the numbers of states, inputs and outputs of the first sample.
fn check_shapes(system: &StateSpace, like: &StateSpace) -> Result<(), SystemError> {
    let (n, m, p) = (like.a.nrows(), like.b.ncols(), like.c.nrows());
    for (name, matrix, rows, cols) in
        [("A", &system.a, n, n), ("B", &system.b, n, m), ("C", &system.c, p, n), ("D", &system.d, p, m)]
    {
        if matrix.shape() != (rows, cols) {
            return Err(SystemError::Shape { name, found: matrix.shape(), expected: (rows, cols) });
        }
    }
    Ok(())
}

/// Returns the indices of every `stride`-th sample and of the last.
fn points(system: &Grid<'_>, stride: usize) -> Vec<usize> {
    let last = system.samples.len() - 1;
    (0..last).step_by(stride.max(1)).chain([last]).collect()
}

/// Solves at some of the samples and adds those at which the solution fails, until it holds at all of them; returns the
/// gamma and its proof.
fn refine(
    system: &Grid<'_>,
    mut points: Vec<usize>,
    mut solve: impl FnMut(&[usize]) -> Result<RateSolution, RateError>,
) -> Result<(f64, RateProof), RateError> {
    let samples = system.samples;
    let last = samples.len() - 1;
    loop {
        let solution = solve(&points)?;
        let values: Vec<f64> = (0..=last).map(|i| system.eigenvalue(i, &solution)).collect();
        let worst = (0..=last).max_by(|&i, &j| values[i].total_cmp(&values[j])).unwrap_or(0);
        let (largest_eigenvalue, worst_theta) = (values[worst], samples[worst].0);
        if largest_eigenvalue < 0.0 {
            let grid = points.iter().map(|&i| samples[i].0).collect();
            let proof = RateProof { lyapunov: solution.lyapunov, grid, largest_eigenvalue };
            return Ok((solution.gamma, proof));
        }
        let more = peaks(&values, &points);
        if more.is_empty() {
            return Err(missed(solution.gamma, worst_theta, largest_eigenvalue));
        }
        points.extend(more);
        points.sort_unstable();
    }
}

/// Returns the samples not among `points` at which the inequality fails, and fails worst among the neighbours.
fn peaks(values: &[f64], points: &[usize]) -> Vec<usize> {
    let at = |i: Option<usize>| i.and_then(|i| values.get(i)).copied().unwrap_or(f64::NEG_INFINITY);
    (0..values.len())
        .filter(|&i| values[i] >= 0.0 && !points.contains(&i))
        .filter(|&i| values[i] >= at(i.checked_sub(1)) && values[i] >= at(Some(i + 1)))
        .collect()
}
