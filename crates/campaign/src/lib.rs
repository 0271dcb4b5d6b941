//! Monte Carlo campaigns of a design: flights over its declared uncertainty, its speeds and a sea.
//!
//! ```text
//! plan       the definition of a campaign, and the random numbers of each flight
//! starts     the initial deviations from trim
//! flight     one flight, and its row of figures
//! table      rows to and from a Parquet file
//! run        runs the missing flights on all cores; finished ones are kept
//! summary    statistics of all rows
//! bound      gains of the drawn vehicles, and the guaranteed gain
//! ```
//!
//! `table` and `run` need the feature `parquet`.

pub mod bound;
pub mod error;
pub mod flight;
pub mod plan;
#[cfg(feature = "parquet")]
pub mod run;
pub mod starts;
pub mod summary;
#[cfg(feature = "parquet")]
pub mod table;
