//! The ball of models around the fit that contains the true linearisations, with the slope of the trim, at every speed
//! of the range.
//!
//! `[A B1 B2]` of the plant with the fit is off by `L R(V) Q`: `R = [A B G x0'; 0 0 0 u0'](V) - [A B G x0'; 0 0 0
//! u0'](rho)` is what the fit misses, of the waves G as far as there are any; L and Q are where the model is in the
//! plant ([`lpv::tracking::ModelPlace`]). The ball is the set of all `E Delta [F Fw Fu]` with `|Delta| <= 1`.

use crate::error::ProofError;
use certificate::Residual;
use lpv::analysis::GainBound;
use lpv::error::SynthesisError;
use lpv::matrix::{Mat, block, from_rows, largest, largest_singular_value, pseudo_inverse, solve};
use lpv::model_error::ModelError;

/// How far beyond the ball the residual, computed again, may reach: rounding on another processor.
const SAME_BALL: f64 = 1e-6;

/// Singular values of E and `[F Fw Fu]` below this part of the largest count as zero.
const RANK_TOLERANCE: f64 = 1e-13;

/// How far `E P` may be from L and `Q [F Fw Fu]` from G, relatively: rounding.
const SAME_PLACE: f64 = 1e-9;

/// The part of what [A B] misses that each column beside it takes in the ball: the slope of the trim, for the states
/// and for the inputs, and the two of waves. That raises its size by a tenth at most, and with waves by a sixth.
const SLOPE: f64 = 1.0 / 3.0;

/// Between what the units of the slope are, where the fit misses nothing of it or of [A B].
const UNITS: (f64, f64) = (1e-3, 1e3);

/// What a fit misses of the true models, `L R Q` of `[A B1 B2]`, and where that is in the plant.
#[derive(Debug, Clone)]
pub struct Missed {
    /// L, as many rows as the plant has states.
    pub left: Mat,
    /// Q, columns for the states, w and u of the plant.
    pub right: Mat,
    /// R at samples of the parameter that are evenly spaced.
    pub residuals: Vec<Mat>,
    /// The states of the model, with which rows and columns of R begin.
    pub states: usize,
    /// What counts as 1 of each command; their columns follow in R.
    pub scales: Vec<f64>,
}

impl Missed {
    /// The smallest ball, in coordinates in which the Lyapunov matrix of the bound is the identity on the states that
    /// the model moves, and its size e.
    ///
    /// With T upper triangular, `T'(L'XL)T = I`, and `T_x` its part for the model's states,
    ///
    /// ```text
    /// E = sqrt(e) L T P,   [F Fw Fu] = sqrt(e) W^-1 G,   e = max |P^-1 T^-1 R(V) W|
    /// ```
    ///
    /// W is `blkdiag(T_x, S_u, d)`, with the inputs' scales and units d of the states of waves and of the rate of the
    /// trim, `P = blkdiag(I, p I)` has a unit p of how the inputs' trim moves. With d and p the error of each such
    /// column is, for the states and for the inputs, a third of the largest one of `[A B]`. The maximum is taken over
    /// the samples and raised by a bound on the rise between two of them: see `between_samples`.
    ///
    /// # Errors
    /// [`SynthesisError::Numerical`] when the bound's Lyapunov matrix is not positive definite.
    pub fn smallest(&self, bound: &GainBound) -> Result<(ModelError, f64), SynthesisError> {
        let Self { left, right, residuals, states, scales } = self;
        let (states, m, n) = (*states, scales.len(), left.nrows());
        let (rows, columns) = (left.ncols(), right.nrows());
        // L'XL = C C', so T = C^-T.
        let own = left.transpose() * bound.x.view((0, 0), (n, n)) * left;
        let mut t_inverse = own.cholesky().ok_or_else(not_definite)?.l().transpose();
        let mut t = solve(&t_inverse, &Mat::identity(rows, rows)).ok_or_else(not_definite)?;
        let mut w = Mat::identity(columns, columns);
        w.view_mut((0, 0), (states, states)).copy_from(&t.view((0, 0), (states, states)));
        for (j, scale) in scales.iter().enumerate() {
            w[(states + j, states + j)] = *scale;
        }
        let scaled: Vec<Mat> = residuals.iter().map(|r| &t_inverse * r * &w).collect();
        for column in states + m..columns {
            let most = |(row, height), (column, width)| {
                let part =
                    |r: &Mat| largest_singular_value(&r.view((row, column), (height, width)).into_owned());
                largest(0.0, scaled.iter().map(part))
            };
            let (of_states, of_inputs, beside) = ((0, states), (states, rows - states), (column, 1));
            let missed = most(of_states, beside).max(f64::MIN_POSITIVE);
            w[(column, column)] = (SLOPE * most(of_states, (0, states + m)) / missed).clamp(UNITS.0, UNITS.1);
            if column + 1 < columns {
                continue;
            }
            let unit = (most(of_inputs, beside) / missed).clamp(UNITS.0, UNITS.1);
            t.columns_mut(states, rows - states).scale_mut(unit);
            t_inverse.rows_mut(states, rows - states).scale_mut(1.0 / unit);
        }
        let size = reach(residuals.iter().map(|r| &t_inverse * r * &w));
        let seen = solve(&w, right).ok_or_else(not_definite)? * size.sqrt();
        let part = |at: usize, count: usize| seen.columns(at, count).into_owned();
        let inputs = right.ncols() - n - m;
        let error = ModelError {
            e: left * t * size.sqrt(),
            f: part(0, n),
            fw: part(n, inputs),
            fu: part(n + inputs, m),
        };
        Ok((error, size))
    }

    /// Checks that the ball of a certificate contains the true models, computed again.
    ///
    /// With `P = E^+ L` and `Q = G [F Fw Fu]^+` the Delta of a residual is `P R Q`; it has to be no larger than 1 with
    /// the reserve between samples, and `E P = L`, `Q [F Fw Fu] = G` must hold to rounding. With `held` the rows of
    /// Delta from there on must be 0 where the trim stands still, which then leaves R only the rows of the model's
    /// states.
    ///
    /// # Errors
    /// [`ProofError::Ball`] when the ball is too small, or none of this shape.
    pub fn check(&self, ball: &Residual, held: Option<usize>) -> Result<(), ProofError> {
        let Self { left, right, residuals, states, scales } = self;
        let shapeless = || ProofError::Ball { reach: None };
        let (n, m) = (left.nrows(), scales.len());
        let w = right.ncols() - n - m;
        let ModelError { e, f, fw, fu } = ball_of(ball, (n, w, m)).ok_or_else(shapeless)?;
        if e.nrows() != n || [&fw, &fu].iter().any(|part| part.nrows() != f.nrows()) {
            return Err(shapeless());
        }
        let seen = block(&[&[&f, &fw, &fu]]);
        let (p, q) =
            (pseudo_inverse(&e, RANK_TOLERANCE) * left, right * pseudo_inverse(&seen, RANK_TOLERANCE));
        let same = |found: Mat, wanted: &Mat| {
            (found - wanted).iter().all(|off| off.abs() <= SAME_PLACE * wanted.amax())
        };
        let first = held.unwrap_or(p.nrows()).min(p.nrows());
        let beyond = p.view((first, 0), (p.nrows() - first, *states));
        let is_still = beyond.iter().all(|entry| entry.abs() <= SAME_PLACE * p.amax());
        if !same(&e * &p, left) || !same(&q * &seen, right) || !is_still {
            return Err(shapeless());
        }
        let reach = reach(residuals.iter().map(|r| &p * r * &q));
        if reach <= 1.0 + SAME_BALL {
            Ok(())
        } else {
            Err(ProofError::Ball { reach: reach.is_finite().then_some(reach) })
        }
    }

    /// The sample before the one at which R bends most; `None` for fewer than three.
    pub fn most_bent(&self) -> Option<usize> {
        let each = second_differences(&self.residuals).enumerate();
        each.max_by(|a, b| a.1.total_cmp(&b.1)).map(|(i, _)| i)
    }
}

/// `E`, `F`, `Fw` and `Fu` of a certificate for n states and m commands; `None` when they are ragged.
pub(crate) fn ball_of(ball: &Residual, (n, w, m): (usize, usize, usize)) -> Option<ModelError> {
    let columns = ball.e.first().map_or(0, Vec::len);
    let [e, f, fw, fu] = [(&ball.e, columns), (&ball.f, n), (&ball.fw, w), (&ball.fu, m)]
        .map(|(rows, columns)| from_rows(rows, columns));
    Some(ModelError { e: e?, f: f?, fw: fw?, fu: fu? })
}

/// The largest singular value over samples of a curve of matrices, with a reserve for the rise between them;
/// not-a-number when a sample contains one.
fn reach(samples: impl Iterator<Item = Mat>) -> f64 {
    let samples: Vec<Mat> = samples.collect();
    largest(0.0, samples.iter().map(largest_singular_value)) + between_samples(&samples)
}

fn not_definite() -> SynthesisError {
    SynthesisError::numerical("model error", "the Lyapunov matrix is not positive definite")
}

/// A bound of how far the residual may rise above its samples: 17/8 of the largest second difference D.
///
/// Let `R = S + J (V - v)_+` on an interval of length h between two speeds, with S smooth, `C = h^2 max |S''|`, and a
/// kink of slope J at the fraction s of the interval, because A has kinks where w|w| changes sign. The norm is
/// convex, so that on the chord it is largest at an end, and R leaves the chord by at most
///
/// ```text
/// C/8 + s (1 - s) h |J|
/// ```
///
/// (for S: linear interpolation, for instance K. Atkinson, An Introduction to Numerical Analysis, 1989, eq. 3.1.10).
/// The second difference at the interval's first speed contains `(1 - s) h J`, the one at its last speed `s h J`, and S
/// adds C at most to either. In the first and the last interval of the range only one of the two exists, but each
/// gives `s (1 - s) h |J| <= D + C`; together at most `9/8 C + D`. That is 17/8 D where `C <= D`, that is, where the
/// second differences of a thousand speeds show somewhere how much S bends, and where no two kinks share an interval
/// or lie in neighbouring ones.
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

    /// How far a curve rises above its samples, and the reserve for it.
    fn rise_and_reserve(curve: impl Fn(f64) -> f64) -> (f64, f64) {
        let samples: Vec<Mat> =
            (0..=INTERVALS).map(|i| Mat::from_element(1, 1, curve(H * f64::from(i)))).collect();
        let sampled = samples.iter().map(largest_singular_value).fold(0.0, f64::max);
        let highest =
            (0..=1000 * INTERVALS).map(|i| curve(H * f64::from(i) / 1000.0).abs()).fold(0.0, f64::max);
        (highest - sampled, between_samples(&samples))
    }

    /// A kink anywhere in any interval, the first and the last among them, upon a parabola that bends with it or
    /// against it.
    #[test]
    fn the_reserve_covers_kinks_and_curves() {
        let mut hidden = 0;
        for interval in 0..INTERVALS {
            for fraction in [0.02, 0.1, 0.3, 0.5, 0.8, 0.98] {
                for bend in [-0.2, 0.0, 0.2] {
                    let kink = H * (f64::from(interval) + fraction);
                    let curve = |x: f64| 1.0 - (x - kink).abs() + bend * (x - kink).powi(2);
                    let (rise, reserve) = rise_and_reserve(curve);
                    assert!(rise <= reserve, "kink at {kink}, bend {bend}: {rise} above {reserve}");
                    hidden += i32::from(rise > 0.5 / (17.0 / 8.0) * reserve);
                }
            }
        }
        assert!(hidden > 0, "some of these would need more than half of the second difference");
        let (rise, reserve) = rise_and_reserve(|x| 1.0 - (x - 0.35).powi(2));
        assert!(0.0 < rise && rise <= reserve);
    }
}
