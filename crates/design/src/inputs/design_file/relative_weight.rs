//! Table `[control.actuators]` of a design file: weights of single actuators relative to W_u.

use squid_auv::Vehicle;
use squid_auv::toml_file::{Document, FileError, FileProblem, Mistake, Table};
use std::ops::RangeInclusive;

const TABLE: &str = "control.actuators";

/// Allowed factors.
const FACTORS: RangeInclusive<f64> = 0.01..=100.0;
const ALLOWED: &str = "from 0.01 to 100, relative to 'control.weight'";

/// Weight of one actuator relative to W_u.
#[derive(Debug, Clone, PartialEq)]
pub struct RelativeWeight {
    /// Name of the actuator in the vehicle file.
    pub actuator: String,
    /// Ratio of the weight to `control.weight`.
    pub factor: f64,
    /// Line of the design file.
    pub line: usize,
}

/// Reads the entries of the table; unreadable ones are left out.
pub(super) fn read(document: &Document<'_>, control: &Table<'_>) -> Vec<RelativeWeight> {
    let Some(table) = control.table("actuators") else { return vec![] };
    let each = table.keys().into_iter().filter_map(|(at, name)| {
        let factor = table.number(name, |v| FACTORS.contains(&v), ALLOWED)?;
        Some(RelativeWeight { actuator: name.to_owned(), factor, line: document.line(at) })
    });
    each.collect()
}

/// Checks that each entry names an actuator of the vehicle; `file` is for messages.
///
/// # Errors
/// [`FileError`] with each unknown name.
pub fn check(entries: &[RelativeWeight], vehicle: &Vehicle, file: &str) -> Result<(), FileError> {
    let names: Vec<&str> = vehicle.actuators.iter().map(|one| one.name.as_str()).collect();
    let unknown = entries.iter().filter(|one| !names.contains(&one.actuator.as_str()));
    let mistake = |one: &RelativeWeight| {
        let (key, found) = (format!("{TABLE}.{}", one.actuator), "not an actuator of this axis".into());
        let allowed = format!("named {}", names.join(", "));
        Mistake { line: one.line, problem: FileProblem::NotAllowed { key, found, allowed } }
    };
    let mistakes: Vec<Mistake> = unknown.map(mistake).collect();
    if mistakes.is_empty() { Ok(()) } else { Err(FileError { file: file.into(), mistakes }) }
}
