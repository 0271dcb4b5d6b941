//! The scheduled controller, an LFT in the same parameters as the plant.

use crate::error::LftError;
use crate::matrix::Mat;
use crate::plant::{channels, closing};
use crate::state_space::StateSpace;

/// A controller scheduled on Theta.
///
/// ```text
/// xk' = A xk + By y + Bt wk
/// u   = Cu xk + Duy y + Dut wk
/// zk  = Ct xk + Dty y + Dtt wk      wk = Theta zk
/// ```
#[derive(Debug, Clone, PartialEq)]
#[allow(missing_docs)] // The names are the equations above.
pub struct Controller {
    pub a: Mat,
    pub by: Mat,
    pub bt: Mat,
    pub cu: Mat,
    pub duy: Mat,
    pub dut: Mat,
    pub ct: Mat,
    pub dty: Mat,
    pub dtt: Mat,
    /// The repetitions of the parameters.
    pub blocks: Vec<usize>,
}

impl Controller {
    /// The controller at a frozen parameter value, from y to u.
    ///
    /// # Errors
    /// [`LftError::NotWellPosed`] when `I - Dtt Theta` is singular.
    pub fn frozen(&self, theta: &[f64]) -> Result<StateSpace, LftError> {
        let closing = closing(&channels(&self.blocks), &self.dtt, theta)?;
        Ok(StateSpace {
            a: &self.a + &self.bt * &closing * &self.ct,
            b: &self.by + &self.bt * &closing * &self.dty,
            c: &self.cu + &self.dut * &closing * &self.ct,
            d: &self.duy + &self.dut * &closing * &self.dty,
        })
    }

    /// The whole matrix `[A By Bt; Cu Duy Dut; Ct Dty Dtt]`.
    pub fn matrix(&self) -> Mat {
        crate::matrix::block(&[
            &[&self.a, &self.by, &self.bt],
            &[&self.cu, &self.duy, &self.dut],
            &[&self.ct, &self.dty, &self.dtt],
        ])
    }

    /// The controller whose whole matrix is `m`, with `states` states, `y` measurements and `u` controls.
    pub fn from_matrix(m: &Mat, states: usize, y: usize, u: usize, blocks: Vec<usize>) -> Self {
        let r: usize = blocks.iter().sum();
        let part = |i, j, rows, cols| m.view((i, j), (rows, cols)).into_owned();
        Self {
            a: part(0, 0, states, states),
            by: part(0, states, states, y),
            bt: part(0, states + y, states, r),
            cu: part(states, 0, u, states),
            duy: part(states, states, u, y),
            dut: part(states, states + y, u, r),
            ct: part(states + u, 0, r, states),
            dty: part(states + u, states, r, y),
            dtt: part(states + u, states + y, r, r),
            blocks,
        }
    }
}
