//! Reads `[[thruster]]` and `[[control_surface]]`.

use std::collections::BTreeMap;

use super::error::{FileProblem, VehicleFileError};
use super::table::Table;
use crate::actuator::{Actuator, Effect};
use crate::coefficients::Allowed;

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
    let letters = name.starts_with(|c: char| c.is_ascii_alphabetic());
    if letters && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_') {
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
            x: self.optional("x", &["m"], Allowed::Any, sources)?,
            z: self.required("z", &["m"], Allowed::Any, "position below the origin", sources)?,
            direction: self.optional("direction", &ANGLES, Allowed::Any, sources)?,
        };
        self.finish(&["N"], effect, sources)
    }

    fn control_surface(self, sources: &mut Sources) -> Result<Actuator, VehicleFileError> {
        let keys = ["name", "Z_uu_delta", "M_uu_delta", "X_uu_delta2", "min", "max", "lag"];
        self.table.allow_only(&keys)?;
        let (force, moment) = ("heave force per u|u| delta", "pitch moment per u|u| delta");
        let effect = Effect::ControlSurface {
            Z_uu_delta: self.required("Z_uu_delta", &["kg/(m.rad)"], Allowed::Any, force, sources)?,
            M_uu_delta: self.required("M_uu_delta", &["kg/rad"], Allowed::Any, moment, sources)?,
            X_uu_delta2: self.optional("X_uu_delta2", &["kg/(m.rad2)"], Allowed::NonPositive, sources)?,
        };
        self.finish(&ANGLES, effect, sources)
    }

    fn finish(
        self,
        units: &[&str],
        effect: Effect,
        sources: &mut Sources,
    ) -> Result<Actuator, VehicleFileError> {
        let min = self.required("min", units, Allowed::Any, "the least output", sources)?;
        let max = self.required("max", units, Allowed::Any, "the greatest output", sources)?;
        let lag = self.required("lag", &["s"], Allowed::NonNegative, "time constant of the lag", sources)?;
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
        allowed: Allowed,
        meaning: &str,
        sources: &mut Sources,
    ) -> Result<f64, VehicleFileError> {
        self.number(key, units, allowed, sources)?.ok_or_else(|| self.table.missing(key, meaning))
    }

    fn optional(
        &self,
        key: &str,
        units: &[&str],
        allowed: Allowed,
        sources: &mut Sources,
    ) -> Result<f64, VehicleFileError> {
        Ok(self.number(key, units, allowed, sources)?.unwrap_or(0.0))
    }

    fn number(
        &self,
        key: &str,
        units: &[&str],
        allowed: Allowed,
        sources: &mut Sources,
    ) -> Result<Option<f64>, VehicleFileError> {
        let Some(quantity) = self.table.quantity(key, units)? else { return Ok(None) };
        quantity.check(allowed)?;
        let number = quantity.si();
        sources.insert(format!("{}.{key}", self.name), quantity.source);
        Ok(Some(number))
    }
}
