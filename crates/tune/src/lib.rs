//! Tuning of the numbers of a design file.
//!
//! ```text
//! knob       tuning key of a design file: a number to be multiplied by a factor
//! attempt    design with some keys changed, evaluated at few speeds and without proof
//! advise     effect of each key on missed requirements, from repeated designs
//! range      speed range of a first design file
//! start      first design file for a vehicle without one
//! search     search for the fastest design that meets the requirements
//! candidate  design of a search, and the order of candidates
//! descent    one descent of a search, subject to the requirements
//! direction  keys of a search that are changed together
//! finals     best candidates of a search, fully evaluated and proved
//! gain       tuned PID gains, and a design file with them
//! pid        PID gains for the weights of a design, or for simulated flights
//! required   PID gains that meet the requirements
//! ```

pub mod advise;
pub mod attempt;
pub mod candidate;
mod descent;
mod direction;
pub mod error;
mod finals;
pub mod gain;
pub mod knob;
pub mod pid;
mod range;
mod required;
pub mod search;
pub mod start;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
