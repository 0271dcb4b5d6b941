//! Errors that end the command.

use squid_design::error::{CertifyError, Error as DesignError, InputError, ModelError, StoreError};
use squid_problem::error::Error as ProblemError;
use squid_proof::error::ProofError;
use thiserror::Error as ThisError;

/// An error that ends the command with one message.
#[derive(Debug, ThisError)]
#[allow(missing_docs, reason = "the message says what each field is")]
pub enum Error {
    /// The design failed, or one of its files is wrong.
    #[error(transparent)]
    Design(#[from] squid_design::error::Error),
    /// A simulation failed.
    #[error(transparent)]
    Flight(#[from] squid_flight::error::Error),
    /// The report failed.
    #[error(transparent)]
    Report(#[from] squid_report::error::Error),
    /// An FMU cannot be packed, or is wrong.
    #[error(transparent)]
    Package(#[from] squid_package::error::Error),
    /// A number on the command line is out of range.
    #[error("{name} is {found}; it must be {allowed}")]
    Argument { name: &'static str, found: String, allowed: String },
    /// A record of a simulation cannot be plotted.
    #[error("{path}: {reason}")]
    Record { path: String, reason: String },
    /// A directory exists already.
    #[error("{path} exists already; name a new directory: nothing is overwritten")]
    Exists { path: String },
    /// Programs are missing without which no FMU can be made.
    #[error("missing: {programs}")]
    Missing { programs: String },
    /// A general problem has no answer.
    #[error(transparent)]
    Problem(#[from] ProblemError),
    /// The bound of a finished design is not proved.
    #[error(
        "NOT PROVED: {reason}\nThe design is in {directory}, for inspection; it proves nothing, and `squid \
            package` refuses it"
    )]
    NotProved { directory: String, reason: String },
    /// The bound of a given controller is not proved.
    #[error("NOT PROVED: {reason}")]
    Unproved { reason: String },
    /// An internal error of the program.
    #[error("this is a defect of squid, and not of your files: {message}")]
    Defect { message: String },
    /// A requirement is missed.
    #[error("{}", .missed.join("\n"))]
    Missed { missed: Vec<String> },
    /// A campaign ended.
    #[error(transparent)]
    Campaign(#[from] squid_campaign::error::Error),
    /// The weights could not be tuned.
    #[error(transparent)]
    Tune(#[from] squid_tune::error::Error),
}

impl Error {
    /// Returns the status in the JSON output: `not_proved` if a proof fails, else `error`.
    pub fn status(&self) -> &'static str {
        match self {
            Self::NotProved { .. } | Self::Unproved { .. } => "not_proved",
            Self::Design(DesignError::Proof(reason)) | Self::Problem(ProblemError::Proof(reason))
                if matches!(reason, ProofError::Unproved(_) | ProofError::WrongPlant { .. }) =>
            {
                "not_proved"
            }
            _ => "error",
        }
    }

    /// Returns `true` if the command line is wrong, rather than a file.
    pub fn is_usage(&self) -> bool {
        matches!(self, Self::Argument { .. })
    }
}

squid_design::from_design_errors! {
    Error: CertifyError, InputError, ModelError, ProofError, StoreError, squid_auv::FileError, squid_base::files::Error,
        squid_certificate::Failure, squid_lpv::error::LftError, squid_lpv::error::ShapeError, squid_lpv::error::SynthesisError,
        squid_scheduled::DesignError
}
