//! Optional section `[hull]` of a vehicle file: stations and drag coefficient for cross-flow drag.

use std::collections::BTreeMap;

use crate::toml_file::Table;
use crate::vehicle::hull::Hull;

/// Name of the section.
pub(super) const SECTION: &str = "hull";
/// Key in addition to the coefficients.
pub(super) const STATIONS: &str = "stations";

/// Reads the stations of the section.
pub(super) fn read(table: &Table<'_>, sources: &mut BTreeMap<String, String>) -> Option<Hull> {
    table.requires("C_d", "the drag coefficient of the sections in cross flow");
    let meaning = "a table { value = [[x, breadth], ...], unit = \"m\", source = \"...\" }";
    let stations = table.requires(STATIONS, meaning).then(|| table.table(STATIONS)).flatten()?;
    stations.allow_only(&["value", "unit", "source"]);
    let pairs = stations.pairs("value", Hull::ALLOWED);
    let unit = stations.one_of("unit", &["m"]);
    let source = stations.text("source");
    let (pairs, _, source) = (pairs?, unit?, source?);
    let hull = Hull::new(&pairs);
    match hull {
        Some(_) => _ = sources.insert(STATIONS.to_owned(), source),
        None => stations.not_allowed("value", "not in order", Hull::ALLOWED),
    }
    hull
}
