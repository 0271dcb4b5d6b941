//! The record of a flight: columns by the names of the outputs of `squid.fmu`, as a table and as a plot.

use crate::page::plot::{Kind, Line, Panel};
use auv::Actuator;
use signals::{SIGNALS, tracked};
use squid_flight::flight::{Flight, Row, SeaRow};

/// The values of each variable over time, SI; in a CSV file each is headed `name [unit]`, or `name` without a unit.
#[derive(Debug, Clone, PartialEq)]
pub struct Record(Vec<Column>);

#[derive(Debug, Clone, PartialEq)]
struct Column {
    heading: String,
    values: Vec<f64>,
}

impl Column {
    /// Without the unit.
    fn name(&self) -> &str {
        self.split().0
    }

    /// Name and unit; 1 where there is none.
    fn split(&self) -> (&str, &str) {
        let split = self.heading.split_once(" [");
        split.map_or((&self.heading, "1"), |(name, unit)| (name, unit.trim_end_matches(']')))
    }
}

impl Record {
    /// Columns of one length, each with its heading.
    pub fn new(columns: Vec<(String, Vec<f64>)>) -> Self {
        Self(columns.into_iter().map(|(heading, values)| Column { heading, values }).collect())
    }

    /// The record of a flight in this process.
    pub fn of(rows: &[Row], actuators: &[Actuator]) -> Self {
        let mut columns = Vec::new();
        let mut add = |name: &str, unit: &str, of: &dyn Fn(&Row) -> f64| {
            let heading = if unit.is_empty() { name.to_owned() } else { format!("{name} [{unit}]") };
            columns.push((heading, rows.iter().map(of).collect()));
        };
        add("time", "s", &|r| r.time);
        for (place, (signal, wanted)) in tracked().enumerate() {
            add(signal.name, signal.unit, &|r| r.measured(place));
            add(&format!("{}_used", wanted.name), signal.unit, &|r| r.reference(place));
        }
        add("depth", "m", &|r| r.depth);
        add("scheduling_parameter", "", &|r| r.rho);
        add("speed_out_of_range", "", &|r| f64::from(u8::from(r.out_of_range)));
        for (j, actuator) in actuators.iter().enumerate() {
            add(&actuator.name, actuator.taken_unit(), &|r| actuator.taken(r.commands[j]).0);
        }
        Self::new(columns)
    }

    /// The record of a flight in still water or at sea.
    pub fn of_any(flight: &Flight, actuators: &[Actuator]) -> Self {
        if flight.sea.is_empty() {
            Self::of(&flight.rows, actuators)
        } else {
            Self::at_sea(flight, actuators)
        }
    }

    /// The record of a flight at sea: beside these the surface over the vehicle, the velocity of the water, and what
    /// the sensors read.
    pub fn at_sea(flight: &Flight, actuators: &[Actuator]) -> Self {
        let mut record = Self::of(&flight.rows, actuators);
        let mut add = |heading: String, of: &dyn Fn(&SeaRow) -> f64| {
            record.0.push(Column { heading, values: flight.sea.iter().map(of).collect() });
        };
        add("wave_elevation [m]".into(), &|row| row.elevation);
        add("current_horizontal [m/s]".into(), &|row| row.water.horizontal);
        add("current_vertical [m/s]".into(), &|row| row.water.vertical);
        for (place, signal) in SIGNALS.iter().enumerate() {
            add(format!("{}_read [{}]", signal.name, signal.unit), &|row| row.read[place]);
        }
        record
    }

    /// Name, unit and values of each variable.
    pub fn columns(&self) -> impl Iterator<Item = (&str, &str, &[f64])> {
        self.0.iter().map(|column| (column.split().0, column.split().1, column.values.as_slice()))
    }

    /// Each heading, with its values.
    pub fn into_columns(self) -> Vec<(String, Vec<f64>)> {
        self.0.into_iter().map(|column| (column.heading, column.values)).collect()
    }

    /// The values of a variable.
    pub fn get(&self, name: &str) -> Option<&[f64]> {
        self.0.iter().rfind(|column| column.name() == name).map(|column| column.values.as_slice())
    }

    /// Leaves out all rows but the first ones.
    pub fn truncate(&mut self, rows: usize) {
        self.0.iter_mut().for_each(|column| column.values.truncate(rows));
    }

    /// The record as CSV.
    pub fn csv(&self) -> String {
        let line = |cells: Vec<String>| cells.join(",") + "\n";
        let head = line(self.0.iter().map(|column| column.heading.clone()).collect());
        let rows = self.0.first().map_or(0, |column| column.values.len());
        let row = |k: usize| line(self.0.iter().map(|column| column.values[k].to_string()).collect());
        head + &(0..rows).map(row).collect::<String>()
    }

    /// Pitch, speed, commands and depth over time, as far as they are recorded; commands are those of the actuators
    /// that are given as the outputs that they ask for, one panel a unit.
    pub fn panels(&self, actuators: &[Actuator]) -> Vec<Panel> {
        let mapped = |name: &str, key: &str, kind: Kind, of: &dyn Fn(f64) -> f64| {
            let points = self.get("time")?.iter().zip(self.get(key)?).map(|(t, v)| (*t, of(*v))).collect();
            Some(Line { name: name.into(), points, kind })
        };
        let line = |name: &str, key: &str, factor: f64, kind: Kind| mapped(name, key, kind, &|v| factor * v);
        let panel = |label: &str, lines: Vec<Option<Line>>| Panel {
            label: label.into(),
            lines: lines.into_iter().flatten().collect(),
        };
        let commands = |unit: &str, factor: f64| {
            let own = actuators.iter().filter(|a| a.unit() == unit);
            own.map(|a| mapped(&a.name, &a.name, Kind::Own, &|v| factor * a.asked(v).0)).collect()
        };
        let deg = 1f64.to_degrees();
        let pitch = vec![
            line("reference", "pitch_reference_used", deg, Kind::Reference),
            line("pitch", "pitch", deg, Kind::Own),
        ];
        let wanted_speed = line("reference", "speed_reference_used", 1.0, Kind::Reference);
        let speed = vec![wanted_speed, line("forward speed", "speed", 1.0, Kind::Own)];
        let panels = [
            panel("pitch (deg)", pitch),
            panel("speed (m/s)", speed),
            panel("thrust (N)", commands("N", 1.0)),
            panel("deflection (deg)", commands("rad", deg)),
            panel("depth (m)", vec![line("depth", "depth", 1.0, Kind::Own)]),
            panel("surface (m)", vec![line("elevation", "wave_elevation", 1.0, Kind::Own)]),
        ];
        panels.into_iter().filter(|panel| !panel.lines.is_empty()).collect()
    }
}
