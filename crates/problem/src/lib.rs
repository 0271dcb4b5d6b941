//! LPV problems of any plant: input as JSON, result as a report.
//!
//! ```text
//! source        JSON text and its name in messages
//! object        JSON objects and matrices; errors name the key
//! problem_file  a generalised plant
//! discrete      a plant in discrete time
//! mu_file       a matrix or a system, and the blocks of its perturbation
//! synth         least gamma, controller and proof, as a `report`
//! check         proof of a certificate for a given plant
//! gain          gain of a closed loop
//! sampled       gain of a sampled-data loop
//! mu            structured singular value
//! ```

pub mod check;
pub mod discrete;
pub mod error;
mod findings;
pub mod gain;
pub mod mu;
pub mod mu_file;
mod object;
pub mod problem_file;
pub mod report;
pub mod sampled;
pub mod source;
pub mod synth;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
