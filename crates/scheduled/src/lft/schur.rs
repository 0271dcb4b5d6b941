//! Channel coordinates in which the loop through Theta is cheap to solve, for one scheduling parameter.
//!
//! `Theta = theta I` commutes with every orthogonal Q, so that a change of channel coordinates leaves the map from y to
//! u unchanged. In the coordinates of the real Schur form `Dtt = Q T Q^T`, a tick solves `(I - theta T) z = b` by back
//! substitution, in r^2 operations and without pivoting; a full matrix takes r^3/3.
//!
//! Source: Golub and Van Loan, Matrix Computations, 4th ed., 2013, sections 7.4.1 and 7.6.2.

use crate::{Lft, Matrix};

/// Maximum number of QR iterations for the Schur form; usually a few per channel suffice.
const MAX_ITERATIONS: usize = 10_000;

impl Lft {
    /// Returns this controller with `Dtt` quasi-triangular: `Bt Q`, `Dut Q`, `Q^T Ct`, `Q^T Dty` and `T` in place of
    /// `Bt`, `Dut`, `Ct`, `Dty` and `Dtt`; `None` with several parameters, or if the iteration does not converge.
    #[inline]
    pub(crate) fn in_schur_coordinates(&self) -> Option<Self> {
        if self.blocks.len() != 1 {
            return None;
        }
        let (q, t) = self.dtt.to_dense().try_schur(f64::EPSILON, MAX_ITERATIONS)?.unpack();
        let (transposed, q) = (Matrix::from_dense(&q.transpose()), Matrix::from_dense(&q));
        Some(Self {
            bt: self.bt.times(&q),
            dut: self.dut.times(&q),
            ct: transposed.times(&self.ct),
            dty: transposed.times(&self.dty),
            dtt: Matrix::from_dense(&t),
            ..self.clone()
        })
    }
}

/// Replaces `b` by the solution of `(I - theta T) z = b` with T quasi-triangular; entries below its blocks of one or
/// two rows are not read.
///
/// # Errors
/// The determinant of the first block found singular to working precision.
pub(crate) fn solve_quasi_triangular(t: &Matrix, theta: f64, b: &mut [f64]) -> Result<(), f64> {
    let precision = b.len() as f64 * f64::EPSILON;
    let mut end = b.len();
    while end > 0 {
        let (open, solved) = b.split_at_mut(end);
        // The newest entry of z is added last, so that the sum of the others does not wait for it.
        let known = |row: &[f64]| -> f64 {
            row[end..].iter().zip(&*solved).rev().map(|(entry, z)| entry * z).sum::<f64>() * theta
        };
        let lower = t.row(end - 1);
        let (d, right) = (1.0 - theta * lower[end - 1], open[end - 1] + known(lower));
        if end == 1 || lower[end - 2] == 0.0 {
            reject_singular(d, precision * (1.0 + (theta * lower[end - 1]).abs()))?;
            open[end - 1] = right / d;
            end -= 1;
            continue;
        }
        let upper = t.row(end - 2);
        let (a, left) = (1.0 - theta * upper[end - 2], open[end - 2] + known(upper));
        let (above, below) = (-theta * upper[end - 1], -theta * lower[end - 2]);
        let determinant = a * d - above * below;
        // The determinant is quadratic in the entries, and so is its rounding error.
        let rounding = precision * (1.0 + (1.0 - a).abs() + (1.0 - d).abs());
        let cancelled = precision * ((a * d).abs() + (above * below).abs());
        reject_singular(determinant, cancelled + rounding * rounding)?;
        open[end - 2] = (d * left - above * right) / determinant;
        open[end - 1] = (a * right - below * left) / determinant;
        end -= 2;
    }
    Ok(())
}

fn reject_singular(determinant: f64, threshold: f64) -> Result<(), f64> {
    if determinant.is_nan() || determinant.abs() <= threshold {
        return Err(determinant);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solves_with_blocks_of_one_and_two_rows() {
        let t = [
            [0.5, 1.0, -2.0, 0.3, 4.0],
            [0.0, 0.2, 3.0, -1.0, 0.7],
            [0.0, -0.9, 0.2, 2.0, 1.0],
            [0.0, 0.0, 0.0, -3.0, 0.5],
            [0.0, 0.0, 0.0, 0.0, 0.1],
        ];
        let matrix = Matrix::new(5, 5, t.concat()).unwrap();
        let b = [1.0, -2.0, 0.5, 3.0, -0.25];
        for theta in [-1.0, -0.3, 0.0, 0.8, 1.0] {
            let mut z = b;
            solve_quasi_triangular(&matrix, theta, &mut z).unwrap();
            for (row, entries) in t.iter().enumerate() {
                let product: f64 = entries.iter().zip(z).map(|(entry, z)| entry * z).sum();
                assert!((z[row] - theta * product - b[row]).abs() < 1e-13, "row {row} at {theta}");
            }
        }
    }

    #[test]
    fn finds_singular_blocks() {
        let of = |size, entries: &[f64]| Matrix::new(size, size, entries.to_vec()).unwrap();
        assert_eq!(solve_quasi_triangular(&of(1, &[2.0]), 0.5, &mut [1.0]), Err(0.0));
        let rotation = of(2, &[1.0, 1e-20, -1e-20, 1.0]);
        assert!(solve_quasi_triangular(&rotation, 1.0, &mut [1.0, 1.0]).is_err());
        assert!(solve_quasi_triangular(&rotation, 0.9, &mut [1.0, 1.0]).is_ok());
        assert!(solve_quasi_triangular(&of(1, &[2.0]), f64::NAN, &mut [1.0]).is_err());
        assert!(solve_quasi_triangular(&of(0, &[]), 1.0, &mut []).is_ok());
    }
}
