//! Many flights of a design: over its declared uncertainty, its speeds, and a sea.
//!
//! ```text
//! plan       what a campaign is made of; the numbers drawn for its flight n
//! starts     how far off its trim a flight may begin
//! flight     one flight, and the row of figures that it comes to
//! table      rows as a Parquet file, and back
//! run        the flights that are missing, on all cores; what is done is kept
//! summary    what all rows say
//! bound      gains of vehicles drawn beside the guaranteed one
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
