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
    #[error("{path} is not a results file of a campaign: {reason}")]
    Results { path: String, reason: String },
    /// Results of another campaign.
    #[error(
        "{path} belongs to another campaign: {what} differs. Choose another directory with --to, or remove this one \
         to simulate all flights again"
    )]
    Other { path: String, what: String },
    /// A feature of the campaign that FMUs do not support.
    #[error("FMUs cannot simulate {what}; run the campaign without FMUs")]
    NotOfFmus { what: String },
    /// A campaign without an axis.
    #[error("there is no axis to simulate")]
    NoAxis,
    /// An uncertain parameter that the vehicle does not have in six degrees of freedom.
    #[error(
        "the uncertainty of {name} applies to motion in the vertical plane only; select one axis with --axis"
    )]
    NotWhole { name: String },
    /// Rows that cannot be written as Parquet.
    #[cfg(feature = "parquet")]
    #[error("the results cannot be written as Parquet: {0}")]
    Parquet(#[from] ParquetError),
    /// A directory without results.
    #[error("{path}: file not found; run `squid campaign` first, and give the directory of its results")]
    NoCampaign { path: String },
    /// A flight that does not exist.
    #[error("{path} has no flight {flight}; its flights are 0 to {last}")]
    NoFlight { path: String, flight: u64, last: u64 },
}
