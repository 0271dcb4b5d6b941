//! The files that a design starts from.

pub mod actuator_names;
pub mod design_file;

use crate::error::InputError;
use crate::files::read;
use crate::inputs::design_file::{BANDWIDTH, DesignFile, UncertainParameter};
use auv::Vehicle;
use sha2::{Digest, Sha256};
use std::path::{Path, PathBuf};

/// A vehicle and a design, with what identifies the files they came from.
#[derive(Debug, Clone)]
pub struct Inputs {
    /// The vehicle's directory, in full.
    pub directory: PathBuf,
    /// The vehicle.
    pub vehicle: Vehicle,
    /// The design.
    pub design: DesignFile,
    /// The uncertain coefficients that the design names, in the order of the vehicle file.
    pub uncertain: Vec<UncertainParameter>,
    /// SHA-256 of the vehicle file.
    pub vehicle_sha256: String,
    /// SHA-256 of the design file, and of what the command line changed in it.
    pub design_sha256: String,
}

impl Inputs {
    /// Reads `vehicle.toml` and the design `name` from a vehicle's directory.
    ///
    /// `bandwidth` replaces w_b of every W_e.
    ///
    /// # Errors
    /// The first file, key or value that is wrong.
    pub fn read(directory: &Path, name: &str, bandwidth: Option<f64>) -> Result<Self, InputError> {
        if !directory.is_dir() {
            return Err(InputError::NoVehicle { directory: directory.display().to_string() });
        }
        let vehicle_path = directory.join("vehicle.toml");
        let vehicle = Vehicle::read(&vehicle_path)?;
        actuator_names::check(&vehicle, &vehicle_path.display().to_string())?;
        let design_path = design_path(directory, name);
        let mut design = DesignFile::read(&design_path)?;
        let uncertain = match &design.uncertainty {
            Some(section) => section.resolve(&vehicle, &design_path.display().to_string())?,
            None => Vec::new(),
        };
        let mut hash = Sha256::new_with_prefix(read(&design_path)?);
        if let Some(bandwidth) = bandwidth {
            if !BANDWIDTH.allows(bandwidth) {
                return Err(InputError::Bandwidth { found: bandwidth });
            }
            hash.update(format!("bandwidth = {bandwidth:?}"));
            design = design.with_bandwidth(bandwidth);
        }
        let vehicle_sha256 = hexadecimal(&Sha256::digest(read(&vehicle_path)?));
        let directory = std::path::absolute(directory).unwrap_or_else(|_| directory.to_owned());
        Ok(Self {
            directory,
            vehicle,
            vehicle_sha256,
            design,
            uncertain,
            design_sha256: hexadecimal(&hash.finalize()),
        })
    }
}

fn design_path(directory: &Path, name: &str) -> PathBuf {
    let file = if name.ends_with(".toml") { name.to_owned() } else { format!("{name}.toml") };
    directory.join(file)
}

fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|b| format!("{b:02x}")).collect()
}
