//! The controller's LFT as matrices with checked shapes.

pub(crate) mod controller;
pub(crate) mod discretise;
pub(crate) mod lu;
pub(crate) mod matrix;
pub(crate) mod numbers;
pub(crate) mod panels;
pub(crate) mod schur;

use crate::{DesignError, LftMatrices, Matrix, Rows};

/// Dimensions of an LFT controller.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Sizes {
    /// Number of states n.
    pub states: usize,
    /// Number of inputs p, the length of y.
    pub inputs: usize,
    /// Number of outputs m, the length of u.
    pub outputs: usize,
    /// Number of channels r of Theta.
    pub channels: usize,
}

/// LFT with nine matrices, in continuous or discrete time; see the crate's documentation for the partition.
#[derive(Debug, Clone, PartialEq)]
#[allow(missing_docs)]
pub struct Lft {
    /// Repetitions of each scheduling parameter.
    pub blocks: Vec<usize>,
    pub a: Matrix,
    pub by: Matrix,
    pub bt: Matrix,
    pub cu: Matrix,
    pub duy: Matrix,
    pub dut: Matrix,
    pub ct: Matrix,
    pub dty: Matrix,
    pub dtt: Matrix,
}

impl Lft {
    /// Checks shapes and entries of the matrices of a design with `inputs` inputs and `outputs` actuators.
    ///
    /// # Errors
    /// [`DesignError::WrongLength`], [`DesignError::BadNumber`].
    #[inline]
    pub fn from_rows(matrices: &LftMatrices, inputs: usize, outputs: usize) -> Result<Self, DesignError> {
        let (n, r) = (matrices.a.len(), matrices.blocks.iter().sum());
        Ok(Self {
            blocks: matrices.blocks.clone(),
            a: checked("lft.A", &matrices.a, n, n)?,
            by: checked("lft.By", &matrices.by, n, inputs)?,
            bt: checked("lft.Bt", &matrices.bt, n, r)?,
            cu: checked("lft.Cu", &matrices.cu, outputs, n)?,
            duy: checked("lft.Duy", &matrices.duy, outputs, inputs)?,
            dut: checked("lft.Dut", &matrices.dut, outputs, r)?,
            ct: checked("lft.Ct", &matrices.ct, r, n)?,
            dty: checked("lft.Dty", &matrices.dty, r, inputs)?,
            dtt: checked("lft.Dtt", &matrices.dtt, r, r)?,
        })
    }

    /// Returns the numbers of states, inputs, outputs and channels.
    pub fn sizes(&self) -> Sizes {
        Sizes {
            states: self.a.rows(),
            inputs: self.by.columns(),
            outputs: self.cu.rows(),
            channels: self.dtt.rows(),
        }
    }
}

/// Returns a matrix of the given shape with finite entries; `key` is its path in the JSON file.
#[inline]
pub(crate) fn checked(key: &str, rows: &Rows, height: usize, width: usize) -> Result<Matrix, DesignError> {
    let wrong = |key: String, found, expected| DesignError::WrongLength { key, found, expected };
    if rows.len() != height {
        return Err(wrong(key.to_owned(), rows.len(), height));
    }
    for (i, row) in rows.iter().enumerate() {
        if row.len() != width {
            return Err(wrong(format!("{key}[{i}]"), row.len(), width));
        }
        for (j, &value) in row.iter().enumerate() {
            numbers::finite(format_args!("{key}[{i}][{j}]"), value)?;
        }
    }
    Matrix::new(height, width, rows.concat()).ok_or_else(|| wrong(key.to_owned(), 0, height * width))
}
