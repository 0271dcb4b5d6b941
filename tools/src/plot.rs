//! `squid plot`: a flight's record as any FMI tool writes it: CSV with a column `time` and one for each variable.

use crate::error::Error;
use crate::output::say;
use auv::toml_file::cited;
use auv::{Actuator, Vehicle};
use squid_design::files::{read, write};
use squid_flight::flight::out_of_water;
use squid_report::page::plot::{Line, Panel, draw};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Plots a record, beside it if no other file is named.
///
/// # Errors
/// As [`plot`], and those of the vehicle file.
pub fn run(record: &Path, vehicle: Option<&Path>, out: Option<PathBuf>) -> Result<(), Error> {
    let to = out.unwrap_or_else(|| record.with_extension("svg"));
    let actuators = match vehicle {
        Some(directory) => Vehicle::read(&directory.join("vehicle.toml"))?.actuators,
        None => Vec::new(),
    };
    plot(record, &to, &actuators)?;
    say(&to.display().to_string());
    Ok(())
}

/// Draws the record of a flight of `squid.fmu`; commands are shown of the actuators that are given.
///
/// # Errors
/// [`Error::Record`] when a column is missing or a number is none, [`Error::Plot`],
/// [`StoreError::Unwritable`](squid_design::error::StoreError::Unwritable).
fn plot(record: &Path, to: &Path, actuators: &[Actuator]) -> Result<(), Error> {
    let mut columns = columns(record)?;
    if let Some(words) = end_at_surface(&mut columns) {
        say(&words);
    }
    let wrong = |reason: String| Error::Record { path: record.display().to_string(), reason };
    let time = columns.get("time").ok_or_else(|| wrong("there is no column 'time'".into()))?;
    let mut panels = Vec::new();
    let line = |name: &str, key: &str, factor: f64, reference: bool| {
        columns.get(key).map(|values| Line {
            name: name.into(),
            points: time.iter().zip(values).map(|(t, v)| (*t, factor * v)).collect(),
            reference,
        })
    };
    let mut add = |label: &str, lines: Vec<Option<Line>>| {
        let lines: Vec<Line> = lines.into_iter().flatten().collect();
        if !lines.is_empty() {
            panels.push(Panel { label: label.into(), lines });
        }
    };
    let deg = 1f64.to_degrees();
    add(
        "pitch (deg)",
        vec![line("reference", "pitch_reference_used", deg, true), line("pitch", "pitch", deg, false)],
    );
    add(
        "speed (m/s)",
        vec![
            line("reference", "speed_reference_used", 1.0, true),
            line("forward speed", "speed", 1.0, false),
        ],
    );
    let commands = |unit: &str, factor: f64| -> Vec<Option<Line>> {
        let own = actuators.iter().filter(|a| a.unit() == unit);
        own.map(|a| line(&a.name, &a.name, factor, false)).collect()
    };
    add("thrust (N)", commands("N", 1.0));
    add("deflection (deg)", commands("rad", deg));
    add("depth (m)", vec![line("depth", "depth", 1.0, false)]);
    if panels.is_empty() {
        return Err(wrong("it holds none of the outputs that a flight has (pitch, speed, depth ...)".into()));
    }
    let name = record.file_stem().map_or_else(String::new, |s| s.to_string_lossy().into_owned());
    Ok(write(to, draw(to, &format!("Flight: {name}"), &panels)?.as_bytes())?)
}

/// Takes off what lies beyond the surface, where the equations of the plant hold no longer, and says so.
fn end_at_surface(columns: &mut BTreeMap<String, Vec<f64>>) -> Option<String> {
    let row = columns.get("depth")?.iter().position(|depth| out_of_water(*depth))?;
    let time = columns.get("time")?.get(row)?;
    let speed = columns.get("speed").and_then(|speeds| speeds.get(row));
    let speed = speed.map_or_else(String::new, |speed| format!(", with {speed:.2} m/s"));
    let words = format!("The vehicle reaches the surface at {time:.2} s{speed}; the plot ends there.");
    columns.values_mut().for_each(|column| column.truncate(row));
    Some(words)
}

/// The columns by name; quotes around names are taken off, as FMPy puts them.
fn columns(path: &Path) -> Result<BTreeMap<String, Vec<f64>>, Error> {
    let text = read(path)?;
    let wrong = |reason: String| Error::Record { path: path.display().to_string(), reason };
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(text.as_bytes());
    let names: Vec<String> = reader
        .headers()
        .map_err(|e| wrong(e.to_string()))?
        .iter()
        .map(|n| n.trim_matches('"').to_owned())
        .collect();
    let mut columns: Vec<Vec<f64>> = vec![Vec::new(); names.len()];
    for row in reader.records() {
        let row = row.map_err(|e| wrong(e.to_string()))?;
        for ((field, name), column) in row.iter().zip(&names).zip(&mut columns) {
            let value = match field {
                "True" | "true" => Ok(1.0),
                "False" | "false" => Ok(0.0),
                other => other.parse::<f64>(),
            };
            let line = row.position().map_or(0, csv::Position::line);
            column.push(value.map_err(|_| Error::Record {
                path: format!("{}:{line}", path.display()),
                reason: format!("'{name}' is {}; it must be a number", cited(field)),
            })?);
        }
    }
    if columns.iter().all(Vec::is_empty) {
        return Err(wrong("it has no rows".into()));
    }
    Ok(names.into_iter().zip(columns).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plot_ends_at_the_surface() {
        let record = "time,depth,speed\n0,1,2\n1,0.2,2.5\n2,-0.3,2.75\n3,0.1,2\n";
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("flight.csv");
        std::fs::write(&path, record).unwrap();
        let mut found = columns(&path).unwrap();
        let words = end_at_surface(&mut found).unwrap();
        assert_eq!(words, "The vehicle reaches the surface at 2.00 s, with 2.75 m/s; the plot ends there.");
        assert_eq!((&found["time"], &found["depth"]), (&vec![0.0, 1.0], &vec![1.0, 0.2]));
        assert_eq!(end_at_surface(&mut found), None);

        std::fs::write(&path, record.replace("2.75", "much")).unwrap();
        let words = columns(&path).unwrap_err().to_string();
        assert!(words.ends_with("flight.csv:4: 'speed' is \"much\"; it must be a number"), "{words}");
    }
}
