//! Decides without rounding whether a symmetric matrix of exact numbers is positive definite.
//!
//! Scaled by powers of two to diagonals between 1 and 4, `M` is shown to be positive definite in one of two ways.
//!
//! 1. A witness. A Cholesky factor of `M - delta I`, computed in floating point, is rounded to a matrix `L` of whole
//!    multiples of `2^-52`. The proof does not depend on how `L` was computed: if in exact arithmetic `R = M - L L'`
//!    has positive diagonal entries, each larger than the sum of the magnitudes of the other entries of its row, `R` is
//!    positive definite (Gershgorin), and so is `M = L L' + R`.
//! 2. Elimination. Without a witness, the fraction-free elimination of E. H. Bareiss ("Sylvester's identity
//!    and multistep integer-preserving Gaussian elimination", Math. Comp. 22, 1968, eq. 7) gives the leading
//!    principal minors as whole numbers, and Sylvester's criterion decides. Every refusal comes from the elimination.

use crate::exact::dyadic::{Dyadic, approximate_ratio};
use crate::exact::matrix::Matrix;
use num_bigint::{BigInt, Sign};

/// The first pivot that is not positive.
#[derive(Debug, PartialEq)]
pub(crate) struct WrongPivot {
    /// The row of the matrix.
    pub(crate) row: usize,
    /// The pivot, rounded.
    pub(crate) value: f64,
    pub(crate) exactly_zero: bool,
}

/// Decides whether the symmetric matrix `m` is positive definite.
///
/// The elimination takes the rows in the given order, on which the answer does not depend.
///
/// # Errors
/// [`WrongPivot`], the first pivot of the elimination that is not positive.
pub(crate) fn positive_definite(m: &Matrix, order: &[usize]) -> Result<(), WrongPivot> {
    let halves: Vec<i64> = (0..m.rows).map(|i| -m[(i, i)].magnitude().unwrap_or(0).div_euclid(2)).collect();
    let mut scaled = Matrix::zeros(m.rows, m.rows);
    for (a, &i) in order.iter().enumerate() {
        for (b, &j) in order.iter().enumerate() {
            scaled[(a, b)] = m[(i, j)].shifted(halves[i] + halves[j]);
        }
    }
    if witnessed(&scaled) {
        return Ok(());
    }
    eliminate(&scaled).map_err(|(pivot, row)| {
        let row = order[row];
        let value = approximate_ratio(&pivot.minor, &pivot.previous, pivot.unit - 2 * halves[row]);
        WrongPivot { row, value, exactly_zero: pivot.minor.sign() == Sign::NoSign }
    })
}

/// Shifts delta, tried in turn: well above the rounding of the factorisation, and if possible below the least
/// eigenvalue.
const DELTAS: [f64; 3] = [1e-6, 1e-9, 1e-12];

/// Whether a Cholesky factor proves that `m` is positive definite.
fn witnessed(m: &Matrix) -> bool {
    let n = m.rows;
    let rounded: Vec<f64> = (0..n * n).map(|k| m[(k / n, k % n)].to_f64()).collect();
    DELTAS.iter().any(|delta| factor(&rounded, n, *delta).is_some_and(|l| remainder_dominates(m, &l)))
}

/// Binary places of the factor's entries.
const BITS: i64 = 52;

/// The lower Cholesky factor of `m - delta I` in multiples of `2^-52`.
fn factor(m: &[f64], n: usize, delta: f64) -> Option<Vec<i64>> {
    let mut l = vec![0.0_f64; n * n];
    for j in 0..n {
        for i in j..n {
            let dot: f64 = (0..j).map(|k| l[i * n + k] * l[j * n + k]).sum();
            let rest = m[i * n + j] - dot - if i == j { delta } else { 0.0 };
            l[i * n + j] = if i == j { rest.sqrt() } else { rest / l[j * n + j] };
            // With diagonals of M up to 4, no entry of a factor exceeds 2; NaN is refused.
            let fits = l[i * n + j].abs() <= 4.0 && l[j * n + j] > 0.0;
            if !fits {
                return None;
            }
        }
    }
    Some(l.into_iter().map(|x| (x * 2f64.powi(BITS as i32)).round() as i64).collect())
}

/// Whether `R = M - L L'` is strictly diagonally dominant with positive diagonal entries, exactly.
fn remainder_dominates(m: &Matrix, l: &[i64]) -> bool {
    let n = m.rows;
    // Each product is at most 2^108, each sum at most n 2^108: it fits into an i128.
    debug_assert!(n < 1 << 18);
    let square = |i: usize, j: usize| -> Dyadic {
        let sum: i128 = (0..=i.min(j)).map(|k| i128::from(l[i * n + k]) * i128::from(l[j * n + k])).sum();
        Dyadic::new((-sum).into(), -2 * BITS)
    };
    let mut beside = vec![Dyadic::default(); n];
    let mut diagonal = vec![Dyadic::default(); n];
    for i in 0..n {
        diagonal[i] = &m[(i, i)] + &square(i, i);
        for j in 0..i {
            let magnitude = (&m[(i, j)] + &square(i, j)).abs();
            beside[i] = &beside[i] + &magnitude;
            beside[j] = &beside[j] + &magnitude;
        }
    }
    diagonal.iter().zip(&beside).all(|(d, b)| (d + &-b).is_positive())
}

/// A leading principal minor that is not positive; the pivot is `minor 2^unit / previous`.
struct Minor {
    minor: BigInt,
    previous: BigInt,
    unit: i64,
}

/// Bareiss elimination of the upper triangle: after step k the entries are minors of order k + 2.
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
    use proptest::prelude::*;
    use std::time::Instant;

    /// `sum of v v'/64` over the columns `v` of a square matrix of f64s, plus `shift I`.
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
    fn the_first_wrong_pivot_is_named_in_unscaled_terms() {
        let mut m = Matrix::scalar(3, &Dyadic::from_f64(1024.0));
        m[(1, 1)] = Dyadic::from_f64(3.0);
        m[(0, 1)] = Dyadic::from_f64(64.0);
        m[(1, 0)] = Dyadic::from_f64(64.0);
        // Rows 2 and 1 first: the pivot of row 0 is 1024 - 64^2/3.
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

    /// A wrong factor must be refused.
    #[test]
    fn a_remainder_must_dominate_strictly() {
        let matrix = |rows: [[f64; 2]; 2]| Matrix::from_rows(&rows.map(Vec::from).to_vec(), 2);
        let whole = |l: [i64; 4]| l.map(|x| x << BITS);
        let none = whole([0; 4]);
        assert!(remainder_dominates(&matrix([[1.0, 0.9], [0.9, 1.0]]), &none));
        assert!(!remainder_dominates(&matrix([[1.0, 1.0], [1.0, 1.0]]), &none));
        assert!(!remainder_dominates(&matrix([[1.0, 2.0], [2.0, 1.0]]), &none));
        assert!(!remainder_dominates(&matrix([[1.0, 2.0], [2.0, 9.0]]), &none));
        // L L' = [4 2; 2 1]: the remainder must be positive in both rows.
        let l = whole([2, 0, 1, 0]);
        assert!(!remainder_dominates(&matrix([[4.0, 2.0], [2.0, 1.0]]), &l));
        assert!(!remainder_dominates(&matrix([[4.0, 2.0], [2.0, 2.0]]), &l));
        assert!(!remainder_dominates(&matrix([[4.5, 2.0], [2.0, 0.5]]), &l));
        assert!(remainder_dominates(&matrix([[4.0_f64.next_up(), 2.0], [2.0, 1.0_f64.next_up()]]), &l));
    }

    /// Prints the time of both methods.
    #[test]
    fn both_ways_agree_on_large_matrices() {
        for n in [20, 42, 60] {
            let entries: Vec<f64> =
                (0..n * n).map(|k| (k as f64 * 0.7 + (k * k) as f64 * 0.01).sin()).collect();
            let m = gram(n, &entries, 0.01);
            let start = Instant::now();
            assert!(witnessed(&m));
            let quick = start.elapsed();
            let start = Instant::now();
            assert!(eliminate(&m).is_ok());
            println!("{n} x {n}: witness {quick:?}, elimination {:?}", start.elapsed());
        }
    }

    proptest! {
        #[test]
        fn whatever_the_factor_what_dominates_is_definite(
            n in 1_usize..5,
            entries in prop::collection::vec(-1.0..1.0, 16),
            shift in -0.1..0.1,
            error in prop_oneof![Just(0.0), -0.05..0.05],
        ) {
            let m = gram(n, &entries, shift);
            let perturbation = |k: usize| if k.is_multiple_of(n + 1) { 0.1 } else { error };
            let near: Vec<f64> = (0..n * n).map(|k| m[(k / n, k % n)].to_f64() + perturbation(k)).collect();
            if let Some(l) = factor(&near, n, 0.11) {
                prop_assert!(!remainder_dominates(&m, &l) || eliminate(&m).is_ok());
            }
        }

        #[test]
        fn a_witness_is_never_found_where_elimination_refuses(
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
            prop_assert!(exact || !witnessed(&m));
            prop_assert_eq!(positive_definite(&m, &order(n)).is_ok(), exact);
            prop_assert!(shift <= 0.0 || exact);
            prop_assert!(!(singular && n > 1 && shift <= 0.0 && exact));
        }
    }
}
