//! Owner of a design's directory, and its files of an earlier design.

use crate::check::coupled::gain::CERTIFICATES;
use crate::error::{Error, StoreError};
use crate::inputs::Inputs;
use crate::run::Finished;
use squid_base::files::{read, reading};
use squid_scheduled::ControllerDesign;
use std::path::{Path, PathBuf};

/// File that contains the directory of the vehicle to which the design belongs.
pub(super) const MARK: &str = ".squid-vehicle";

/// Returns the content of that file; `None` for a vehicle in memory.
pub(super) fn mark(inputs: &Inputs) -> Option<String> {
    let directory = &inputs.directory;
    let path = directory.canonicalize().ok().filter(|_| !directory.as_os_str().is_empty())?;
    Some(format!("{}\n", path.display()))
}

/// Checks that a directory contains no design of another vehicle, which would be overwritten.
///
/// Vehicles of the same name in two directories are different vehicles, as long as both directories exist.
///
/// # Errors
/// [`StoreError::OtherVehicle`].
pub fn check_owner(directory: &Path, inputs: &Inputs) -> Result<(), StoreError> {
    let path = directory.join("controller.json");
    let _lock = reading(&path);
    if !path.is_file() {
        return Ok(());
    }
    let refused = |theirs: String| StoreError::OtherVehicle {
        directory: directory.display().to_string(),
        theirs,
        own: inputs.directory.display().to_string(),
    };
    let written = read(&directory.join(MARK)).ok();
    match (written, mark(inputs)) {
        (Some(theirs), Some(own)) if theirs == own => return Ok(()),
        (Some(theirs), Some(_)) if Path::new(theirs.trim_end()).join("vehicle.toml").is_file() => {
            return Err(refused(theirs.trim_end().to_owned()));
        }
        _ => {}
    }
    // An unreadable design has no owner.
    let stored = read(&path).ok().and_then(|text| ControllerDesign::from_json(&text).ok());
    match stored.map(|stored| stored.vehicle.name).filter(|name| *name != inputs.vehicle.name) {
        Some(name) => Err(refused(format!("'{name}'"))),
        None => Ok(()),
    }
}

/// Returns the FMUs and the SSP in a directory that belong to an earlier design; for one of several axes also the
/// packages and the certificates of all axes, in the directory above.
///
/// # Errors
/// The errors of the files.
pub fn outdated(directory: &Path, inputs: &Inputs, finished: &Finished) -> Result<Vec<PathBuf>, Error> {
    if is_written(&directory.join("controller.json"), finished)? {
        return Ok(vec![]);
    }
    let name = squid_model_description::identifier(&inputs.vehicle.name);
    let packed = ["_plant.fmu", "_controller.fmu", ".fmu", ".ssp"].map(|end| format!("{name}{end}"));
    let own = packed.iter().map(|file| directory.join(file));
    let above = directory.parent().filter(|_| inputs.design.axis.is_some());
    let of_all = packed.iter().map(String::as_str).chain(CERTIFICATES);
    let of_all = above.into_iter().flat_map(|above| of_all.clone().map(|file| above.join(file)));
    Ok(own.chain(of_all).filter(|path| path.is_file()).collect())
}

/// Returns `true` if the source in the folder of `squid export` belongs to an earlier design.
///
/// # Errors
/// The errors of the files.
pub fn is_source_outdated(source: &Path, finished: &Finished) -> Result<bool, Error> {
    let path = source.join("controller.json");
    Ok(path.is_file() && !is_written(&path, finished)?)
}

/// Returns `true` if a file contains the controller of a finished design.
fn is_written(path: &Path, finished: &Finished) -> Result<bool, Error> {
    let text = finished.frozen.controller.to_json()?;
    Ok(read(path).is_ok_and(|written| written == text))
}
