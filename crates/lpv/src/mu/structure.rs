//! The block structure of a perturbation.

use super::CMat;
use nalgebra::Complex;
use std::ops::Range;
use thiserror::Error;

/// A block of a perturbation, w = Delta z.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Block {
    /// A real scalar, `delta I`; the number of repetitions.
    Real(usize),
    /// A complex scalar, `delta I`; the number of repetitions.
    Complex(usize),
    /// A full complex matrix.
    Full {
        /// Number of rows: entries of w.
        rows: usize,
        /// Number of columns: entries of z.
        cols: usize,
    },
}

impl Block {
    /// Returns the number of entries of w.
    pub fn rows(self) -> usize {
        match self {
            Self::Real(r) | Self::Complex(r) => r,
            Self::Full { rows, .. } => rows,
        }
    }

    /// Returns the number of entries of z.
    pub fn cols(self) -> usize {
        match self {
            Self::Real(r) | Self::Complex(r) => r,
            Self::Full { cols, .. } => cols,
        }
    }
}

/// A list of blocks on the diagonal of a perturbation.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Structure(Vec<Block>);

/// An invalid structure, or a matrix that does not fit it.
#[derive(Debug, Clone, PartialEq, Error)]
#[allow(missing_docs, reason = "the message says what each field is")]
pub enum StructureError {
    /// A block without rows or columns.
    #[error("block {number} is empty; a block must have at least one row and one column")]
    EmptyBlock {
        /// The number of the block, from 1.
        number: usize,
    },
    /// A structure without blocks.
    #[error("there is no block")]
    NoBlock,
    /// A block that is not in the usual notation [-r, 0], [r, 0] or [p, q].
    #[error(
        "block {number} is [{}, {}]; it must be [-r, 0] (a real scalar repeated r times), [r, 0] (a complex one) or \
         [p, q] (a full complex block)",
        found.0,
        found.1
    )]
    Notation {
        /// The number of the block, from 1.
        number: usize,
        found: (i64, i64),
    },
    /// A matrix M that does not map w to z.
    #[error("M is {} x {}; for these blocks it must be {} x {}", found.0, found.1, expected.0, expected.1)]
    Shape { found: (usize, usize), expected: (usize, usize) },
    /// A matrix M with an entry that is not finite.
    #[error("M has an entry that is not finite")]
    NotFinite,
}

impl Structure {
    /// Builds a structure from its blocks.
    ///
    /// # Errors
    /// Returns [`StructureError::NoBlock`] or [`StructureError::EmptyBlock`].
    pub fn new(blocks: Vec<Block>) -> Result<Self, StructureError> {
        if blocks.is_empty() {
            return Err(StructureError::NoBlock);
        }
        match blocks.iter().position(|b| b.rows() == 0 || b.cols() == 0) {
            Some(k) => Err(StructureError::EmptyBlock { number: k + 1 }),
            None => Ok(Self(blocks)),
        }
    }

    /// Returns a perturbation with each block replaced for which `part` returns another.
    pub(super) fn replaced(
        &self,
        mut delta: CMat,
        mut part: impl FnMut(Block, &Range<usize>, &Range<usize>) -> Option<CMat>,
    ) -> CMat {
        for (block, rows, cols) in self.places() {
            if let Some(part) = part(block, &rows, &cols) {
                delta.view_mut((rows.start, cols.start), part.shape()).copy_from(&part);
            }
        }
        delta
    }

    /// Returns the zero perturbation.
    pub(super) fn zeros(&self) -> CMat {
        CMat::zeros(self.rows(), self.cols())
    }

    /// Returns a structure of nonempty blocks.
    pub(super) fn of(blocks: Vec<Block>) -> Self {
        Self(blocks)
    }

    /// Builds a structure from the usual notation: `[-r, 0]` a real scalar repeated r times, `[r, 0]` a complex one,
    /// `[p, q]` a full block of p rows and q columns. `[-1, 1]` is read as `[-1, 0]`; `[1, 1]` is a complex scalar
    /// either way.
    ///
    /// # Errors
    /// Returns [`StructureError`] for an invalid block.
    pub fn from_notation(blocks: &[(i64, i64)]) -> Result<Self, StructureError> {
        let block = |(k, &(p, q)): (usize, &(i64, i64))| match (p, q) {
            (-1, 1) => Ok(Block::Real(1)),
            (r, 0) if r < 0 => Ok(Block::Real(r.unsigned_abs() as usize)),
            (r, 0) if r > 0 => Ok(Block::Complex(r as usize)),
            (1, 1) => Ok(Block::Complex(1)),
            (p, q) if p > 0 && q > 0 => Ok(Block::Full { rows: p as usize, cols: q as usize }),
            found => Err(StructureError::Notation { number: k + 1, found }),
        };
        Self::new(blocks.iter().enumerate().map(block).collect::<Result<_, _>>()?)
    }

    /// Returns the blocks.
    pub fn blocks(&self) -> &[Block] {
        &self.0
    }

    /// Returns the number of real unknowns of D-G scalings.
    pub(super) fn unknowns(&self) -> usize {
        let of = |block: &Block| match block {
            Block::Real(r) => 2 * r * r,
            Block::Complex(r) => r * r,
            Block::Full { .. } => 1,
        };
        self.0.iter().map(of).sum()
    }

    /// Returns the number of entries of w.
    pub fn rows(&self) -> usize {
        self.0.iter().map(|b| b.rows()).sum()
    }

    /// Returns the number of entries of z.
    pub fn cols(&self) -> usize {
        self.0.iter().map(|b| b.cols()).sum()
    }

    /// Returns each block with its entries of w and of z.
    pub fn places(&self) -> Vec<(Block, Range<usize>, Range<usize>)> {
        let (mut row, mut col) = (0, 0);
        let entries = |b: &Block| {
            let ranges = (*b, row..row + b.rows(), col..col + b.cols());
            (row, col) = (ranges.1.end, ranges.2.end);
            ranges
        };
        self.0.iter().map(entries).collect()
    }

    /// Returns `true` if every block is a real scalar.
    pub fn is_real(&self) -> bool {
        self.0.iter().all(|b| matches!(b, Block::Real(_)))
    }

    /// Checks that M maps w to z.
    ///
    /// # Errors
    /// Returns [`StructureError::Shape`], [`StructureError::NotFinite`].
    pub fn check(&self, m: &CMat) -> Result<(), StructureError> {
        let expected = (self.cols(), self.rows());
        if m.shape() != expected {
            return Err(StructureError::Shape { found: m.shape(), expected });
        }
        if m.iter().any(|v| !(v.re.is_finite() && v.im.is_finite())) {
            return Err(StructureError::NotFinite);
        }
        Ok(())
    }

    /// Returns `true` if `delta` has this structure, to rounding.
    pub fn holds(&self, delta: &CMat) -> bool {
        if delta.shape() != (self.rows(), self.cols()) {
            return false;
        }
        let mut allowed = CMat::zeros(self.rows(), self.cols());
        for (block, rows, cols) in self.places() {
            let part = delta.view((rows.start, cols.start), (rows.len(), cols.len()));
            let first = part[(0, 0)];
            let kept = match block {
                Block::Full { .. } => part.into_owned(),
                Block::Complex(r) => CMat::identity(r, r) * first,
                Block::Real(r) => CMat::identity(r, r) * Complex::new(first.re, 0.0),
            };
            allowed.view_mut((rows.start, cols.start), kept.shape()).copy_from(&kept);
        }
        (delta - allowed).norm() <= 1e-12 * delta.norm()
    }
}

/// Random structures and matrices for the tests of all bounds.
#[cfg(test)]
pub(super) mod random {
    use super::*;
    use proptest::prelude::*;

    /// Returns random blocks of every kind.
    pub(crate) fn blocks(most: usize) -> impl Strategy<Value = Structure> {
        let block = prop_oneof![
            (1usize..3).prop_map(Block::Real),
            (1usize..3).prop_map(Block::Complex),
            (1usize..3, 1usize..3).prop_map(|(rows, cols)| Block::Full { rows, cols }),
        ];
        prop::collection::vec(block, 1..most).prop_map(|blocks| Structure::new(blocks).unwrap())
    }

    /// Returns a structure, and a matrix for it.
    pub(crate) fn problem() -> impl Strategy<Value = (Structure, CMat)> {
        blocks(5).prop_flat_map(|structure| {
            let (rows, cols) = (structure.cols(), structure.rows());
            let entry = (-1.0..1.0f64, -1.0..1.0f64).prop_map(|(re, im)| Complex::new(re, im));
            let matrix =
                prop::collection::vec(entry, rows * cols).prop_map(move |v| CMat::from_vec(rows, cols, v));
            (Just(structure), matrix)
        })
    }
}
