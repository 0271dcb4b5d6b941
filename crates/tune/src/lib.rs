//! Turns the keys of a design file.
//!
//! ```text
//! knob     a key of the design file that can be turned: its number is multiplied
//! attempt  a design with some keys turned, judged at few speeds and without proof
//! advise   what each key does to what a verdict misses, by designing again
//! range    the speeds of a first design file
//! start    a first design file for a vehicle that has none
//! search   the fastest design that meets what is required
//! ```

pub mod advise;
pub mod attempt;
pub mod error;
pub mod knob;
mod range;
pub mod search;
pub mod start;
