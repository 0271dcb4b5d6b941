//! Turns the keys of a design file.
//!
//! ```text
//! knob     a key of the design file that can be turned: its number is multiplied
//! attempt  a design with some keys turned, judged at few speeds and without proof
//! advise   what each key does to what a verdict misses, by designing again
//! range    the speeds of a first design file
//! start    a first design file for a vehicle that has none
//! search   the fastest design that meets what is required
//! tried    a design that was tried, and which of two is better
//! direction  keys of a search that are turned together
//! finals   the best of a search, judged in full and proved
//! ```

pub mod advise;
pub mod attempt;
mod direction;
pub mod error;
mod finals;
pub mod knob;
mod range;
pub mod search;
pub mod start;
pub mod tried;
