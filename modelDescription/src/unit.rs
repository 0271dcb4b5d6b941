//! Units, converted from their usual spelling to powers of the SI base units (section 2.2.2).

use std::f64::consts::PI;

use crate::element::number;

/// Unit with its base-unit exponents and the display units that a tool may choose.
#[derive(Debug, Clone, PartialEq)]
pub struct Unit {
    /// Spelling, such as `kg.m2/s`.
    pub name: String,
    /// Powers of the base units.
    pub base: BaseUnit,
    /// Value of one unit in these base units; 1 except for the few units that are not coherent.
    pub factor: f64,
    /// Display units: a value in the display unit is `factor` times the value in this unit.
    pub display_units: Vec<DisplayUnit>,
}

/// Exponents of kg, m, s, A, K, mol, cd and rad.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct BaseUnit {
    /// Exponents in the order of [`BaseUnit::SYMBOLS`].
    pub exponents: [i32; 8],
}

/// Display unit.
#[derive(Debug, Clone, PartialEq)]
pub struct DisplayUnit {
    /// Spelling.
    pub name: String,
    /// Value in this display unit of one unit.
    pub factor: f64,
}

/// Error in reading a unit.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[allow(missing_docs, reason = "the message says what each field is")]
pub enum UnitError {
    /// Symbol that is neither an SI base unit nor a known derived unit.
    #[error("unit '{unit}' has the unknown symbol '{symbol}'")]
    UnknownSymbol { unit: String, symbol: String },
    /// More than one `/`, which makes the order of operations ambiguous.
    #[error("unit '{unit}' has more than one '/'")]
    SeveralSlashes { unit: String },
}

impl BaseUnit {
    /// Symbols of the exponents, as in the XML.
    pub const SYMBOLS: [&'static str; 8] = ["kg", "m", "s", "A", "K", "mol", "cd", "rad"];
}

/// Coherent derived units in powers of kg, m, s (BIPM, The International System of Units, 9th ed., 2019, table 4).
const DERIVED: [(&str, [i32; 3]); 5] =
    [("N", [1, 1, -2]), ("Pa", [1, -1, -2]), ("J", [1, 2, -2]), ("W", [1, 2, -3]), ("Hz", [0, 0, -1])];

/// Units that are not coherent, with the coherent unit and their value in it.
const SCALED: [(&str, &str, f64); 3] = [("us", "s", 1e-6), ("rpm", "rad/s", PI / 30.0), ("%", "1", 0.01)];

impl Unit {
    /// Reads a unit: symbols with integer exponents, `.` between factors, at most one `/`, and `1` for no unit; or
    /// `us`, `rpm`, `%`.
    ///
    /// ```
    /// let unit = squid_model_description::Unit::parse("kg.m2/s").unwrap();
    /// assert_eq!(unit.base.exponents[..3], [1, 2, -1]);
    /// ```
    pub fn parse(name: &str) -> Result<Self, UnitError> {
        if let Some((_, coherent, factor)) = SCALED.into_iter().find(|(known, ..)| *known == name) {
            return Ok(Self {
                name: name.to_owned(),
                factor,
                display_units: Vec::new(),
                ..Self::parse(coherent)?
            });
        }
        let mut parts = name.split('/');
        let (numerator, denominator) = (parts.next().unwrap_or_default(), parts.next());
        if parts.next().is_some() {
            return Err(UnitError::SeveralSlashes { unit: name.to_owned() });
        }
        let mut base = BaseUnit::default();
        base.multiply(name, numerator, 1)?;
        if let Some(denominator) = denominator {
            base.multiply(name, denominator, -1)?;
        }
        let display_units = display_units(name, base);
        Ok(Self { name: name.to_owned(), base, factor: 1.0, display_units })
    }

    /// Returns the attributes of the element `BaseUnit`: the powers that are not zero, and a factor that is not 1.
    pub fn in_base_units(&self) -> Vec<(&'static str, String)> {
        let powers = BaseUnit::SYMBOLS.into_iter().zip(self.base.exponents).filter(|(_, power)| *power != 0);
        let factor = (self.factor != 1.0).then(|| ("factor", number(self.factor)));
        powers.map(|(symbol, power)| (symbol, power.to_string())).chain(factor).collect()
    }
}

impl BaseUnit {
    fn multiply(&mut self, unit: &str, product: &str, sign: i32) -> Result<(), UnitError> {
        for factor in product.split('.') {
            let digits = factor.find(|c: char| c == '-' || c.is_ascii_digit());
            let (symbol, exponent) = factor.split_at(digits.unwrap_or(factor.len()));
            let unknown = || UnitError::UnknownSymbol { unit: unit.to_owned(), symbol: factor.to_owned() };
            if factor == "1" {
                continue;
            }
            let power = match exponent {
                "" => 1,
                digits => digits.parse::<i8>().map(i32::from).map_err(|_| unknown())?,
            };
            if let Some(position) = Self::SYMBOLS.iter().position(|&known| known == symbol) {
                self.exponents[position] += sign * power;
            } else {
                let derived = DERIVED.iter().find(|(known, _)| *known == symbol).ok_or_else(unknown)?;
                for (own, of_derived) in self.exponents.iter_mut().zip(derived.1) {
                    *own += sign * power * of_derived;
                }
            }
        }
        Ok(())
    }
}

/// Returns the display unit in degrees, if the unit contains radians to the first power.
fn display_units(name: &str, base: BaseUnit) -> Vec<DisplayUnit> {
    let power = base.exponents[7];
    if power.abs() != 1 || name.matches("rad").count() != 1 {
        return Vec::new();
    }
    vec![DisplayUnit { name: name.replacen("rad", "deg", 1), factor: (180.0 / PI).powi(power) }]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_base_and_derived_units() {
        for (name, expected) in [
            ("rad", [0, 0, 0, 0, 0, 0, 0, 1]),
            ("1", [0; 8]),
            ("m/s", [0, 1, -1, 0, 0, 0, 0, 0]),
            ("N.m", [1, 2, -2, 0, 0, 0, 0, 0]),
            ("kg.m2/s2", [1, 2, -2, 0, 0, 0, 0, 0]),
            ("1/s", [0, 0, -1, 0, 0, 0, 0, 0]),
            ("kg/m.s", [1, -1, -1, 0, 0, 0, 0, 0]),
            ("m.s-2", [0, 1, -2, 0, 0, 0, 0, 0]),
        ] {
            assert_eq!(Unit::parse(name).unwrap().base.exponents, expected, "{name}");
        }
    }

    #[test]
    fn reads_units_that_are_not_coherent() {
        for (name, power, factor) in
            [("us", [1, 0], 1e-6), ("rpm", [-1, 1], 2.0 * PI / 60.0), ("%", [0, 0], 0.01)]
        {
            let unit = Unit::parse(name).unwrap();
            assert_eq!([unit.base.exponents[2], unit.base.exponents[7]], power, "{name}");
            assert!(
                (unit.factor - factor).abs() < 1e-15 && unit.display_units.is_empty() && unit.name == name
            );
        }
        assert_eq!(Unit::parse("N").unwrap().factor, 1.0);
    }

    #[test]
    fn rejects_unknown_units() {
        for name in ["furlong", "m/s/s", "m2x", "", "m."] {
            assert!(Unit::parse(name).is_err(), "{name}");
        }
    }

    #[test]
    fn displays_radians_in_degrees() {
        let rate = Unit::parse("rad/s").unwrap();
        assert_eq!(rate.display_units[0].name, "deg/s");
        assert_eq!(rate.display_units[0].factor * PI, 180.0);
        let per_radian = Unit::parse("N/rad").unwrap();
        assert_eq!(per_radian.display_units[0].name, "N/deg");
        assert!((per_radian.display_units[0].factor - PI / 180.0).abs() < 1e-16);
        assert!(Unit::parse("m").unwrap().display_units.is_empty());
    }
}
