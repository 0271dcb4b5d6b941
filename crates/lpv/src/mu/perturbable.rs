//! A loop with a perturbation of known structure and size, and inputs and outputs of performance.

use super::structure::{Block, Structure, StructureError};
use crate::system::state_space::StateSpace;

/// A perturbed system: from (wd, w) to (zd, z), `wd = Delta zd`.
#[derive(Debug, Clone, PartialEq)]
pub struct Perturbable {
    /// The system.
    pub system: StateSpace,
    /// The structure of Delta; its entries of w and of z stand first.
    pub structure: Structure,
    /// The size of Delta.
    pub size: f64,
}

impl Perturbable {
    /// Inputs and outputs beside those of Delta.
    pub(super) fn performance(&self) -> (usize, usize) {
        let (outputs, inputs) = self.system.d.shape();
        (inputs.saturating_sub(self.structure.rows()), outputs.saturating_sub(self.structure.cols()))
    }

    /// What Delta alone sees, from wd to zd, without the states that have no part in it.
    pub fn stability(&self) -> StateSpace {
        let (k, w) = (self.structure.cols(), self.structure.rows());
        let whole = StateSpace {
            a: self.system.a.clone(),
            b: self.system.b.columns(0, w).into_owned(),
            c: self.system.c.rows(0, k).into_owned(),
            d: self.system.d.view((0, 0), (k, w)).into_owned(),
        };
        whole.without_idle_states()
    }

    /// The structure with the full block of performance.
    ///
    /// # Errors
    /// [`StructureError::EmptyBlock`] when there is no input or no output beside those of Delta.
    pub fn with_performance(&self) -> Result<Structure, StructureError> {
        let (rows, cols) = self.performance();
        let blocks = self.structure.blocks().iter().copied();
        Structure::new(blocks.chain([Block::Full { rows, cols }]).collect())
    }

    /// The system with zd in units of the size and z in units of `gain`.
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
