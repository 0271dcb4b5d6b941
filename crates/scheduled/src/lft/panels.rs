//! Matrices side by side, laid out for products.

use crate::Matrix;

/// Rows whose sums are kept at a time; a processor adds to them in parallel.
const HEIGHT: usize = 4;

/// `[M1 M2 ...]`, column by column within panels of four rows; the last panel is filled up with zeros.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Panels {
    columns: usize,
    entries: Vec<[f64; HEIGHT]>,
}

impl Panels {
    /// Matrices with equally many rows, side by side.
    #[inline]
    pub(crate) fn beside(matrices: &[&Matrix]) -> Self {
        let rows = matrices.first().map_or(0, |matrix| matrix.rows());
        let columns = matrices.iter().map(|matrix| matrix.columns()).sum();
        let mut entries = vec![[0.0; HEIGHT]; rows.div_ceil(HEIGHT) * columns];
        for row in 0..rows {
            let panel = &mut entries[row / HEIGHT * columns..];
            let whole = matrices.iter().flat_map(|matrix| matrix.row(row));
            for (column, entry) in panel.iter_mut().zip(whole) {
                column[row % HEIGHT] = *entry;
            }
        }
        Self { columns, entries }
    }

    /// `out = [M1 M2 ...] x`.
    ///
    /// Shapes: `x` has as many entries as there are columns, `out` as many as there are rows.
    pub(crate) fn product(&self, x: &[f64], out: &mut [f64]) {
        debug_assert_eq!((self.columns, self.entries.len()), (x.len(), out.len().div_ceil(HEIGHT) * x.len()));
        for (index, out) in out.chunks_mut(HEIGHT).enumerate() {
            let panel = &self.entries[index * self.columns..(index + 1) * self.columns];
            let mut sums = [0.0; HEIGHT];
            for (column, x) in panel.iter().zip(x) {
                for (sum, entry) in sums.iter_mut().zip(column) {
                    *sum += entry * x;
                }
            }
            for (to, sum) in out.iter_mut().zip(sums) {
                *to = sum;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn counted(rows: usize, columns: usize, first: f64) -> Matrix {
        let entries = (0..rows * columns).map(|index| first + index as f64).collect();
        Matrix::new(rows, columns, entries).unwrap()
    }

    #[test]
    fn products_are_those_of_the_matrices() {
        for (rows, left, right) in [(0, 2, 1), (1, 1, 0), (3, 2, 4), (4, 0, 0), (4, 3, 1), (9, 6, 5)] {
            let (one, other) = (counted(rows, left, -3.0), counted(rows, right, 7.0));
            let x: Vec<f64> = (0..left + right).map(|index| 0.5 * index as f64 - 1.0).collect();
            let (mut expected, mut product) = (vec![0.0; rows], vec![f64::NAN; rows]);
            one.add_product(&x[..left], &mut expected);
            other.add_product(&x[left..], &mut expected);
            Panels::beside(&[&one, &other]).product(&x, &mut product);
            assert_eq!(product, expected, "{rows} x ({left} + {right})");
        }
    }
}
