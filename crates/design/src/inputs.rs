//! The input files of a design.

pub mod actuator_names;
pub mod design_file;
mod doubts;
mod reweighted;

use crate::axis::VehicleModel;
use crate::error::InputError;
use crate::inputs::design_file::{BANDWIDTH, DesignFile, UncertainParameter, relative_weight};
use crate::linearise::{LevelFlight, TRIM_ROWS};
use auv::longitudinal::SPEED;
use auv::{Pitch, Vehicle};
use base::files::read;
use pid::Pid;
use scheduled::InputHashes;
use sha2::{Digest, Sha256};
use std::path::{Path, PathBuf};

/// A vehicle and a design file, with their hashes.
#[derive(Debug, Clone)]
pub struct Inputs {
    /// The vehicle's directory, as an absolute path.
    pub directory: PathBuf,
    /// The vehicle as the axis of the design has it: in the vertical plane, or with what yaws it.
    pub vehicle: Vehicle,
    /// The vehicle in the vertical plane, which is in level trim.
    pub plane: Vehicle,
    /// The vehicle as its file has it.
    pub whole: Vehicle,
    /// The design.
    pub design: DesignFile,
    /// The uncertain coefficients of the design, in the order of the vehicle file.
    pub uncertain: Vec<UncertainParameter>,
    /// The hashes of the vehicle file, and of the design file with the changes from the command line.
    pub hashes: InputHashes,
}

impl Inputs {
    /// Half range of the gain of every actuator, relative; 0 if it is not uncertain.
    pub fn actuator_gain(&self) -> f64 {
        self.design.uncertainty.as_ref().map_or(0.0, |u| u.actuator_gain)
    }

    /// The vehicle as the design has it.
    pub fn axis(&self) -> LevelFlight<'_> {
        let Self { vehicle, plane, design: file, uncertain, .. } = self;
        LevelFlight { vehicle, plane, file, uncertain }
    }

    /// Whether the design declares anything uncertain.
    pub fn is_uncertain(&self) -> bool {
        !self.uncertain.is_empty() || self.actuator_gain() != 0.0
    }

    /// The minimum and the maximum output of each actuator.
    pub fn limits(&self) -> Vec<(f64, f64)> {
        self.vehicle.actuators.iter().map(|a| (a.min, a.max)).collect()
    }

    /// A vehicle and a design created in memory, identified by a hash of their content.
    ///
    /// # Errors
    /// [`InputError`]: an actuator name that the FMUs use, or an uncertain coefficient that the vehicle does not have.
    pub fn new(vehicle: Vehicle, design: DesignFile) -> Result<Self, InputError> {
        let texts = [format!("{vehicle:?}"), format!("{design:?}")];
        Self::of((vehicle, &texts[0]), (design, &texts[1]), ["the vehicle", "the design"])
    }

    /// Parses the texts of a vehicle file and a design file.
    ///
    /// # Errors
    /// [`InputError`]: the first wrong file, key or value.
    pub fn parse(vehicle: &str, design: &str) -> Result<Self, InputError> {
        let files = ["vehicle.toml", "design.toml"];
        let parsed = (Vehicle::parse(vehicle, files[0])?, DesignFile::parse(design, files[1], "design")?);
        Self::of((parsed.0, vehicle), (parsed.1, design), files)
    }

    /// Reads `vehicle.toml` and the design `name` from a vehicle's directory.
    ///
    /// # Errors
    /// [`InputError`]: the first wrong file, key or value.
    pub fn read(directory: &Path, name: &str) -> Result<Self, InputError> {
        if !directory.is_dir() {
            return Err(InputError::NoVehicle { directory: directory.display().to_string() });
        }
        let paths = [directory.join("vehicle.toml"), design_path(directory, name)];
        let files = paths.each_ref().map(|path| path.display().to_string());
        let vehicle_text = read(&paths[0])?;
        if !paths[1].exists() {
            let (path, directory) = (files[1].clone(), directory.display().to_string());
            return Err(InputError::NoDesign { path, directory, name: stem(&paths[1]) });
        }
        let design_text = read(&paths[1])?;
        let vehicle = Vehicle::parse(&vehicle_text, &files[0])?;
        let design = DesignFile::parse(&design_text, &files[1], &stem(&paths[1]))?;
        let mut inputs =
            Self::of((vehicle, &vehicle_text), (design, &design_text), files.each_ref().map(String::as_str))?;
        inputs.directory = std::path::absolute(directory).unwrap_or_else(|_| directory.to_owned());
        Ok(inputs)
    }

    /// Checks vehicle and design against each other; `files` are their names in messages, the texts are hashed.
    fn of(
        vehicle: (Vehicle, &str),
        design: (DesignFile, &str),
        files: [&str; 2],
    ) -> Result<Self, InputError> {
        actuator_names::check(&vehicle.0, files[0])?;
        let hashes = InputHashes { vehicle_sha256: sha256(vehicle.1), design_sha256: sha256(design.1) };
        let (whole, mut design) = (vehicle.0, design.0);
        let plane = whole.in_plane();
        if design.is_lateral() && design.controller.is_some() {
            return Err(InputError::ControllerOfHeading { file: files[1].to_owned() });
        }
        let vehicle = if design.is_lateral() { yawing(&whole, files)? } else { plane.clone() };
        design.states =
            LevelFlight { vehicle: &vehicle, plane: &plane, file: &design, uncertain: &[] }.states();
        check_states(&design, files[1])?;
        relative_weight::check(&design.relative_weights, &vehicle, files[1])?;
        if design.sea.is_some() && vehicle.geometry.is_none() {
            return Err(InputError::NoGeometry { file: files[1].into() });
        }
        design.pitch =
            Pitch::over(&plane, design.depth, &design.spread(TRIM_ROWS), design.pitch_asked.as_ref());
        let uncertain = design.uncertainty.as_ref().map(|section| section.resolve(&vehicle, files[1]));
        Ok(Self {
            directory: PathBuf::new(),
            uncertain: uncertain.transpose()?.unwrap_or_default(),
            hashes,
            vehicle,
            plane,
            whole,
            design,
        })
    }

    /// The inputs with another bandwidth w_b of every W_e \[rad/s\], which the paper tunes in its Fig. 5.
    ///
    /// # Errors
    /// [`InputError::Bandwidth`].
    pub fn with_bandwidth(mut self, bandwidth: f64) -> Result<Self, InputError> {
        if !BANDWIDTH.allows(bandwidth) {
            return Err(InputError::Bandwidth { found: bandwidth });
        }
        let both = format!("{} and bandwidth = {bandwidth:?}", self.hashes.design_sha256);
        self.hashes.design_sha256 = sha256(&both);
        self.design = self.design.with_bandwidth(bandwidth);
        Ok(self)
    }

    /// The inputs with a given controller, read from a text.
    #[must_use]
    pub fn with_controller(mut self, controller: Pid, text: &str) -> Self {
        let both = format!("{} and controller {}", self.hashes.design_sha256, sha256(text));
        self.hashes.design_sha256 = sha256(&both);
        let name = stem(Path::new(&controller.file));
        self.design.name = format!("{}-{name}", self.design.name);
        self.design.controller = Some(controller);
        self
    }

    /// The first file whose hash differs from these.
    pub fn changed_since(&self, hashes: &InputHashes) -> Option<&'static str> {
        if self.hashes.vehicle_sha256 != hashes.vehicle_sha256 {
            return Some("the vehicle file");
        }
        (self.hashes.design_sha256 != hashes.design_sha256).then_some("the design file")
    }
}

/// The vehicle as an axis of heading has it; the names of its file and of the design's are for messages.
///
/// # Errors
/// [`InputError::NoLateral`], [`InputError::NothingYaws`].
pub fn yawing(whole: &Vehicle, [vehicle, design]: [&str; 2]) -> Result<Vehicle, InputError> {
    let file = |file: &str| file.to_owned();
    if !whole.coefficients.has_lateral() {
        return Err(InputError::NoLateral { design: file(design), vehicle: file(vehicle) });
    }
    let yawing = whole.yawing();
    if yawing.actuators.is_empty() {
        return Err(InputError::NothingYaws { design: file(design), vehicle: file(vehicle) });
    }
    Ok(yawing)
}

/// Checks that the tracked, measured and required signals depend on the states of the vehicle; `file` is for messages.
fn check_states(design: &DesignFile, file: &str) -> Result<(), InputError> {
    let tracked = design.tracked.iter().map(|t| ("track.output", t.signal));
    let measured = design.measured.iter().map(|m| ("measure.signal", m.signal));
    let unknown = tracked.chain(measured).find(|(_, signal)| !signal.is_among(design.states));
    let required =
        ["speed_rise", "speed_settling"].into_iter().find(|key| design.require.limit(key).is_some());
    let required = required.filter(|_| !design.interface.signals[SPEED].is_among(design.states));
    let key = match (unknown, required) {
        (Some((key, signal)), _) => format!("{key} = \"{}\"", signal.name),
        (None, Some(key)) => format!("require.{key}"),
        (None, None) => return Ok(()),
    };
    Err(InputError::GivenSpeed { file: file.into(), key })
}

/// The name of a file without its extension.
fn stem(path: &Path) -> String {
    path.file_stem().map_or_else(|| path.display().to_string(), |stem| stem.to_string_lossy().into_owned())
}

fn design_path(directory: &Path, name: &str) -> PathBuf {
    let file = if name.ends_with(".toml") { name.to_owned() } else { format!("{name}.toml") };
    directory.join(file)
}

/// The SHA-256 of a text, in hexadecimal.
pub fn sha256(text: &str) -> String {
    Sha256::digest(text).iter().map(|b| format!("{b:02x}")).collect()
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// A shipped vehicle with one of its designs.
    pub(crate) fn shipped(vehicle: &str, design: &str) -> Inputs {
        let vehicles = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../vehicles");
        Inputs::read(&vehicles.join(vehicle), design).unwrap()
    }
}
