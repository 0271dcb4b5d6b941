//! Errors that end the command.

use serde_json::{Value, json};
use squid_design::error::{CertifyError, Error as DesignError, InputError, ModelError, StoreError};
use squid_package::error::Error as PackageError;
use squid_problem::error::Error as ProblemError;
use squid_proof::error::ProofError;
use strum::IntoStaticStr;
use thiserror::Error as ThisError;

/// An error that ends the command with one message.
#[derive(Debug, ThisError, IntoStaticStr)]
#[strum(serialize_all = "snake_case")]
#[allow(missing_docs, reason = "the message says what each field is")]
pub enum Error {
    /// The design failed, or one of its files is wrong.
    #[error(transparent)]
    #[strum(transparent)]
    Design(#[from] squid_design::error::Error),
    /// A simulation failed.
    #[error(transparent)]
    #[strum(transparent)]
    Flight(#[from] squid_flight::error::Error),
    /// The report failed.
    #[error(transparent)]
    #[strum(transparent)]
    Report(#[from] squid_report::error::Error),
    /// An FMU cannot be packed, or is wrong.
    #[error(transparent)]
    #[strum(transparent)]
    Package(#[from] squid_package::error::Error),
    /// A number on the command line is out of range.
    #[error("{name} is {found}; it must be {allowed}")]
    Argument { name: &'static str, found: String, allowed: String },
    /// A record of a simulation cannot be plotted.
    #[error("{path}: {reason}")]
    Record { path: String, reason: String },
    /// A directory exists already.
    #[error("{path} already exists and is not overwritten; give a new directory")]
    Exists { path: String },
    /// Programs are missing without which no FMU can be made.
    #[error("missing: {programs}")]
    Missing { programs: String },
    /// A general problem has no answer.
    #[error(transparent)]
    #[strum(transparent)]
    Problem(#[from] ProblemError),
    /// The bound of a finished design is not proved.
    #[error(
        "NOT PROVED: {reason}\nThe design was written to {directory} for inspection only; `squid package` rejects it"
    )]
    NotProved { directory: String, reason: String },
    /// The bound of a given controller is not proved.
    #[error("NOT PROVED: {reason}")]
    Unproved { reason: String },
    /// An internal error of the program.
    #[error("internal error in squid, not in your files: {message}")]
    Defect { message: String },
    /// A requirement is missed.
    #[error("{}", .missed.join("\n"))]
    Missed { missed: Vec<String> },
    /// A campaign ended.
    #[error(transparent)]
    #[strum(transparent)]
    Campaign(#[from] squid_campaign::error::Error),
    /// The weights could not be tuned.
    #[error(transparent)]
    #[strum(transparent)]
    Tune(#[from] squid_tune::error::Error),
}

impl Error {
    /// Returns the status in the JSON output: `not_proved` if a proof fails, else `error`.
    pub fn status(&self) -> &'static str {
        let proof = match self {
            Self::NotProved { .. } | Self::Unproved { .. } => return "not_proved",
            Self::Design(DesignError::Proof(reason)) | Self::Problem(ProblemError::Proof(reason)) => reason,
            Self::Package(reason) => match reason.cause() {
                PackageError::Design(DesignError::Proof(reason)) => reason,
                _ => return "error",
            },
            _ => return "error",
        };
        match proof {
            ProofError::Unproved(_) | ProofError::WrongPlant { .. } => "not_proved",
            _ => "error",
        }
    }

    /// Returns the answer for programs: `status`, the key of the error, `reason` in a sentence, and each mistake in a
    /// file with its line, its key and what is allowed.
    pub fn answer(&self) -> Value {
        let key: &'static str = match self {
            Self::Package(reason) => reason.cause().into(),
            other => other.into(),
        };
        let mut answer = json!({ "status": self.status(), "key": key, "reason": self.to_string() });
        match self {
            Self::Design(DesignError::Input(InputError::File(wrong))) => {
                answer["file"] = json!(wrong.file);
                answer["mistakes"] = json!(wrong.mistakes);
            }
            Self::Design(DesignError::NoController { causes, .. }) => answer["causes"] = json!(causes),
            Self::Design(DesignError::Refused(refusal)) => answer["refusal"] = json!(refusal),
            Self::Problem(ProblemError::Problem { file, line, key, .. }) => {
                answer["file"] = json!(file);
                answer["mistakes"] = json!([{ "line": line, "key": key }]);
            }
            _ => {}
        }
        answer
    }

    /// Returns `true` if the command line is wrong, rather than a file.
    pub fn is_usage(&self) -> bool {
        matches!(self, Self::Argument { .. })
    }
}

squid_design::from_design_errors! {
    Error: CertifyError, InputError, ModelError, ProofError, StoreError, squid_auv::FileError, squid_base::files::Error,
        squid_certificate::Failure, squid_lpv::error::SynthesisError, squid_lpv::error::SystemError,
        squid_scheduled::DesignError
}
