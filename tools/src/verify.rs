//! `squid verify`: proves the certificate of an FMU, or of a file.

use crate::cli::inputs;
use crate::error::Error;
use crate::output::say;
use squid_package::verify::verify;
use std::path::Path;

/// Proves a certificate; for the design of a vehicle if one is given.
///
/// # Errors
/// Those of the files, and why nothing is proved.
pub fn run(file: &Path, vehicle: Option<&Path>, design: &str, bandwidth: Option<f64>) -> Result<(), Error> {
    let inputs = vehicle.map(|directory| inputs(directory, design, bandwidth)).transpose()?;
    let verified = verify(file, inputs.as_ref())?;
    verified.about.iter().for_each(|line| say(line));
    say(&format!("PROVED: {}", verified.theorem));
    Ok(())
}
