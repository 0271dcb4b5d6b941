//! What is wrong with the archive of an FMU.

use thiserror::Error;
use zip::result::ZipError;

/// What is wrong with the archive.
#[derive(Debug, Error)]
#[allow(missing_docs, reason = "the message says what each field is")]
pub enum ArchiveError {
    /// It is no zip, or damaged.
    #[error(transparent)]
    Zip(#[from] ZipError),
    /// An entry cannot be read.
    #[error("{name}: {reason}")]
    Unreadable { name: String, reason: std::io::Error },
    /// A name that is not plain, and that one tool may unpack to another place than the next.
    #[error(
        "it contains an entry called '{name}'; allowed are files and folders with / between them, without '\\' \
            and ':', none called '.' or '..' or with a dot or a space at the end, and no links"
    )]
    Name { name: String },
    /// Two entries that a tool may unpack to the same place.
    #[error("it contains the entry '{name}' twice, if upper and lower case are taken for the same")]
    Twice { name: String },
    /// An entry that is larger than any that is shipped.
    #[error("{name}: it has more than {most} bytes")]
    Large { name: String, most: u64 },
    /// There is no GUID.
    #[error(
        "modelDescription.xml: it is missing, or names no guid; of an SSP, unpack the FMUs in resources/"
    )]
    NoGuid,
}
