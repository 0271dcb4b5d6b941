//! Declared types of Real variables (section 2.2.3), determined by unit and range.

use crate::{Kind, ModelDescription, ScalarVariable, Unit};

/// Physical quantity with its unit and its natural limits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RealType {
    /// Name of the type in the variables; the dot distinguishes it from names of actuators.
    pub name: &'static str,
    /// Name of the quantity, as in `Modelica.Units.SI` of the Modelica Standard Library 4.0, if it exists there.
    pub quantity: &'static str,
    /// Meaning of the quantity.
    pub description: &'static str,
    /// Unit of the quantity.
    pub unit: &'static str,
    /// Smallest value.
    pub min: Option<f64>,
    /// Largest value.
    pub max: Option<f64>,
}

const QUARTER_TURN: f64 = std::f64::consts::FRAC_PI_2;

/// Declared types; among those with the same unit, the one without limits is used if no other fits.
#[rustfmt::skip]
const TYPES: [RealType; 22] = [
    real("SI.Angle",               "Angle",               "angle",                                 "rad"),
    real("SI.Inclination",         "Angle",               "angle to the horizontal, from -90 to 90 deg", "rad")
        .within(-QUARTER_TURN, QUARTER_TURN),
    real("SI.AngularVelocity",     "AngularVelocity",     "angular rate",                          "rad/s"),
    real("SI.AngularAcceleration", "AngularAcceleration", "angular acceleration",               "rad/s2"),
    real("SI.Time",                "Time",                "time, or duration",                         "s"),
    real("SI.Duration",            "Time",                "duration",                                  "s").positive(),
    real("SI.Length",              "Length",              "position along an axis",                    "m"),
    real("SI.Distance",            "Length",              "length, or depth below the surface",        "m").positive(),
    real("SI.Area",                "Area",                "area",                                      "m2").positive(),
    real("SI.Velocity",            "Velocity",            "velocity along an axis",                    "m/s"),
    real("SI.Speed",               "Velocity",            "magnitude of a velocity",             "m/s").positive(),
    real("SI.Acceleration",        "Acceleration",        "acceleration along an axis",                "m/s2"),
    real("SI.Force",               "Force",               "force along an axis",                       "N"),
    real("SI.RateOfForce",         "RateOfForce",         "rate of a force",                           "N/s"),
    real("SI.ForceGradient",       "ForceGradient",       "change of force per length",              "N/m"),
    real("SI.Mass",                "Mass",                "mass",                                      "kg").positive(),
    real("SI.AddedMass",           "Mass",                "added mass as a derivative of force, after SNAME \
        (1950)", "kg").negative(),
    real("SI.MomentOfInertia",     "MomentOfInertia",     "moment of \
        inertia",                         "kg.m2").positive(),
    real("SI.Density",             "Density",             "density",                                "kg/m3").positive(),
    real("SI.KinematicViscosity",  "KinematicViscosity",  "kinematic \
        viscosity",                       "m2/s").positive(),
    real("SI.Number",              "Dimensionless",       "dimensionless number",                     "1"),
    real("SI.Ratio",               "Dimensionless",       "ratio of two quantities",                   "1").positive(),
];

const fn real(
    name: &'static str,
    quantity: &'static str,
    description: &'static str,
    unit: &'static str,
) -> RealType {
    RealType { name, quantity, description, unit, min: None, max: None }
}

impl RealType {
    const fn within(self, min: f64, max: f64) -> Self {
        Self { min: Some(min), max: Some(max), ..self }
    }

    const fn positive(self) -> Self {
        Self { min: Some(0.0), ..self }
    }

    const fn negative(self) -> Self {
        Self { max: Some(0.0), ..self }
    }

    /// Returns the unit in which a tool should display values.
    pub fn display_unit(&self) -> Option<String> {
        Unit::parse(self.unit).ok()?.display_units.into_iter().next().map(|one| one.name)
    }

    /// Returns the type with this unit and these limits, or else the one without limits.
    ///
    /// Coefficients whose unit and range match no named quantity have no type.
    fn of(unit: &str, min: Option<f64>, max: Option<f64>) -> Option<&'static Self> {
        let mut candidates = TYPES.iter().filter(|entry| entry.unit == unit);
        let fitting = candidates.clone().find(|entry| (entry.min, entry.max) == (min, max));
        fitting.or_else(|| candidates.find(|entry| entry.min.is_none() && entry.max.is_none()))
    }
}

impl ScalarVariable {
    /// Returns the declared type of a Real variable, if its quantity has a name.
    pub fn real_type(&self) -> Option<&'static RealType> {
        match &self.kind {
            Kind::Real { unit: Some(unit), min, max, .. } => RealType::of(unit, *min, *max),
            _ => None,
        }
    }
}

impl ModelDescription {
    /// Returns the declared types of the Real variables, each once, sorted by name.
    pub fn real_types(&self) -> Vec<&'static RealType> {
        let mut types: Vec<_> = self.variables.iter().filter_map(ScalarVariable::real_type).collect();
        types.sort_unstable_by_key(|one| one.name);
        types.dedup_by_key(|one| one.name);
        types
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn name(unit: &str, min: Option<f64>, max: Option<f64>) -> Option<&'static str> {
        RealType::of(unit, min, max).map(|one| one.name)
    }

    #[test]
    fn unit_and_range_determine_type() {
        assert_eq!(name("rad", Some(-QUARTER_TURN), Some(QUARTER_TURN)), Some("SI.Inclination"));
        assert_eq!(name("rad", Some(-0.3), Some(0.3)), Some("SI.Angle"));
        assert_eq!(name("m/s", Some(0.0), None), Some("SI.Speed"));
        assert_eq!(name("m/s", Some(0.0), Some(3.0)), Some("SI.Velocity"));
        assert_eq!(name("kg", None, Some(0.0)), Some("SI.AddedMass"));
    }

    #[test]
    fn unnamed_quantities_have_no_type() {
        assert_eq!(name("kg", None, None), None);
        assert_eq!(name("kg.m2", None, Some(0.0)), None);
        assert_eq!(name("kg.m", None, None), None);
    }

    #[test]
    fn table_is_consistent() {
        for (position, one) in TYPES.iter().enumerate() {
            assert!(TYPES[position + 1..].iter().all(|other| other.name != one.name), "{}", one.name);
            let same = |other: &RealType| (other.unit, other.min, other.max) == (one.unit, one.min, one.max);
            assert!(!TYPES[position + 1..].iter().any(same), "{}", one.name);
            assert!(Unit::parse(one.unit).is_ok(), "{}", one.unit);
        }
        assert_eq!(TYPES[0].display_unit().as_deref(), Some("deg"));
    }
}
