//! The record of a flight: columns by the names of the outputs of `squid.fmu`, as a table and as a plot.

use crate::page::plot::{Kind, Line, Panel};
use auv::Actuator;
use signals::tracked;
use squid_flight::flight::Row;

/// The values of each variable over time, SI.
#[derive(Debug, Clone, PartialEq)]
pub struct Record(Vec<(String, Vec<f64>)>);

impl Record {
    /// Columns of one length, each with its name.
    pub fn new(columns: Vec<(String, Vec<f64>)>) -> Self {
        Self(columns)
    }

    /// The record of a flight in this process.
    pub fn of(rows: &[Row], actuators: &[Actuator]) -> Self {
        let mut columns = Vec::new();
        let mut add = |name: &str, of: &dyn Fn(&Row) -> f64| {
            columns.push((name.to_owned(), rows.iter().map(of).collect()));
        };
        add("time", &|r| r.time);
        for (place, (signal, wanted)) in tracked().enumerate() {
            add(signal.name, &|r| r.measured(place));
            add(&format!("{}_used", wanted.name), &|r| r.reference(place));
        }
        add("depth", &|r| r.depth);
        add("scheduling_parameter", &|r| r.rho);
        add("speed_out_of_range", &|r| f64::from(u8::from(r.out_of_range)));
        for (j, actuator) in actuators.iter().enumerate() {
            add(&actuator.name, &|r| r.commands[j]);
        }
        Self(columns)
    }

    /// The values of a variable.
    pub fn get(&self, name: &str) -> Option<&[f64]> {
        self.0.iter().rfind(|(own, _)| own == name).map(|(_, values)| values.as_slice())
    }

    /// Leaves out all rows but the first ones.
    pub fn truncate(&mut self, rows: usize) {
        self.0.iter_mut().for_each(|(_, values)| values.truncate(rows));
    }

    /// The record as CSV.
    pub fn csv(&self) -> String {
        let line = |cells: Vec<String>| cells.join(",") + "\n";
        let head = line(self.0.iter().map(|(name, _)| name.clone()).collect());
        let rows = self.0.first().map_or(0, |(_, values)| values.len());
        let row = |k: usize| line(self.0.iter().map(|(_, values)| values[k].to_string()).collect());
        head + &(0..rows).map(row).collect::<String>()
    }

    /// Pitch, speed, commands and depth over time, as far as they are recorded; commands are those of the actuators
    /// that are given, one panel a unit.
    pub fn panels(&self, actuators: &[Actuator]) -> Vec<Panel> {
        let line = |name: &str, key: &str, factor: f64, kind: Kind| {
            let points =
                self.get("time")?.iter().zip(self.get(key)?).map(|(t, v)| (*t, factor * v)).collect();
            Some(Line { name: name.into(), points, kind })
        };
        let panel = |label: &str, lines: Vec<Option<Line>>| Panel {
            label: label.into(),
            lines: lines.into_iter().flatten().collect(),
        };
        let commands = |unit: &str, factor: f64| {
            let own = actuators.iter().filter(|a| a.unit() == unit);
            own.map(|a| line(&a.name, &a.name, factor, Kind::Own)).collect()
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
        ];
        panels.into_iter().filter(|panel| !panel.lines.is_empty()).collect()
    }
}
