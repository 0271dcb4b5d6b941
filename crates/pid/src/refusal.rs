//! What is wrong with a controller, at its place in the file.

use squid_auv::toml_file::{FileError, FileProblem, Mistake};

/// A file with one mistake.
pub(crate) fn refused(file: &str, line: usize, problem: FileProblem) -> FileError {
    FileError { file: file.to_owned(), mistakes: vec![Mistake { line, problem }] }
}

/// A value that is not allowed.
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
