//! Numbers formatted for people.

pub use base::numbers::{above, decimals, rounded_down, rounded_up};

/// The factor from a unit to the displayed one, and the latter: degrees for radians.
pub fn readable(unit: &str) -> (f64, &str) {
    if unit == "rad" { (1f64.to_degrees(), "deg") } else { (1.0, unit) }
}
