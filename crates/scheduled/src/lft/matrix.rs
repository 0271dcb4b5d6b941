//! Small dense matrix in row-major order, for products without allocation.

use nalgebra::DMatrix;

/// Row-major matrix.
#[derive(Debug, Clone, PartialEq)]
pub struct Matrix {
    rows: usize,
    columns: usize,
    entries: Vec<f64>,
}

impl Matrix {
    /// Creates a matrix from its entries in row-major order; `None` if their number is not `rows columns`.
    pub fn new(rows: usize, columns: usize, entries: Vec<f64>) -> Option<Self> {
        (entries.len() == rows * columns).then_some(Self { rows, columns, entries })
    }

    /// Returns the number of rows.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Returns the number of columns.
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// Returns a row.
    pub fn row(&self, index: usize) -> &[f64] {
        &self.entries[index * self.columns..(index + 1) * self.columns]
    }

    /// Computes `out += M x`.
    ///
    /// Shapes: `x` has one entry per column, `out` one per row.
    pub fn add_product(&self, x: &[f64], out: &mut [f64]) {
        debug_assert_eq!((self.rows, self.columns), (out.len(), x.len()));
        for (index, sum) in out.iter_mut().enumerate() {
            *sum += self.row(index).iter().zip(x).map(|(entry, x)| entry * x).sum::<f64>();
        }
    }

    /// Returns `self other`; shapes m x k and k x n.
    #[inline]
    pub(crate) fn times(&self, other: &Self) -> Self {
        debug_assert_eq!(self.columns, other.rows);
        let mut entries = vec![0.0; self.rows * other.columns];
        for (index, out) in entries.chunks_exact_mut(other.columns.max(1)).enumerate() {
            for (inner, factor) in self.row(index).iter().enumerate() {
                for (to, entry) in out.iter_mut().zip(other.row(inner)) {
                    *to += factor * entry;
                }
            }
        }
        Self { rows: self.rows, columns: other.columns, entries }
    }

    /// Returns `self + factor other`, for matrices of the same shape.
    #[inline]
    pub(crate) fn plus(&self, factor: f64, other: &Self) -> Self {
        debug_assert_eq!((self.rows, self.columns), (other.rows, other.columns));
        let sum = |(one, other): (&f64, &f64)| one + factor * other;
        Self { entries: self.entries.iter().zip(&other.entries).map(sum).collect(), ..*self }
    }

    /// Returns `factor self`.
    #[inline]
    pub(crate) fn scaled(mut self, factor: f64) -> Self {
        self.entries.iter_mut().for_each(|entry| *entry *= factor);
        self
    }

    #[inline]
    pub(crate) fn to_dense(&self) -> DMatrix<f64> {
        DMatrix::from_row_slice(self.rows, self.columns, &self.entries)
    }

    #[inline]
    pub(crate) fn from_dense(dense: &DMatrix<f64>) -> Self {
        let entries = dense.transpose().as_slice().to_vec();
        Self { rows: dense.nrows(), columns: dense.ncols(), entries }
    }
}
