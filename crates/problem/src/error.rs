//! Why a problem has no answer.

use base::files;
use proof::error::ProofError;
use thiserror::Error as ThisError;

/// Why a problem has no answer.
#[derive(Debug, ThisError)]
#[allow(missing_docs, reason = "the message says what each field is")]
pub enum Error {
    /// A file cannot be read or written.
    #[error(transparent)]
    File(#[from] files::Error),
    /// A certificate does not prove.
    #[error(transparent)]
    Proof(#[from] ProofError),
    /// The text is wrong.
    #[error("{file}: {reason}")]
    Problem { file: String, reason: String },
    /// mu has no bound.
    #[error("{file}: {reason}")]
    Mu { file: String, reason: lpv::mu::sweep::SweepError },
}
