//! Matrices of exact numbers.

use crate::exact::dyadic::Dyadic;
use crate::plant::Rows;
use std::ops::{Index, IndexMut};

/// Matrix, row by row.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Matrix {
    pub(crate) rows: usize,
    pub(crate) cols: usize,
    entries: Vec<Dyadic>,
}

impl Matrix {
    pub(crate) fn zeros(rows: usize, cols: usize) -> Self {
        Self { rows, cols, entries: vec![Dyadic::default(); rows * cols] }
    }

    /// Returns `x I`.
    pub(crate) fn scalar(n: usize, x: &Dyadic) -> Self {
        let mut m = Self::zeros(n, n);
        (0..n).for_each(|i| m[(i, i)] = x.clone());
        m
    }

    /// Creates a matrix from a checked list of rows; `cols` is needed because an empty list does not determine it.
    pub(crate) fn from_rows(rows: &Rows, cols: usize) -> Self {
        let entries = rows.iter().flatten().map(|&x| Dyadic::from_f64(x)).collect();
        Self { rows: rows.len(), cols, entries }
    }

    /// Creates a matrix from a checked square list of rows.
    pub(crate) fn square(rows: &Rows) -> Self {
        Self::from_rows(rows, rows.len())
    }

    /// Writes `part` with its first entry at `(row, col)`.
    pub(crate) fn place(&mut self, row: usize, col: usize, part: &Self) {
        for i in 0..part.rows {
            for j in 0..part.cols {
                self[(row + i, col + j)] = part[(i, j)].clone();
            }
        }
    }

    /// Adds `part` with its first entry at `(row, col)`.
    pub(crate) fn add(&mut self, row: usize, col: usize, part: &Self) {
        for i in 0..part.rows {
            for j in 0..part.cols {
                self[(row + i, col + j)] = &self[(row + i, col + j)] + &part[(i, j)];
            }
        }
    }

    /// Returns the rows `from..to`.
    pub(crate) fn row_range(&self, from: usize, to: usize) -> Self {
        let entries = self.entries[from * self.cols..to * self.cols].to_vec();
        Self { rows: to - from, cols: self.cols, entries }
    }

    /// Returns the columns `from..to`.
    pub(crate) fn column_range(&self, from: usize, to: usize) -> Self {
        self.transpose().row_range(from, to).transpose()
    }

    /// Returns the rows and columns of these indices.
    pub(crate) fn principal(&self, indices: &[usize]) -> Self {
        let n = indices.len();
        let entries = indices.iter().flat_map(|&i| indices.iter().map(move |&j| self[(i, j)].clone()));
        Self { rows: n, cols: n, entries: entries.collect() }
    }

    /// Stacks this matrix above another.
    pub(crate) fn above(mut self, bottom: Self) -> Self {
        debug_assert_eq!(self.cols, bottom.cols);
        self.rows += bottom.rows;
        self.entries.extend(bottom.entries);
        self
    }

    pub(crate) fn transpose(&self) -> Self {
        let mut m = Self::zeros(self.cols, self.rows);
        for i in 0..self.rows {
            for j in 0..self.cols {
                m[(j, i)] = self[(i, j)].clone();
            }
        }
        m
    }

    pub(crate) fn plus(&self, other: &Self) -> Self {
        debug_assert_eq!((self.rows, self.cols), (other.rows, other.cols));
        let entries = self.entries.iter().zip(&other.entries).map(|(a, b)| a + b).collect();
        Self { entries, ..*self }
    }

    pub(crate) fn times(&self, other: &Self) -> Self {
        debug_assert_eq!(self.cols, other.rows);
        let mut m = Self::zeros(self.rows, other.cols);
        for i in 0..self.rows {
            for k in (0..self.cols).filter(|&k| !self[(i, k)].is_zero()) {
                for j in (0..other.cols).filter(|&j| !other[(k, j)].is_zero()) {
                    m[(i, j)] = &m[(i, j)] + &(&self[(i, k)] * &other[(k, j)]);
                }
            }
        }
        m
    }

    /// Returns the sum of the products of the entries.
    pub(crate) fn dot(&self, other: &Self) -> Dyadic {
        let products = self.entries.iter().zip(&other.entries).map(|(a, b)| a * b);
        products.fold(Dyadic::default(), |sum, product| &sum + &product)
    }

    pub(crate) fn scaled(&self, factor: &Dyadic) -> Self {
        Self { entries: self.entries.iter().map(|x| x * factor).collect(), ..*self }
    }

    pub(crate) fn negated(&self) -> Self {
        Self { entries: self.entries.iter().map(|x| -x).collect(), ..*self }
    }
}

impl Index<(usize, usize)> for Matrix {
    type Output = Dyadic;

    fn index(&self, (i, j): (usize, usize)) -> &Dyadic {
        &self.entries[i * self.cols + j]
    }
}

impl IndexMut<(usize, usize)> for Matrix {
    fn index_mut(&mut self, (i, j): (usize, usize)) -> &mut Dyadic {
        &mut self.entries[i * self.cols + j]
    }
}
