//! Errors of a problem.

use squid_base::files;
use squid_proof::error::ProofError;
use strum::IntoStaticStr;
use thiserror::Error as ThisError;

/// Reason why a problem could not be solved.
#[derive(Debug, ThisError, IntoStaticStr)]
#[strum(serialize_all = "snake_case")]
#[allow(missing_docs, reason = "the message says what each field is")]
pub enum Error {
    /// A file cannot be read or written.
    #[error(transparent)]
    #[strum(transparent)]
    File(#[from] files::Error),
    /// A certificate fails its proof.
    #[error(transparent)]
    #[strum(transparent)]
    Proof(#[from] ProofError),
    /// The text is invalid; `key` is the path to the wrong value, empty for the text as a whole.
    #[error("{file}{}: {reason}", .line.map_or_else(String::new, |line| format!(":{line}")))]
    Problem { file: String, line: Option<usize>, key: String, reason: String },
    /// mu cannot be bounded.
    #[error("{file}: {reason}")]
    Mu { file: String, reason: squid_lpv::mu::sweep::SweepError },
}
