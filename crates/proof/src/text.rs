//! Certificates as text.

use crate::error::ProofError;
use certificate::Certificate;
use std::path::Path;

/// Reads a certificate; `file` is for messages.
///
/// # Errors
/// [`ProofError::Certificate`].
pub fn parse(text: &str, file: &str) -> Result<Certificate, ProofError> {
    Certificate::from_json(text).map_err(|reason| ProofError::Certificate { file: file.into(), reason })
}

/// The text of a certificate for the file `path`.
///
/// # Errors
/// [`ProofError::Certificate`].
pub fn text(certificate: &Certificate, path: &Path) -> Result<String, ProofError> {
    let wrong = |reason| ProofError::Certificate { file: path.display().to_string(), reason };
    certificate.to_json().map_err(wrong)
}
