//! Monte Carlo campaigns of a design: flights over its declared uncertainty, its range of speeds and a sea.
//!
//! ```text
//! plan       definition of a campaign, and the random numbers of each flight
//! starts     initial deviations from trim
//! flight     a single flight, and its row of figures
//! table      rows to and from a Parquet file
//! run        simulation of the missing flights on all cores
//! summary    statistics of all rows
//! bound      gains of the drawn vehicles, and the guaranteed gain
//! ```
//!
//! `table` and `run` require the feature `parquet`.

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

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
