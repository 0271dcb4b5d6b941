//! The section `[uncertainty]` of a design file: which numbers of the vehicle are uncertain, and how far.

use super::DesignFileError;
use super::checker::Checker;
use auv::{COEFFICIENTS, Parameter, UnknownParameter, Vehicle};
use serde::Deserialize;
use std::collections::BTreeMap;
use toml::Spanned;

const SECTION: &str = "uncertainty";
const COEFFICIENT: &str = "uncertainty.coefficients";
const RELATIVE: &str = "above 0 and below 1, or it would change sign; it is the half range over the value";

/// What is uncertain, checked but for what the vehicle must know.
#[derive(Debug, Clone, PartialEq)]
pub struct Uncertainty {
    /// Half range of every actuator's gain, relative; 0 for none.
    pub actuator_gain: f64,
    /// The coefficients, in the order of the file.
    pub coefficients: Vec<UncertainCoefficient>,
}

/// A coefficient that is uncertain.
#[derive(Debug, Clone, PartialEq)]
pub struct UncertainCoefficient {
    /// Its name in the vehicle file.
    pub name: String,
    /// How far it may be off.
    pub half_range: HalfRange,
    /// The line of the design file.
    pub line: usize,
}

/// How far a coefficient may be off its value, to either side.
#[derive(Debug, Clone, PartialEq)]
pub enum HalfRange {
    /// As a fraction of its value.
    Relative(f64),
    /// In a unit.
    Absolute {
        /// How far.
        value: f64,
        /// In what, which must be the coefficient's own unit.
        unit: String,
    },
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawUncertainty {
    actuator_gain: Option<Spanned<f64>>,
    #[serde(default)]
    coefficients: BTreeMap<Spanned<String>, Spanned<RawHalfRange>>,
}

#[derive(Clone, Deserialize)]
#[serde(untagged, expecting = "a relative half range such as 0.3, or { absolute = 0.005, unit = \"m\" }")]
enum RawHalfRange {
    Relative(f64),
    Absolute(RawAbsolute),
}

#[derive(Clone, Deserialize)]
#[serde(deny_unknown_fields)]
struct RawAbsolute {
    absolute: f64,
    unit: String,
}

impl Checker<'_> {
    /// The section, with everything that can be checked without the vehicle.
    pub(super) fn uncertainty(&self, raw: &RawUncertainty) -> Result<Uncertainty, DesignFileError> {
        let actuator_gain = match &raw.actuator_gain {
            Some(gain) => self.number(
                "uncertainty.actuator_gain",
                gain,
                |v| (0.0..1.0).contains(&v),
                "from 0 to below 1, relative",
            )?,
            None => 0.0,
        };
        let mut coefficients = Vec::new();
        for (name, half_range) in &raw.coefficients {
            let at = name.span().start;
            let name = name.get_ref().clone();
            let blame = |found: f64, words| {
                self.out_of_range(&format!("{COEFFICIENT}.{name}"), at, found.to_string(), words)
            };
            let half_range = match half_range.get_ref().clone() {
                RawHalfRange::Relative(v) if v > 0.0 && v < 1.0 => HalfRange::Relative(v),
                RawHalfRange::Relative(v) => return Err(blame(v, RELATIVE)),
                RawHalfRange::Absolute(RawAbsolute { absolute, unit })
                    if absolute > 0.0 && absolute.is_finite() =>
                {
                    HalfRange::Absolute { value: absolute, unit }
                }
                RawHalfRange::Absolute(raw) => return Err(blame(raw.absolute, "above 0 and finite")),
            };
            coefficients.push((at, UncertainCoefficient { name, half_range, line: self.line(at) }));
        }
        coefficients.sort_by_key(|(at, _)| *at);
        Ok(Uncertainty { actuator_gain, coefficients: coefficients.into_iter().map(|(_, c)| c).collect() })
    }
}

/// A coefficient of the vehicle with its range, SI.
#[derive(Debug, Clone, PartialEq)]
pub struct UncertainParameter {
    /// Which.
    pub parameter: Parameter,
    /// Its value in the vehicle file.
    pub value: f64,
    /// How far it may be off, to either side.
    pub half_range: f64,
}

impl Uncertainty {
    /// The coefficients and their ranges for a vehicle, in the order of the vehicle file; `file` is for messages.
    ///
    /// # Errors
    /// [`DesignFileError`]: a name that the vehicle does not have, another unit than the coefficient's, a relative range of a
    /// coefficient that is 0, or a range that leaves what the coefficient may be.
    pub fn resolve(&self, vehicle: &Vehicle, file: &str) -> Result<Vec<UncertainParameter>, DesignFileError> {
        let mut found: Vec<UncertainParameter> =
            self.coefficients.iter().map(|c| c.resolve(vehicle, file)).collect::<Result<_, _>>()?;
        let order = Parameter::all(vehicle);
        found.sort_by_key(|u| order.iter().position(|p| *p == u.parameter));
        Ok(found)
    }
}

impl UncertainCoefficient {
    fn resolve(&self, vehicle: &Vehicle, file: &str) -> Result<UncertainParameter, DesignFileError> {
        let (line, key) = (self.line, format!("{COEFFICIENT}.{}", self.name));
        let parameter = Parameter::named(vehicle, &self.name).map_err(|reason: UnknownParameter| {
            let reason = Box::new(reason);
            DesignFileError::UnknownCoefficient { file: file.into(), line, section: SECTION, reason }
        })?;
        let wrong = |found: String, allowed: &'static str| DesignFileError::OutOfRange {
            file: file.into(),
            line,
            key: key.clone(),
            found,
            allowed,
        };
        let value = parameter.coefficient(vehicle).unwrap_or(0.0);
        let half_range = match &self.half_range {
            HalfRange::Relative(_) if value == 0.0 => {
                let allowed = "{ absolute = ..., unit = ... }, because the value in the vehicle file is 0";
                return Err(wrong("a relative range".into(), allowed));
            }
            HalfRange::Relative(fraction) => fraction * value.abs(),
            HalfRange::Absolute { value, unit } if unit == parameter.unit(vehicle) => *value,
            HalfRange::Absolute { unit, .. } => {
                return Err(wrong(format!("in \"{unit}\""), parameter.unit(vehicle)));
            }
        };
        if let Parameter::Coefficient(name) = parameter {
            let spec = COEFFICIENTS.iter().find(|spec| spec.key == name);
            let outside = |v: &f64| spec.is_some_and(|spec| !spec.allowed.contains(*v));
            if let Some(end) = [value - half_range, value + half_range].into_iter().find(outside) {
                let allowed = spec.map_or("", |spec| spec.allowed.describe());
                return Err(wrong(format!("a range that reaches {end}"), allowed));
            }
        }
        Ok(UncertainParameter { parameter, value, half_range })
    }
}

#[cfg(test)]
mod tests {
    use super::super::DesignFile;
    use super::*;
    use std::path::Path;

    /// The design of Squid with another section, resolved for the vehicle; the section begins on line 1.
    fn resolve(vehicle: &str, section: &str) -> Result<Vec<UncertainParameter>, DesignFileError> {
        let directory = Path::new(env!("CARGO_MANIFEST_DIR")).join("../vehicles");
        let vehicle = Vehicle::read(&directory.join(vehicle).join("vehicle.toml")).unwrap();
        let text = std::fs::read_to_string(directory.join("squid/paper.toml")).unwrap();
        let (before, _) = text.split_once("[uncertainty]").unwrap();
        let lines = before.lines().count();
        let file = format!("{before}[uncertainty]\n{section}");
        let design = DesignFile::parse(&file, "design.toml", "design").map_err(|e| shifted(e, lines))?;
        design.uncertainty.unwrap().resolve(&vehicle, "design.toml").map_err(|e| shifted(e, lines))
    }

    fn shifted(error: DesignFileError, by: usize) -> DesignFileError {
        match error {
            DesignFileError::OutOfRange { file, line, key, found, allowed } => {
                DesignFileError::OutOfRange { file, line: line - by, key, found, allowed }
            }
            DesignFileError::UnknownCoefficient { file, line, section, reason } => {
                DesignFileError::UnknownCoefficient { file, line: line - by, section, reason }
            }
            other => other,
        }
    }

    #[test]
    fn ranges_are_read_in_the_order_of_the_vehicle_file() {
        let section = "[uncertainty.coefficients]\nM_q = 0.3\nx_G = { absolute = 0.01, unit = \"m\" }\n\"lower.z\" = 0.05\n";
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
    fn what_is_wrong_is_told_with_line_and_key() {
        let coefficients = |line: &str| format!("[uncertainty.coefficients]\nM_q = 0.3\n{line}\n");
        let begins = [
            (
                "actuator_gain = 1.0".to_string(),
                "design.toml, line 2: 'uncertainty.actuator_gain' is 1; it must be from 0",
            ),
            (
                coefficients("Z_vw = 0.3"),
                "design.toml, line 4: [uncertainty]: the vehicle has no coefficient 'Z_vw' (did you mean 'Z_",
            ),
            (
                coefficients("Z_w = 1.2"),
                "design.toml, line 4: 'uncertainty.coefficients.Z_w' is 1.2; it must be above 0 and below 1",
            ),
            (
                coefficients("Z_w = nan"),
                "design.toml, line 4: 'uncertainty.coefficients.Z_w' is NaN; it must be",
            ),
            (
                coefficients("x_G = 0.3"),
                "design.toml, line 4: 'uncertainty.coefficients.x_G' is a relative range; it must be { absolute",
            ),
            (
                coefficients("z_G = { absolute = 5, unit = \"mm\" }"),
                "design.toml, line 4: 'uncertainty.coefficients.z_G' is in \"mm\"; it must be m",
            ),
            (
                coefficients("z_G = { absolute = -0.1, unit = \"m\" }"),
                "design.toml, line 4: 'uncertainty.coefficients.z_G' is -0.1; it must be above 0 and finite",
            ),
            (
                coefficients("Z_w = { absolute = 20.0, unit = \"kg/s\" }"),
                "design.toml, line 4: 'uncertainty.coefficients.Z_w' is a range that reaches 8; it must be zero or a negative",
            ),
        ];
        for (section, words) in begins {
            let message = resolve("squid", &section).unwrap_err().to_string();
            assert!(message.starts_with(words), "{message}\n{words}");
        }
        for section in
            [coefficients("Z_w = \"much\""), coefficients("Z_w = { absolut = 1.0, unit = \"kg/s\" }")]
        {
            let message = resolve("squid", &section).unwrap_err().to_string();
            assert!(message.contains("a relative half range such as 0.3"), "{message}");
        }
        let message = resolve("squid", "gain = 0.1\n").unwrap_err().to_string();
        assert!(message.contains("unknown field `gain`"), "{message}");
    }
}
