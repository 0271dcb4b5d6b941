//! The controller's LFT as matrices of checked shapes.

pub(crate) mod controller;
pub(crate) mod discretise;
pub(crate) mod lu;
pub(crate) mod matrix;
pub(crate) mod numbers;
pub(crate) mod panels;
pub(crate) mod schur;

use crate::{DesignError, LftMatrices, Matrix, Rows};

/// Sizes of an LFT controller.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Sizes {
    /// States n.
    pub states: usize,
    /// Inputs p, the length of y.
    pub inputs: usize,
    /// Outputs m, the length of u.
    pub outputs: usize,
    /// Channels r of Theta.
    pub channels: usize,
}

/// The nine matrices, in continuous or in discrete time; see the crate's documentation for the partition.
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
        let of = checked;
        Ok(Self {
            blocks: matrices.blocks.clone(),
            a: of("lft.A", &matrices.a, (n, n))?,
            by: of("lft.By", &matrices.by, (n, inputs))?,
            bt: of("lft.Bt", &matrices.bt, (n, r))?,
            cu: of("lft.Cu", &matrices.cu, (outputs, n))?,
            duy: of("lft.Duy", &matrices.duy, (outputs, inputs))?,
            dut: of("lft.Dut", &matrices.dut, (outputs, r))?,
            ct: of("lft.Ct", &matrices.ct, (r, n))?,
            dty: of("lft.Dty", &matrices.dty, (r, inputs))?,
            dtt: of("lft.Dtt", &matrices.dtt, (r, r))?,
        })
    }

    /// Numbers of states, inputs, outputs and channels.
    pub fn sizes(&self) -> Sizes {
        Sizes {
            states: self.a.rows(),
            inputs: self.by.columns(),
            outputs: self.cu.rows(),
            channels: self.dtt.rows(),
        }
    }
}

#[inline]
pub(crate) fn checked(
    key: &str,
    rows: &Rows,
    (height, width): (usize, usize),
) -> Result<Matrix, DesignError> {
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
