//! Errors of the stored files of a design.

use std::fmt::Display;
use std::path::Path;
use strum::IntoStaticStr;
use thiserror::Error;

/// Error of the stored files of a design.
#[derive(Debug, Error, IntoStaticStr)]
#[strum(serialize_all = "snake_case")]
#[allow(missing_docs, reason = "the message says what each field is")]
pub enum StoreError {
    /// There is no frozen design yet.
    #[error("{directory}: no design found; run `squid design` first")]
    NotDesigned { directory: String },
    /// The frozen design belongs to another vehicle or another design file.
    #[error(
        "{directory}: this directory contains design '{design}' of {vehicle}; choose another directory with --out"
    )]
    OtherDesign { directory: String, vehicle: String, design: String },
    /// A design of another vehicle would be overwritten.
    #[error(
        "{directory}: this directory contains the design of another vehicle, {theirs}, which a design of {own} would \
         overwrite; choose another directory with --out, or remove this one"
    )]
    OtherVehicle { directory: String, theirs: String, own: String },
    /// The frozen design belongs to changed inputs.
    #[error("{directory}: {what} changed after this design; run `squid design` again")]
    Stale { directory: String, what: &'static str },
    /// A frozen file differs from the one that vehicle and design file give.
    #[error(
        "{file}: `{key}` is {found}, but vehicle and design file give {expected}; run `squid design` again"
    )]
    Edited { file: &'static str, key: String, found: String, expected: String },
    /// A stored file with keys or values of another version.
    #[error(
        "{path}: the format of the stored design is not that of this version of squid ({reason}); run `squid design` \
         again"
    )]
    OtherFormat { path: String, reason: String },
    /// A frozen controller is not valid.
    #[error("{path}: {reason}")]
    BadController { path: String, reason: squid_scheduled::DesignError },
    /// A frozen LPV model is not valid.
    #[error("{path}: {reason}")]
    BadPlant { path: String, reason: squid_auv::LpvModelError },
    /// The LPV model of the plant cannot be frozen or read.
    #[error(transparent)]
    LpvModel(#[from] squid_auv::LpvModelError),
    /// A vehicle cannot be written as JSON.
    #[error(transparent)]
    VehicleJson(#[from] squid_auv::VehicleJsonError),
    /// The frozen controller is invalid.
    #[error(transparent)]
    ControllerDesign(#[from] squid_scheduled::DesignError),
    /// The manoeuvre is invalid.
    #[error(transparent)]
    Manoeuvre(#[from] squid_scheduled::ManoeuvreError),
}

impl StoreError {
    /// Returns the error of a stored file that is JSON, but not as this version writes it.
    pub(crate) fn other_format(path: &Path, reason: impl Display) -> Self {
        let reason = reason.to_string();
        // Serde's list of all keys is too long for a sentence.
        let found = reason.split(", expected one of").next().unwrap_or_default().to_owned();
        Self::OtherFormat { path: path.display().to_string(), reason: found }
    }
}
