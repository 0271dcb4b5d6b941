//! Reading of `[[thruster]]`, `[[thruster_group]]` and `[[control_surface]]`.

#![allow(non_snake_case, reason = "the field's symbols keep their capitals: Z is a force, z a length")]

use std::collections::BTreeMap;

use squid_signals::Curve;

use crate::motion::dynamics::add;
use crate::text::{number, readable, rounded};
use crate::toml_file::{FileProblem, Table, cited};
use crate::vehicle::actuator::{Actuator, Effect, LAG_WITH_RATE, allowed, is_actuator_name};
use crate::vehicle::file::curve_table::{self, CURVE, SQUARE};
use crate::vehicle::file::units::Units;

const ANGLES: [&str; 2] = ["rad", "deg"];
const THRUSTER: [&str; 13] =
    ["name", "x", "y", "z", "direction", "azimuth", "torque", CURVE, SQUARE, "min", "max", "lag", "rate"];
const THRUSTER_GROUP: [&str; 8] = ["name", "thruster", CURVE, SQUARE, "min", "max", "lag", "rate"];
const MEMBER: [&str; 7] = ["share", "x", "y", "z", "direction", "azimuth", "torque"];
const CONTROL_SURFACE: [&str; 11] = [
    "name",
    "Z_uu_delta",
    "M_uu_delta",
    "X_uu_delta2",
    "Y_uu_delta",
    "K_uu_delta",
    "N_uu_delta",
    "min",
    "max",
    "lag",
    "rate",
];

/// Largest deflection \[rad\]: 90 deg, plus a margin for rounding.
const FARTHEST_DEFLECTION: f64 = std::f64::consts::FRAC_PI_2 + 1e-9;

type Sources = BTreeMap<String, String>;

type Read = fn(Reader<'_>, &mut Sources) -> Option<Actuator>;

/// Name of a kind of actuator, its keys, and its reader.
const KINDS: [(&str, &[&str], Read); 3] = [
    ("thruster", &THRUSTER, |reader, sources| reader.thruster(sources)),
    ("thruster_group", &THRUSTER_GROUP, |reader, sources| reader.thruster_group(sources)),
    ("control_surface", &CONTROL_SURFACE, |reader, sources| reader.control_surface(sources)),
];

/// Returns the names of the kinds of actuators, which are those of their tables.
pub(super) fn kinds() -> impl Iterator<Item = &'static str> {
    KINDS.iter().map(|(kind, ..)| *kind)
}

/// Reads all actuators in the order of [`KINDS`]; those that cannot be read are omitted.
pub(super) fn read(root: &Table<'_>, units: &Units<'_>, sources: &mut Sources) -> Vec<Actuator> {
    let mut actuators: Vec<Actuator> = Vec::new();
    let mut names: Vec<(String, usize)> = Vec::new();
    if !KINDS.iter().any(|(kind, ..)| root.has(kind)) {
        root.problem(FileProblem::NoActuator);
    }
    let mut all_read = true;
    for (kind, keys, read) in KINDS {
        let tables = root.tables(kind);
        all_read &= root.has(kind) != tables.is_empty();
        for table in tables {
            table.allow_only(keys);
            let name = name(&table, &mut names);
            let reader = Reader { name: name.clone().unwrap_or_default(), table: &table, units };
            let actuator = name.and(read(reader, sources));
            all_read &= actuator.is_some();
            actuators.extend(actuator);
        }
    }
    if all_read && !actuators.is_empty() && !actuators.iter().any(Actuator::acts_in_plane) {
        root.problem(FileProblem::NoActuator);
    }
    actuators
}

/// Reads a name that no other actuator has.
fn name(table: &Table<'_>, names: &mut Vec<(String, usize)>) -> Option<String> {
    let name = table.text("name")?;
    if !is_actuator_name(&name) {
        table.not_allowed("name", cited(&name), "letters, digits and '_', starting with a letter");
        return None;
    }
    if let Some((_, first_line)) = names.iter().find(|(other, _)| *other == name) {
        table.blame("name", FileProblem::DuplicateActuator { name, first_line: *first_line });
        return None;
    }
    names.push((name.clone(), table.line()));
    Some(name)
}

/// Least and greatest output, lag, and rate limit.
struct Limits {
    min: f64,
    max: f64,
    lag: f64,
    rate: Option<f64>,
}

struct Reader<'a> {
    name: String,
    table: &'a Table<'a>,
    units: &'a Units<'a>,
}

impl Reader<'_> {
    fn thruster(self, sources: &mut Sources) -> Option<Actuator> {
        let effect = self.one_thruster(sources);
        let thrust_data = self.thrust(sources);
        self.finish(thrust_data?, effect?)
    }

    /// Reads position, direction and torque of a thruster.
    fn one_thruster(&self, sources: &mut Sources) -> Option<Effect> {
        let [x, y] = ["x", "y"].map(|key| self.optional(key, &["m"], sources));
        let z = self.required("z", &["m"], "the position below the origin", sources);
        let [direction, azimuth] = ["direction", "azimuth"].map(|key| self.optional(key, &ANGLES, sources));
        let torque = self.optional("torque", &["m"], sources);
        let (azimuth, torque) = (azimuth?, torque?);
        Some(Effect::Thruster { x: x?, y: y?, z: z?, direction: direction?, azimuth, torque })
    }

    fn thruster_group(self, sources: &mut Sources) -> Option<Actuator> {
        let meaning = "one [[thruster_group.thruster]] for each thruster of the group";
        let members = self.table.requires("thruster", meaning).then(|| self.table.tables("thruster"))?;
        let mut sums = Some([[0.0; 3]; 2]);
        for (index, table) in members.iter().enumerate() {
            table.allow_only(&MEMBER);
            let name = format!("{}.{}", self.name, index + 1);
            let reader = Reader { name, table, units: self.units };
            let share = reader.required(
                "share",
                &["1"],
                "the thrust of this thruster as a fraction of the command",
                sources,
            );
            let effect = reader.one_thruster(sources);
            let force = effect
                .zip(share)
                .map(|(effect, share)| [effect.force(0.0, share), effect.lateral_force(0.0, share)]);
            let both = |(sum, force): ([[f64; 3]; 2], [[f64; 3]; 2])| [0, 1].map(|i| add(sum[i], force[i]));
            sums = sums.zip(force).map(both);
        }
        let thrust_data = self.thrust(sources);
        let [[X_T, Z_T, M_T], [Y_T, K_T, N_T]] = sums?;
        self.finish(thrust_data?, Effect::ThrusterGroup { X_T, Y_T, Z_T, K_T, M_T, N_T })
    }

    /// Reads a control surface, which requires force and moment in one of the two planes; those of the other are 0 by
    /// default.
    fn control_surface(self, sources: &mut Sources) -> Option<Actuator> {
        let steers = ["Y_uu_delta", "N_uu_delta"].iter().any(|key| self.table.has(key));
        let rolls = self.table.has("K_uu_delta");
        let dives = !(steers || rolls) || ["Z_uu_delta", "M_uu_delta"].iter().any(|key| self.table.has(key));
        let mut number = |key: &str, unit: &str, meaning: &str, needed: bool| {
            let present = !needed || self.table.requires(key, meaning);
            present.then(|| self.optional(key, &[unit], sources)).flatten()
        };
        let (force, moment) = ("kg/(m.rad)", "kg/rad");
        let heave = number("Z_uu_delta", force, "heave force per u|u| delta", dives);
        let pitch = number("M_uu_delta", moment, "pitch moment per u|u| delta", dives);
        let sway = number("Y_uu_delta", force, "sway force per u|u| delta", steers);
        let yaw = number("N_uu_delta", moment, "yaw moment per u|u| delta", steers);
        let roll = number("K_uu_delta", moment, "", false);
        let surge = number("X_uu_delta2", "kg/(m.rad2)", "", false);
        let limits = self.limits([&ANGLES, &["rad/s", "deg/s"]], None, sources);
        let limits = limits.filter(|limits| self.check_deflections(limits));
        let (Z_uu_delta, M_uu_delta, X_uu_delta2) = (heave?, pitch?, surge?);
        let (Y_uu_delta, K_uu_delta, N_uu_delta) = (sway?, roll?, yaw?);
        let effect = Effect::ControlSurface {
            Z_uu_delta,
            M_uu_delta,
            X_uu_delta2,
            Y_uu_delta,
            K_uu_delta,
            N_uu_delta,
        };
        self.finish((limits?, None), effect)
    }

    /// Returns `true` if the deflections are possible; otherwise reports them.
    fn check_deflections(&self, limits: &Limits) -> bool {
        let out_of_range = [("min", limits.min), ("max", limits.max)];
        let out_of_range = out_of_range.into_iter().find(|(_, angle)| angle.abs() > FARTHEST_DEFLECTION);
        if let Some((key, angle)) = out_of_range {
            let found = format!("{} rad ({} deg)", rounded(angle), rounded(angle.to_degrees()));
            self.table.not_allowed(
                key,
                found,
                "from -90 to 90 deg (is the angle in degrees, with the unit \"rad\"?)",
            );
        }
        out_of_range.is_none()
    }

    /// Reads limits, lag and curve of a thruster; the limits must not exceed the ends of a table of points.
    fn thrust(&self, sources: &mut Sources) -> Option<(Limits, Option<Curve>)> {
        let curve = curve_table::read(self.table, &self.name, sources);
        let ends =
            curve.iter().flatten().map(Curve::ends).find(|ends| ends.iter().all(|end| end.is_finite()));
        let limits = self.limits([&["N"], &["N/s"]], ends, sources);
        let (limits, curve) = (limits?, curve?);
        if let Some([least, most]) = ends {
            let Limits { min, max, .. } = limits;
            for (key, value, within, end) in
                [("min", min, min >= least, least), ("max", max, max <= most, most)]
            {
                if !within {
                    let side = if key == "min" { "at least" } else { "at most" };
                    let allowed = format!("{side} {} N, the end of the curve", number(end));
                    self.table.not_allowed(key, format!("{} N", number(value)), allowed);
                    return None;
                }
            }
        }
        Some((limits, curve))
    }

    /// Reads the limits, in units of the output and of its rate; `ends`, if any, replace absent limits.
    fn limits(
        &self,
        [output, of_rate]: [&[&str]; 2],
        ends: Option<[f64; 2]>,
        sources: &mut Sources,
    ) -> Option<Limits> {
        let mut limit = |key: &str, index: usize, meaning: &str| match ends {
            Some(ends) if !self.table.has(key) => Some(ends[index]),
            _ => self.required(key, output, meaning, sources),
        };
        let min = limit("min", 0, "the least output");
        let max = limit("max", 1, "the largest output");
        let lag = self.required("lag", &["s"], "the time constant of the lag", sources);
        let rate = self.optional("rate", of_rate, sources).map(|rate| (rate > 0.0).then_some(rate));
        let (lag, rate) = (lag?, rate?);
        if rate.is_some() && lag <= 0.0 {
            self.table.not_allowed("lag", format!("{} s", number(lag)), LAG_WITH_RATE);
            return None;
        }
        Some(Limits { min: min?, max: max?, lag, rate })
    }

    fn finish(self, (limits, curve): (Limits, Option<Curve>), effect: Effect) -> Option<Actuator> {
        let Limits { min, max, lag, rate } = limits;
        let actuator = Actuator { name: self.name, min, max, lag, rate, curve, effect };
        if min < max {
            return Some(actuator);
        }
        let (key, (factor, unit)) = (actuator.name.clone(), readable(actuator.unit()));
        let (min, max) = (factor * min, factor * max);
        self.table.blame("min", FileProblem::LimitsReversed { key, min, max, unit });
        None
    }

    fn required(&self, key: &str, units: &[&str], meaning: &str, sources: &mut Sources) -> Option<f64> {
        self.table.requires(key, meaning).then(|| self.optional(key, units, sources)).flatten()
    }

    /// Returns the number, or 0 if it is absent.
    fn optional(&self, key: &str, units: &[&str], sources: &mut Sources) -> Option<f64> {
        if !self.table.has(key) {
            return Some(0.0);
        }
        let (number, source) = self.units.quantity(self.table, key, units, allowed(key))?;
        sources.insert(format!("{}.{key}", self.name), source);
        Some(number)
    }
}
