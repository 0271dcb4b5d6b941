//! Parameters that the controller does not measure: a bound for them ([`bound`]), and a controller that tolerates
//! larger ones ([`alternation`]).

pub mod alternation;
pub mod bound;
pub mod constant;
mod size;
pub mod uncertain_plant;

pub use alternation::{NoSize, RobustDesign, RobustOptions, Round, StopReason, more_robust};
pub use uncertain_plant::UncertainPlant;
