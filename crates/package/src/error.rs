//! Errors of packing a design or verifying an FMU.

#![allow(missing_docs, reason = "the message says what each field is")]

use squid_design::error::{InputError, ModelError, StoreError};
use squid_proof::error::ProofError;
use strum::IntoStaticStr;
use thiserror::Error as ThisError;
use zip::result::ZipError;

/// Errors of packing a design or verifying an FMU.
#[derive(Debug, ThisError, IntoStaticStr)]
#[strum(serialize_all = "snake_case")]
pub enum Error {
    /// The design is wrong.
    #[error(transparent)]
    #[strum(transparent)]
    Design(#[from] squid_design::error::Error),
    /// The platform is unknown.
    #[error("the platform is {found}; it must be {allowed}")]
    UnknownPlatform { found: String, allowed: String },
    /// A frozen design does not give a valid FMU.
    #[error(transparent)]
    Describe(#[from] squid_fmi2::DescribeError),
    /// A shared library is missing.
    #[error(
        "{library} was not found in {places}; build it with `{how}`, or give its directory with --binaries"
    )]
    NoBinary { library: String, how: String, places: String },
    /// FMI 2.0 has no name for this platform.
    #[error("FMI 2.0 has no name for the platform {os} on {arch}")]
    Platform { os: &'static str, arch: &'static str },
    /// The file is not an FMU that every tool unpacks alike.
    #[error("{path}: {reason}")]
    Archive { path: String, reason: ArchiveError },
    /// The zip cannot be written.
    #[error("{path}: {reason}")]
    Zip { path: String, reason: ZipError },
    /// The description of the system of plant and controller cannot be written.
    #[error("{path}: {reason}")]
    Ssp { path: String, reason: std::io::Error },
    /// The resources of an FMU differ from those with which it was packed.
    #[error(
        "{path}: the GUID differs; its resources were changed after packing, or another version of squid packed it"
    )]
    WrongGuid { path: String },
    /// The model description of an FMU differs from the one with which it was packed.
    #[error("{path}: its modelDescription.xml was changed after packing")]
    WrongDescription { path: String },
    /// The FMU does not follow from vehicle and design file.
    #[error("{path}: it does not follow from these vehicle and design files: {reason}")]
    NotOfInputs { path: String, reason: String },
    /// A plant, loop or system was requested for a heading design alone.
    #[error(
        "a heading design is packed as a controller only; the vehicle belongs to the design of pitch or depth"
    )]
    OfHeading,
    /// The axes of the file are not those of the design.
    #[error(
        "{path}: it is for {found}, but {design} has {axes}; select one of these with --axis, or another design with \
            --design"
    )]
    OtherAxes { path: String, found: String, design: String, axes: String },
    /// The FMU contains no certificate.
    #[error("{path}: it contains no resources/{name} to verify")]
    NoCertificate { path: String, name: String },
    /// The controller cannot be exported as C.
    #[error(transparent)]
    Export(#[from] squid_embedded::ExportError),
    /// A source differs from the one written for the controller of the certificate.
    #[error("{path}: {reason}")]
    Source { path: String, reason: squid_embedded::SourceError },
    /// The design or the certificate of a source is missing next to it.
    #[error(
        "{path}: file not found; `squid export` writes it next to the source, and the verification requires it"
    )]
    NotBeside { path: String },
    /// A controller without proof is not packed.
    #[error(
        "the controller in {directory} is not certified: {reason}\nNothing was written. With --allow-uncertified it \
         is written and marked as uncertified"
    )]
    Uncertified { directory: String, reason: String },
    /// An error of a file, with the path added to a message that lacks it.
    #[error("{path}: {reason}")]
    InFile { path: String, reason: Box<Error> },
}

impl Error {
    /// Returns the error without the path that was added to it.
    pub fn cause(&self) -> &Self {
        match self {
            Self::InFile { reason, .. } => reason.cause(),
            other => other,
        }
    }
}

/// Errors of the archive of an FMU.
#[derive(Debug, ThisError, IntoStaticStr)]
#[strum(serialize_all = "snake_case")]
pub enum ArchiveError {
    /// The file is not a zip, or is damaged.
    #[error(transparent)]
    Zip(#[from] ZipError),
    /// An entry cannot be read.
    #[error("{name}: {reason}")]
    Unreadable { name: String, reason: std::io::Error },
    /// The name of an entry is not plain, so that tools may unpack it to different paths.
    #[error(
        "it contains the entry '{name}'; allowed are files and directories separated by /, without '\\', ':' and \
            links, with names other than '.' and '..' that do not end in a dot or a space"
    )]
    Name { name: String },
    /// Two entries may be unpacked to the same path.
    #[error("it contains the entry '{name}' twice if case is ignored")]
    Twice { name: String },
    /// The entries unpack to more than any packed FMU.
    #[error("the entries up to {name} unpack to more than {most} MB, the largest size that is read")]
    Large { name: String, most: u64 },
    /// The GUID is missing.
    #[error(
        "modelDescription.xml is missing or has no guid (for an SSP, unpack the FMUs in resources/ first)"
    )]
    NoGuid,
}

squid_design::from_design_errors! {
    Error: InputError, ModelError, ProofError, StoreError, squid_auv::FileError, squid_auv::LpvModelError,
        squid_auv::VehicleJsonError, squid_base::files::Error, squid_certificate::Failure, squid_scheduled::DesignError,
        squid_scheduled::ManoeuvreError
}
