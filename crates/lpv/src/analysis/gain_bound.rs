//! A bound on the gain of a loop, with its proof.

use crate::matrix::Mat;

/// A bound on the gain with the matrices that prove it.
#[derive(Debug, Clone, PartialEq)]
pub struct GainBound {
    /// The bound: for every measurable trajectory Theta(t) in the unit box the loop is exponentially stable and its L2
    /// gain from w to z is below this.
    pub gamma: f64,
    /// The Lyapunov matrix, ordered plant's states, then controller's.
    pub x: Mat,
    /// The factor V with `X = V'V`, if it proves the bound and X, rounded, may not.
    pub factor: Option<Mat>,
    /// The symmetric scaling, ordered plant's channels, then controller's.
    pub s: Mat,
    /// The skew scaling.
    pub t: Mat,
    /// The multiplier of the model error; 0 if there is none.
    pub lambda: f64,
    /// The largest eigenvalue of the bounded-real matrix, -X and -S, scaled to unit diagonals: minus the margin.
    pub largest_eigenvalue: f64,
}
