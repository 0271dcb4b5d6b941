//! Errors of a campaign.

#[cfg(feature = "parquet")]
use parquet::errors::ParquetError;
use strum::IntoStaticStr;
use thiserror::Error as ThisError;

/// Reason why a campaign failed.
#[derive(Debug, ThisError, IntoStaticStr)]
#[strum(serialize_all = "snake_case")]
#[allow(missing_docs, reason = "the message says what each field is")]
pub enum Error {
    /// Invalid file of the design or of the results.
    #[error(transparent)]
    #[strum(transparent)]
    Design(#[from] squid_design::error::Error),
    /// A file that cannot be read or written.
    #[error(transparent)]
    #[strum(transparent)]
    File(#[from] squid_base::files::Error),
    /// A sea that cannot be simulated with the vehicle.
    #[error(transparent)]
    #[strum(transparent)]
    Flight(#[from] squid_flight::error::Error),
    /// Results that cannot be read.
    #[error("{path} is not a file of results: {reason}")]
    Results { path: String, reason: String },
    /// Results of another campaign.
    #[error(
        "{path} is of another campaign: {what} differs. Name another directory with --to, or remove this one to fly \
         all flights again"
    )]
    Other { path: String, what: String },
    /// A feature of the campaign that FMUs do not support.
    #[error("FMUs cannot fly {what}; fly the campaign without FMUs")]
    NotOfFmus { what: String },
    /// A campaign without an axis.
    #[error("there is no axis to fly")]
    NoAxis,
    /// An uncertain parameter that the vehicle does not have in six degrees of freedom.
    #[error("{name} is uncertain in the vertical plane alone: fly one axis, by --axis")]
    NotWhole { name: String },
    /// Rows that cannot be written as Parquet.
    #[cfg(feature = "parquet")]
    #[error("the results cannot be written as Parquet: {0}")]
    Parquet(#[from] ParquetError),
    /// A directory without results.
    #[error(
        "{path}: there is no such file; run `squid campaign` first, and name the directory of its results"
    )]
    NoCampaign { path: String },
    /// A flight that does not exist.
    #[error("there is no flight {flight} in {path}: its flights are 0 to {last}")]
    NoFlight { path: String, flight: u64, last: u64 },
}
