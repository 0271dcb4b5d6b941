//! A loop with a perturbation of known structure and size, and performance inputs and outputs.

use super::CMat;
use super::structure::{Block, Structure, StructureError};
use crate::matrix::{Mat, solve};
use crate::system::StateSpace;

/// A perturbed system: from (wd, w) to (zd, z), `wd = Delta zd`.
#[derive(Debug, Clone, PartialEq)]
pub struct Perturbable {
    /// The system.
    pub system: StateSpace,
    /// The structure of Delta; its entries of w and of z come first.
    pub structure: Structure,
    /// The size of Delta.
    pub size: f64,
}

impl Perturbable {
    /// Returns the numbers of inputs and outputs in addition to those of Delta.
    pub(super) fn performance(&self) -> (usize, usize) {
        let (outputs, inputs) = self.system.d.shape();
        (inputs.saturating_sub(self.structure.rows()), outputs.saturating_sub(self.structure.cols()))
    }

    /// Returns the system from wd to zd, to which Delta is connected, without idle states.
    pub fn stability(&self) -> StateSpace {
        self.system.parts(0..self.structure.cols(), 0..self.structure.rows()).without_idle_states()
    }

    /// Returns the system from w to z with a real perturbation; `None` if the loop is not well posed with it.
    pub fn closed(&self, delta: &CMat) -> Option<StateSpace> {
        let (k, w) = (self.structure.cols(), self.structure.rows());
        let s = &self.system;
        let delta: Mat = delta.map(|v| v.re);
        let (rows, cols) = (s.d.nrows() - k, s.d.ncols() - w);
        let d11 = s.d.view((0, 0), (k, w)).into_owned();
        let closing = solve(&(Mat::identity(w, w) - &delta * d11), &delta)?;
        let through = |left: &Mat, right: &Mat| left * &closing * right;
        let (b1, b2) = (s.b.columns(0, w).into_owned(), s.b.columns(w, cols).into_owned());
        let (c1, c2) = (s.c.rows(0, k).into_owned(), s.c.rows(k, rows).into_owned());
        let (d12, d21) = (s.d.view((0, w), (k, cols)).into_owned(), s.d.view((k, 0), (rows, w)).into_owned());
        Some(StateSpace {
            a: &s.a + through(&b1, &c1),
            b: b2 + through(&b1, &d12),
            c: c2 + through(&d21, &c1),
            d: s.d.view((k, w), (rows, cols)).into_owned() + through(&d21, &d12),
        })
    }

    /// Returns the structure with the full performance block.
    ///
    /// # Errors
    /// Returns [`StructureError::EmptyBlock`] if there is no input or no output in addition to those of Delta.
    pub fn with_performance(&self) -> Result<Structure, StructureError> {
        let (rows, cols) = self.performance();
        let blocks = self.structure.blocks().iter().copied();
        Structure::new(blocks.chain([Block::Full { rows, cols }]).collect())
    }

    /// Returns the system with zd in units of the size and z in units of `gain`.
    pub(super) fn scaled(&self, gain: f64) -> StateSpace {
        let mut out = self.system.clone();
        let k = self.structure.cols();
        let z = out.d.nrows() - k;
        for m in [&mut out.c, &mut out.d] {
            m.rows_mut(0, k).scale_mut(self.size);
            m.rows_mut(k, z).unscale_mut(gain);
        }
        out
    }
}
