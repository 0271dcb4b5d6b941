//! Interface between `lpv`, which searches for bounds, and `certificate`, which proves them in exact arithmetic and
//! shares no code with the search.
//!
//! ```text
//! claim         plant, controller and bounds as a certificate, read and written
//! rate          the bound for a parameter with a bounded rate
//! ball          the ball of models around a fit
//! limits        the step from which a loop with saturated commands returns to trim
//! sampled       the bound of a sampled loop
//! constant      the bound for constant parameters
//! same_plant    check that two plants are the same function of their parameters
//! ```

pub mod ball;
pub mod claim;
pub mod constant;
pub mod error;
pub mod limits;
pub mod rate;
pub mod same_plant;
pub mod sampled;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
