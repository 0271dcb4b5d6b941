//! LPV problems for any plant: read from JSON text, answered by a report.
//!
//! ```text
//! source        a text with its name in messages
//! object        its objects and matrices; errors name the key
//! problem_file  a generalised plant
//! discrete      a plant in discrete time
//! mu_file       a matrix or a system, and the blocks of its perturbation
//! synth         least gamma, controller, proof: a `report`
//! check         whether a certificate is for a given plant
//! gain          the gain of a closed loop
//! sampled       the gain of a sampled-data loop
//! mu            the structured singular value
//! ```

pub mod check;
pub mod discrete;
pub mod error;
pub mod gain;
pub mod mu;
pub mod mu_file;
mod object;
pub mod problem_file;
pub mod report;
pub mod sampled;
pub mod source;
pub mod synth;
