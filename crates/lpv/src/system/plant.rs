//! The generalised plant with its parameter channels, frozen or closed by a controller.

use crate::error::SystemError;
use crate::matrix::{Mat, block};
use crate::system::{
    Group, LOOP, NamedBlock, PLANT, Partitioned, Sizes, StateSpace, evenly_spread, named_blocks,
};

/// Returns the parameter of each channel of `Theta = blkdiag(theta_i I_ri)` for repetitions `[r_1, r_2, ...]`.
pub fn channels(blocks: &[usize]) -> Vec<usize> {
    blocks.iter().enumerate().flat_map(|(i, &r)| std::iter::repeat_n(i, r)).collect()
}

/// The generalised plant.
///
/// ```text
/// x' = A x + Bt wt + B1 w + B2 u
/// zt = Ct x + Dtt wt + Dt1 w + Dt2 u      wt = Theta zt,  Theta = blkdiag(theta_i I_ri),  |theta_i| <= 1
/// z  = C1 x + D1t wt + D11 w + D12 u
/// y  = C2 x + D2t wt + D21 w
/// ```
///
/// A direct path D22 from u to y is ignored: see [`crate::synthesis::direct_path`].
#[derive(Debug, Clone, PartialEq)]
pub struct GeneralisedPlant {
    /// The matrix, rows x', zt, z, y and columns x, wt, w, u.
    pub parts: Partitioned,
    /// The repetitions `[r_1, r_2, ...]` of the parameters.
    pub blocks: Vec<usize>,
}

named_blocks!(GeneralisedPlant: a X X, bt X T, b1 X W, b2 X U, ct T X, dtt T T, dt1 T W, dt2 T U,
    c1 Z X, d1t Z T, d11 Z W, d12 Z U, c2 Y X, d2t Y T, d21 Y W);

impl GeneralisedPlant {
    /// Builds a plant from blocks with their rows and columns; blocks left out are zero.
    ///
    /// # Errors
    /// Returns [`SystemError::Shape`] for the first block whose shape does not fit, or for a wrong sum of the
    /// repetitions.
    pub fn new(blocks: Vec<usize>, parts: &[NamedBlock]) -> Result<Self, SystemError> {
        Ok(Self { parts: Partitioned::new(PLANT, parts)?.with_channels(&blocks)?, blocks })
    }

    /// Returns the plant of a system from `[wt; w; u]` to `[zt; z; y]`, without the direct path from u to y, and that
    /// path D22 (y x u).
    ///
    /// # Panics
    /// If the sizes are not those of the system.
    pub fn of_system(system: &StateSpace, sizes: Sizes, blocks: Vec<usize>) -> (Self, Mat) {
        let matrix = block(&[&[&system.a, &system.b], &[&system.c, &system.d]]);
        let mut parts = Partitioned::of(matrix, PLANT, sizes);
        let d22 = parts.block(Group::Y, Group::U);
        parts.block_mut(Group::Y, Group::U).fill(0.0);
        (Self { parts, blocks }, d22)
    }

    /// Returns the sizes of the groups.
    pub fn sizes(&self) -> Sizes {
        self.parts.sizes()
    }

    /// Checks that the repetitions add up to the channels.
    ///
    /// # Errors
    /// Returns [`SystemError`] if they do not.
    pub fn check(&self) -> Result<(), SystemError> {
        self.parts.check_channels(&self.blocks)
    }

    /// Returns the plant at a frozen parameter value: the same partition without parameter channels. A direct path from
    /// u to y through the channels is left out.
    ///
    /// # Errors
    /// Returns [`SystemError::NotWellPosed`] if `I - Dtt Theta` is singular.
    pub fn frozen(&self, theta: &[f64]) -> Result<Self, SystemError> {
        let mut parts = self.parts.frozen(&channels(&self.blocks), theta)?;
        parts.block_mut(Group::Y, Group::U).fill(0.0);
        Ok(Self { parts, blocks: vec![] })
    }

    /// Returns the transposed plant; its primal inequality is the dual one of this plant. w and z, u and y are
    /// exchanged: `A', Ct', C1', C2'` for `A, Bt, B1, B2`.
    pub fn dual(&self) -> Self {
        self.changed(Partitioned::dual)
    }

    /// Returns the plant with w and z in units in which a gain of `gamma` is 1. The inequalities have the same X, Y and
    /// scalings.
    pub(crate) fn in_units_of(&self, gamma: f64) -> Self {
        self.changed(|parts| parts.in_units_of(gamma))
    }

    /// Returns the plant with another matrix in the same channels.
    pub(crate) fn changed(&self, change: impl FnOnce(&Partitioned) -> Partitioned) -> Self {
        Self { parts: change(&self.parts), blocks: self.blocks.clone() }
    }

    /// Returns the plant as a loop without control, u = 0.
    pub fn open(&self) -> ClosedLoop {
        ClosedLoop { parts: self.parts.cut(LOOP), channels: channels(&self.blocks) }
    }
}

/// A closed loop `x' = A x + Bt wt + B1 w, zt = Ct x + Dtt wt + Dt1 w, z = C1 x + D1t wt + D11 w, wt = Theta zt`.
#[derive(Debug, Clone, PartialEq)]
pub struct ClosedLoop {
    /// The matrix, rows x', zt, z and columns x, wt, w.
    pub parts: Partitioned,
    /// The parameter of each channel.
    pub channels: Vec<usize>,
}

named_blocks!(ClosedLoop: a X X, bt X T, b1 X W, ct T X, dtt T T, dt1 T W, c1 Z X, d1t Z T, d11 Z W);

impl ClosedLoop {
    /// Returns the loop in the coordinates `x = T x~`, `zt = tau zt~`, `wt = tau wt~`, each given with its inverse.
    pub fn in_coordinates(&self, state: (&Mat, &Mat), channel: (&Mat, &Mat)) -> Self {
        Self { parts: self.parts.in_coordinates(state, channel), channels: self.channels.clone() }
    }

    /// Returns the loop with w and z in units in which a gain of `gamma` is 1. The inequalities have the same X and
    /// scalings.
    pub(crate) fn in_units_of(&self, gamma: f64) -> Self {
        Self { parts: self.parts.in_units_of(gamma), channels: self.channels.clone() }
    }

    /// Returns the loop from w to z at a frozen parameter value.
    ///
    /// # Errors
    /// Returns [`SystemError::NotWellPosed`] if `I - Dtt Theta` is singular.
    pub fn frozen(&self, theta: &[f64]) -> Result<StateSpace, SystemError> {
        Ok(self.parts.frozen(&self.channels, theta)?.state_space(&[Group::Z], &[Group::W]))
    }

    /// Returns the loop of one parameter at `count` values, evenly spaced over [-1, 1], at least two.
    pub fn sampled(&self, count: usize) -> Result<Vec<(f64, StateSpace)>, SystemError> {
        evenly_spread(count).map(|theta| Ok((theta, self.frozen(&[theta])?))).collect()
    }
}
