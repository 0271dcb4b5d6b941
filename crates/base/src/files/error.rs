//! What stops a file from being read or written.

use std::io;
use thiserror::Error as ThisError;

/// What stops a file from being read or written.
#[derive(Debug, ThisError)]
#[allow(missing_docs, reason = "the message says what each field is")]
pub enum Error {
    /// A file cannot be read.
    #[error("{path}: cannot be read: {reason}")]
    Unreadable { path: String, reason: io::Error },
    /// There is no such file.
    #[error("{path}: there is no such file")]
    NotFound { path: String },
    /// The path is a folder.
    #[error("{path}: this is a folder; it must be a file")]
    Folder { path: String },
    /// A link to a file that does not exist.
    #[error(
        "{path}: this is a link that leads to no file, or back to itself; it must be a file, or a link to one"
    )]
    Link { path: String },
    /// The text is not UTF-8; `place` is the file, with the line if that is known.
    #[error("{place}: the text is not UTF-8 but {found}; save the file as UTF-8")]
    Encoding { place: String, found: String },
    /// A file cannot be written.
    #[error("{path}: cannot be written: {reason}")]
    Unwritable { path: String, reason: io::Error },
    /// JSON could not be written or read.
    #[error("{path}: {reason}")]
    Json { path: String, reason: serde_json::Error },
}
