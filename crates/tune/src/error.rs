//! Errors of tuning.

use strum::IntoStaticStr;
use thiserror::Error as ThisError;

/// Reason why a design could not be tuned.
#[derive(Debug, ThisError, IntoStaticStr)]
#[strum(serialize_all = "snake_case")]
#[allow(missing_docs, reason = "the message says what each field is")]
pub enum Error {
    /// A design or one of its files is invalid.
    #[error(transparent)]
    #[strum(transparent)]
    Design(#[from] squid_design::error::Error),
    /// A key to be written is not in its expected table.
    #[error(
        "{file}: 'track' and 'measure' must be tables with their own [[...]] headers; otherwise '{key}' cannot be \
            written"
    )]
    NotATable { file: String, key: String },
    /// No speed range is suitable for a design.
    #[error(
        "no speed range for a first design: no two adjacent speeds from {from} to {to} m/s are suitable for \
         {vehicle}: {reasons}; write a design file for the required range"
    )]
    NoRange { vehicle: String, from: f64, to: f64, reasons: String },
    /// The vehicle has no straight level flight.
    #[error("{vehicle} has no straight and level trim at {speed:.2} m/s: {reason}")]
    NoStraightFlight { vehicle: String, speed: f64, reason: String },
    /// No actuator acts on pitch, speed or heading.
    #[error(
        "no actuator of {vehicle} acts on its {signal} at {speed:.2} m/s, which therefore cannot be controlled"
    )]
    NoAuthority { vehicle: String, signal: &'static str, speed: f64 },
    /// No design was found.
    #[error("no controller was found in {tried} designs; the first failed: {reason}")]
    NoDesign { tried: usize, reason: String },
    /// There is no PID to start from.
    #[error(
        "{file} has no [controller], and no initial PID could be created: {reason}; write one as explained in \
            docs/pid.md"
    )]
    NoPid { file: String, reason: String },
}

squid_design::from_design_errors! {
    Error: squid_design::error::InputError, squid_design::error::ModelError, squid_auv::FileError,
        squid_base::files::Error
}
