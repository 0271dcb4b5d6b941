//! Problems of any plant, as JSON: what is asked in a text, what was found in a report.
//!
//! ```text
//! source        a text, with the name that messages give it
//! matrices      its matrices; errors name the key
//! problem_file  a generalised plant
//! discrete      a plant in discrete time
//! mu_file       a matrix or a system, and the blocks of its perturbation
//! synth         least gamma, controller, proof: a `report`
//! check         whether a certificate is of a plant
//! gain          the gain of a finished loop
//! sampled       the gain of a sampled loop
//! mu            the structured singular value
//! words         numbers as people read them
//! ```

pub mod check;
pub mod discrete;
pub mod error;
pub mod gain;
mod matrices;
pub mod mu;
mod mu_file;
pub mod problem_file;
pub mod report;
pub mod sampled;
pub mod source;
pub mod synth;
mod words;
