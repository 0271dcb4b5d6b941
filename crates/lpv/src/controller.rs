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

    /// The fastest mode of the frozen controller over some parameter values, the largest |lambda| of its A, rad/s.
    ///
    /// Infinity where the controller is not well posed, or its eigenvalues cannot be found. Between the values nothing is known.
    pub fn fastest_mode(&self, thetas: &[Vec<f64>]) -> f64 {
        let fastest_at = |theta: &Vec<f64>| match self.frozen(theta) {
            Ok(frozen) => frozen.poles().iter().map(|pole| pole.norm()).fold(0.0, worse),
            Err(_) => f64::INFINITY,
        };
        thetas.iter().map(fastest_at).fold(0.0, worse)
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

/// The larger of two; what is not a number counts as infinite.
fn worse(most: f64, v: f64) -> f64 {
    if v.is_nan() { f64::INFINITY } else { most.max(v) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::dmatrix;

    /// One state with the pole `-1 - 3 theta/(1 - d theta)`.
    fn controller(d: f64) -> Controller {
        Controller {
            a: dmatrix![-1.0],
            by: dmatrix![1.0],
            bt: dmatrix![-3.0],
            cu: dmatrix![1.0],
            duy: dmatrix![0.0],
            dut: dmatrix![0.0],
            ct: dmatrix![1.0],
            dty: dmatrix![0.0],
            dtt: dmatrix![d],
            blocks: vec![1],
        }
    }

    #[test]
    fn the_fastest_mode_is_that_of_the_worst_value() {
        assert_eq!(controller(0.0).fastest_mode(&[vec![-1.0], vec![0.0], vec![1.0]]), 4.0);
        assert_eq!(controller(0.5).fastest_mode(&[vec![1.0]]), 7.0);
    }

    #[test]
    fn a_controller_that_is_not_well_posed_is_infinitely_fast() {
        assert_eq!(controller(1.0).fastest_mode(&[vec![0.0], vec![1.0]]), f64::INFINITY);
    }
}
