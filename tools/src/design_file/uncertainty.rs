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
