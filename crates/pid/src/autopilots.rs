//! Gains in the files of autopilots that teams have, read as `[controller]`, and written back into the same files.
//!
//! Each format has one table of keys, by which it is read and written. Numbers alone are replaced; every other byte of
//! a file stays.

mod ardusub;
mod cascade;
mod dune;
mod form;
mod mss;
mod mvp;
mod source;

use crate::angle::Angle;
use crate::file::Pid;
use squid_auv::toml_file::FileError;

pub use form::{Export, Import, Imported, LeftOut, Missing};
pub use source::Change;

/// An autopilot with a file of gains.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Autopilot {
    /// DUNE of LSTS, Porto.
    Dune,
    /// ArduSub.
    ArduSub,
    /// `mvp_control` of the University of Rhode Island.
    Mvp,
    /// MSS of Fossen, and the Python Vehicle Simulator.
    Mss,
}

/// Reads the gains of an angle in a file; `missing` has what the file does not say.
///
/// # Errors
/// [`FileError`] with the line and the key of what is missing, no number, negative, there twice, or ambiguous.
pub fn import(
    autopilot: Autopilot,
    angle: Angle,
    text: &str,
    file: &str,
    missing: &Missing,
) -> Result<Import, FileError> {
    match autopilot {
        Autopilot::Dune => dune::import(angle, text, file),
        Autopilot::ArduSub => ardusub::import(angle, text, file, missing),
        Autopilot::Mvp => mvp::import(angle, text, file, missing),
        Autopilot::Mss => mss::import(angle, text, file),
    }
}

/// Replaces the gains in a file.
///
/// # Errors
/// As [`import`]; [`FileError`] of `[controller]` with what the autopilot does not have.
pub fn export(
    autopilot: Autopilot,
    pid: &Pid,
    text: &str,
    file: &str,
    missing: &Missing,
) -> Result<Export, FileError> {
    match autopilot {
        Autopilot::Dune => dune::export(pid, text, file),
        Autopilot::ArduSub => ardusub::export(pid, text, file, missing),
        Autopilot::Mvp => mvp::export(pid, text, file, missing),
        Autopilot::Mss => mss::export(pid, text, file),
    }
}
