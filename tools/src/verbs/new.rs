//! `squid new`: creates a commented vehicle to start from.

use crate::error::Error;
use crate::output::{answer, say};
use serde_json::json;
use squid_auv::toml_file::cited;
use squid_auv::{VEHICLE_NAMES, Vehicle, is_vehicle_name};
use squid_base::files::Files;
use squid_design::inputs::design_file::DesignFile;
use squid_design::inputs::together::common_speeds;
use std::path::Path;

/// Files of a vehicle that ships with squid, and the line with its name.
struct Template {
    vehicle: &'static str,
    design: &'static str,
    /// Further designs: file names, the quantities they steer, and texts.
    others: &'static [(&'static str, &'static str, &'static str)],
    name: &'static str,
}

macro_rules! template {
    ($name:literal $(, $file:literal of $what:literal)*) => {
        Template {
            vehicle: include_str!(concat!("../../vehicles/", $name, "/vehicle.toml")),
            design: include_str!(concat!("../../vehicles/", $name, "/design.toml")),
            others: &[$(($file, $what, include_str!(concat!("../../vehicles/", $name, "/", $file)))),*],
            name: concat!("name = \"", $name, "\""),
        }
    };
}

/// Vehicles from which a new one can start.
#[derive(Debug, Clone, Copy, clap::ValueEnum)]
#[value(rename_all = "snake_case")]
pub enum Like {
    /// Thrusters; explains the usual keys; uses the coefficients of the Squid surrogate
    Squid,
    /// Propeller and stern planes; published coefficients of REMUS 100
    Remus100,
    /// Propeller and stern planes given by their lift; published coefficients of LAUV
    Lauv,
    /// Slow long-range hull with stern planes; published coefficients of LRAUV Tethys
    Tethys,
    /// Thrusters along and across the hull; published coefficients of Sparus II
    Sparus2,
    /// Box-shaped ROV, held level by thrusters even at rest; published coefficients of BlueROV2 Heavy
    Bluerov2Heavy,
}

impl Like {
    fn template(self) -> Template {
        match self {
            Self::Squid => template!("squid", "heading.toml" of "pitch, speed and heading"),
            Self::Remus100 => template!("remus100", "pitch.toml" of "pitch"),
            Self::Lauv => template!("lauv", "pitch.toml" of "pitch and speed"),
            Self::Tethys => template!("tethys", "pitch.toml" of "pitch and speed"),
            Self::Sparus2 => template!("sparus2"),
            Self::Bluerov2Heavy => template!("bluerov2_heavy"),
        }
    }
}

/// Writes vehicle.toml, design.toml and the other designs of the chosen vehicle to a new directory, whose name becomes
/// that of the vehicle.
///
/// # Errors
/// [`Error::Exists`], [`Error::Argument`] for a name that a vehicle cannot have, and errors of the files.
pub fn run(directory: &Path, like: Like) -> Result<(), Error> {
    let name = directory.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    if directory.exists() {
        return Err(Error::Exists { path: directory.display().to_string() });
    }
    if !is_vehicle_name(&name) {
        let allowed = format!("a directory whose name can be that of the vehicle: {VEHICLE_NAMES}");
        return Err(Error::Argument { name: "DIRECTORY", found: cited(&name), allowed });
    }
    let Template { vehicle, design, others, name: theirs } = like.template();
    let whose = theirs.trim_start_matches("name = ").trim_matches('"');
    let head =
        format!("# Created by `squid new` from {whose}: replace every number by that of your vehicle.\n#\n");
    // Commands in comments must name the new directory.
    let shown = quoted(&directory.display().to_string());
    let here = |text: &str| text.replace(&format!("vehicles/{whose}"), &shown);
    let status = |line: &str| line.starts_with("status = ");
    let own = |line: &str| match line {
        line if line == theirs => format!("name = \"{name}\""),
        line if status(line) => "status = \"surrogate\"".to_owned(),
        line => here(line),
    };
    let vehicle = head.clone() + &vehicle.lines().map(|line| own(line) + "\n").collect::<String>();
    let file = directory.join("vehicle.toml");
    Vehicle::parse(&vehicle, &file.display().to_string())?;
    let [speed_min, speed_max] = common_speeds(&DesignFile::parse_each(design, "design.toml", "design")?);
    let mut files = Files::default();
    files.add(file, vehicle);
    files.add(directory.join("design.toml"), head.clone() + &here(design));
    for (file, _, text) in others {
        files.add(directory.join(file), head.clone() + &here(text));
    }
    files.save(directory)?;
    let more = |(file, what, _): &(&str, &str, &str)| {
        format!("{shown}/{file}: a design with a controller of {what}\n")
    };
    let more: String = others.iter().map(more).collect();
    let speed = squid_auv::number(0.5 * (speed_min + speed_max));
    say(&format!(
        "{shown}/vehicle.toml: the coefficients, each with its unit and source; set the status from \"surrogate\" to \
         yours when they are those of your vehicle\n\
         {shown}/design.toml: the requirements on the controller\n\
         {more}Next: squid show {shown} --speed {speed}; squid design {shown}\n\
         Once vehicle.toml has your own numbers: squid tune {shown} --design own creates own.toml with a speed \
         range, steps and weights that suit the vehicle; then squid design {shown} --design own. Remove design.toml, \
         which is still that of {whose}."
    ));
    let names = ["vehicle.toml", "design.toml"].into_iter().chain(others.iter().map(|(file, ..)| *file));
    let files: Vec<_> = names.map(|name| directory.join(name)).collect();
    Ok(answer(&json!({ "files": files }))?)
}

/// Returns a path quoted for a shell if necessary.
fn quoted(path: &str) -> String {
    let plain = |c: char| c.is_alphanumeric() || "/\\.:_-~".contains(c);
    if path.chars().all(plain) { path.to_owned() } else { format!("\"{path}\"") }
}
