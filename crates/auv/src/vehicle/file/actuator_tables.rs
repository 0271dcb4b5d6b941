//! Reads `[[thruster]]` and `[[control_surface]]`.

use std::collections::BTreeMap;

use crate::toml_file::{FileProblem, Table, cited};
use crate::vehicle::actuator::{Actuator, Effect, allowed, is_actuator_name};

const ANGLES: [&str; 2] = ["rad", "deg"];
const THRUSTER: [&str; 7] = ["name", "x", "z", "direction", "min", "max", "lag"];
const CONTROL_SURFACE: [&str; 7] = ["name", "Z_uu_delta", "M_uu_delta", "X_uu_delta2", "min", "max", "lag"];

type Sources = BTreeMap<String, String>;

/// Reads all actuators, thrusters first; those that cannot be read are omitted.
pub(crate) fn read(root: &Table<'_>, sources: &mut Sources) -> Vec<Actuator> {
    let mut actuators: Vec<Actuator> = Vec::new();
    let mut taken: Vec<(String, usize)> = Vec::new();
    let thrusters = root.tables("thruster").into_iter().map(|table| (table, true));
    let surfaces = root.tables("control_surface").into_iter().map(|table| (table, false));
    let tables: Vec<(Table<'_>, bool)> = thrusters.chain(surfaces).collect();
    if !root.has("thruster") && !root.has("control_surface") {
        root.problem(FileProblem::NoActuator);
    }
    for (table, is_thruster) in tables {
        table.allow_only(if is_thruster { &THRUSTER } else { &CONTROL_SURFACE });
        let name = name(&table, &mut taken);
        let reader = Reader { name: name.clone().unwrap_or_default(), table: &table };
        let actuator = if is_thruster { reader.thruster(sources) } else { reader.control_surface(sources) };
        actuators.extend(name.and(actuator));
    }
    actuators
}

/// A name that no other actuator has.
fn name(table: &Table<'_>, taken: &mut Vec<(String, usize)>) -> Option<String> {
    let name = table.text("name")?;
    if !is_actuator_name(&name) {
        table.not_allowed("name", cited(&name), "letters, digits and '_', beginning with a letter");
        return None;
    }
    if let Some((_, first_line)) = taken.iter().find(|(other, _)| *other == name) {
        table.blame("name", FileProblem::DuplicateActuator { name, first_line: *first_line });
        return None;
    }
    taken.push((name.clone(), table.line()));
    Some(name)
}

struct Reader<'a> {
    name: String,
    table: &'a Table<'a>,
}

impl Reader<'_> {
    fn thruster(self, sources: &mut Sources) -> Option<Actuator> {
        let x = self.optional("x", &["m"], sources);
        let z = self.required("z", &["m"], "position below the origin", sources);
        let direction = self.optional("direction", &ANGLES, sources);
        let limits = self.limits(&["N"], sources);
        let effect = Effect::Thruster { x: x?, z: z?, direction: direction? };
        self.finish(limits?, effect)
    }

    fn control_surface(self, sources: &mut Sources) -> Option<Actuator> {
        let (force, moment) = ("heave force per u|u| delta", "pitch moment per u|u| delta");
        let heave = self.required("Z_uu_delta", &["kg/(m.rad)"], force, sources);
        let pitch = self.required("M_uu_delta", &["kg/rad"], moment, sources);
        let surge = self.optional("X_uu_delta2", &["kg/(m.rad2)"], sources);
        let limits = self.limits(&ANGLES, sources);
        let effect = Effect::ControlSurface { Z_uu_delta: heave?, M_uu_delta: pitch?, X_uu_delta2: surge? };
        self.finish(limits?, effect)
    }

    /// Least and greatest output, and lag.
    fn limits(&self, units: &[&str], sources: &mut Sources) -> Option<[f64; 3]> {
        let min = self.required("min", units, "the least output", sources);
        let max = self.required("max", units, "the greatest output", sources);
        let lag = self.required("lag", &["s"], "time constant of the lag", sources);
        Some([min?, max?, lag?])
    }

    fn finish(self, [min, max, lag]: [f64; 3], effect: Effect) -> Option<Actuator> {
        let actuator = Actuator { name: self.name, min, max, lag, effect };
        if min < max {
            return Some(actuator);
        }
        let (key, unit) = (actuator.name.clone(), actuator.unit());
        self.table.blame("min", FileProblem::LimitsReversed { key, min, max, unit });
        None
    }

    fn required(&self, key: &str, units: &[&str], meaning: &str, sources: &mut Sources) -> Option<f64> {
        self.table.requires(key, meaning).then(|| self.optional(key, units, sources)).flatten()
    }

    /// Returns the number, or 0 if it is missing.
    fn optional(&self, key: &str, units: &[&str], sources: &mut Sources) -> Option<f64> {
        if !self.table.has(key) {
            return Some(0.0);
        }
        let quantity = self.table.quantity(key, units, allowed(key))?;
        let number = quantity.si();
        sources.insert(format!("{}.{key}", self.name), quantity.source);
        Some(number)
    }
}
