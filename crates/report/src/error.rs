//! Errors of a report.

use squid_design::error::{CertifyError, ModelError, StoreError};
use squid_proof::error::ProofError;
use strum::IntoStaticStr;
use thiserror::Error as ThisError;

/// Reason why a report, or a section of it, could not be computed.
#[derive(Debug, ThisError, IntoStaticStr)]
#[strum(serialize_all = "snake_case")]
#[allow(missing_docs, reason = "the message says what each field is")]
pub enum Error {
    /// The design of the report is invalid.
    #[error(transparent)]
    #[strum(transparent)]
    Design(#[from] squid_design::error::Error),
    /// A flight could not be simulated.
    #[error(transparent)]
    #[strum(transparent)]
    Flight(#[from] squid_flight::error::Error),
    /// A plot could not be drawn.
    #[error("{path}: the plot cannot be drawn: {reason}")]
    Plot { path: String, reason: String },
    /// Another design cannot fly the course of the report's design.
    #[error("{file}: {what}; designs that are compared (--beside) must have the same manoeuvre")]
    NotBeside { file: String, what: String },
    /// There is no verdict.
    #[error("there is no verdict: {reason}")]
    Verdict { reason: String },
    /// The section needs a pitch step.
    #[error("it requires steps of pitch, but the design does not track pitch")]
    PitchNotTracked,
    /// The report has no axis.
    #[error("there is no axis to report on")]
    NoAxis,
    /// The report needs a step of pitch or depth.
    #[error("the design tracks neither pitch nor depth, so there is no response to show")]
    NothingSteps,
}

squid_design::from_design_errors! {
    Error: CertifyError, ModelError, ProofError, StoreError, squid_auv::LpvModelError, squid_base::files::Error,
        squid_lpv::error::SystemError, squid_lpv::error::SynthesisError,
        squid_scheduled::DesignError, squid_scheduled::ManoeuvreError
}
