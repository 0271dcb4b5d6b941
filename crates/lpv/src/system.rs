//! Systems that depend on parameters: representation, interconnection, closed loop.
//!
//! - [`polynomial`], [`rational`], [`lft`]: matrices that depend on parameters;
//! - [`partition`], [`plant`], [`controller`]: generalised plant, controller and closed loop;
//! - [`tracking`], [`weights`]: the augmented plant of a tracking problem;
//! - [`model_error`]: a norm-bounded error of the model;
//! - [`state_space`], [`modes`]: systems without parameters, their norm and their modes;
//! - [`bilinear`]: transform between discrete and continuous time.

mod assembly;
pub mod bilinear;
pub mod controller;
pub mod lft;
pub(crate) mod lyapunov;
pub mod model_error;
pub mod modes;
pub mod parameter_grid;
pub mod partition;
pub mod plant;
pub mod polynomial;
pub mod rational;
pub mod state_space;
pub mod tracking;
pub mod weights;

pub use controller::Controller;
pub use lft::Lft;
pub(crate) use lyapunov::{gramian_factors, lyapunov, middle_of_gramians};
pub use model_error::{LoopError, ModelError};
pub use modes::{check_detectable, check_stabilisable};
pub use parameter_grid::parameter_grid;
pub(crate) use parameter_grid::{coarse_grid, evenly_spread};
pub(crate) use partition::named_blocks;
pub use partition::{CONTROLLER, Group, LOOP, NamedBlock, PLANT, Partitioned, Sizes};
pub use plant::{ClosedLoop, GeneralisedPlant, channels};
pub use polynomial::MatrixPolynomial;
pub use rational::MatrixRational;
pub use state_space::{HinfNorm, StateSpace};
pub use weights::{ReferenceModel, ReferenceWeight, RisingWeight, TrackingWeight};
