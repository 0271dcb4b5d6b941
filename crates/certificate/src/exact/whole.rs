//! Fraction-free elimination: solves systems of equations in integers.
//!
//! E. H. Bareiss, "Sylvester's identity and multistep integer-preserving Gaussian elimination", Math. Comp. 22, 1968,
//! eq. 7, applied to the rows above the pivot as well as below: all entries remain minors of the matrix.

use crate::exact::dyadic::{Dyadic, approximate_ratio};
use crate::exact::matrix::Matrix;
use num_bigint::{BigInt, Sign};

/// Matrix in reduced row form: each remaining row has `pivot` in its pivot column, and the other rows have zeros there.
pub(crate) struct Reduced {
    /// Remaining rows.
    pub(crate) rows: Matrix,
    /// Pivot column of each row.
    pub(crate) pivots: Vec<usize>,
    /// Common pivot, positive; 1 without rows.
    pub(crate) pivot: Dyadic,
}

/// Reduces a matrix; each pivot is the largest entry after multiplication of column j by `weights[j]`.
pub(crate) fn reduce(m: &Matrix, weights: &[f64]) -> Reduced {
    let entries = (0..m.rows).flat_map(|i| (0..m.cols).map(move |j| (i, j)));
    let unit = entries.filter_map(|at| m[at].last_bit()).min().unwrap_or(0);
    let mut a: Vec<Vec<BigInt>> =
        (0..m.rows).map(|i| (0..m.cols).map(|j| m[(i, j)].in_units(unit)).collect()).collect();
    let mut pivots: Vec<usize> = vec![];
    let mut previous = BigInt::from(1);
    while let Some((row, column)) = largest(&a, pivots.len(), weights) {
        let k = pivots.len();
        a.swap(k, row);
        pivots.push(column);
        if a[k][column].sign() == Sign::Minus {
            a[k].iter_mut().for_each(|x| *x = -&*x);
        }
        let pivot_row = a[k].clone();
        let pivot = &pivot_row[column];
        for (_, other) in a.iter_mut().enumerate().filter(|(i, _)| *i != k) {
            let factor = other[column].clone();
            for (x, p) in other.iter_mut().zip(&pivot_row) {
                *x = (pivot * &*x - &factor * p) / &previous;
            }
        }
        previous = pivot.clone();
    }
    let mut rows = Matrix::zeros(pivots.len(), m.cols);
    for (i, row) in a.into_iter().take(pivots.len()).enumerate() {
        row.into_iter().enumerate().for_each(|(j, x)| rows[(i, j)] = Dyadic::new(x, 0));
    }
    Reduced { rows, pivots, pivot: Dyadic::new(previous, 0) }
}

/// Returns N and d > 0 with `M N = d I`, without fractions; `None` if M is singular. `[M I]` reduces to `[d I N]`.
pub(crate) fn fraction_free_inverse(m: &Matrix) -> Option<(Matrix, Dyadic)> {
    let n = m.rows;
    let mut augmented = Matrix::zeros(n, 2 * n);
    augmented.place(0, 0, m);
    augmented.place(0, n, &Matrix::scalar(n, &Dyadic::from_f64(1.0)));
    let weights: Vec<f64> = (0..2 * n).map(|j| if j < n { 1.0 } else { 0.0 }).collect();
    let Reduced { rows, pivots, pivot } = reduce(&augmented, &weights);
    let mut inverse = Matrix::zeros(n, n);
    for (k, &i) in pivots.iter().enumerate() {
        if i >= n {
            return None;
        }
        (0..n).for_each(|j| inverse[(i, j)] = rows[(k, n + j)].clone());
    }
    Some((inverse, pivot))
}

/// Returns row and column of the largest weighted entry that is not zero, from row `from` on. All entries are in the
/// same unit.
fn largest(a: &[Vec<BigInt>], from: usize, weights: &[f64]) -> Option<(usize, usize)> {
    let bits = a.iter().skip(from).flatten().map(BigInt::bits).max().filter(|bits| *bits > 0)?;
    let scale = BigInt::from(1) << bits;
    let mut best: Option<(f64, (usize, usize))> = None;
    for (i, row) in a.iter().enumerate().skip(from) {
        for (j, x) in row.iter().enumerate().filter(|(_, x)| x.sign() != Sign::NoSign) {
            let size = approximate_ratio(x, &scale, 0).abs() * weights[j];
            if best.is_none_or(|(known, _)| size > known) {
                best = Some((size, (i, j)));
            }
        }
    }
    best.map(|(_, at)| at)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exact::definite::positive_definite;
    use proptest::prelude::*;

    #[test]
    fn drops_dependent_rows() {
        let m = Matrix::from_rows(&vec![vec![1.0, 2.0, 0.0], vec![-2.0, -4.0, 0.0], vec![0.0, 0.0, 3.0]], 3);
        let found = reduce(&m, &[1.0, 1.0, 1.0]);
        assert_eq!((found.rows.rows, found.pivots), (2, vec![1, 2]));
        assert!(found.pivot.is_positive());
    }

    proptest! {
        #[test]
        fn inverse_is_exact(
            n in 0_usize..6,
            entries in prop::collection::vec(prop_oneof![Just(0.0), -3.0..3.0, -1e-9..1e-9], 25),
            singular in any::<bool>(),
        ) {
            let mut m = Matrix::zeros(n, n);
            (0..n * n).for_each(|k| m[(k / n, k % n)] = Dyadic::from_f64(entries[k]));
            let singular = singular && n > 1;
            if singular {
                (0..n).for_each(|j| m[(n - 1, j)] = &m[(0, j)] + &m[(0, j)]);
            }
            match fraction_free_inverse(&m) {
                Some((inverse, d)) => {
                    prop_assert!(d.is_positive() && !singular);
                    prop_assert_eq!(m.times(&inverse), Matrix::scalar(n, &d));
                }
                None => {
                    // The Gram matrix of a regular matrix would be positive definite.
                    let gram = m.times(&m.transpose());
                    prop_assert!(positive_definite(&gram, &(0..n).collect::<Vec<_>>()).is_err());
                }
            }
        }
    }
}
