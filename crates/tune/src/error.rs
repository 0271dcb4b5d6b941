//! Why keys could not be turned.

use thiserror::Error as ThisError;

/// Why keys could not be turned.
#[derive(Debug, ThisError)]
#[allow(missing_docs, reason = "the message says what each field is")]
pub enum Error {
    /// A design, or a file of it, is wrong.
    #[error(transparent)]
    Design(#[from] squid_design::error::Error),
    /// A key that is to be written is not where it is looked for.
    #[error(
        "{file}: 'track' and 'measure' must be tables, each under its own [[...]]; '{key}' cannot be written otherwise"
    )]
    NotATable { file: String, key: String },
    /// The vehicle holds level flight nowhere.
    #[error(
        "no two neighbouring speeds from {from} to {to} m/s suit {vehicle}, so that there is no range of speed to \
         begin a design for: {reasons}; write a design file for the range that you need"
    )]
    NoRange { vehicle: String, from: f64, to: f64, reasons: String },
    /// Nothing moves pitch or speed.
    #[error(
        "no actuator of {vehicle} moves its {signal} at {speed:.2} m/s; there is nothing to control it with"
    )]
    NoAuthority { vehicle: String, signal: &'static str, speed: f64 },
    /// No design at all was found.
    #[error("none of {tried} designs has a controller; the first failed: {reason}")]
    NoDesign { tried: usize, reason: String },
}

squid_design::from_design_errors!(
    Error: squid_design::error::InputError,
    squid_design::error::ModelError,
    auv::FileError,
    base::files::Error
);
