//! Numbers formatted for people: rounded, with a unit, or text for a missing number.

/// Formats a number with `digits` decimals, and 0 instead of -0; with an exponent from 10^15 on, where f64 has no
/// decimals.
pub fn decimals(v: f64, digits: usize) -> String {
    if v.is_finite() && v.abs() >= 1e15 {
        return format!("{v:.digits$e}");
    }
    let text = format!("{v:.digits$}");
    let is_zero = text.bytes().all(|b| matches!(b, b'-' | b'0' | b'.'));
    if is_zero { text.trim_start_matches('-').into() } else { text }
}

/// Formats an upper bound with four decimals, rounded up so that the displayed value is still a bound.
pub fn above(bound: f64) -> String {
    format!("{:.4}", rounded_up(bound))
}

/// Returns an upper bound as [`above`] displays it.
pub fn rounded_up(bound: f64) -> f64 {
    const DECIMALS: f64 = 1e4;
    let up = (bound * DECIMALS).ceil() / DECIMALS;
    if up.is_finite() { up } else { bound }
}

/// Formats a number rounded down to two significant digits.
pub fn rounded_down(v: f64) -> String {
    let unit = 10f64.powf(v.log10().floor() - 1.0);
    format!("{:.*}", (1.0 - v.log10().floor()).max(0.0) as usize, (v / unit).floor() * unit)
}

/// Formats a number like [`decimals`], without trailing zeros.
pub fn tidy(v: f64, digits: usize) -> String {
    let text = decimals(v, digits);
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').into() } else { text }
}

/// Formats a fraction in percent, with `digits` decimals.
pub fn percent(fraction: f64, digits: usize) -> String {
    format!("{} %", decimals(100.0 * fraction, digits))
}

/// Formats a figure that may be unknown (NaN) or never reached (infinite).
pub fn known(v: f64, digits: usize) -> String {
    match v {
        v if v.is_nan() => "-".into(),
        v if v.is_infinite() => "never".into(),
        v => decimals(v, digits),
    }
}

/// Formats six significant digits, rounded by `round`; all digits if the rounded value is subnormal or overflows.
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

/// Formats an upper bound, or `unknown`.
pub fn at_most(bound: Option<f64>) -> String {
    bound.map_or_else(|| "unknown".into(), |v| digits(v, f64::ceil))
}

/// Formats a lower bound.
pub fn at_least(bound: f64) -> String {
    digits(bound, f64::floor)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keeps_two_digits() {
        assert_eq!([0.0112, 0.999, 1.26, 0.000541].map(rounded_down), ["0.011", "0.99", "1.2", "0.00054"]);
    }

    #[test]
    fn zero_has_no_sign() {
        let shown = [-0.00004, -0.0, 0.0, -0.00006, -12.5].map(|v| decimals(v, 4));
        assert_eq!(shown, ["0.0000", "0.0000", "0.0000", "-0.0001", "-12.5000"]);
        assert_eq!(decimals(f64::NAN, 1), "NaN");
        assert_eq!([999e12, -2e301].map(|v| decimals(v, 1)), ["999000000000000.0", "-2.0e301"]);
    }

    #[test]
    fn rounded_bound_is_a_bound() {
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
