//! Numbers in C, written and parsed without loss.

/// The type of all numbers of a source.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Real {
    /// IEEE 754 binary64.
    Double,
    /// IEEE 754 binary32.
    Float,
}

impl Real {
    /// Both types, the default first.
    pub const ALL: [Real; 2] = [Real::Double, Real::Float];

    /// Returns the name in C.
    pub fn name(self) -> &'static str {
        match self {
            Self::Double => "double",
            Self::Float => "float",
        }
    }

    /// Returns the suffix of literals.
    pub(crate) fn suffix(self) -> &'static str {
        match self {
            Self::Double => "",
            Self::Float => "f",
        }
    }

    /// Returns the nearest number of this type.
    pub(crate) fn nearest(self, value: f64) -> f64 {
        match self {
            Self::Double => value,
            Self::Float => f64::from(value as f32),
        }
    }

    /// Returns the distance from 1 to the next larger number.
    pub(crate) fn epsilon(self) -> f64 {
        match self {
            Self::Double => f64::EPSILON,
            Self::Float => f64::from(f32::EPSILON),
        }
    }

    /// Formats the nearest number as a hexadecimal literal, which no compiler rounds.
    pub(crate) fn literal(self, value: f64) -> String {
        format!("{}{}", hexadecimal(self.nearest(value)), self.suffix())
    }

    /// Formats literals separated by commas.
    pub(crate) fn list(self, values: impl IntoIterator<Item = f64>) -> String {
        values.into_iter().map(|value| self.literal(value)).collect::<Vec<_>>().join(", ")
    }
}

const MANTISSA_BITS: u32 = f64::MANTISSA_DIGITS - 1;
const BIAS: i64 = f64::MAX_EXP as i64 - 1;

/// Formats a finite number according to C99, section 6.4.4.2: `-0x1.8p+1`.
fn hexadecimal(value: f64) -> String {
    let bits = value.to_bits();
    let sign = if value.is_sign_negative() { "-" } else { "" };
    let (exponent, mantissa) = ((bits >> MANTISSA_BITS) & 0x7ff, bits & ((1 << MANTISSA_BITS) - 1));
    if exponent == 0 && mantissa == 0 {
        return format!("{sign}0.0");
    }
    // Subnormal numbers have no leading one and the smallest exponent.
    let (lead, power) = if exponent == 0 { (0, 1 - BIAS) } else { (1, exponent as i64 - BIAS) };
    let digits = format!("{mantissa:013x}");
    let digits = digits.trim_end_matches('0');
    let point = if digits.is_empty() { "" } else { "." };
    format!("{sign}0x{lead}{point}{digits}p{power:+}")
}

/// Parses an unsigned number of C into value and suffix; `None` if the text is not a number.
pub(crate) fn parse(text: &str) -> Option<(f64, &str)> {
    let Some(hex) = text.strip_prefix("0x").filter(|hex| hex.contains('p')) else {
        let end = text.trim_end_matches(|c: char| c.is_ascii_alphabetic());
        return end.parse().ok().map(|value| (value, &text[end.len()..]));
    };
    let (digits, power) = hex.split_once('p')?;
    let number = power.trim_end_matches(|c: char| c.is_ascii_alphabetic());
    let (integer, fraction) = digits.split_once('.').unwrap_or((digits, ""));
    let mantissa = u64::from_str_radix(&format!("{integer}{fraction}"), 16).ok()?;
    let shift: i32 = number.parse().ok()?;
    // Two steps, because the power alone may underflow; each is exact for the literals written here.
    let value = mantissa as f64 * 16f64.powi(-(fraction.len() as i32));
    let half = shift / 2;
    Some((value * 2f64.powi(half) * 2f64.powi(shift - half), &power[number.len()..]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn literals_follow_the_standard() {
        let shown = [1.0, -3.0, 0.1, -0.0, 5e-324, f64::MAX].map(|value| Real::Double.literal(value));
        assert_eq!(
            shown,
            [
                "0x1p+0",
                "-0x1.8p+1",
                "0x1.999999999999ap-4",
                "-0.0",
                "0x0.0000000000001p-1022",
                "0x1.fffffffffffffp+1023"
            ]
        );
        assert_eq!(Real::Float.literal(0.1), "0x1.99999ap-4f");
        assert_eq!(parse("7u"), Some((7.0, "u")));
        assert_eq!([parse("x"), parse("0xp"), parse("0x1p")], [None, None, None]);
    }

    proptest! {
        #[test]
        fn literals_parse_to_their_number(value in proptest::num::f64::ANY.prop_filter("finite", |v| v.is_finite())) {
            let value = value.abs();
            let literal = Real::Double.literal(value);
            prop_assert_eq!(parse(&literal), Some((value, "")));
            let narrow = f64::from(value as f32);
            if narrow.is_finite() {
                let literal = Real::Float.literal(value);
                prop_assert_eq!(parse(&literal), Some((narrow, "f")));
            }
        }
    }
}
