//! Modes that no control reaches or no measurement shows.
//!
//! Popov-Belevitch-Hautus test: the mode lambda of A is reached by B when `[A - lambda I, B]` has full row rank.
//! M. L. J. Hautus, Indag. Math. 31, 1969.

use crate::error::SynthesisError;
use crate::matrix::{Mat, complex_singular_values, eigenvalues};
use crate::synthesis::balance::Coordinates;
use crate::system::plant::GeneralisedPlant;
use nalgebra::{Complex, DMatrix};

/// A mode counts as out of reach when the least singular value of the pencil, its rows and columns scaled to one
/// size, is below this fraction of the largest.
const MODE_RANK_TOLERANCE: f64 = 1e-12;

/// A mode whose real part is this close to zero, relative to the size of A, may lie on the axis; whether one does
/// that is out of reach is asked there.
const NEAR_AXIS: f64 = 1e-9;

/// The first mode with `Re >= 0` that B does not reach. A is n x n, B n x m; rad/s.
pub fn unreachable_mode(a: &Mat, b: &Mat) -> Option<Complex<f64>> {
    let near = NEAR_AXIS * a.norm();
    let candidates = eigenvalues(a).into_iter().filter(|mode| mode.re >= -near);
    let places = candidates.flat_map(|mode| {
        let on_axis = (mode.re <= near).then_some(Complex::new(0.0, mode.im));
        on_axis.into_iter().chain((mode.re > 0.0).then_some(mode))
    });
    places.into_iter().find(|place| {
        let n = a.nrows();
        let pencil = DMatrix::from_fn(n, n + b.ncols(), |i, j| {
            let entry = if j < n { a[(i, j)] } else { b[(i, j - n)] };
            Complex::new(entry, 0.0) - if i == j { *place } else { Complex::new(0.0, 0.0) }
        });
        let values = complex_singular_values(&equilibrated(pencil, n));
        matches!((values.first(), values.last()), (Some(most), Some(least)) if *least <= MODE_RANK_TOLERANCE * most)
    })
}

/// A pencil with each row, and each of its first n columns, divided by a number so that they are of one size. Its
/// rank stays: a fast mode elsewhere, or a unit, does not decide. Rows and columns of zeros stay as they are.
fn equilibrated(mut pencil: DMatrix<Complex<f64>>, n: usize) -> DMatrix<Complex<f64>> {
    for _ in 0..10 {
        for mut row in pencil.row_iter_mut() {
            let norm = row.norm();
            if norm > 0.0 {
                row.unscale_mut(norm);
            }
        }
        for mut column in pencil.columns_mut(0, n).column_iter_mut() {
            let norm = column.norm();
            if norm > 0.0 {
                column.unscale_mut(norm);
            }
        }
    }
    pencil
}

/// Checks that u reaches every mode of the plant at Theta = 0 that does not decay.
///
/// # Errors
/// [`SynthesisError::NotStabilisable`] with the mode.
pub fn check_stabilisable(plant: &GeneralisedPlant) -> Result<(), SynthesisError> {
    match lost_mode(plant, |balanced| (balanced.a(), balanced.b2()))? {
        Some(mode) => Err(SynthesisError::NotStabilisable { re: mode.re, im: mode.im }),
        None => Ok(()),
    }
}

/// Checks that y shows every mode of the plant at Theta = 0 that does not decay.
///
/// # Errors
/// [`SynthesisError::NotDetectable`] with the mode.
pub fn check_detectable(plant: &GeneralisedPlant) -> Result<(), SynthesisError> {
    match lost_mode(plant, |balanced| (balanced.a().transpose(), balanced.c2().transpose()))? {
        Some(mode) => Err(SynthesisError::NotDetectable { re: mode.re, im: mode.im }),
        None => Ok(()),
    }
}

/// Numbers that overflow prove nothing.
fn check_finite(plant: &GeneralisedPlant) -> Result<(), SynthesisError> {
    if eigenvalues(&plant.a()).iter().all(|v| v.re.is_finite() && v.im.is_finite()) {
        return Ok(());
    }
    Err(SynthesisError::numerical(
        "modes of the plant",
        "the eigenvalues of A cannot be computed: its numbers are too large",
    ))
}

/// The mode, in the user's unit of time, that does not decay and that the input matrix of a pair does not reach. (Rank
/// is judged in balanced coordinates: in badly scaled ones everything looks unreachable.)
fn lost_mode(
    plant: &GeneralisedPlant,
    pair: impl Fn(&GeneralisedPlant) -> (Mat, Mat),
) -> Result<Option<Complex<f64>>, SynthesisError> {
    let coordinates = Coordinates::diagonal(plant);
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
    fn the_mode_is_named() {
        let a = dmatrix![-1.0, 0.0; 0.0, 0.5];
        assert_eq!(unreachable_mode(&a, &dmatrix![1.0; 0.0]), Some(Complex::new(0.5, 0.0)));
        assert_eq!(unreachable_mode(&a, &dmatrix![0.0; 1.0]), None);
        // Neither a fast mode nor a slow stable one that is out of reach makes a mode at zero look so.
        let a = dmatrix![0.0, 0.0, 0.0; 0.0, -1e-8, 0.0; 0.0, 0.0, -1e12];
        assert_eq!(unreachable_mode(&a, &dmatrix![1.0; 0.0; 0.0]), None);
        assert_eq!(unreachable_mode(&a, &dmatrix![0.0; 1.0; 1.0]), Some(Complex::new(0.0, 0.0)));
    }
}
