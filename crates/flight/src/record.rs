//! Record of a flight; its columns have the names of the outputs of `squid.fmu`.

use crate::flight::{Flight, Row, SeaRow};
use crate::whole::SixDofFlight;
use squid_auv::longitudinal::SPEED;
use squid_auv::{Actuator, State};
use squid_scheduled::ControllerDesign;

/// Time histories of the variables, SI; the heading in a CSV file is `name [unit]`, or `name` without a unit.
#[derive(Debug, Clone, PartialEq)]
pub struct Record(Vec<Column>);

#[derive(Debug, Clone, PartialEq)]
struct Column {
    heading: String,
    values: Vec<f64>,
}

impl Column {
    /// Returns the heading without the unit.
    fn name(&self) -> &str {
        self.split().0
    }

    /// Returns name and unit; the unit is 1 if none is given.
    fn split(&self) -> (&str, &str) {
        let split = self.heading.split_once(" [");
        split.map_or((&self.heading, "1"), |(name, unit)| (name, unit.trim_end_matches(']')))
    }
}

/// Heading of a column, and its value in a row.
type Named<T> = (&'static str, fn(&T) -> f64);

impl Record {
    /// Returns a record of columns of equal length, each with its heading.
    pub fn new(columns: Vec<(String, Vec<f64>)>) -> Self {
        Self(columns.into_iter().map(|(heading, values)| Column { heading, values }).collect())
    }

    /// Returns the record of a flight in this process; at sea with the surface elevation above the vehicle, the
    /// velocity of the water and the sensor readings.
    pub fn of(flight: &Flight, actuators: &[Actuator], design: &ControllerDesign) -> Self {
        let mut columns = Vec::new();
        let mut add = |name: &str, unit: &str, of: &dyn Fn(&Row) -> f64| {
            let heading = if unit.is_empty() { name.to_owned() } else { format!("{name} [{unit}]") };
            columns.push((heading, flight.rows.iter().map(of).collect()));
        };
        add("time", "s", &|r| r.time);
        for (index, (signal, reference)) in design.references().enumerate() {
            add(&signal.name, &signal.unit, &|r| r.measured(index));
            if design.has_reference(index) {
                add(&format!("{}_used", reference.name), &signal.unit, &|r| r.used[index]);
            }
        }
        add("scheduling_parameter", "", &|r| r.rho);
        add("speed_out_of_range", "", &|r| f64::from(u8::from(r.out_of_range)));
        for (j, actuator) in actuators.iter().enumerate() {
            add(&actuator.name, actuator.input_unit(), &|r| actuator.input_for(r.commands[j]).0);
        }
        if !flight.sea.is_empty() {
            let mut add = |heading: String, of: &dyn Fn(&SeaRow) -> f64| {
                columns.push((heading, flight.sea.iter().map(of).collect()));
            };
            add("wave_elevation [m]".into(), &|row| row.elevation);
            add("current_horizontal [m/s]".into(), &|row| row.water.horizontal);
            add("current_vertical [m/s]".into(), &|row| row.water.vertical);
            for (index, signal) in design.signals.iter().enumerate() {
                add(format!("{}_read [{}]", signal.name, signal.unit), &|row| row.read[index]);
            }
        }
        Self::new(columns)
    }

    /// Returns the record of a flight in six degrees of freedom, from the actuators of the vehicle, and actuators and
    /// design of each axis; the columns are named as in [`Record::of`]. At sea it includes the elevation, the velocity
    /// of the water and the sensor readings.
    pub fn of_six_dof(
        flight: &SixDofFlight,
        actuators: &[Actuator],
        axes: &[(&[Actuator], &ControllerDesign)],
    ) -> Self {
        let Some(first) = flight.axes.first() else { return Self(Vec::new()) };
        let mut columns = vec![("time [s]".into(), first.rows.iter().map(|row| row.time).collect())];
        let of_state: [Named<State>; 9] = [
            ("pitch [rad]", |state| state.motion.theta),
            ("roll [rad]", |state| state.motion.phi),
            ("heading [rad]", |state| state.heading),
            ("speed [m/s]", |state| state.motion.u),
            ("sway [m/s]", |state| state.motion.v),
            ("heave [m/s]", |state| state.motion.w),
            ("depth [m]", |state| state.depth),
            ("north [m]", |state| state.x),
            ("east [m]", |state| state.east),
        ];
        columns.extend(of_state.map(|(name, of)| (name.into(), flight.states.iter().map(of).collect())));
        let flown = || axes.iter().zip(&flight.axes).enumerate();
        // The reference and the sensor of the speed are common to all axes.
        let is_own = |axis: usize, index: usize| axis == 0 || index != SPEED;
        for (axis, ((_, design), flown)) in flown() {
            for (index, (signal, reference)) in design.references().enumerate() {
                if design.has_reference(index) && is_own(axis, index) {
                    let used = flown.rows.iter().map(|row| row.used[index]).collect();
                    columns.push((format!("{}_used [{}]", reference.name, signal.unit), used));
                }
            }
        }
        for (actuator, held) in actuators.iter().zip(&flight.held) {
            let own = flown().find_map(|(_, ((own, _), flown))| {
                let index = own.iter().position(|one| one.name == actuator.name)?;
                Some(flown.rows.iter().map(|row| actuator.input_for(row.commands[index]).0).collect())
            });
            let idle = || vec![actuator.input_for(*held).0; flight.states.len()];
            let heading = format!("{} [{}]", actuator.name, actuator.input_unit());
            columns.push((heading, own.unwrap_or_else(idle)));
        }
        if !first.sea.is_empty() {
            let of_sea: [Named<SeaRow>; 4] = [
                ("wave_elevation [m]", |row| row.elevation),
                ("current_north [m/s]", |row| row.water.horizontal),
                ("current_east [m/s]", |row| row.water.east),
                ("current_vertical [m/s]", |row| row.water.vertical),
            ];
            columns.extend(of_sea.map(|(name, of)| (name.into(), first.sea.iter().map(of).collect())));
            for (axis, ((_, design), flown)) in flown() {
                for (index, signal) in
                    design.signals.iter().enumerate().filter(|(index, _)| is_own(axis, *index))
                {
                    let heading = format!("{}_read [{}]", signal.name, signal.unit);
                    // A signal of several axes has one sensor.
                    if columns.iter().all(|(other, _)| *other != heading) {
                        columns.push((heading, flown.sea.iter().map(|row| row.read[index]).collect()));
                    }
                }
            }
        }
        Self::new(columns)
    }

    /// Returns name, unit and values of each variable.
    pub fn columns(&self) -> impl Iterator<Item = (&str, &str, &[f64])> {
        self.0.iter().map(|column| (column.split().0, column.split().1, column.values.as_slice()))
    }

    /// Returns the values of a variable.
    pub fn get(&self, name: &str) -> Option<&[f64]> {
        self.0.iter().rfind(|column| column.name() == name).map(|column| column.values.as_slice())
    }

    /// Truncates the record to the first `rows` rows.
    pub fn truncate(&mut self, rows: usize) {
        self.0.iter_mut().for_each(|column| column.values.truncate(rows));
    }

    /// Returns the record as CSV.
    pub fn csv(&self) -> String {
        let line = |cells: Vec<String>| cells.join(",") + "\n";
        let head = line(self.0.iter().map(|column| column.heading.clone()).collect());
        let rows = self.0.first().map_or(0, |column| column.values.len());
        let row = |k: usize| line(self.0.iter().map(|column| column.values[k].to_string()).collect());
        head + &(0..rows).map(row).collect::<String>()
    }
}
