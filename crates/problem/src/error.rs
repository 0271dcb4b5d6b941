//! Why a problem has no answer.

use squid_design::error::{Error as DesignError, ProofError, StoreError};
use thiserror::Error as ThisError;

/// Why a problem has no answer.
#[derive(Debug, ThisError)]
#[allow(missing_docs, reason = "the message says what each field is")]
pub enum Error {
    /// A file cannot be read or written, or a certificate does not prove.
    #[error(transparent)]
    Design(#[from] DesignError),
    /// The text is wrong.
    #[error("{file}: {reason}")]
    Problem { file: String, reason: String },
    /// mu has no bound.
    #[error("{file}: {reason}")]
    Mu { file: String, reason: lpv::mu::sweep::SweepError },
}

squid_design::by_way_of_the_design!(Error: ProofError, StoreError, auv::FileError, certificate::Failure);
