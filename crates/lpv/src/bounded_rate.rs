//! Synthesis for a parameter that moves at a bounded rate, with Lyapunov matrices that depend on it.
//!
//! ```text
//! plant at some theta -> least gamma of X(theta), Y -> back-off -> controller at many theta -> LFT -> loop ->
//! intervals
//! ```
//!
//! F. Wu, X. H. Yang, A. Packard, G. Becker, "Induced L2-norm control for LPV systems with bounded parameter variation
//! rates", Int. J. Robust Nonlinear Control 6, 1996. One of X and Y is constant, so that the controller does not need
//! the parameter's rate: P. Apkarian, R. J. Adams, "Advanced gain-scheduling techniques for uncertain systems", IEEE
//! Trans. Control Systems Technology 6(1), 1998, section IV.
//!
//! - [`inequalities`]: the synthesis inequalities at values of the parameter;
//! - `central`: the controller at one value, in closed form;
//! - `scheduled`: an LFT through the controllers of many values;
//! - [`mod@intervals`]: what proves the gain of the finished loop, between the values too;
//! - [`own`]: Lyapunov matrices sought for the finished loop alone, also with model error;
//! - [`mod@finished`]: the same for a loop that is given, by Lyapunov matrices of rising order;
//! - [`design`]: all of it in one go.

pub(crate) mod central;
pub mod design;
pub mod finished;
pub mod inequalities;
pub mod intervals;
pub mod own;
pub(crate) mod scheduled;

pub use design::{Least, SlowDesign, SlowOptions, least_gamma, synthesise};
pub use finished::finished;
pub use inequalities::Varying;
pub use intervals::{Claim, SlowBound, intervals};
pub use own::covering;
