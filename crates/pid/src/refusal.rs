//! Errors of a controller, with their position in the file.

use squid_auv::toml_file::{FileError, FileProblem, Mistake};

/// Returns the error of a file with a single mistake.
pub(crate) fn refused(file: &str, line: usize, problem: FileProblem) -> FileError {
    FileError { file: file.to_owned(), mistakes: vec![Mistake { line, problem }] }
}

/// Returns the error for a value that is not allowed.
pub(crate) fn not_allowed(
    file: &str,
    line: usize,
    key: &str,
    found: impl Into<String>,
    allowed: impl Into<String>,
) -> FileError {
    let problem =
        FileProblem::NotAllowed { key: key.to_owned(), found: found.into(), allowed: allowed.into() };
    refused(file, line, problem)
}
