//! `squid plot`: plot and figures of a simulation, from the record of any FMI tool: CSV with a column `time` and one
//! for each variable.

use crate::cli::read_vehicle;
use crate::error::Error;
use crate::output::{answer, is_for_programs, say, say_path};
use csv::ErrorKind;
use serde_json::{Value, json};
use squid_auv::longitudinal::{DEPTH, PITCH};
use squid_auv::toml_file::cited;
use squid_auv::{Actuator, TRACKED, VIEWS};
use squid_base::files::{read, write};
use squid_base::numbers::decimals;
use squid_flight::flight::{Row, Signals, Surfacing, out_of_water};
use squid_flight::metrics::{FlightFigures, GRACE, SETTLED, Step};
use squid_flight::record::Record;
use squid_report::page::draw;
use squid_report::record::panels;
use squid_signals::{Level, Signal};
use std::array::from_fn;
use std::path::{Path, PathBuf};

/// Plots a record, by default to a file next to it, and prints the path, or the figures of the simulation as JSON.
///
/// # Errors
/// [`Error::Record`] if a column is missing or an entry is not a number, [`Error::Report`],
/// [`files::Error`](squid_base::files::Error), and errors of the vehicle file.
pub fn run(path: &Path, vehicle: Option<&Path>, out: Option<PathBuf>) -> Result<(), Error> {
    let to = out.unwrap_or_else(|| path.with_extension("svg"));
    check_plot(&to)?;
    let mut record = read_record(path)?;
    let actuators = match vehicle {
        Some(directory) => {
            let whole = read_vehicle(&directory.join("vehicle.toml"))?;
            if record.get(HEADING_USED).is_some() {
                let recorded = |one: &Actuator| record.get(&one.name).is_some();
                whole.actuators.into_iter().filter(recorded).collect()
            } else {
                whole.in_plane().actuators
            }
        }
        None => Vec::new(),
    };
    match record.get("time") {
        Some([]) => return Err(record_error(path, "it has no rows")),
        Some([first, .., last]) if first == last => {
            return Err(record_error(path, "its time does not advance"));
        }
        _ => {}
    }
    let surfacing = end_at_surface(&mut record);
    plot(path, &record, &to, &actuators)?;
    if is_for_programs() {
        let found =
            figures(&record, &actuators, surfacing, &to).map_err(|reason| record_error(path, reason))?;
        return Ok(answer(&found)?);
    }
    if let Some(Surfacing { time, speed }) = surfacing {
        let [time, shown] = [time, speed].map(|v| decimals(v, 2));
        let speed = if speed.is_nan() { String::new() } else { format!(", with {shown} m/s") };
        say(&format!("The vehicle reaches the surface at {time} s{speed}; the plot ends there."));
    }
    say_path(&to);
    Ok(())
}

/// Returns the error for a record that cannot be used.
pub(super) fn record_error(path: &Path, reason: impl Into<String>) -> Error {
    Error::Record { path: path.display().to_string(), reason: reason.into() }
}

/// Refuses to overwrite files other than plots, such as the record itself or a vehicle file.
fn check_plot(to: &Path) -> Result<(), Error> {
    if to.is_file() && !std::fs::read(to).is_ok_and(|found| found.is_empty() || found.starts_with(b"<svg")) {
        let allowed = "a new file or an SVG, because other files are not overwritten".to_owned();
        return Err(Error::Argument { name: "--out", found: to.display().to_string(), allowed });
    }
    Ok(())
}

/// Column of the heading reference, present for a vehicle in six degrees of freedom.
const HEADING_USED: &str = "heading_reference_used";

/// Returns the record as rows of an axis with these signals, one per time, with the commands of the given actuators.
pub(super) fn rows(record: &Record, actuators: &[Actuator], signals: &[Signal]) -> Result<Vec<Row>, String> {
    let column = |name: &str| record.get(name).ok_or_else(|| format!("there is no column '{name}'"));
    let tracked = || signals.iter().filter_map(|signal| Some((signal, signal.reference?)));
    for (signal, _) in tracked() {
        column(signal.name)?;
    }
    let measured: Vec<Option<&[f64]>> = signals.iter().map(|signal| record.get(signal.name)).collect();
    let mut used: Vec<Option<&[f64]>> =
        tracked().map(|(_, reference)| record.get(&format!("{}_used", reference.name))).collect();
    used.resize(TRACKED.min(signals.len()), None);
    // The record contains references after limiting only; those requested are reconstructed.
    let requested = signals.iter().zip(&used).map(|(signal, used)| {
        let used = (*used)?;
        Some(if signal.level == Level::Start { ends_of_ramps(used) } else { used.to_vec() })
    });
    let requested: Vec<Option<Vec<f64>>> = requested.collect();
    column("speed_reference_used")?;
    let commands: Vec<&[f64]> = actuators.iter().map(|a| column(&a.name)).collect::<Result<_, _>>()?;
    let (time, depth) = (column("time")?, column("depth")?);
    let at = |column: Option<&[f64]>, k: usize| column.map_or(f64::NAN, |column| column[k]);
    let row = |k: usize| Row {
        time: time[k],
        used: from_fn(|index| at(used.get(index).copied().flatten(), k)),
        signals: Signals {
            measured: from_fn(|index| at(measured.get(index).copied().flatten(), k)),
            references: from_fn(|index| at(requested.get(index).and_then(Option::as_deref), k)),
        },
        depth: depth[k],
        rho: f64::NAN,
        out_of_range: false,
        commands: actuators.iter().zip(&commands).map(|(a, taken)| a.requested_output(taken[k]).0).collect(),
    };
    Ok((0..time.len()).map(row).collect())
}

/// Replaces a rate-limited reference, such as depth or heading, by the value at the end of each ramp.
fn ends_of_ramps(used: &[f64]) -> Vec<f64> {
    let mut ends = used.to_vec();
    for k in (1..used.len()).rev() {
        if used[k] != used[k - 1] {
            ends[k - 1] = ends[k];
        }
    }
    ends
}

/// Returns the figures of a simulation in SI units and fractions, with the names in `squid plot --help`; unknown is
/// null.
fn figures(
    record: &Record,
    actuators: &[Actuator],
    surfacing: Option<Surfacing>,
    plot: &Path,
) -> Result<Value, String> {
    let limits: Vec<(f64, f64)> = actuators.iter().map(|a| (a.min, a.max)).collect();
    let step = |Step { time, height, figures: f }: &Step| {
        json!({
            "time": time,
            "height": height,
            "overshoot": f.overshoot,
            "rise_time": f.rise_time,
            "settling_time": f.settling_time,
            "steady_error": f.steady_error,
        })
    };
    let used = |signal: &Signal| signal.reference.map(|reference| format!("{}_used", reference.name));
    let has = |signal: &Signal| used(signal).is_some_and(|name| record.get(&name).is_some());
    let level = VIEWS[0].interface.signals;
    let axes = VIEWS.map(|view| {
        let signals = view.interface.signals;
        let steered =
            |(index, one): (usize, &Signal)| (one.level != Level::Scheduled && has(one)).then_some(index);
        (signals, signals.iter().enumerate().filter_map(steered).collect::<Vec<usize>>())
    });
    if axes.iter().all(|(_, indices)| indices.is_empty()) {
        let columns = [PITCH, DEPTH].map(|index| used(&level[index]).unwrap_or_default());
        return Err(format!("there is no column '{}' and none '{}'", columns[0], columns[1]));
    }
    let mut figures = json!({
        "plot": plot.display().to_string(),
        "surface": surfacing.map(|s| json!({ "time": s.time, "speed": s.speed })),
        "settled": SETTLED,
        "grace": GRACE,
    });
    for (signals, indices) in &axes {
        let rows = if indices.is_empty() { vec![] } else { rows(record, actuators, signals)? };
        for index in indices {
            let (flight, name) = (FlightFigures::of(&rows, *index, &limits), signals[*index].name);
            figures[format!("{name}_steps")] = flight.steps.iter().map(step).collect();
            figures[format!("{name}_error")] = json!(flight.error);
            figures["speed_error"] = json!(flight.speed_deviation);
            figures["actuator_use"] = json!((!actuators.is_empty()).then_some(flight.actuator_use));
        }
    }
    Ok(figures)
}

/// Plots the record of a simulation of `squid.fmu`, with the commands of the given actuators.
fn plot(path: &Path, record: &Record, to: &Path, actuators: &[Actuator]) -> Result<(), Error> {
    record.get("time").ok_or_else(|| record_error(path, "there is no column 'time'"))?;
    let panels = panels(record, actuators);
    if panels.is_empty() {
        return Err(record_error(path, "it contains no output of a simulation (pitch, speed, depth ...)"));
    }
    let name = path.file_stem().map_or_else(String::new, |s| s.to_string_lossy().into_owned());
    Ok(write(to, draw(to, &format!("Flight: {name}"), &panels)?.as_bytes())?)
}

/// Removes the rows from the surface on, where the plant's equations are not valid. The speed is NaN if the record has
/// none.
fn end_at_surface(record: &mut Record) -> Option<Surfacing> {
    let row = record.get("depth")?.iter().position(|depth| out_of_water(*depth))?;
    let time = *record.get("time")?.get(row)?;
    let speed = record.get("speed").and_then(|speeds| speeds.get(row)).copied().unwrap_or(f64::NAN);
    record.truncate(row);
    Some(Surfacing { time, speed })
}

/// Returns the position of a column name without its unit, counted from 1; 0 if there is none.
fn position(names: &[String], name: &str) -> usize {
    names.iter().position(|one| bare(one) == bare(name)).map_or(0, |index| index + 1)
}

/// Returns a column name without its unit.
fn bare(heading: &str) -> &str {
    heading.split_once(" [").map_or(heading, |(name, _)| name)
}

/// Reads the columns of a record by name, without the quotes that FMPy puts around names.
pub(super) fn read_record(path: &Path) -> Result<Record, Error> {
    let text = read(path)?;
    let unreadable = |reason: csv::Error| match reason.kind() {
        ErrorKind::UnequalLengths { pos: Some(row), expected_len, len } => Error::Record {
            path: format!("{}:{}", path.display(), row.line()),
            reason: format!(
                "there are {len} fields; it must be {expected_len}, one for each column of the header"
            ),
        },
        _ => record_error(path, reason.to_string()),
    };
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(text.as_bytes());
    let names: Vec<String> =
        reader.headers().map_err(unreadable)?.iter().map(|n| n.trim_matches('"').to_owned()).collect();
    if let Some((i, name)) = names.iter().enumerate().find(|(i, name)| position(&names[..*i], name) > 0) {
        let message = format!("columns {} and {} are both '{name}'", position(&names, name), i + 1);
        return Err(record_error(path, message));
    }
    let mut columns: Vec<Vec<f64>> = vec![Vec::new(); names.len()];
    for row in reader.records() {
        let row = row.map_err(unreadable)?;
        for ((field, name), column) in row.iter().zip(&names).zip(&mut columns) {
            let value = match field {
                "True" | "true" => Ok(1.0),
                "False" | "false" => Ok(0.0),
                other => other.parse::<f64>(),
            };
            let line = row.position().map_or(0, csv::Position::line);
            let at = |allowed: &str| Error::Record {
                path: format!("{}:{line}", path.display()),
                reason: format!("'{name}' is {}; it must be {allowed}", cited(field)),
            };
            let value = value.map_err(|_| at("a number"))?;
            let is_time = bare(name) == "time";
            if value.is_nan() || (is_time && column.last().is_some_and(|before| value < *before)) {
                return Err(at(if is_time { "at least the previous one" } else { "a number" }));
            }
            if value.is_infinite() {
                return Err(at("a finite number"));
            }
            column.push(value);
        }
    }
    Ok(Record::new(names.into_iter().zip(columns).collect()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn plot_ends_at_the_surface() {
        let record = "time,depth,speed\n0,1,2\n1,0.2,2.5\n2,-0.3,2.75\n3,0.1,2\n";
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("flight.csv");
        std::fs::write(&path, record).unwrap();
        let mut found = read_record(&path).unwrap();
        assert_eq!(end_at_surface(&mut found), Some(Surfacing { time: 2.0, speed: 2.75 }));
        assert_eq!((found.get("time"), found.get("depth")), (Some(&[0.0, 1.0][..]), Some(&[1.0, 0.2][..])));
        assert_eq!(end_at_surface(&mut found), None);

        std::fs::write(&path, record.replace("2.75", "much")).unwrap();
        let Error::Record { path: at, reason } = read_record(&path).unwrap_err() else { panic!() };
        assert!(at.ends_with("flight.csv:4"), "{at}");
        insta::assert_snapshot!(reason);
    }

    /// Numbers that cannot be drawn and rows of another length are refused with their line.
    #[test]
    fn names_the_line_of_a_wrong_row() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("flight.csv");
        let mut messages = vec![];
        for row in ["1,inf", "1,-1e999", "1,nan", "1", "1,2,3"] {
            std::fs::write(&path, format!("time,depth\n0,1\n{row}\n")).unwrap();
            let Error::Record { path: at, reason } = read_record(&path).unwrap_err() else { panic!() };
            assert!(at.ends_with("flight.csv:3"), "{row}: {at}");
            messages.push(format!("{row}: {reason}"));
        }
        insta::assert_snapshot!(messages.join("\n"));
    }
}
