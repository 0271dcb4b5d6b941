//! Exact test whether a symmetric matrix is positive definite.
//!
//! A witness is tried first ([`crate::exact::witness`]). Without one, the fraction-free elimination of E. H. Bareiss
//! ("Sylvester's identity and multistep integer-preserving Gaussian elimination", Math. Comp. 22, 1968, eq. 7) gives
//! the leading principal minors as integers, and Sylvester's criterion decides. Every rejection comes from the
//! elimination.

use crate::exact::dyadic::approximate_ratio;
use crate::exact::matrix::Matrix;
use crate::exact::witness::{has_witness, scaled};
use num_bigint::{BigInt, Sign};

/// First pivot that is not positive.
#[derive(Debug, PartialEq)]
pub(crate) struct NonPositivePivot {
    /// Row of the matrix.
    pub(crate) row: usize,
    /// Rounded value of the pivot.
    pub(crate) value: f64,
    pub(crate) exactly_zero: bool,
}

/// Checks that the symmetric matrix `m` is positive definite.
///
/// The elimination takes the rows in the given order, on which the result does not depend.
///
/// # Errors
/// [`WrongPivot`], the first pivot of the elimination that is not positive.
pub(crate) fn positive_definite(m: &Matrix, order: &[usize]) -> Result<(), NonPositivePivot> {
    let (scaled, halves) = scaled(m, order);
    if has_witness(&scaled) {
        return Ok(());
    }
    eliminate(&scaled).map_err(|(pivot, row)| {
        let row = order[row];
        let value = approximate_ratio(&pivot.minor, &pivot.previous, pivot.unit - 2 * halves[row]);
        NonPositivePivot { row, value, exactly_zero: pivot.minor.sign() == Sign::NoSign }
    })
}

/// Leading principal minor that is not positive; the pivot is `minor 2^unit / previous`.
struct Minor {
    minor: BigInt,
    previous: BigInt,
    unit: i64,
}

/// Eliminates the upper triangle by Bareiss' method: after step k the entries are minors of order k + 2.
fn eliminate(m: &Matrix) -> Result<(), (Minor, usize)> {
    let n = m.rows;
    let entries = (0..n).flat_map(|i| (i..n).map(move |j| (i, j)));
    let unit = entries.filter_map(|at| m[at].last_bit()).min().unwrap_or(0);
    let mut a: Vec<Vec<BigInt>> =
        (0..n).map(|i| (i..n).map(|j| m[(i, j)].in_units(unit)).collect()).collect();
    let mut previous = BigInt::from(1);
    for k in 0..n {
        let (done, rest) = a.split_at_mut(k + 1);
        let row = &done[k];
        if row[0].sign() != Sign::Plus {
            return Err((Minor { minor: row[0].clone(), previous, unit }, k));
        }
        for (i, target) in rest.iter_mut().enumerate() {
            for (j, entry) in target.iter_mut().enumerate() {
                // Column k + 1 + i + j of the pivot row is at index 1 + i + j.
                let cross = &row[1 + i] * &row[1 + i + j];
                *entry = (&row[0] * &*entry - cross) / &previous;
            }
        }
        previous = row[0].clone();
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exact::dyadic::Dyadic;
    use crate::exact::witness::{rough_dominates, rough_factor, shown_positive};
    use proptest::prelude::*;
    use std::time::Instant;

    /// Returns the sum of `v v'/64` over the columns `v` of a square matrix of f64s, plus `shift I`.
    fn gram(n: usize, entries: &[f64], shift: f64) -> Matrix {
        let mut g = Matrix::zeros(n, n);
        entries
            .iter()
            .take(n * n)
            .enumerate()
            .for_each(|(k, &x)| g[(k / n, k % n)] = Dyadic::from_f64(x / 8.0));
        g.times(&g.transpose()).plus(&Matrix::scalar(n, &Dyadic::from_f64(shift)))
    }

    fn order(n: usize) -> Vec<usize> {
        (0..n).rev().collect()
    }

    #[test]
    fn reports_first_wrong_pivot_unscaled() {
        let mut m = Matrix::scalar(3, &Dyadic::from_f64(1024.0));
        m[(1, 1)] = Dyadic::from_f64(3.0);
        m[(0, 1)] = Dyadic::from_f64(64.0);
        m[(1, 0)] = Dyadic::from_f64(64.0);
        // Rows 2 and 1 come first: the pivot of row 0 is 1024 - 64^2/3.
        let wrong = positive_definite(&m, &order(3)).unwrap_err();
        assert_eq!(wrong.row, 0);
        assert!((wrong.value - (1024.0 - 4096.0 / 3.0)).abs() < 1e-9);
        m[(1, 1)] = Dyadic::from_f64(4.0);
        assert!(positive_definite(&m, &order(3)).unwrap_err().exactly_zero);
        m[(1, 1)] = Dyadic::from_f64(4.0_f64.next_up());
        assert_eq!(positive_definite(&m, &order(3)), Ok(()));
        assert_eq!(positive_definite(&Matrix::zeros(0, 0), &[]), Ok(()));
        assert!(positive_definite(&Matrix::zeros(1, 1), &[0]).unwrap_err().exactly_zero);
    }

    /// Checks that both methods agree, and prints their times.
    #[test]
    fn witness_and_elimination_agree_on_large_matrices() {
        for n in [20, 42, 60] {
            let entries: Vec<f64> =
                (0..n * n).map(|k| (k as f64 * 0.7 + (k * k) as f64 * 0.01).sin()).collect();
            let m = gram(n, &entries, 0.01);
            let start = Instant::now();
            assert!(has_witness(&m));
            let quick = start.elapsed();
            let start = Instant::now();
            assert!(eliminate(&m).is_ok());
            println!("{n} x {n}: witness {quick:?}, elimination {:?}", start.elapsed());
        }
    }

    proptest! {
        #[test]
        fn dominance_implies_definiteness_for_any_factor(
            n in 1_usize..5,
            entries in prop::collection::vec(-1.0..1.0, 16),
            shift in -0.1..0.1,
            error in prop_oneof![Just(0.0), -0.05..0.05],
        ) {
            let m = gram(n, &entries, shift);
            let perturbation = |k: usize| if k.is_multiple_of(n + 1) { 0.1 } else { error };
            let near: Vec<f64> = (0..n * n).map(|k| m[(k / n, k % n)].to_f64() + perturbation(k)).collect();
            if let Some(l) = rough_factor(&near, n, 0.11) {
                prop_assert!(!rough_dominates(&m, &l) || eliminate(&m).is_ok());
            }
        }

        #[test]
        fn shown_matrices_are_definite(
            n in 1_usize..7,
            entries in prop::collection::vec(-1.0..1.0, 36),
            shift in prop_oneof![-1.0..1.0, -1e-13..1e-13],
        ) {
            let mut g = Matrix::zeros(n, n);
            (0..n * n).for_each(|k| g[(k / n, k % n)] = Dyadic::from_f64(entries[k]));
            let m = g.times(&g.transpose()).plus(&Matrix::scalar(n, &Dyadic::from_f64(shift)));
            let exact = eliminate(&m).is_ok();
            prop_assert_eq!(shown_positive(&m), exact);
        }

        #[test]
        fn no_witness_where_elimination_rejects(
            n in 1_usize..7,
            entries in prop::collection::vec(-1.0..1.0, 36),
            shift in prop_oneof![-1.0..1.0, -1e-3..1e-3, -1e-13..1e-13],
            singular in any::<bool>(),
        ) {
            let mut entries = entries;
            if singular {
                (0..n).for_each(|j| entries[j] = entries[(n - 1) * n + j]);
            }
            let m = gram(n, &entries, shift);
            let exact = eliminate(&m).is_ok();
            prop_assert!(exact || !has_witness(&m));
            prop_assert_eq!(positive_definite(&m, &order(n)).is_ok(), exact);
            prop_assert!(shift <= 0.0 || exact);
            prop_assert!(!(singular && n > 1 && shift <= 0.0 && exact));
        }
    }
}
