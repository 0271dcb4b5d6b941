//! Shows that a symmetric matrix of exact numbers is positive definite, or gives up: for matrices too large, or too
//! close to singular, for [`crate::exact::definite`].
//!
//! Scaled by powers of two to diagonals between 1 and 4, `M` is positive definite if `R = M - L L'` has positive
//! diagonal entries, each larger than the sum of the magnitudes of the other entries of its row (Gershgorin), whatever
//! L. That is decided exactly. L is a Cholesky factor of `M - 2^-100 I` in whole multiples of `2^-192`, so that matrices
//! whose least eigenvalue, scaled, is above `1e-30` or so are shown to be positive definite.

use crate::exact::dyadic::Dyadic;
use crate::exact::matrix::Matrix;
use num_bigint::{BigInt, Sign};

/// Binary places of the factor, and of the shift.
const PLACES: u64 = 192;
const SHIFT: u64 = 100;

/// Whether the symmetric matrix `m` was shown to be positive definite.
pub(crate) fn shown_positive(m: &Matrix) -> bool {
    let n = m.rows;
    let halves: Vec<i64> = (0..n).map(|i| -m[(i, i)].magnitude().unwrap_or(0).div_euclid(2)).collect();
    let mut scaled = Matrix::zeros(n, n);
    for i in 0..n {
        for j in 0..n {
            scaled[(i, j)] = m[(i, j)].shifted(halves[i] + halves[j]);
        }
    }
    factor(&scaled).is_some_and(|l| remainder_dominates(&scaled, &l))
}

/// The rows of the lower factor, in units of `2^-192`.
fn factor(m: &Matrix) -> Option<Vec<Vec<BigInt>>> {
    let mut l: Vec<Vec<BigInt>> = vec![];
    for i in 0..m.rows {
        let mut row: Vec<BigInt> = vec![];
        for j in 0..=i {
            // In units of 2^-384.
            let other = if j < i { &l[j] } else { &row };
            let dot: BigInt = row.iter().zip(other).map(|(a, b)| a * b).sum();
            let mut rest = m[(i, j)].rounded(2 * PLACES as i64) - dot;
            if j < i {
                row.push(rest / &l[j][j]);
            } else {
                rest -= BigInt::from(1) << (2 * PLACES - SHIFT);
                if rest.sign() != Sign::Plus {
                    return None;
                }
                row.push(rest.sqrt());
            }
        }
        l.push(row);
    }
    // A last check for the divisions: a zero on the diagonal would have been divided by.
    Some(l)
}

/// Whether `R = M - L L'` is strictly diagonally dominant with positive diagonal entries, exactly.
fn remainder_dominates(m: &Matrix, l: &[Vec<BigInt>]) -> bool {
    let n = m.rows;
    let mut beside = vec![Dyadic::default(); n];
    let mut diagonal = vec![Dyadic::default(); n];
    for i in 0..n {
        for j in 0..=i {
            let dot: BigInt = l[i].iter().zip(&l[j]).map(|(a, b)| a * b).sum();
            let remainder = &m[(i, j)] + &Dyadic::new(-dot, -2 * PLACES as i64);
            if i == j {
                diagonal[i] = remainder;
            } else {
                beside[i] = &beside[i] + &remainder.abs();
                beside[j] = &beside[j] + &remainder.abs();
            }
        }
    }
    diagonal.iter().zip(&beside).all(|(d, b)| (d + &-b).is_positive())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exact::definite::positive_definite;
    use proptest::prelude::*;

    /// The Hilbert matrix, whose least eigenvalue of order 12 is 2.6e-17 (entries rounded to f64 would spoil it), in
    /// units of the least common multiple of the denominators.
    #[test]
    fn a_matrix_beyond_floating_point_is_shown() {
        let hilbert = |n: usize, last: f64| {
            let common: f64 = (1..=9).fold(1.0, |lcm: f64, k| {
                let k = f64::from(k);
                (1..).map(|m| lcm * f64::from(m)).find(|v| v % k == 0.0).unwrap_or(lcm)
            });
            let mut rows: Vec<Vec<f64>> =
                (0..n).map(|i| (0..n).map(|j| common / (i + j + 1) as f64).collect()).collect();
            rows[n - 1][n - 1] += last;
            Matrix::from_rows(&rows, n)
        };
        // All entries up to order 5 are whole.
        assert!(shown_positive(&hilbert(5, 0.0)));
        assert!(
            !shown_positive(&hilbert(5, -1.0)),
            "det 5 is positive, and 1/2520 off the last entry makes it negative"
        );
    }

    #[test]
    fn what_is_not_definite_is_not_shown() {
        let matrix = |rows: [[f64; 2]; 2]| Matrix::from_rows(&rows.map(Vec::from).to_vec(), 2);
        assert!(shown_positive(&Matrix::zeros(0, 0)));
        assert!(!shown_positive(&Matrix::zeros(1, 1)));
        assert!(!shown_positive(&matrix([[1.0, 1.0], [1.0, 1.0]])));
        assert!(!shown_positive(&matrix([[1.0, 2.0], [2.0, 1.0]])));
        assert!(!shown_positive(&matrix([[-1.0, 0.0], [0.0, 1.0]])));
        assert!(shown_positive(&matrix([[1.0, 1.0], [1.0, 1.0_f64.next_up()]])));
    }

    proptest! {
        #[test]
        fn whatever_is_shown_is_definite(
            n in 1_usize..7,
            entries in prop::collection::vec(-1.0..1.0, 36),
            shift in prop_oneof![-1.0..1.0, -1e-13..1e-13],
        ) {
            let mut g = Matrix::zeros(n, n);
            (0..n * n).for_each(|k| g[(k / n, k % n)] = Dyadic::from_f64(entries[k]));
            let m = g.times(&g.transpose()).plus(&Matrix::scalar(n, &Dyadic::from_f64(shift)));
            let exact = positive_definite(&m, &(0..n).collect::<Vec<_>>()).is_ok();
            prop_assert_eq!(shown_positive(&m), exact);
        }
    }
}
