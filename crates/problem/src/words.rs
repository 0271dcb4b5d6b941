//! Numbers as people read them: a bound from above is rounded up, one from below down.

/// Six digits, rounded by `round`.
pub fn digits(value: f64, round: fn(f64) -> f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return value.to_string();
    }
    let places = 5.0 - value.abs().log10().floor();
    let scale = 10f64.powf(places);
    let rounded = round(value * scale) / scale;
    match (-3.0..=9.0).contains(&places) {
        true => format!("{rounded:.*}", places.max(0.0) as usize),
        false => format!("{rounded:.5e}"),
    }
}

/// A bound from above, if it is known.
pub fn at_most(bound: Option<f64>) -> String {
    bound.map_or_else(|| "unknown".into(), |v| digits(v, f64::ceil))
}
