//! Horizontally concatenated matrices, laid out for fast products.

use crate::Matrix;

/// Number of rows per panel, whose sums a processor accumulates in parallel.
const HEIGHT: usize = 4;

/// `[M1 M2 ...]`, column-major within panels of four rows; the last panel is padded with zeros.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Panels {
    columns: usize,
    entries: Vec<[f64; HEIGHT]>,
}

impl Panels {
    /// Concatenates matrices with the same number of rows.
    #[inline]
    pub(crate) fn concatenated(matrices: &[&Matrix]) -> Self {
        let rows = matrices.first().map_or(0, |matrix| matrix.rows());
        let columns = matrices.iter().map(|matrix| matrix.columns()).sum();
        let mut panels = vec![[0.0; HEIGHT]; rows.div_ceil(HEIGHT) * columns];
        for row in 0..rows {
            let panel = &mut panels[row / HEIGHT * columns..];
            let entries = matrices.iter().flat_map(|matrix| matrix.row(row));
            for (column, entry) in panel.iter_mut().zip(entries) {
                column[row % HEIGHT] = *entry;
            }
        }
        Self { columns, entries: panels }
    }

    /// Computes `out = [M1 M2 ...] x`.
    ///
    /// Shapes: `x` has one entry per column, `out` one per row.
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

    fn numbered(rows: usize, columns: usize, first: f64) -> Matrix {
        let entries = (0..rows * columns).map(|index| first + index as f64).collect();
        Matrix::new(rows, columns, entries).unwrap()
    }

    #[test]
    fn products_are_those_of_the_matrices() {
        for (rows, left, right) in [(0, 2, 1), (1, 1, 0), (3, 2, 4), (4, 0, 0), (4, 3, 1), (9, 6, 5)] {
            let (one, other) = (numbered(rows, left, -3.0), numbered(rows, right, 7.0));
            let x: Vec<f64> = (0..left + right).map(|index| 0.5 * index as f64 - 1.0).collect();
            let (mut expected, mut product) = (vec![0.0; rows], vec![f64::NAN; rows]);
            one.add_product(&x[..left], &mut expected);
            other.add_product(&x[left..], &mut expected);
            Panels::concatenated(&[&one, &other]).product(&x, &mut product);
            assert_eq!(product, expected, "{rows} x ({left} + {right})");
        }
    }
}
