//! Why a design could not be packed, or an FMU not be verified.

#![allow(missing_docs, reason = "the message says what each field is")]

use squid_design::error::{InputError, ModelError, StoreError};
use squid_proof::error::ProofError;
use strum::IntoStaticStr;
use thiserror::Error as ThisError;
use zip::result::ZipError;

/// Why a design could not be packed, or an FMU not be verified.
#[derive(Debug, ThisError, IntoStaticStr)]
#[strum(serialize_all = "snake_case")]
pub enum Error {
    /// The design is wrong.
    #[error(transparent)]
    #[strum(transparent)]
    Design(#[from] squid_design::error::Error),
    /// A platform that is not known.
    #[error("the platform is {found}; it must be {allowed}")]
    UnknownPlatform { found: String, allowed: String },
    /// A frozen design gives no valid FMU.
    #[error(transparent)]
    Describe(#[from] squid_fmi2::DescribeError),
    /// A shared library is missing.
    #[error("{library} is not in {places}; build it with `{how}`, or name its directory with --binaries")]
    NoBinary { library: String, how: String, places: String },
    /// FMI 2.0 has no name for this platform.
    #[error("FMI 2.0 has no name for the platform {os} on {arch}")]
    Platform { os: &'static str, arch: &'static str },
    /// A file is no FMU that every tool unpacks alike.
    #[error("{path}: {reason}")]
    Archive { path: String, reason: ArchiveError },
    /// The zip could not be made.
    #[error("{path}: {reason}")]
    Zip { path: String, reason: ZipError },
    /// The system of plant and controller could not be described.
    #[error("{path}: {reason}")]
    Ssp { path: String, reason: std::io::Error },
    /// The resources of an FMU are not those that it was packed with.
    #[error(
        "{path}: its resources were changed after it was packed, or another version of squid packed it (the \
            GUID differs)"
    )]
    WrongGuid { path: String },
    /// The model description of an FMU is not the one that it was packed with.
    #[error("{path}: its modelDescription.xml was changed after it was packed")]
    WrongDescription { path: String },
    /// An FMU is not what vehicle and design file make.
    #[error("{path}: it is not what these vehicle and design files make: {reason}")]
    NotOfInputs { path: String, reason: String },
    /// A plant, a loop or a system of a design of heading.
    #[error(
        "a design of heading is packed as a controller alone: the vehicle is that of its design of pitch or depth"
    )]
    OfHeading,
    /// The axes of a file are not those of the design.
    #[error(
        "{path}: it is of {found}, and {design} is of {axes}; name one of these with --axis, or another --design"
    )]
    OtherAxes { path: String, found: String, design: String, axes: String },
    /// The FMU contains no certificate.
    #[error("{path}: it contains no resources/{name}, so there is nothing to verify")]
    NoCertificate { path: String, name: String },
    /// The controller cannot be written as C.
    #[error(transparent)]
    Export(#[from] squid_embedded::ExportError),
    /// A source is not the one that was written for the controller of the certificate.
    #[error("{path}: {reason}")]
    Source { path: String, reason: squid_embedded::SourceError },
    /// What a source was written for is not beside it.
    #[error("{path} is not there; `squid export` writes it beside the source, which is verified by it")]
    NotBeside { path: String },
    /// A controller without proof is not packed.
    #[error(
        "the controller in {directory} is not certified: {reason}\nNothing is written. With --allow-uncertified \
         it is, and says that it is uncertified"
    )]
    Uncertified { directory: String, reason: String },
    /// What was said of a file that does not name it.
    #[error("{path}: {reason}")]
    Of { path: String, reason: Box<Error> },
}

/// What is wrong with the archive of an FMU.
#[derive(Debug, ThisError, IntoStaticStr)]
#[strum(serialize_all = "snake_case")]
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
    /// Entries that unpack to more than any FMU that is shipped.
    #[error("all entries up to {name} unpack to more than {most} MB, the most that is read")]
    Large { name: String, most: u64 },
    /// There is no GUID.
    #[error(
        "modelDescription.xml: it is missing, or names no guid; of an SSP, unpack the FMUs in resources/"
    )]
    NoGuid,
}

squid_design::from_design_errors! {
    Error: InputError, ModelError, ProofError, StoreError, squid_auv::FileError, squid_auv::LpvModelError,
        squid_auv::VehicleJsonError, squid_base::files::Error, squid_certificate::Failure, squid_scheduled::DesignError,
        squid_scheduled::ManoeuvreError
}
