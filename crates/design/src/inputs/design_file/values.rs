//! Readers of values common to several tables.

use crate::inputs::design_file::{FREQUENCY, RISE, Range};
use squid_auv::toml_file::Table;
use squid_lpv::weights::RisingWeight;

/// Relative tolerance of the limits of a step, a speed or a tick, for the rounding of units.
pub(super) const ROUNDING: f64 = 1e-9;

/// Reads a number in a range, in the unit of its key.
pub(super) fn within(table: &Table<'_>, key: &str, range: Range) -> Option<f64> {
    table.number(key, |v| range.allows(v), range.text)
}

/// Reads a weight `key` at low frequencies that rises by the factor `rise` above `corner`; both are given or neither.
pub(super) fn rising(table: &Table<'_>, key: &str, range: Range, unit: f64) -> Option<RisingWeight> {
    let low = within(table, key, range).map(|low| low * unit);
    if !table.has("rise") && !table.has("corner") {
        return low.map(RisingWeight::constant);
    }
    let (rise, corner) = (within(table, "rise", RISE), within(table, "corner", FREQUENCY));
    let (low, corner) = (low?, corner?);
    Some(RisingWeight { low, high: low * rise?, corner })
}

/// Reads the unit of the table and returns its factor to SI.
pub(super) fn angle(table: &Table<'_>) -> Option<f64> {
    table.one_of("unit", &["deg", "rad"]).map(|index| [1f64.to_radians(), 1.0][index])
}
