//! Modes that no control reaches or no measurement shows.
//!
//! Popov-Belevitch-Hautus test: the mode lambda of A is reached by B when `[A - lambda I, B]` has full row rank.
//! M. L. J. Hautus, Indag. Math. 31, 1969.

use crate::balance::Coordinates;
use crate::error::SynthesisError;
use crate::matrix::{Mat, complex_singular_values, eigenvalues};
use crate::plant::GeneralisedPlant;
use nalgebra::{Complex, DMatrix};

/// A mode with non-negative real part counts as out of reach when the least singular value of the pencil is
/// below this fraction of the largest.
const RANK_TOLERANCE: f64 = 1e-10;

/// The first mode with `Re >= 0` that B does not reach.
pub fn unreachable_mode(a: &Mat, b: &Mat) -> Option<Complex<f64>> {
    eigenvalues(a).into_iter().filter(|mode| mode.re >= 0.0).find(|mode| {
        let n = a.nrows();
        let pencil = DMatrix::from_fn(n, n + b.ncols(), |i, j| {
            let entry = if j < n { a[(i, j)] } else { b[(i, j - n)] };
            Complex::new(entry, 0.0) - if i == j { *mode } else { Complex::new(0.0, 0.0) }
        });
        let values = complex_singular_values(&pencil);
        matches!((values.first(), values.last()), (Some(most), Some(least)) if *least <= RANK_TOLERANCE * most)
    })
}

/// Checks that u reaches every mode of the plant at Theta = 0 that does not decay.
///
/// # Errors
/// [`SynthesisError::NotStabilisable`] with the mode.
pub fn check_stabilisable(plant: &GeneralisedPlant) -> Result<(), SynthesisError> {
    let balanced = Coordinates::diagonal(plant).apply(plant);
    match unreachable_mode(&balanced.a, &balanced.b2).map(|mode| in_users_time(mode, plant)) {
        Some(mode) => Err(SynthesisError::NotStabilisable { re: mode.re, im: mode.im }),
        None => Ok(()),
    }
}

/// Checks that y shows every mode of the plant at Theta = 0 that does not decay.
///
/// # Errors
/// [`SynthesisError::NotDetectable`] with the mode.
pub fn check_detectable(plant: &GeneralisedPlant) -> Result<(), SynthesisError> {
    let balanced = Coordinates::diagonal(plant).apply(plant);
    let unseen = unreachable_mode(&balanced.a.transpose(), &balanced.c2.transpose());
    match unseen.map(|mode| in_users_time(mode, plant)) {
        Some(mode) => Err(SynthesisError::NotDetectable { re: mode.re, im: mode.im }),
        None => Ok(()),
    }
}

/// A mode of the balanced plant, in the user's unit of time. (Rank is judged in balanced coordinates: in badly scaled ones
/// everything looks unreachable.)
fn in_users_time(mode: Complex<f64>, plant: &GeneralisedPlant) -> Complex<f64> {
    mode / Coordinates::diagonal(plant).scaled_rate(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::dmatrix;

    #[test]
    fn the_mode_is_named() {
        let a = dmatrix![-1.0, 0.0; 0.0, 0.5];
        assert_eq!(unreachable_mode(&a, &dmatrix![1.0; 0.0]), Some(Complex::new(0.5, 0.0)));
        assert_eq!(unreachable_mode(&a, &dmatrix![0.0; 1.0]), None);
    }
}
