//! Inverse of a matrix of 32-digit numbers, which dominates the time of a Riccati equation.
//!
//! High and low words are stored separately, so that one vector instruction processes several numbers; scalar code
//! calls the system's fused multiply-add for each.

use nalgebra::DMatrix;
use pulp::{Arch, Simd, WithSimd};
use qd::Quad;
use qd::simd::{mul, splat, sub_estimate};

/// The numbers of a row, padded with zeros to whole vectors.
#[derive(Clone, Default)]
struct Row {
    high: Vec<f64>,
    low: Vec<f64>,
}

/// The length of which a padded row is a multiple: itself a multiple of the lanes of every vector type.
const LANES: usize = 8;

impl Row {
    fn of(numbers: impl Iterator<Item = Quad>, length: usize) -> Self {
        let padded = length.next_multiple_of(LANES);
        let (mut high, mut low): (Vec<f64>, Vec<f64>) = numbers.map(|v| (v.0, v.1)).unzip();
        high.resize(padded, 0.0);
        low.resize(padded, 0.0);
        Self { high, low }
    }

    fn at(&self, column: usize) -> Quad {
        Quad(self.high[column], self.low[column])
    }

    fn set(&mut self, column: usize, value: Quad) {
        (self.high[column], self.low[column]) = (value.0, value.1);
    }
}

/// Subtracts from each row of `rows` its multiple of `row` that eliminates a column.
struct Elimination<'a> {
    rows: &'a mut [Row],
    row: &'a Row,
    column: usize,
}

impl WithSimd for Elimination<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { rows, row, column } = self;
        let (row_high, row_low) = (S::as_simd_f64s(&row.high).0, S::as_simd_f64s(&row.low).0);
        for other in rows.iter_mut().filter(|other| !other.high.is_empty()) {
            let factor = other.at(column);
            other.set(column, Quad::ZERO);
            if factor.0 == 0.0 {
                continue;
            }
            let factor = splat(simd, factor);
            let (high, low) = (S::as_mut_simd_f64s(&mut other.high).0, S::as_mut_simd_f64s(&mut other.low).0);
            for ((high, low), (row_high, row_low)) in
                high.iter_mut().zip(low).zip(row_high.iter().zip(row_low))
            {
                let product = mul(simd, factor, Quad(*row_high, *row_low));
                let Quad(one, two) = sub_estimate(simd, Quad(*high, *low), product);
                (*high, *low) = (one, two);
            }
        }
    }
}

/// Returns the inverse, and the logarithm of the magnitude of the determinant, by in-place elimination with partial
/// pivoting; `None` for a singular matrix.
pub(crate) fn inverse(a: &DMatrix<Quad>) -> Option<(DMatrix<Quad>, f64)> {
    let n = a.nrows();
    let arch = Arch::new();
    let mut rows: Vec<Row> = a.row_iter().map(|row| Row::of(row.iter().copied(), n)).collect();
    let mut swapped = vec![0; n];
    let mut log_det = 0.0;
    for k in 0..n {
        let size = |at: usize| rows[at].high[k].abs();
        let pivot = (k..n).max_by(|&p, &q| size(p).total_cmp(&size(q)))?;
        rows.swap(k, pivot);
        swapped[k] = pivot;
        let mut row = std::mem::take(&mut rows[k]);
        let value = row.at(k);
        if value.0 == 0.0 || !value.0.is_finite() {
            return None;
        }
        log_det += value.0.abs().ln();
        let reciprocal = value.recip();
        row.set(k, Quad::ONE);
        (0..n).for_each(|j| row.set(j, row.at(j) * reciprocal));
        arch.dispatch(Elimination { rows: &mut rows, row: &row, column: k });
        rows[k] = row;
    }
    for k in (0..n).rev() {
        for row in &mut rows {
            row.high.swap(k, swapped[k]);
            row.low.swap(k, swapped[k]);
        }
    }
    let inverse = DMatrix::from_fn(n, n, |i, j| rows[i].at(j));
    inverse.iter().all(|v| v.0.is_finite()).then_some((inverse, log_det))
}
