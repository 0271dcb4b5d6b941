//! Synthesis for a parameter with a bounded rate, by Lyapunov matrices that depend on it.
//!
//! ```text
//! plant at values of theta -> least gamma of X(theta), Y -> back-off -> controllers at many values -> LFT -> closed
//! loop -> proof on intervals
//! ```
//!
//! F. Wu, X. H. Yang, A. Packard, G. Becker, "Induced L2-norm control for LPV systems with bounded parameter variation
//! rates", Int. J. Robust Nonlinear Control 6, 1996. One of X and Y is constant, so that the controller does not need
//! the parameter's rate: P. Apkarian, R. J. Adams, "Advanced gain-scheduling techniques for uncertain systems", IEEE
//! Trans. Control Systems Technology 6(1), 1998, section IV.
//!
//! - [`inequalities`]: the synthesis inequalities at values of the parameter;
//! - `central`: the controller at one value, in closed form;
//! - `scheduled`: an LFT fitted to controllers at many values;
//! - [`mod@intervals`]: proof of the gain of the closed loop on the whole range of the parameter;
//! - [`loop_lyapunov`]: Lyapunov matrices computed for the closed loop, also with model error;
//! - [`mod@finished`]: the gain of a given closed loop, by Lyapunov matrices of increasing order;
//! - [`design`]: the complete design.

pub(crate) mod central;
pub mod design;
pub mod finished;
pub mod inequalities;
pub mod intervals;
pub mod loop_lyapunov;
pub(crate) mod scheduled;

pub use design::{Least, SlowDesign, SlowOptions, least_gamma, synthesise};
pub use finished::finished;
pub use inequalities::Varying;
pub use intervals::{Claim, SlowBound, intervals};
pub use loop_lyapunov::covering;
