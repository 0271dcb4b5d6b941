//! Reads `[[thruster]]` and `[[control_surface]]`.

use std::collections::BTreeMap;

use super::error::{FileProblem, VehicleFileError};
use super::table::Table;
use crate::actuator::{Actuator, Effect, allowed, is_actuator_name};

const ANGLES: [&str; 2] = ["rad", "deg"];

type Sources = BTreeMap<String, String>;

/// Reads all actuators, thrusters first.
pub(crate) fn read(root: &Table<'_>, sources: &mut Sources) -> Result<Vec<Actuator>, VehicleFileError> {
    let mut actuators: Vec<(Actuator, usize)> = Vec::new();
    let thrusters = root.tables("thruster")?.into_iter().map(|table| (table, true));
    let surfaces = root.tables("control_surface")?.into_iter().map(|table| (table, false));
    for (table, is_thruster) in thrusters.chain(surfaces) {
        let reader = Reader { name: name(&table)?, table: &table };
        let actuator =
            if is_thruster { reader.thruster(sources)? } else { reader.control_surface(sources)? };
        if let Some((_, first_line)) = actuators.iter().find(|(other, _)| other.name == actuator.name) {
            let problem = FileProblem::DuplicateActuator { name: actuator.name, first_line: *first_line };
            return Err(table.blame("name", problem));
        }
        actuators.push((actuator, table.line()));
    }
    if actuators.is_empty() {
        return Err(root.problem(FileProblem::NoActuator));
    }
    Ok(actuators.into_iter().map(|(actuator, _)| actuator).collect())
}

fn name(table: &Table<'_>) -> Result<String, VehicleFileError> {
    let name = table.text("name")?;
    if is_actuator_name(&name) {
        return Ok(name);
    }
    Err(table.blame("name", FileProblem::ActuatorName { name }))
}

struct Reader<'a> {
    name: String,
    table: &'a Table<'a>,
}

impl Reader<'_> {
    fn thruster(self, sources: &mut Sources) -> Result<Actuator, VehicleFileError> {
        self.table.allow_only(&["name", "x", "z", "direction", "min", "max", "lag"])?;
        let effect = Effect::Thruster {
            x: self.optional("x", &["m"], sources)?,
            z: self.required("z", &["m"], "position below the origin", sources)?,
            direction: self.optional("direction", &ANGLES, sources)?,
        };
        self.finish(&["N"], effect, sources)
    }

    fn control_surface(self, sources: &mut Sources) -> Result<Actuator, VehicleFileError> {
        let keys = ["name", "Z_uu_delta", "M_uu_delta", "X_uu_delta2", "min", "max", "lag"];
        self.table.allow_only(&keys)?;
        let (force, moment) = ("heave force per u|u| delta", "pitch moment per u|u| delta");
        let effect = Effect::ControlSurface {
            Z_uu_delta: self.required("Z_uu_delta", &["kg/(m.rad)"], force, sources)?,
            M_uu_delta: self.required("M_uu_delta", &["kg/rad"], moment, sources)?,
            X_uu_delta2: self.optional("X_uu_delta2", &["kg/(m.rad2)"], sources)?,
        };
        self.finish(&ANGLES, effect, sources)
    }

    fn finish(
        self,
        units: &[&str],
        effect: Effect,
        sources: &mut Sources,
    ) -> Result<Actuator, VehicleFileError> {
        let min = self.required("min", units, "the least output", sources)?;
        let max = self.required("max", units, "the greatest output", sources)?;
        let lag = self.required("lag", &["s"], "time constant of the lag", sources)?;
        let actuator = Actuator { name: self.name.clone(), min, max, lag, effect };
        if min < max {
            return Ok(actuator);
        }
        let (key, unit) = (actuator.name.clone(), actuator.unit());
        Err(self.table.blame("min", FileProblem::LimitsReversed { key, min, max, unit }))
    }

    fn required(
        &self,
        key: &str,
        units: &[&str],
        meaning: &str,
        sources: &mut Sources,
    ) -> Result<f64, VehicleFileError> {
        self.number(key, units, sources)?.ok_or_else(|| self.table.missing(key, meaning))
    }

    fn optional(&self, key: &str, units: &[&str], sources: &mut Sources) -> Result<f64, VehicleFileError> {
        Ok(self.number(key, units, sources)?.unwrap_or(0.0))
    }

    fn number(
        &self,
        key: &str,
        units: &[&str],
        sources: &mut Sources,
    ) -> Result<Option<f64>, VehicleFileError> {
        let Some(quantity) = self.table.quantity(key, units)? else { return Ok(None) };
        quantity.check(allowed(key))?;
        let number = quantity.si();
        sources.insert(format!("{}.{key}", self.name), quantity.source);
        Ok(Some(number))
    }
}
