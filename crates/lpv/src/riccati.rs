//! H-infinity control of a plant without parameters, by Riccati equations with 32 digits.
//!
//! ```text
//! inverse    the inverse of a matrix with 32 digits
//! wide       matrices with 32 digits, the matrix sign function
//! equations  the two Riccati equations at a gain, and the central controller
//! least      the bracket of the least gain
//! bound      the gain of a closed loop, with the matrix that proves it
//! h2         the H2-optimal controller
//! ```
//!
//! The results do not depend on the coordinates of the states or on units, unlike matrix inequalities in floating
//! point.

pub(crate) mod bound;
pub(crate) mod equations;
pub mod h2;
mod inverse;
pub(crate) mod least;
pub(crate) mod wide;
