//! Tuning of the keys of a design file.
//!
//! ```text
//! knob       a tuning key of the design file: a number that is multiplied
//! attempt    a design with some keys changed, evaluated at few speeds and without proof
//! advise     the effect of each key on missed requirements, from new designs
//! range      the speed range of a first design file
//! start      a first design file for a vehicle without one
//! search     the fastest design that meets the requirements
//! candidate  a design of a search, and the order of two
//! descent    one descent of a search within the requirements
//! direction  keys of a search that are changed together
//! finals     the best of a search, fully evaluated and proved
//! gain       gains of a PID, and a design file with them
//! pid        gains of a PID for the weights of a design, or for flights
//! required   gains of a PID that meet the requirements
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
