//! The scheduled controller, an LFT in the same parameters as the plant.

use crate::error::SystemError;
use crate::matrix::Mat;
use crate::system::{
    CONTROLLER, ClosedLoop, GeneralisedPlant, Group, NamedBlock, Partitioned, Sizes, StateSpace, channels,
    named_blocks,
};

/// A controller scheduled on Theta.
///
/// ```text
/// xk' = A xk + By y + Bt wk
/// u   = Cu xk + Duy y + Dut wk
/// zk  = Ct xk + Dty y + Dtt wk      wk = Theta zk
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Controller {
    /// The matrix, rows xk', u, zk and columns xk, y, wk.
    pub parts: Partitioned,
    /// The repetitions of the parameters.
    pub blocks: Vec<usize>,
}

named_blocks!(Controller: a X X, by X Y, bt X T, cu U X, duy U Y, dut U T, ct T X, dty T Y, dtt T T);

impl Controller {
    /// Builds a controller from blocks with their rows and columns; blocks left out are zero.
    ///
    /// # Errors
    /// Returns [`SystemError::Shape`] for the first block whose shape does not fit, or for a wrong sum of the
    /// repetitions.
    pub fn new(blocks: Vec<usize>, parts: &[NamedBlock]) -> Result<Self, SystemError> {
        Ok(Self { parts: Partitioned::new(CONTROLLER, parts)?.with_channels(&blocks)?, blocks })
    }

    /// Returns the controller at a frozen parameter value, from y to u.
    ///
    /// ```text
    /// A + Bt D Ct,   By + Bt D Dty,   Cu + Dut D Ct,   Duy + Dut D Dty   with   D = Theta (I - Dtt Theta)^-1
    /// ```
    ///
    /// Shapes: `theta` has one value per entry of `blocks`.
    ///
    /// # Errors
    /// Returns [`SystemError::NotWellPosed`] if `I - Dtt Theta` is singular.
    pub fn frozen(&self, theta: &[f64]) -> Result<StateSpace, SystemError> {
        let frozen = self.parts.frozen(&channels(&self.blocks), theta)?;
        Ok(frozen.state_space(&[Group::U], &[Group::Y]))
    }

    /// Returns the fastest mode of the frozen controller over some parameter values: the largest |lambda| of its A,
    /// rad/s.
    ///
    /// Infinite if the controller is not well posed at one of them, or its eigenvalues cannot be computed. Nothing
    /// follows for the values between them.
    pub fn fastest_mode(&self, thetas: &[Vec<f64>]) -> f64 {
        let fastest_at = |theta: &Vec<f64>| match self.frozen(theta) {
            Ok(frozen) => frozen.poles().iter().map(|pole| pole.norm()).fold(0.0, worse),
            Err(_) => f64::INFINITY,
        };
        thetas.iter().map(fastest_at).fold(0.0, worse)
    }

    /// Returns the matrix `[A By Bt; Cu Duy Dut; Ct Dty Dtt]`.
    pub fn matrix(&self) -> &Mat {
        self.parts.matrix()
    }

    /// Returns the controller with the matrix `m`, `states` states, `y` measurements and `u` controls.
    ///
    /// Shapes: m is (states + u + r) x (states + y + r), where r is the sum of the repetitions.
    pub fn from_matrix(m: &Mat, states: usize, y: usize, u: usize, blocks: Vec<usize>) -> Self {
        let sizes = Sizes { x: states, y, u, t: blocks.iter().sum(), ..Sizes::default() };
        Self { parts: Partitioned::of(m.clone(), CONTROLLER, sizes), blocks }
    }
}

impl GeneralisedPlant {
    /// Returns the closed loop with a controller; the plant's channels come first, then the controller's.
    ///
    /// The direct path from u to y is zero, so the loop is well posed at Theta = 0. Shapes: plant and controller have
    /// the same number of measurements y and of controls u.
    ///
    /// Source: the star product of K. Zhou, J. C. Doyle, K. Glover, "Robust and Optimal Control", 1996, ch. 10.
    pub fn close(&self, k: &Controller) -> ClosedLoop {
        let channels = channels(&self.blocks).into_iter().chain(channels(&k.blocks)).collect();
        ClosedLoop { parts: self.parts.closed_by(&k.parts), channels }
    }
}

/// Returns the larger of two values; NaN is taken as infinite.
fn worse(most: f64, v: f64) -> f64 {
    if v.is_nan() { f64::INFINITY } else { most.max(v) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::dmatrix;

    /// Returns a controller with one state and the pole `-1 - 3 theta/(1 - d theta)`.
    fn controller(d: f64) -> Controller {
        let matrix = dmatrix![-1.0, 1.0, -3.0; 1.0, 0.0, 0.0; 1.0, 0.0, d];
        Controller::from_matrix(&matrix, 1, 1, 1, vec![1])
    }

    #[test]
    fn the_fastest_mode_is_that_of_the_worst_value() {
        assert_eq!(controller(0.0).fastest_mode(&[vec![-1.0], vec![0.0], vec![1.0]]), 4.0);
        assert_eq!(controller(0.5).fastest_mode(&[vec![1.0]]), 7.0);
    }

    #[test]
    fn the_fastest_mode_of_an_ill_posed_controller_is_infinite() {
        assert_eq!(controller(1.0).fastest_mode(&[vec![0.0], vec![1.0]]), f64::INFINITY);
    }
}
