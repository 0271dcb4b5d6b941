//! Section `[uncertainty]` of a design file: the uncertain parameters of the vehicle, and their ranges.

use squid_auv::number;
use squid_auv::toml_file::{Document, FileError, FileProblem, Mistake, Table, cited};
use squid_auv::{COEFFICIENTS, Parameter, Vehicle};

const SECTION: &str = "uncertainty";
const COEFFICIENT: &str = "uncertainty.coefficients";
const EITHER: &str = "a relative half range such as 0.3, or { absolute = 0.005, unit = \"m\" }";
const RELATIVE: &str = "above 0 and below 1, as half range over value (from 1 on the sign would change)";

/// Declared uncertainty, before it is checked against the vehicle.
#[derive(Debug, Clone, PartialEq)]
pub struct Uncertainty {
    /// Half range of every actuator's gain, relative; 0 for none.
    pub actuator_gain: f64,
    /// Uncertain coefficients, in the order of the file.
    pub coefficients: Vec<UncertainCoefficient>,
}

/// Uncertain coefficient.
#[derive(Debug, Clone, PartialEq)]
pub struct UncertainCoefficient {
    /// Name in the vehicle file.
    pub name: String,
    /// Half range about the value.
    pub half_range: HalfRange,
    /// Line of the design file.
    pub line: usize,
}

/// Half range of a coefficient about its value.
#[derive(Debug, Clone, PartialEq)]
pub enum HalfRange {
    /// Fraction of the value.
    Relative(f64),
    /// Number with a unit.
    Absolute {
        /// Half range in the unit.
        value: f64,
        /// Unit, which must be that of the coefficient.
        unit: String,
    },
}

/// Reads the section and checks everything that does not need the vehicle; unreadable entries are left out.
pub(super) fn read(document: &Document<'_>, table: &Table<'_>) -> Uncertainty {
    table.allow_only(&["actuator_gain", "coefficients"]);
    let gain = table.or("actuator_gain", 0.0, |table, key| {
        table.number(key, |v| (0.0..1.0).contains(&v), "from 0 to below 1, relative")
    });
    let coefficients = table.table("coefficients").map_or_else(Vec::new, |named| {
        let each = named.keys().into_iter().filter_map(|(at, name)| {
            let half_range = half_range(&named, name)?;
            Some(UncertainCoefficient { name: name.to_owned(), half_range, line: document.line(at) })
        });
        each.collect()
    });
    Uncertainty { actuator_gain: gain.unwrap_or(0.0), coefficients }
}

fn half_range(named: &Table<'_>, name: &str) -> Option<HalfRange> {
    if !named.holds_table(name) {
        let found = named.float(name, EITHER)?;
        if found > 0.0 && found < 1.0 {
            return Some(HalfRange::Relative(found));
        }
        named.not_allowed(name, number(found), RELATIVE);
        return None;
    }
    let table = named.table(name)?;
    if let Some((_, key)) = table.keys().first().filter(|_| named.is_dotted(name)) {
        table.problem(FileProblem::NoQuotes { name: format!("{name}.{key}") });
        return None;
    }
    table.allow_only(&["absolute", "unit"]);
    let value = table.number("absolute", |v| v > 0.0, "above 0 and finite");
    let unit = table.text("unit");
    Some(HalfRange::Absolute { value: value?, unit: unit? })
}

/// Coefficient of the vehicle with its range, SI.
#[derive(Debug, Clone, PartialEq)]
pub struct UncertainParameter {
    /// Parameter of the vehicle.
    pub parameter: Parameter,
    /// Value in the vehicle file.
    pub value: f64,
    /// Half range about the value.
    pub half_range: f64,
}

impl Uncertainty {
    /// Removes the coefficients that the vehicle of this axis does not have but that of another axis has.
    pub fn leave_out_of(&mut self, vehicle: &Vehicle, others: &[Vehicle]) {
        let has = |vehicle: &Vehicle, name: &str| Parameter::named(vehicle, name).is_ok();
        let is_of_another = |name: &str| others.iter().any(|other| has(other, name));
        self.coefficients.retain(|one| has(vehicle, &one.name) || !is_of_another(&one.name));
    }

    /// Returns the coefficients and their ranges for a vehicle, in the order of the vehicle file; `file` is for
    /// messages.
    ///
    /// # Errors
    /// [`FileError`]: unknown coefficients, wrong units, relative ranges of coefficients that are 0, ranges that exceed
    /// the allowed range of the coefficient.
    pub fn resolve(&self, vehicle: &Vehicle, file: &str) -> Result<Vec<UncertainParameter>, FileError> {
        let (mut found, mut mistakes) = (Vec::new(), Vec::new());
        for coefficient in &self.coefficients {
            match coefficient.resolve(vehicle) {
                Ok(parameter) => found.push(parameter),
                Err(problem) => mistakes.push(Mistake { line: coefficient.line, problem }),
            }
        }
        if !mistakes.is_empty() {
            return Err(FileError { file: file.into(), mistakes });
        }
        let order = Parameter::all(vehicle);
        found.sort_by_key(|u: &UncertainParameter| order.iter().position(|p| *p == u.parameter));
        Ok(found)
    }
}

impl UncertainCoefficient {
    fn resolve(&self, vehicle: &Vehicle) -> Result<UncertainParameter, FileProblem> {
        let parameter = Parameter::named(vehicle, &self.name)
            .map_err(|source| FileProblem::UnknownCoefficient { section: SECTION, source })?;
        let wrong = |found: String, allowed: &str| FileProblem::NotAllowed {
            key: format!("{COEFFICIENT}.{}", self.name),
            found,
            allowed: allowed.into(),
        };
        let value = parameter.coefficient(vehicle).unwrap_or(0.0);
        let half_range = match &self.half_range {
            HalfRange::Relative(_) if value == 0.0 => {
                let allowed =
                    "{ absolute = ..., unit = ... } or omitted, because the value in the vehicle file is 0";
                return Err(wrong("a relative range".into(), allowed));
            }
            HalfRange::Relative(fraction) => fraction * value.abs(),
            HalfRange::Absolute { value, unit } if unit == parameter.unit(vehicle) => *value,
            HalfRange::Absolute { unit, .. } => {
                return Err(wrong(
                    format!("in {}", cited(unit)),
                    &format!("in \"{}\"", parameter.unit(vehicle)),
                ));
            }
        };
        if let Parameter::Coefficient(name) = parameter {
            let spec = COEFFICIENTS.iter().find(|spec| spec.key == name);
            let outside = |v: &f64| spec.is_some_and(|spec| !spec.allowed.contains(*v));
            if let Some(end) = [value - half_range, value + half_range].into_iter().find(outside) {
                let allowed = spec.map_or("", |spec| spec.allowed.describe());
                return Err(wrong(format!("a range that extends to {}", number(end)), allowed));
            }
        }
        Ok(UncertainParameter { parameter, value, half_range })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::inputs::design_file::DesignFile;
    use std::path::Path;

    /// Resolves this section in the paper's design of Squid for a vehicle; the section begins on line 1.
    fn resolve(vehicle: &str, section: &str) -> Result<Vec<UncertainParameter>, FileError> {
        let directory = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../vehicles");
        let text = std::fs::read_to_string(directory.join(vehicle).join("vehicle.toml")).unwrap();
        let vehicle = Vehicle::parse(&text, "vehicle.toml").unwrap().in_plane();
        let text = std::fs::read_to_string(directory.join("squid/paper.toml")).unwrap();
        let (before, _) = text.split_once("[uncertainty]").unwrap();
        let shifted = |mut error: FileError| {
            for mistake in &mut error.mistakes {
                mistake.line -= before.lines().count();
            }
            error
        };
        let file = format!("{before}[uncertainty]\n{section}");
        let design = DesignFile::parse(&file, "design.toml", "design").map_err(shifted)?;
        design.uncertainty.unwrap().resolve(&vehicle, "design.toml").map_err(shifted)
    }

    #[test]
    fn reads_ranges_in_order_of_vehicle_file() {
        let section = "[uncertainty.coefficients]\nM_q = 0.3\nx_G = \
            { absolute = 0.01, unit = \"m\" }\n\"lower.z\" = 0.05\n";
        let found = resolve("squid", section).unwrap();
        let shown: Vec<(Parameter, f64, f64)> =
            found.iter().map(|u| (u.parameter, u.value, u.half_range)).collect();
        let lower = Parameter::Effect { actuator: 0, key: "z" };
        assert_eq!(
            shown,
            [
                (Parameter::Coefficient("x_G"), 0.0, 0.01),
                (Parameter::Coefficient("M_q"), -5.0, 1.5),
                (lower, 0.2, 0.2 * 0.05),
            ]
        );
        assert_eq!(resolve("squid", "actuator_gain = 0.1\n").unwrap(), []);
    }

    #[test]
    fn reports_line_and_key_of_mistakes() {
        let coefficients = |line: &str| format!("[uncertainty.coefficients]\nM_q = 0.3\n{line}\n");
        let uncertain = |key: &str| format!("uncertainty.{key}");
        let of = |key: &str| format!("uncertainty.coefficients.{key}");
        let mut messages = vec![];
        for (section, line, key) in [
            ("actuator_gain = 1.0\n".to_owned(), 2, uncertain("actuator_gain")),
            ("gain = 0.1\n".to_owned(), 2, uncertain("gain")),
            (coefficients("Z_vw = 0.3"), 4, String::new()),
            (coefficients("Z_w = 1.2"), 4, of("Z_w")),
            (coefficients("lower.z = 0.05"), 4, String::new()),
            (coefficients("Z_w = nan"), 4, of("Z_w")),
            (coefficients("x_G = 0.3"), 4, of("x_G")),
            (coefficients("z_G = { absolute = 5, unit = \"mm\" }"), 4, of("z_G")),
            (coefficients("z_G = { absolute = -0.1, unit = \"m\" }"), 4, of("z_G.absolute")),
            (coefficients("Z_w = { absolute = 20.0, unit = \"kg/s\" }"), 4, of("Z_w")),
            (coefficients("Z_w = \"much\""), 4, of("Z_w")),
            (coefficients("Z_w = { absolut = 1.0, unit = \"kg/s\" }"), 4, of("Z_w.absolut")),
        ] {
            let error = resolve("squid", &section).unwrap_err();
            let mistake = &error.mistakes[0];
            let key_found = mistake.problem.key().unwrap_or_default();
            assert_eq!((mistake.line, key_found), (line, key.as_str()), "{error}");
            messages.push(mistake.problem.to_string());
        }
        insta::assert_snapshot!(messages.join("\n\n"));
    }

    /// Each mistake has one line, in the order of the file.
    #[test]
    fn reports_all_mistakes_at_once() {
        let section = "[uncertainty.coefficients]\nZ_vw = 0.3\nM_q = 0.3\nx_G = 0.3\n";
        let error = resolve("squid", section).unwrap_err();
        assert_eq!(error.mistakes.iter().map(|one| one.line).collect::<Vec<_>>(), [3, 5], "{error}");
    }
}
