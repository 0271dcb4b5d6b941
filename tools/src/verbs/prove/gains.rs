//! `squid gains`: conversion of gains between an autopilot's file and `[controller]`.

use crate::error::Error;
use crate::output::{answer, note, say, say_unwrapped};
use clap::{Args, Subcommand, ValueEnum};
use serde_json::json;
use squid_auv::{Actuator, Vehicle};
use squid_base::files::{read, write};
use squid_pid::autopilots::{Autopilot, Import, Missing, export, import};
use squid_pid::{Angle, Drive};
use std::path::{Path, PathBuf};

#[allow(missing_docs)] // Doc comments here are the help.
#[derive(Debug, Subcommand)]
pub enum GainsVerb {
    /// Read the gains in an autopilot's file, and print them as `[controller]` for `squid prove --controller`
    ///
    /// Each gain has its unit, and its origin as a comment: key, line and conversion. Settings without a counterpart
    /// are listed with their values. Ambiguous gains are refused, with the option that resolves the ambiguity.
    /// docs/pid.md explains laws and conversions.
    Import {
        /// File to read, for instance control.ini
        file: PathBuf,
        #[command(flatten)]
        how: How,
        /// Angle whose gains are read
        #[arg(long, value_enum, default_value_t = Axis::Pitch, value_name = "ANGLE")]
        axis: Axis,
        /// Write to this file instead
        #[arg(long, value_name = "FILE")]
        out: Option<PathBuf>,
        /// Directory of the vehicle, to state the moment of its thrusters if --full-output is missing
        #[arg(long, value_name = "DIR")]
        vehicle: Option<PathBuf>,
    },
    /// Write the gains of a `[controller]` into an autopilot's file
    ///
    /// Only the numbers of the gains change; every other byte of the file is preserved. Gains that the autopilot cannot
    /// represent are refused: scheduled gains, a model, a filter, or a reference weight; the file is then left
    /// unchanged. The angle is that of the `[controller]`.
    Export {
        /// File with `[controller]` only, as for `squid prove --controller`
        controller: PathBuf,
        #[command(flatten)]
        how: How,
        /// File of the autopilot, which must contain gains already
        #[arg(long, value_name = "FILE")]
        into: PathBuf,
    },
}

/// Format of a file, and settings that the file does not contain.
#[derive(Debug, Args)]
pub struct How {
    /// Name of the autopilot
    #[arg(long, value_enum)]
    pub format: Format,
    /// ArduSub: moment about the axis of the angle at output 1, N.m
    #[arg(long, value_name = "N.M", allow_negative_numbers = true)]
    pub full_output: Option<f64>,
    /// mvp: unit of the command
    #[arg(long, value_enum)]
    pub unit: Option<Command>,
    /// mvp: control mode, if several have the angle
    #[arg(long, value_name = "NAME")]
    pub mode: Option<String>,
}

/// Autopilots.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// DUNE: control.ini
    Dune,
    /// ArduSub: a parameter file
    Ardusub,
    /// mvp_control: YAML
    Mvp,
    /// MSS or Python Vehicle Simulator: a script
    Mss,
}

/// Angles.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Axis {
    /// Pitch, and depth and speed if the file has them
    Pitch,
    /// Heading; `yaw` in mvp
    Heading,
    /// Roll
    Roll,
}

impl From<Axis> for Angle {
    fn from(axis: Axis) -> Self {
        match axis {
            Axis::Pitch => Self::Pitch,
            Axis::Heading => Self::Heading,
            Axis::Roll => Self::Roll,
        }
    }
}

/// Units of a command.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Command {
    /// Deflection of control surfaces
    #[value(name = "rad")]
    Deflection,
    /// Moment of thrusters
    #[value(name = "N.m")]
    Moment,
}

impl How {
    /// Returns the autopilot, and the settings that its file does not contain.
    ///
    /// # Errors
    /// [`Error::Argument`] for an option of another format, or a moment that is not positive.
    fn checked(&self) -> Result<(Autopilot, Missing), Error> {
        let Self { format, full_output, unit, mode } = self;
        let options = [
            ("--full-output", full_output.is_some(), Format::Ardusub),
            ("--unit", unit.is_some(), Format::Mvp),
            ("--mode", mode.is_some(), Format::Mvp),
        ];
        if let Some((name, ..)) = options.iter().find(|(_, given, of)| *given && of != format) {
            let allowed = "omitted, because the files of this format contain it".into();
            return Err(Error::Argument { name, found: "given".into(), allowed });
        }
        if let Some(moment) = full_output.filter(|moment| !(*moment > 0.0 && moment.is_finite())) {
            let (found, allowed) = (squid_auv::number(moment), "above 0 (N.m)".into());
            return Err(Error::Argument { name: "--full-output", found, allowed });
        }
        let autopilot = match format {
            Format::Dune => Autopilot::Dune,
            Format::Ardusub => Autopilot::ArduSub,
            Format::Mvp => Autopilot::Mvp,
            Format::Mss => Autopilot::Mss,
        };
        let drive = unit.map(|unit| match unit {
            Command::Deflection => Drive::Deflection,
            Command::Moment => Drive::Moment,
        });
        Ok((autopilot, Missing { full_output: *full_output, hint: None, drive, mode: mode.clone() }))
    }
}

/// Reads or writes gains.
///
/// # Errors
/// Errors of the files; [`Error::Argument`].
pub fn run(verb: &GainsVerb) -> Result<(), Error> {
    match verb {
        GainsVerb::Import { file, how, axis, out, vehicle } => {
            let angle = Angle::from(*axis);
            let (autopilot, mut missing) = how.checked()?;
            missing.hint = vehicle.as_ref().map(|vehicle| hint(vehicle, angle)).transpose()?.flatten();
            let (text, name) = (read(file)?, file.display().to_string());
            if let Some(out) = out.as_ref().filter(|out| out.canonicalize().ok() == file.canonicalize().ok())
            {
                let (found, allowed) =
                    (out.display().to_string(), "a file other than the one that is read".into());
                return Err(Error::Argument { name: "--out", found, allowed });
            }
            let found = import(autopilot, angle, &text, &name, &missing)?;
            print_import(&found, &name, out.as_deref())
        }
        GainsVerb::Export { controller, how, into } => {
            let (autopilot, missing) = how.checked()?;
            let pid = squid_pid::read_file(&read(controller)?, &controller.display().to_string())?;
            write_into(autopilot, &pid, into, &missing)
        }
    }
}

/// Prints or writes the imported gains.
fn print_import(found: &Import, file: &str, out: Option<&Path>) -> Result<(), Error> {
    let (toml, notes) = (found.toml(file), found.notes());
    match out {
        Some(out) => {
            write(out, toml.as_bytes())?;
            say(&format!(
                "{}: {} gains; next: squid prove VEHICLE --controller {0}",
                out.display(),
                found.gains.len()
            ));
        }
        None => say_unwrapped(toml.trim_end()),
    }
    notes.iter().for_each(|text| note(text));
    let gains = found.gains.iter().map(|gain| {
        let (name, source) = (format!("{}.{}", gain.table, gain.key), &gain.source);
        json!({ "name": name, "value": gain.value, "unit": gain.unit, "source": source })
    });
    let gains: Vec<_> = gains.collect();
    let left_out = found
        .left_out
        .iter()
        .map(|one| json!({ "line": one.line, "key": one.key, "value": one.value, "why": one.why }));
    let left_out: Vec<_> = left_out.collect();
    let answered =
        json!({ "controller": toml, "file": out, "gains": gains, "left_out": left_out, "notes": notes });
    Ok(answer(&answered)?)
}

/// Replaces the gains in a file.
fn write_into(
    autopilot: Autopilot,
    pid: &squid_pid::Pid,
    into: &Path,
    missing: &Missing,
) -> Result<(), Error> {
    let (text, name) = (read(into)?, into.display().to_string());
    let found = export(autopilot, pid, &text, &name, missing)?;
    let unreadable = |reason| squid_base::files::Error::Unreadable { path: name.clone(), reason };
    // A byte order mark is preserved, and so is a link to the file.
    let target = into.canonicalize().map_err(unreadable)?;
    let mut bytes = std::fs::read(&target).map_err(unreadable)?;
    bytes.truncate(bytes.len() - text.len());
    bytes.extend(found.text.as_bytes());
    if !found.changes.is_empty() {
        write(&target, &bytes)?;
    }
    for change in &found.changes {
        say(&format!("{name}:{}: {}: {} -> {}", change.line, change.key, change.from, change.to));
    }
    if found.changes.is_empty() {
        say(&format!("{name}: unchanged, because it already has these gains"));
    }
    found.notes.iter().for_each(|text| note(text));
    let changes = found.changes.iter().map(
        |change| json!({ "line": change.line, "key": change.key, "from": change.from, "to": change.to }),
    );
    let changes: Vec<_> = changes.collect();
    Ok(answer(&json!({ "file": into, "changes": changes, "notes": found.notes }))?)
}

/// Returns a text with the total moment of a vehicle's thrusters about the axis of an angle, all at their limits.
fn hint(vehicle: &Path, angle: Angle) -> Result<Option<String>, Error> {
    let file = vehicle.join("vehicle.toml");
    let vehicle = Vehicle::parse(&read(&file)?, &file.display().to_string())?;
    let moment = |actuator: &Actuator| (angle.moment(actuator, 0.0) * actuator.reach()).abs();
    let thrusters = vehicle.actuators.iter().filter(|actuator| actuator.unit() == "N");
    let all: f64 = thrusters.map(moment).sum();
    let text = format!(
        "with all thrusters at their limits it is {1} N.m for {0}",
        vehicle.name,
        squid_auv::rounded(all)
    );
    Ok((all > 0.0).then_some(text))
}
