//! Input files of a design.

pub mod actuator_names;
pub mod design_file;
mod plausible;
mod reweighted;
pub mod together;

use crate::axis::VehicleModel;
use crate::error::InputError;
use crate::inputs::design_file::{BANDWIDTH, DesignFile, UncertainParameter, relative_weight};
use crate::linearise::{LevelFlight, TRIM_ROWS};
use sha2::{Digest, Sha256};
use squid_auv::longitudinal::SPEED;
use squid_auv::{Pitch, VIEWS, Vehicle, View};
use squid_base::files::read;
use squid_pid::Pid;
use squid_scheduled::InputHashes;
use std::path::{Path, PathBuf};

/// Vehicle and design file, with their hashes.
#[derive(Debug, Clone)]
pub struct Inputs {
    /// Absolute path of the vehicle's directory.
    pub directory: PathBuf,
    /// Vehicle reduced to the axis of the design: in the vertical plane, or with lateral motion.
    pub vehicle: Vehicle,
    /// Vehicle in the vertical plane, for level trim.
    pub plane: Vehicle,
    /// Vehicle in six degrees of freedom, as in its file.
    pub six_dof: Vehicle,
    /// Design file of the axis.
    pub design: DesignFile,
    /// Uncertain coefficients of the design, in the order of the vehicle file.
    pub uncertain: Vec<UncertainParameter>,
    /// Hashes of the vehicle file, and of the design file with the changes from the command line.
    pub hashes: InputHashes,
}

impl Inputs {
    /// Returns the relative half range of the gain of every actuator; 0 if it is not uncertain.
    pub fn actuator_gain(&self) -> f64 {
        self.design.uncertainty.as_ref().map_or(0.0, |u| u.actuator_gain)
    }

    /// Returns the vehicle in the level flight of the design.
    pub fn axis(&self) -> LevelFlight<'_> {
        let Self { vehicle, plane, design: file, uncertain, .. } = self;
        LevelFlight { vehicle, plane, file, uncertain }
    }

    /// Returns `true` if the design declares anything uncertain.
    pub fn is_uncertain(&self) -> bool {
        !self.uncertain.is_empty() || self.actuator_gain() != 0.0
    }

    /// Returns the minimum and the maximum output of each actuator.
    pub fn limits(&self) -> Vec<(f64, f64)> {
        self.vehicle.actuators.iter().map(|a| (a.min, a.max)).collect()
    }

    /// Combines a vehicle and a design created in memory, identified by a hash of their content.
    ///
    /// # Errors
    /// [`InputError`]: an actuator name that the FMUs use, or an uncertain coefficient that the vehicle does not have.
    pub fn new(vehicle: Vehicle, design: DesignFile) -> Result<Self, InputError> {
        let texts = [format!("{vehicle:?}"), format!("{design:?}")];
        let hashes = hashes(&texts[0], &texts[1]);
        let mut axes = Self::of(vehicle, vec![design], hashes, ["the vehicle", "the design"])?;
        Ok(axes.remove(0))
    }

    /// Parses the texts of a vehicle file and a design file of one axis.
    ///
    /// # Errors
    /// [`InputError`]: the first wrong file, key or value.
    pub fn parse(vehicle: &str, design: &str) -> Result<Self, InputError> {
        let files = ["vehicle.toml", "design.toml"];
        let parsed = (Vehicle::parse(vehicle, files[0])?, DesignFile::parse(design, files[1], "design")?);
        Ok(Self::of(parsed.0, vec![parsed.1], hashes(vehicle, design), files)?.remove(0))
    }

    /// Parses the text of a design file that is not written yet into the axes of a vehicle; `files` are the names of
    /// both in messages.
    ///
    /// # Errors
    /// The errors of [`new`](Self::new), and those of the text.
    pub fn parse_axes(
        vehicle: &Vehicle,
        design: &str,
        files: [&str; 2],
        name: &str,
    ) -> Result<Vec<Self>, InputError> {
        let designs = DesignFile::parse_each(design, files[1], name)?;
        Self::of(vehicle.clone(), designs, hashes(&format!("{vehicle:?}"), design), files)
    }

    /// Reads `vehicle.toml` and the design `name` from a vehicle's directory, and returns each axis.
    ///
    /// # Errors
    /// [`InputError`]: the first wrong file, key or value.
    pub fn read_axes(directory: &Path, name: &str) -> Result<Vec<Self>, InputError> {
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
        let designs = DesignFile::parse_each(&design_text, &files[1], &stem(&paths[1]))?;
        let hashes = hashes(&vehicle_text, &design_text);
        let mut axes = Self::of(vehicle, designs, hashes, files.each_ref().map(String::as_str))?;
        for axis in &mut axes {
            axis.directory = std::path::absolute(directory).unwrap_or_else(|_| directory.to_owned());
        }
        Ok(axes)
    }

    /// Reads a design with one axis; see [`read_axes`](Self::read_axes).
    ///
    /// # Errors
    /// The errors of [`read_axes`](Self::read_axes); [`InputError::SeveralAxes`].
    pub fn read(directory: &Path, name: &str) -> Result<Self, InputError> {
        Self::read_axis(directory, name, None)
    }

    /// Reads the axis that steers the named signal, or the only one; see [`read_axes`](Self::read_axes).
    ///
    /// # Errors
    /// The errors of [`read_axes`](Self::read_axes); [`InputError::NoAxis`], [`InputError::SeveralAxes`].
    pub fn read_axis(directory: &Path, name: &str, axis: Option<&str>) -> Result<Self, InputError> {
        let mut axes = Self::read_axes(directory, name)?;
        let steered: Vec<&str> = axes.iter().map(|inputs| inputs.design.steered_signal()).collect();
        let (file, available) = (axes[0].design.file.clone(), steered.join(", "));
        let index = match axis {
            Some(axis) => steered.iter().position(|one| *one == axis).ok_or_else(|| InputError::NoAxis {
                file,
                found: axis.to_owned(),
                axes: available,
            })?,
            None if axes.len() > 1 => return Err(InputError::SeveralAxes { file, axes: available }),
            None => 0,
        };
        Ok(axes.swap_remove(index))
    }

    /// Checks a vehicle and the designs of its axes against each other; `files` are their names in messages.
    fn of(
        six_dof: Vehicle,
        designs: Vec<DesignFile>,
        hashes: InputHashes,
        files: [&str; 2],
    ) -> Result<Vec<Self>, InputError> {
        actuator_names::check(&six_dof, files[0])?;
        let plane = six_dof.in_plane();
        let own = |design: &DesignFile| of_view(&six_dof, design.view(), files);
        let vehicles: Vec<Vehicle> = designs.iter().map(own).collect::<Result<_, _>>()?;
        together::check(&designs, &vehicles, files[1])?;
        let one = |(design, vehicle): (DesignFile, &Vehicle)| {
            Self::of_axis([&six_dof, &plane, vehicle], design, hashes.clone(), files[1])
        };
        let mut axes: Vec<Self> = designs.into_iter().zip(&vehicles).map(one).collect::<Result<_, _>>()?;
        // The axis of level flight comes first, whatever the order in the file.
        axes.sort_by_key(|axis| axis.design.view().is_level_held);
        Ok(axes)
    }

    /// Returns the same vehicle with another design of the axis, identified by a hash of its content.
    ///
    /// # Errors
    /// The errors of [`new`](Self::new).
    pub fn redesigned(&self, design: DesignFile) -> Result<Self, InputError> {
        let design_sha256 = sha256(&format!("{design:?}"));
        let hashes = InputHashes { design_sha256, ..self.hashes.clone() };
        let vehicles = [&self.six_dof, &self.plane, &self.vehicle];
        Ok(Self {
            directory: self.directory.clone(),
            ..Self::of_axis(vehicles, design, hashes, "the design")?
        })
    }

    /// Checks the design of an axis against the vehicle in six degrees of freedom, in the vertical plane, and reduced
    /// to the axis; `file` is for messages.
    fn of_axis(
        [six_dof, plane, vehicle]: [&Vehicle; 3],
        mut design: DesignFile,
        hashes: InputHashes,
        file: &str,
    ) -> Result<Self, InputError> {
        design.states = LevelFlight { vehicle, plane, file: &design, uncertain: &[] }.states();
        check_states(&design, file)?;
        relative_weight::check(&design.relative_weights, vehicle, file)?;
        if design.sea.is_some() && vehicle.geometry.is_none() {
            return Err(InputError::NoGeometry { file: file.into() });
        }
        design.pitch =
            Pitch::over(plane, design.depth, &design.spread(TRIM_ROWS), design.pitch_asked.as_ref());
        if let (Some(section), Some(_)) = (&mut design.uncertainty, design.axis) {
            section.leave_out_of(vehicle, &VIEWS.map(|view| view.vehicle(six_dof)));
        }
        let uncertain = design.uncertainty.as_ref().map(|section| section.resolve(vehicle, file));
        Ok(Self {
            directory: PathBuf::new(),
            uncertain: uncertain.transpose()?.unwrap_or_default(),
            hashes,
            vehicle: vehicle.clone(),
            plane: plane.clone(),
            six_dof: six_dof.clone(),
            design,
        })
    }

    /// Returns the inputs with another bandwidth w_b of every W_e \[rad/s\], which the paper tunes in its Fig. 5.
    ///
    /// # Errors
    /// [`InputError::Bandwidth`].
    pub fn with_bandwidth(mut self, bandwidth: f64) -> Result<Self, InputError> {
        if !BANDWIDTH.allows(bandwidth) {
            return Err(InputError::Bandwidth { found: bandwidth });
        }
        let text_with_change = format!("{} and bandwidth = {bandwidth:?}", self.hashes.design_sha256);
        self.hashes.design_sha256 = sha256(&text_with_change);
        self.design = self.design.with_bandwidth(bandwidth);
        Ok(self)
    }

    /// Returns the inputs with a given controller, read from a text.
    #[must_use]
    pub fn with_controller(mut self, controller: Pid, text: &str) -> Self {
        let text_with_change = format!("{} and controller {}", self.hashes.design_sha256, sha256(text));
        self.hashes.design_sha256 = sha256(&text_with_change);
        self.design = self.design.renamed(&stem(Path::new(&controller.file)));
        self.design.controller = Some(controller);
        self
    }

    /// Returns the first file whose hash differs from these.
    pub fn changed_since(&self, hashes: &InputHashes) -> Option<&'static str> {
        if self.hashes.vehicle_sha256 != hashes.vehicle_sha256 {
            return Some("the vehicle file");
        }
        (self.hashes.design_sha256 != hashes.design_sha256).then_some("the design file")
    }
}

/// Reduces a vehicle to an axis of a view; the names of its file and of the design's are for messages.
///
/// # Errors
/// [`InputError::NoLateral`], [`InputError::NothingActs`].
pub fn of_view(six_dof: &Vehicle, view: &View, [vehicle, design]: [&str; 2]) -> Result<Vehicle, InputError> {
    let own = view.vehicle(six_dof);
    if !view.is_level_held {
        return Ok(own);
    }
    let (design, vehicle) = (design.to_owned(), vehicle.to_owned());
    let tracked = view.interface.signals[0].name;
    if !six_dof.coefficients.leaves_plane() {
        return Err(InputError::NoLateral { design, tracked, vehicle });
    }
    if own.actuators.is_empty() {
        return Err(InputError::NothingActs { design, tracked, vehicle, missing: view.missing_actuator });
    }
    Ok(own)
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

/// Name of a file without its extension.
fn stem(path: &Path) -> String {
    path.file_stem().map_or_else(|| path.display().to_string(), |stem| stem.to_string_lossy().into_owned())
}

fn design_path(directory: &Path, name: &str) -> PathBuf {
    let file = if name.ends_with(".toml") { name.to_owned() } else { format!("{name}.toml") };
    directory.join(file)
}

/// Hashes of the texts of a vehicle and a design.
fn hashes(vehicle: &str, design: &str) -> InputHashes {
    InputHashes { vehicle_sha256: sha256(vehicle), design_sha256: sha256(design) }
}

/// Returns the SHA-256 of a text, in hexadecimal.
pub fn sha256(text: &str) -> String {
    Sha256::digest(text).iter().map(|b| format!("{b:02x}")).collect()
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// Reads a shipped vehicle with one of its designs.
    pub(crate) fn shipped(vehicle: &str, design: &str) -> Inputs {
        shipped_axis(vehicle, design, None)
    }

    /// Reads a shipped vehicle with an axis of one of its designs.
    pub(crate) fn shipped_axis(vehicle: &str, design: &str, axis: Option<&str>) -> Inputs {
        let vehicles = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../vehicles");
        Inputs::read_axis(&vehicles.join(vehicle), design, axis).unwrap()
    }
}
