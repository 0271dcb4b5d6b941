//! The ball of models around the fit that contains [A B] of the true linearisations at every speed of the range. The
//! slope of the trim is not in it: it is the fit's.
//!
//! `[A B2]` of the fit is off by `R(V) = [A B2](V) - [A B2](rho)`. The ball is the set of all `E Delta [F Fu]` with
//! `|Delta| <= 1`.

use crate::augment::forces;
use crate::error::{Error, ProofError};
use crate::fit::Model;
use crate::inputs::design_file::DesignFile;
use crate::linearise::{linearise_at, scaled, stacked};
use auv::Vehicle;
use certificate::Residual;
use lpv::analysis::GainBound;
use lpv::matrix::{Mat, block, from_rows, largest, largest_singular_value, solve};
use lpv::model_error::ModelError;
use lpv::plant::GeneralisedPlant;

/// Speeds at which the fit's residual is taken.
pub const SAMPLES: usize = 1001;

/// How far beyond the ball the residual, computed again, may reach: rounding on another processor.
const SAME_BALL: f64 = 1e-6;

/// The smallest ball, in coordinates in which the Lyapunov matrix of the bound is the identity on the model's states
/// and each input is in units of its scale; and its size e.
///
/// With `T` those coordinates and `R~(V) = T^-1 R [T 0; 0 S_u]`, `E = sqrt(e) T` and `[F Fu] = sqrt(e) [T^-1 0; 0
/// S_u^-1]` where `e = max |R~(V)|`. The maximum is taken over [`SAMPLES`] speeds and raised by a bound on the rise
/// between two of them: see `between_samples`. The LFT that was designed on is subtracted, not the polynomial, so
/// that what was dropped there is covered, too. The plant's u is in units of the scales `S_u` already, so that its Fu
/// is the identity times sqrt(e).
///
/// # Errors
/// [`Error::Synthesis`] when the bound's Lyapunov matrix is not positive definite; those of the linearisation.
pub fn smallest_ball(
    vehicle: &Vehicle,
    file: &DesignFile,
    model: &Model,
    plant: &GeneralisedPlant,
    bound: &GainBound,
) -> Result<(ModelError, f64), Error> {
    let states = file.states.len();
    let own = bound.x.view((0, 0), (states, states)).into_owned();
    // X = L L', so T = L^-T.
    let t_inverse = own.cholesky().ok_or_else(not_definite)?.l().transpose();
    let t = solve(&t_inverse, &Mat::identity(states, states)).ok_or_else(not_definite)?;
    let m = vehicle.actuators.len();
    let right = block(&[&[&t, &Mat::zeros(states, m)], &[&Mat::zeros(m, states), &Mat::identity(m, m)]]);
    let size = reach(residuals(vehicle, file, model)?.iter().map(|r| &t_inverse * r * &right));
    let (n, root) = (plant.a().nrows(), size.sqrt());
    let mut e = Mat::zeros(n, states);
    e.view_mut((0, 0), (states, states)).copy_from(&(&t * root));
    let mut f = Mat::zeros(states + m, n + m);
    f.view_mut((0, 0), (states, states)).copy_from(&(&t_inverse * root));
    f.rows_mut(states, m).copy_from(&(forces(&vehicle.actuators, file, n) * root));
    let fu = f.columns(n, m).into_owned();
    Ok((ModelError { e, f: f.columns(0, n).into_owned(), fu }, size))
}

/// Checks that the ball of a certificate contains [A B] of the true linearisations of the vehicle, computed again.
///
/// The Delta of a residual is `Delta = E_1^-1 R [F_1 Fu]^-1`, with the rows of E and the columns of F that belong to
/// the model's states; it has to be no larger than 1 with the reserve between samples, and no other row of E may be
/// needed.
///
/// # Errors
/// [`ProofError::Ball`] when the ball is too small, or none of this shape; those of the linearisation.
pub fn holds(ball: &Residual, vehicle: &Vehicle, file: &DesignFile, model: &Model) -> Result<(), Error> {
    let (states, m) = (file.states.len(), vehicle.actuators.len());
    let shapeless = || ProofError::Ball { reach: None };
    let n = ball.f.first().map_or(0, Vec::len);
    let e = from_rows(&ball.e, states).filter(|e| e.nrows() == n && n >= states).ok_or_else(shapeless)?;
    let f = from_rows(&ball.f, n).filter(|f| f.nrows() == states + m).ok_or_else(shapeless)?;
    let fu = from_rows(&ball.fu, m).filter(|fu| fu.nrows() == states + m).ok_or_else(shapeless)?;
    let invert = |a: &Mat| solve(a, &Mat::identity(a.nrows(), a.nrows())).ok_or_else(shapeless);
    // [F Fu] = H G with G from states and commands to what the model is driven by. Each row of G has a column that no
    // other row needs, of 1 or -1, its last: H consists of these columns, and nothing else may be in [F Fu].
    let mut g = Mat::zeros(states + m, n + m);
    g.view_mut((0, 0), (states, states)).fill_with_identity();
    g.rows_mut(states, m).copy_from(&forces(&vehicle.actuators, file, n));
    let last = |row: usize| (0..n + m).rev().find(|column| g[(row, *column)] != 0.0).unwrap_or(row);
    let own: Vec<usize> = (0..states + m).map(last).collect();
    let whole = block(&[&[&f, &fu]]);
    let h = Mat::from_fn(states + m, states + m, |i, j| whole[(i, own[j])] * g[(j, own[j])]);
    let is_zero = |part: &Mat| part.iter().all(|entry| *entry == 0.0);
    if !is_zero(&e.rows(states, n - states).into_owned()) || whole != &h * &g {
        return Err(shapeless().into());
    }
    let left = invert(&e.rows(0, states).into_owned())?;
    let right = invert(&h)?;
    let reach = reach(residuals(vehicle, file, model)?.iter().map(|r| &left * r * &right));
    if reach <= 1.0 + SAME_BALL {
        Ok(())
    } else {
        Err(ProofError::Ball { reach: reach.is_finite().then_some(reach) }.into())
    }
}

/// `[dA, dB S_u]` over the range of speed: what the fit misses, each input in units of its scale.
fn residuals(vehicle: &Vehicle, file: &DesignFile, model: &Model) -> Result<Vec<Mat>, Error> {
    let (centre, half_range) = file.scheduling();
    let at = |v: f64| -> Result<Mat, Error> {
        let truth = stacked(&linearise_at(vehicle, file, v)?);
        Ok(scaled(&vehicle.actuators, truth - model.lft.evaluate(&[(v - centre) / half_range])?))
    };
    file.spread(SAMPLES).into_iter().map(at).collect()
}

/// The largest singular value over samples of a curve of matrices, with a reserve for the rise between them;
/// not-a-number when a sample contains one.
fn reach(samples: impl Iterator<Item = Mat>) -> f64 {
    let samples: Vec<Mat> = samples.collect();
    largest(0.0, samples.iter().map(largest_singular_value)) + between_samples(&samples)
}

fn not_definite() -> Error {
    let diagnosis = "the Lyapunov matrix is not positive definite".into();
    lpv::error::SynthesisError::Numerical { stage: "model error", diagnosis }.into()
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

/// Whether the range of speed holds 0 inside, and the linearisation bends more there than anywhere else.
///
/// # Errors
/// Those of the linearisation.
pub fn bends_at_rest(vehicle: &Vehicle, file: &DesignFile, model: &Model) -> Result<bool, Error> {
    if file.speed_min >= 0.0 || file.speed_max <= 0.0 {
        return Ok(false);
    }
    let residuals = residuals(vehicle, file, model)?;
    let most = second_differences(&residuals).enumerate().max_by(|a, b| a.1.total_cmp(&b.1));
    let speeds = file.spread(SAMPLES);
    Ok(most.is_some_and(|(i, _)| speeds[i] <= 0.0 && 0.0 <= speeds[i + 2]))
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
