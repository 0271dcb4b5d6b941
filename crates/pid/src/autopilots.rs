//! Reads gains from the files of existing autopilots as `[controller]`, and writes them back into the same files.
//!
//! Each format has one table of keys for both reading and writing. Only numbers are replaced; every other byte of a
//! file stays.

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

/// An autopilot whose gains are in a file.
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

/// Reads the gains of an angle from a file; `missing` supplies what the file does not contain.
///
/// # Errors
/// [`FileError`] with line and key of a value that is missing, negative, duplicate, ambiguous or not a number.
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
/// The errors of [`import`]; [`FileError`] of `[controller]` for terms that the autopilot does not have.
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
