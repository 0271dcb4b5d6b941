//! Uncontrollable and unobservable modes.
//!
//! The reachable subspace: R. E. Kalman, "Mathematical description of linear dynamical systems", SIAM J. Control 1,
//! 1963.

use crate::error::SynthesisError;
use crate::matrix::{Mat, eigenvalues};
use crate::riccati::equations::{is_stabilisable, unreached};
use crate::riccati::wide::{is_stable, narrow};
use crate::synthesis::balance::{Coordinates, power_of_two};
use crate::system::GeneralisedPlant;
use nalgebra::Complex;

/// Returns an unreachable mode with `Re >= 0`, the fastest growing. A is n x n, B n x m; rad/s.
///
/// A stabilising feedback proves that there is none. A mode is reported only if it is unreachable for the given numbers
/// to 32 digits: a mode that is unreachable only to the rounding of 16 digits is taken as reachable.
pub fn unreachable_mode(a: &Mat, b: &Mat) -> Option<Complex<f64>> {
    let size = |m: &Mat| if m.norm() > 0.0 { power_of_two(m.norm()) } else { 1.0 };
    let b = b * (size(a) / size(b));
    if is_stabilisable(&(a / size(a)), &(&b / size(a))) {
        return None;
    }
    let rest = unreached(a, &b);
    if is_stable(&rest) {
        return None;
    }
    eigenvalues(&narrow(&rest)).into_iter().max_by(|p, q| p.re.total_cmp(&q.re))
}

/// Checks that every mode of the plant at Theta = 0 that is not stable is controllable from u.
///
/// # Errors
/// Returns [`SynthesisError::NotStabilisable`] with the mode.
pub fn check_stabilisable(plant: &GeneralisedPlant) -> Result<(), SynthesisError> {
    match lost_mode(plant, |balanced| (balanced.a(), balanced.b2()))? {
        Some(mode) => Err(SynthesisError::NotStabilisable { re: mode.re, im: mode.im }),
        None => Ok(()),
    }
}

/// Checks that every mode of the plant at Theta = 0 that is not stable is observable from y.
///
/// # Errors
/// Returns [`SynthesisError::NotDetectable`] with the mode.
pub fn check_detectable(plant: &GeneralisedPlant) -> Result<(), SynthesisError> {
    match lost_mode(plant, |balanced| (balanced.a().transpose(), balanced.c2().transpose()))? {
        Some(mode) => Err(SynthesisError::NotDetectable { re: mode.re, im: mode.im }),
        None => Ok(()),
    }
}

/// Rejects plants with numbers that overflow, for which nothing can be shown.
fn check_finite(plant: &GeneralisedPlant) -> Result<(), SynthesisError> {
    if eigenvalues(&plant.a()).iter().all(|v| v.re.is_finite() && v.im.is_finite()) {
        return Ok(());
    }
    Err(SynthesisError::numerical(
        "modes of the plant",
        "the eigenvalues of A cannot be computed: its numbers are too large",
    ))
}

/// Returns a mode, in the user's unit of time, that is not stable and not reachable from the input matrix of a pair.
/// Rank is determined in balanced coordinates, since in badly scaled ones every mode seems unreachable; the scale
/// factors are powers of two and cause no rounding.
fn lost_mode(
    plant: &GeneralisedPlant,
    pair: impl Fn(&GeneralisedPlant) -> (Mat, Mat),
) -> Result<Option<Complex<f64>>, SynthesisError> {
    let coordinates = Coordinates::diagonal(plant).in_powers_of_two();
    let balanced = coordinates.apply(plant);
    check_finite(&balanced)?;
    let (a, b) = pair(&balanced);
    Ok(unreachable_mode(&a, &b).map(|mode| mode / coordinates.scaled_rate(1.0)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::dmatrix;

    #[test]
    fn the_unreachable_mode_is_reported() {
        let a = dmatrix![-1.0, 0.0; 0.0, 0.5];
        assert_eq!(unreachable_mode(&a, &dmatrix![1.0; 0.0]), Some(Complex::new(0.5, 0.0)));
        assert_eq!(unreachable_mode(&a, &dmatrix![0.0; 1.0]), None);
        // Neither a fast mode nor a slow stable unreachable one makes a mode at zero look unreachable.
        let a = dmatrix![0.0, 0.0, 0.0; 0.0, -1e-8, 0.0; 0.0, 0.0, -1e12];
        assert_eq!(unreachable_mode(&a, &dmatrix![1.0; 0.0; 0.0]), None);
        assert_eq!(unreachable_mode(&a, &dmatrix![0.0; 1.0; 1.0]), Some(Complex::new(0.0, 0.0)));
    }
}
