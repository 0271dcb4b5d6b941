//! Rounded numbers for terminal output: an upper bound is rounded up, a lower bound down.

/// Six significant digits, rounded by `round`; all digits of a number that is too large or too small for that.
pub fn digits(value: f64, round: fn(f64) -> f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return value.to_string();
    }
    let places = 5.0 - value.abs().log10().floor();
    let scale = 10f64.powf(places);
    let rounded = round(value * scale) / scale;
    if (-3.0..=9.0).contains(&places) {
        format!("{rounded:.*}", places.max(0.0) as usize)
    } else if rounded.is_normal() {
        format!("{rounded:.5e}")
    } else {
        format!("{value:e}")
    }
}

/// An upper bound, if it is known.
pub fn at_most(bound: Option<f64>) -> String {
    bound.map_or_else(|| "unknown".into(), |v| digits(v, f64::ceil))
}

/// A lower bound.
pub fn at_least(bound: f64) -> String {
    digits(bound, f64::floor)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rounded_bound_is_still_a_bound() {
        for (value, expected) in [
            (0.560_244_39, "0.560245"),
            (2.240_977_5, "2.24098"),
            (1.234_561e-8, "1.23457e-8"),
            (1.234_561e12, "1.23457e12"),
            (f64::MIN_POSITIVE / 8.0, "2.781342323134e-309"),
            (f64::MAX, "1.7976931348623157e308"),
        ] {
            let found = digits(value, f64::ceil);
            assert_eq!(found, expected);
            assert!(found.parse::<f64>().unwrap() >= value);
        }
        assert_eq!(at_most(None), "unknown");
    }
}
