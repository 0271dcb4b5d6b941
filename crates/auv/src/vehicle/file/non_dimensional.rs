//! Optional section `[non_dimensional]` of a vehicle file: the conversion of numbers in the unit "prime" to SI.
//!
//! A unit is a product of powers of kg, m and s; the number is multiplied by the same powers of three scales:
//!
//! ```text
//! prime-I     mass rho L^3/2       length L    time L/U
//! prime-II    mass rho L^2 T/2     length L    time L/U
//! ```
//!
//! Z_uw in kg/m, for example, is rho L^2/2 times its non-dimensional value, independent of the speed U; only units with
//! a time require U.
//!
//! Sources: SNAME (1950), prime-I; Fossen (2011), table 7.2.

use crate::toml_file::{FileProblem, Quantity, Table};
use crate::vehicle::allowed::Allowed;

/// Name of the section.
pub(super) const SECTION: &str = "non_dimensional";
/// Unit of a non-dimensional number.
pub(super) const PRIME: &str = "prime";

const SYSTEMS: [&str; 2] = ["prime-I", "prime-II"];
const SPEED: &str = "speed";
const DRAUGHT: &str = "draught";

/// Scales of mass \[kg\], length \[m\] and time \[s\].
pub(super) struct Scales<'a> {
    table: Table<'a>,
    mass: f64,
    length: f64,
    /// Scale of time; `None` without a speed.
    time: Option<f64>,
}

/// Reads the section, if present.
pub(super) fn read<'a>(root: &Table<'a>) -> Option<Scales<'a>> {
    let table = root.table(SECTION)?;
    table.allow_only(&["system", "length", DRAUGHT, "density", SPEED]);
    let positive = |key: &str, unit: &str, meaning: &str| {
        let present = table.requires(key, meaning);
        present.then(|| table.quantity(key, &[unit], Allowed::Positive)).flatten().map(|found| found.value)
    };
    let system = table.one_of("system", &SYSTEMS);
    let length = positive("length", "m", "the length L of the system");
    let density = positive("density", "kg/m3", "the density of the water in the system");
    let second = match system {
        Some(1) => positive(DRAUGHT, "m", "the draught T of the system \"prime-II\""),
        _ => length,
    };
    let speed = table.has(SPEED).then(|| table.quantity(SPEED, &["m/s"], Allowed::Positive)).flatten();
    let (length, second) = (length?, second?);
    let mass = 0.5 * density? * length * length * second;
    Some(Scales { table, mass, length, time: speed.map(|speed| length / speed.value) })
}

impl Scales<'_> {
    /// Returns a number in SI; `unit` is its SI unit. A number not in "prime" is converted by [`Quantity::si`].
    pub(super) fn si(&self, key: &str, found: &Quantity, unit: &str) -> Option<f64> {
        if found.unit != PRIME {
            return Some(found.si());
        }
        let [mass, length, time] = powers(unit);
        if time != 0 && self.time.is_none() {
            let meaning = format!("the speed U of the system, required by '{key}' in \"{PRIME}\"");
            let problem = FileProblem::MissingKey { key: format!("{SECTION}.{SPEED}"), meaning };
            self.table.problem(problem);
            return None;
        }
        let time = self.time.unwrap_or(1.0).powi(time);
        Some(found.value * self.mass.powi(mass) * self.length.powi(length) * time)
    }
}

/// Returns the powers of kg, m and s in a unit such as `kg.m2/s`, `kg/(m.rad)` or `N/m`; angles and `1` have none.
fn powers(unit: &str) -> [i32; 3] {
    let mut powers = [0; 3];
    for (index, part) in unit.split('/').enumerate() {
        let sign = if index == 0 { 1 } else { -1 };
        for factor in part.trim_matches(['(', ')']).split('.') {
            let name = factor.trim_end_matches(|c: char| c.is_ascii_digit());
            let power = sign * factor[name.len()..].parse().unwrap_or(1);
            let own = match name {
                "kg" => [1, 0, 0],
                "m" => [0, 1, 0],
                "s" => [0, 0, 1],
                "N" => [1, 1, -2],
                _ => [0; 3],
            };
            (0..3).for_each(|i| powers[i] += power * own[i]);
        }
    }
    powers
}
