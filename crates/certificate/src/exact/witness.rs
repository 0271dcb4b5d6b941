//! Sufficient exact test for a positive definite symmetric matrix.
//!
//! M is scaled by powers of two to diagonals between 1 and 4. It is positive definite if, for any L, `R = M - L L'` has
//! positive diagonal entries, each larger than the sum of the magnitudes of the other entries of its row (Gershgorin).
//! This is decided exactly. L is a Cholesky factor of `M - delta I`, tried at two precisions:
//!
//! 1. computed in floating point and rounded to integer multiples of `2^-52`, with delta from 1e-6 to 1e-12;
//! 2. computed in integer multiples of `2^-192`, with `delta = 2^-100`: slower, but sufficient for matrices whose
//!    smallest scaled eigenvalue is above about `1e-30`.

use crate::exact::dyadic::Dyadic;
use crate::exact::matrix::Matrix;
use num_bigint::{BigInt, Sign};

/// Binary places of a factor in floating point, and its shifts, tried in turn: well above the rounding errors of the
/// factorisation, and if possible below the smallest eigenvalue.
const BITS: i64 = 52;
const DELTAS: [f64; 3] = [1e-6, 1e-9, 1e-12];

/// Binary places of the finer factor, and of its shift.
const PLACES: u64 = 192;
const SHIFT: u64 = 100;

/// Returns the matrix with rows and columns in `order` and diagonals scaled to between 1 and 4, and the binary
/// exponents of the scaling.
pub(crate) fn scaled(m: &Matrix, order: &[usize]) -> (Matrix, Vec<i64>) {
    let halves: Vec<i64> = (0..m.rows).map(|i| -m[(i, i)].magnitude().unwrap_or(0).div_euclid(2)).collect();
    let mut scaled = Matrix::zeros(m.rows, m.rows);
    for (a, &i) in order.iter().enumerate() {
        for (b, &j) in order.iter().enumerate() {
            scaled[(a, b)] = m[(i, j)].shifted(halves[i] + halves[j]);
        }
    }
    (scaled, halves)
}

/// Returns `true` if the symmetric matrix `m` is shown to be positive definite.
pub(crate) fn shown_positive(m: &Matrix) -> bool {
    has_witness(&scaled(m, &(0..m.rows).collect::<Vec<_>>()).0)
}

/// Returns `true` if a factor proves that the scaled matrix `m` is positive definite.
pub(crate) fn has_witness(m: &Matrix) -> bool {
    let n = m.rows;
    let rounded: Vec<f64> = (0..n * n).map(|k| m[(k / n, k % n)].to_f64()).collect();
    let rough = |delta: &f64| rough_factor(&rounded, n, *delta).is_some_and(|l| rough_dominates(m, &l));
    DELTAS.iter().any(rough) || fine_factor(m).is_some_and(|l| fine_dominates(m, &l))
}

/// Returns the lower Cholesky factor of `m - delta I` in multiples of `2^-52`.
pub(crate) fn rough_factor(m: &[f64], n: usize, delta: f64) -> Option<Vec<i64>> {
    let mut l = vec![0.0_f64; n * n];
    for j in 0..n {
        for i in j..n {
            let dot: f64 = (0..j).map(|k| l[i * n + k] * l[j * n + k]).sum();
            let rest = m[i * n + j] - dot - if i == j { delta } else { 0.0 };
            l[i * n + j] = if i == j { rest.sqrt() } else { rest / l[j * n + j] };
            // No entry of a factor exceeds 2 for diagonals of M up to 4; NaN is rejected.
            let fits = l[i * n + j].abs() <= 4.0 && l[j * n + j] > 0.0;
            if !fits {
                return None;
            }
        }
    }
    Some(l.into_iter().map(|x| (x * 2f64.powi(BITS as i32)).round() as i64).collect())
}

/// Calls [`dominates`] for a factor in multiples of `2^-52`.
pub(crate) fn rough_dominates(m: &Matrix, l: &[i64]) -> bool {
    let n = m.rows;
    // Each product is at most 2^108, so that a sum of n products fits into an i128.
    debug_assert!(n < 1 << 18);
    dominates(m, |i, j| {
        let sum: i128 = (0..=i.min(j)).map(|k| i128::from(l[i * n + k]) * i128::from(l[j * n + k])).sum();
        Dyadic::new((-sum).into(), -2 * BITS)
    })
}

/// Returns the rows of the lower factor, in units of `2^-192`.
fn fine_factor(m: &Matrix) -> Option<Vec<Vec<BigInt>>> {
    let mut l: Vec<Vec<BigInt>> = vec![];
    for i in 0..m.rows {
        let mut row: Vec<BigInt> = vec![];
        for j in 0..=i {
            // Products and remainders are in units of 2^-384.
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
    Some(l)
}

/// Calls [`dominates`] for a factor in multiples of `2^-192`.
fn fine_dominates(m: &Matrix, l: &[Vec<BigInt>]) -> bool {
    dominates(m, |i, j| {
        let dot: BigInt = l[i].iter().zip(&l[j]).map(|(a, b)| a * b).sum();
        Dyadic::new(-dot, -2 * PLACES as i64)
    })
}

/// Returns `true` if `M + negated`, with `negated = -L L'` by its lower triangle, is strictly diagonally dominant with
/// positive diagonal entries; exact.
fn dominates(m: &Matrix, negated: impl Fn(usize, usize) -> Dyadic) -> bool {
    let n = m.rows;
    let mut off_diagonal = vec![Dyadic::default(); n];
    let mut diagonal = vec![Dyadic::default(); n];
    for i in 0..n {
        diagonal[i] = &m[(i, i)] + &negated(i, i);
        for j in 0..i {
            let magnitude = (&m[(i, j)] + &negated(i, j)).abs();
            off_diagonal[i] = &off_diagonal[i] + &magnitude;
            off_diagonal[j] = &off_diagonal[j] + &magnitude;
        }
    }
    diagonal.iter().zip(&off_diagonal).all(|(d, b)| (d + &-b).is_positive())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks a Hilbert matrix in units of the least common multiple of its denominators, because entries rounded to
    /// f64 would spoil it; the smallest eigenvalue of order 12 is 2.6e-17.
    #[test]
    fn shows_hilbert_matrix() {
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
        // All entries up to order 5 are integers.
        assert!(shown_positive(&hilbert(5, 0.0)));
        assert!(
            !shown_positive(&hilbert(5, -1.0)),
            "det 5 is positive, and 1/2520 off the last entry makes it negative"
        );
    }

    /// Checks that a wrong factor is rejected.
    #[test]
    fn remainder_must_dominate_strictly() {
        let matrix = |rows: [[f64; 2]; 2]| Matrix::from_rows(&rows.map(Vec::from).to_vec(), 2);
        let scaled_integers = |l: [i64; 4]| l.map(|x| x << BITS);
        let none = scaled_integers([0; 4]);
        assert!(rough_dominates(&matrix([[1.0, 0.9], [0.9, 1.0]]), &none));
        assert!(!rough_dominates(&matrix([[1.0, 1.0], [1.0, 1.0]]), &none));
        assert!(!rough_dominates(&matrix([[1.0, 2.0], [2.0, 1.0]]), &none));
        assert!(!rough_dominates(&matrix([[1.0, 2.0], [2.0, 9.0]]), &none));
        // The factor gives L L' = [4 2; 2 1]: the remainder must be positive in both rows.
        let l = scaled_integers([2, 0, 1, 0]);
        assert!(!rough_dominates(&matrix([[4.0, 2.0], [2.0, 1.0]]), &l));
        assert!(!rough_dominates(&matrix([[4.0, 2.0], [2.0, 2.0]]), &l));
        assert!(!rough_dominates(&matrix([[4.5, 2.0], [2.0, 0.5]]), &l));
        assert!(rough_dominates(&matrix([[4.0_f64.next_up(), 2.0], [2.0, 1.0_f64.next_up()]]), &l));
    }

    #[test]
    fn does_not_show_indefinite_matrices() {
        let matrix = |rows: [[f64; 2]; 2]| Matrix::from_rows(&rows.map(Vec::from).to_vec(), 2);
        assert!(shown_positive(&Matrix::zeros(0, 0)));
        assert!(!shown_positive(&Matrix::zeros(1, 1)));
        assert!(!shown_positive(&matrix([[1.0, 1.0], [1.0, 1.0]])));
        assert!(!shown_positive(&matrix([[1.0, 2.0], [2.0, 1.0]])));
        assert!(!shown_positive(&matrix([[-1.0, 0.0], [0.0, 1.0]])));
        assert!(shown_positive(&matrix([[1.0, 1.0], [1.0, 1.0_f64.next_up()]])));
    }
}
