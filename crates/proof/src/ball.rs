//! Ball of models around the fit. It contains the true linearisation and the slope of the trim at every speed of the
//! range.
//!
//! The error of `[A B1 B2]` of the plant with the fit is `L R(V) Q`. `R = [A B G x0'; 0 0 0 u0'](V) - [A B G x0'; 0 0 0
//! u0'](rho)` is the residual of the fit, without G if there are no waves; L and Q locate the model within the plant
//! ([`squid_lpv::tracking::ModelPosition`]). The ball is the set of all `E Delta [F Fw Fu]` with `|Delta| <= 1`.

use crate::error::ProofError;
use squid_lpv::analysis::GainBound;
use squid_lpv::error::SynthesisError;
use squid_lpv::matrix::{Mat, block, from_rows, largest, largest_singular_value, pseudo_inverse, solve};
use squid_lpv::model_error::ModelError;

/// Relative tolerance by which the recomputed residual may exceed the ball, for rounding on another processor.
const SAME_BALL: f64 = 1e-6;

/// Fraction of the largest singular value of E and `[F Fw Fu]` below which others count as zero.
const RANK_TOLERANCE: f64 = 1e-13;

/// Relative tolerance of `E P = L` and `S [F Fw Fu] = Q`, for rounding.
const PRODUCT_TOLERANCE: f64 = 1e-9;

/// Error of each further column (the slope of the trim, and two columns of waves), as a fraction of the error of [A B]
/// in the ball, for the states and for the inputs. It increases the size of the ball by at most a tenth, with waves by
/// at most a sixth.
const SLOPE_FRACTION: f64 = 1.0 / 3.0;

/// Bounds of the units of the slope, for a fit without error in the slope or in [A B].
const UNITS: (f64, f64) = (1e-3, 1e3);

/// Residual of a fit, as the error `L R Q` of `[A B1 B2]` of the plant.
#[derive(Debug, Clone)]
pub struct ModelResidual {
    /// Matrix L, with one row per state of the plant.
    pub left: Mat,
    /// Matrix Q, with columns for the states, w and u of the plant.
    pub right: Mat,
    /// Matrices R at evenly spaced samples of the parameter.
    pub residuals: Vec<Mat>,
    /// Number of states of the model, which are the first rows and columns of R.
    pub states: usize,
    /// Unit of each command; the columns of the commands follow in R.
    pub scales: Vec<f64>,
}

impl ModelResidual {
    /// Returns the smallest ball, and its size e, in the coordinates in which the Lyapunov matrix of the bound is the
    /// identity on the states that the model drives.
    ///
    /// With T upper triangular, `T'(L'XL)T = I`, and `T_x` its block of the model's states,
    ///
    /// ```text
    /// E = sqrt(e) L T P,   [F Fw Fu] = sqrt(e) W^-1 Q,   e = max |P^-1 T^-1 R(V) W|
    /// ```
    ///
    /// W is `blkdiag(T_x, S_u, d)`, with the scales of the inputs and the units d of the wave states and of the rate of
    /// the trim; `P = blkdiag(I, p I)` has the unit p of the change of the trim inputs. d and p are chosen so that the
    /// error of each such column is, for the states and for the inputs, a third of the largest error of `[A B]`. The
    /// maximum is taken over the samples, plus a bound on the rise between two of them: see `between_samples`.
    ///
    /// # Errors
    /// [`SynthesisError::Numerical`] if the bound's Lyapunov matrix is not positive definite.
    pub fn smallest(&self, bound: &GainBound) -> Result<(ModelError, f64), SynthesisError> {
        let Self { left, right, residuals, states, scales } = self;
        let (states, m, n) = (*states, scales.len(), left.nrows());
        let (rows, columns) = (left.ncols(), right.nrows());
        // T = C^-T, because L'XL = C C'.
        let gram = left.transpose() * bound.x.view((0, 0), (n, n)) * left;
        let mut t_inverse = gram.cholesky().ok_or_else(not_definite)?.l().transpose();
        let mut t = solve(&t_inverse, &Mat::identity(rows, rows)).ok_or_else(not_definite)?;
        let mut w = Mat::identity(columns, columns);
        w.view_mut((0, 0), (states, states)).copy_from(&t.view((0, 0), (states, states)));
        for (j, scale) in scales.iter().enumerate() {
            w[(states + j, states + j)] = *scale;
        }
        let scaled: Vec<Mat> = residuals.iter().map(|r| &t_inverse * r * &w).collect();
        for column in states + m..columns {
            let largest_part = |(row, height), (column, width)| {
                let part =
                    |r: &Mat| largest_singular_value(&r.view((row, column), (height, width)).into_owned());
                largest(0.0, scaled.iter().map(part))
            };
            let (of_states, of_inputs, own_column) = ((0, states), (states, rows - states), (column, 1));
            let error_of_states = largest_part(of_states, own_column).max(f64::MIN_POSITIVE);
            w[(column, column)] = (SLOPE_FRACTION * largest_part(of_states, (0, states + m))
                / error_of_states)
                .clamp(UNITS.0, UNITS.1);
            if column + 1 < columns {
                continue;
            }
            let unit = (largest_part(of_inputs, own_column) / error_of_states).clamp(UNITS.0, UNITS.1);
            t.columns_mut(states, rows - states).scale_mut(unit);
            t_inverse.rows_mut(states, rows - states).scale_mut(1.0 / unit);
        }
        let size = reach(residuals.iter().map(|r| &t_inverse * r * &w));
        let output = solve(&w, right).ok_or_else(not_definite)? * size.sqrt();
        let part = |at: usize, count: usize| output.columns(at, count).into_owned();
        let inputs = right.ncols() - n - m;
        let error = ModelError {
            e: left * t * size.sqrt(),
            f: part(0, n),
            fw: part(n, inputs),
            fu: part(n + inputs, m),
        };
        Ok((error, size))
    }

    /// Checks that the ball of a certificate contains the recomputed true models.
    ///
    /// With `P = E^+ L` and `S = Q [F Fw Fu]^+` the Delta of a residual is `P R S`. Its norm, with the margin between
    /// samples, must be at most 1, and `E P = L`, `S [F Fw Fu] = Q` must hold to rounding. If `held` is given, the rows
    /// of Delta from that index on must be 0 while the trim is constant; R then has only the rows of the model's
    /// states.
    ///
    /// # Errors
    /// [`ProofError::Ball`] if the ball is too small, or has the wrong shape.
    pub fn check(&self, ball: &squid_certificate::ModelError, held: Option<usize>) -> Result<(), ProofError> {
        let Self { left, right, residuals, states, scales } = self;
        let wrong_shape = || ProofError::Ball { reach: None };
        let (n, m) = (left.nrows(), scales.len());
        let w = right.ncols() - n - m;
        let ModelError { e, f, fw, fu } = ball_of(ball, n, w, m).ok_or_else(wrong_shape)?;
        if e.nrows() != n || [&fw, &fu].iter().any(|part| part.nrows() != f.nrows()) {
            return Err(wrong_shape());
        }
        let output = block(&[&[&f, &fw, &fu]]);
        let (p, s) =
            (pseudo_inverse(&e, RANK_TOLERANCE) * left, right * pseudo_inverse(&output, RANK_TOLERANCE));
        let same = |found: Mat, expected: &Mat| {
            (found - expected).iter().all(|off| off.abs() <= PRODUCT_TOLERANCE * expected.amax())
        };
        let first = held.unwrap_or(p.nrows()).min(p.nrows());
        let beyond = p.view((first, 0), (p.nrows() - first, *states));
        let is_still = beyond.iter().all(|entry| entry.abs() <= PRODUCT_TOLERANCE * p.amax());
        if !same(&e * &p, left) || !same(&s * &output, right) || !is_still {
            return Err(wrong_shape());
        }
        let reach = reach(residuals.iter().map(|r| &p * r * &s));
        if reach <= 1.0 + SAME_BALL {
            Ok(())
        } else {
            Err(ProofError::Ball { reach: reach.is_finite().then_some(reach) })
        }
    }

    /// Returns the index of the sample before the one with the largest second difference of R; `None` for fewer than
    /// three samples.
    pub fn largest_bend(&self) -> Option<usize> {
        let each = second_differences(&self.residuals).enumerate();
        each.max_by(|a, b| a.1.total_cmp(&b.1)).map(|(i, _)| i)
    }
}

/// Returns `E`, `F`, `Fw` and `Fu` of a certificate for n states, w inputs and m commands; `None` if their rows have
/// wrong lengths.
pub(crate) fn ball_of(
    ball: &squid_certificate::ModelError,
    n: usize,
    w: usize,
    m: usize,
) -> Option<ModelError> {
    let columns = ball.e.first().map_or(0, Vec::len);
    let [e, f, fw, fu] = [(&ball.e, columns), (&ball.f, n), (&ball.fw, w), (&ball.fu, m)]
        .map(|(rows, columns)| from_rows(rows, columns));
    Some(ModelError { e: e?, f: f?, fw: fw?, fu: fu? })
}

/// Returns the largest singular value over samples of a matrix function, plus a margin for the rise between them; NaN
/// if a sample contains NaN.
fn reach(samples: impl Iterator<Item = Mat>) -> f64 {
    let samples: Vec<Mat> = samples.collect();
    largest(0.0, samples.iter().map(largest_singular_value)) + between_samples(&samples)
}

fn not_definite() -> SynthesisError {
    SynthesisError::numerical("model error", "the Lyapunov matrix is not positive definite")
}

/// Returns a bound on the rise of the residual between its samples: 17/8 of the largest second difference D.
///
/// Let `R = S + J (V - v)_+` on an interval of length h between two speeds, with S smooth, `C = h^2 max |S''|`, and a
/// kink of slope J at the fraction s of the interval, because A has kinks where w|w| changes sign. The norm is convex,
/// so on the chord it is largest at an end, and R deviates from the chord by at most
///
/// ```text
/// C/8 + s (1 - s) h |J|
/// ```
///
/// (for S: linear interpolation, for instance K. Atkinson, An Introduction to Numerical Analysis, 1989, eq. 3.1.10).
/// The second difference at the interval's first speed contains `(1 - s) h J`, the one at its last speed `s h J`, and S
/// adds at most C to either. In the first and the last interval of the range only one of the two exists, but each gives
/// `s (1 - s) h |J| <= D + C`; together at most `9/8 C + D`. That is 17/8 D if `C <= D`, that is, if some second
/// difference at a thousand speeds reveals the curvature of S, and if no two kinks lie in the same or in neighbouring
/// intervals.
fn between_samples(residuals: &[Mat]) -> f64 {
    17.0 / 8.0 * largest(0.0, second_differences(residuals))
}

fn second_differences(residuals: &[Mat]) -> impl Iterator<Item = f64> {
    residuals.windows(3).map(|w| largest_singular_value(&(&w[0] - &w[1] * 2.0 + &w[2])))
}

#[cfg(test)]
mod tests {
    use super::*;

    const H: f64 = 0.1;
    const INTERVALS: i32 = 8;

    /// Returns the rise of a curve above its samples, and the margin for it.
    fn rise_and_margin(curve: impl Fn(f64) -> f64) -> (f64, f64) {
        let samples: Vec<Mat> =
            (0..=INTERVALS).map(|i| Mat::from_element(1, 1, curve(H * f64::from(i)))).collect();
        let sampled = samples.iter().map(largest_singular_value).fold(0.0, f64::max);
        let highest =
            (0..=1000 * INTERVALS).map(|i| curve(H * f64::from(i) / 1000.0).abs()).fold(0.0, f64::max);
        (highest - sampled, between_samples(&samples))
    }

    /// Checks kinks at various positions in every interval, including the first and the last, on a parabola that bends
    /// with or against them.
    #[test]
    fn margin_covers_kinks_and_curvature() {
        let mut hidden = 0;
        for interval in 0..INTERVALS {
            for fraction in [0.02, 0.1, 0.3, 0.5, 0.8, 0.98] {
                for bend in [-0.2, 0.0, 0.2] {
                    let kink = H * (f64::from(interval) + fraction);
                    let curve = |x: f64| 1.0 - (x - kink).abs() + bend * (x - kink).powi(2);
                    let (rise, margin) = rise_and_margin(curve);
                    assert!(rise <= margin, "kink at {kink}, bend {bend}: {rise} above {margin}");
                    hidden += i32::from(rise > 0.5 / (17.0 / 8.0) * margin);
                }
            }
        }
        assert!(hidden > 0, "some of these would need more than half of the second difference");
        let (rise, margin) = rise_and_margin(|x| 1.0 - (x - 0.35).powi(2));
        assert!(0.0 < rise && rise <= margin);
    }
}
