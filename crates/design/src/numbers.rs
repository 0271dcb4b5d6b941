//! Numbers formatted for people.

/// A number with `digits` decimals, and 0 rather than -0.
pub fn decimals(v: f64, digits: usize) -> String {
    let text = format!("{v:.digits$}");
    let is_zero = text.bytes().all(|b| matches!(b, b'-' | b'0' | b'.'));
    if is_zero { text.trim_start_matches('-').into() } else { text }
}

/// The factor from a unit to the displayed one, and the latter: degrees for radians.
pub fn readable(unit: &str) -> (f64, &str) {
    if unit == "rad" { (1f64.to_degrees(), "deg") } else { (1.0, unit) }
}

/// An upper bound for display: rounded up, so that the displayed value is a bound, too.
pub fn above(bound: f64) -> String {
    format!("{:.4}", rounded_up(bound))
}

/// An upper bound as [`above`] displays it.
pub fn rounded_up(bound: f64) -> f64 {
    const DECIMALS: f64 = 1e4;
    let up = (bound * DECIMALS).ceil() / DECIMALS;
    if up.is_finite() { up } else { bound }
}

/// A number rounded down to two significant digits.
pub fn rounded_down(v: f64) -> String {
    let unit = 10f64.powf(v.log10().floor() - 1.0);
    format!("{:.*}", (1.0 - v.log10().floor()).max(0.0) as usize, (v / unit).floor() * unit)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_digits_are_kept() {
        assert_eq!([0.0112, 0.999, 1.26, 0.000541].map(rounded_down), ["0.011", "0.99", "1.2", "0.00054"]);
    }

    #[test]
    fn zero_has_no_sign() {
        let shown = [-0.00004, -0.0, 0.0, -0.00006, -12.5].map(|v| decimals(v, 4));
        assert_eq!(shown, ["0.0000", "0.0000", "0.0000", "-0.0001", "-12.5000"]);
        assert_eq!(decimals(f64::NAN, 1), "NaN");
    }
}
