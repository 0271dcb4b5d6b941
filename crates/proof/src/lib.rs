//! The dictionary between `lpv`, which searches, and `certificate`, which proves in exact arithmetic and shares no code
//! with the search.
//!
//! ```text
//! text          a certificate, read and written
//! rows          plants and controllers as rows, and what of two is unlike
//! claim         the bound of a loop; with model error
//! rate          the bound for a parameter that moves at a bounded rate
//! ball          the ball of models around a fit
//! limits        what holds with commands at their limits
//! sampled       the bound of a sampled loop
//! constant      the bound for constant parameters
//! same_plant    whether two plants are the same function of their parameters
//! ```

pub mod ball;
pub mod claim;
pub mod constant;
pub mod error;
pub mod limits;
pub mod rate;
pub mod rows;
pub mod same_plant;
pub mod sampled;
pub mod text;
