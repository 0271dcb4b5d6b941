//! H-infinity control of a plant without parameters, by Riccati equations with 32 digits.
//!
//! ```text
//! wide       matrices with 32 digits, the matrix sign function
//! equations  the two Riccati equations at a gain, and the central controller
//! least      the bracket of the least gain
//! bound      the gain of a finished loop, with the matrix that proves it
//! ```
//!
//! None of it depends on the coordinates of the states or on units, as matrix inequalities in floating point do.

pub(crate) mod bound;
pub(crate) mod equations;
pub(crate) mod least;
pub(crate) mod wide;
