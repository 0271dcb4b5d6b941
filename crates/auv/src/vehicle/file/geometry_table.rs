//! Optional section `[geometry]` of a vehicle file: the size of the hull.

use std::collections::BTreeMap;

use crate::text::number;
use crate::toml_file::Table;
use crate::vehicle::allowed::Allowed;
use crate::vehicle::geometry::Geometry;

/// Name of the section.
pub(super) const SECTION: &str = "geometry";

/// Reads the section, if present.
pub(super) fn read(root: &Table<'_>, sources: &mut BTreeMap<String, String>) -> Option<Geometry> {
    let table = root.table(SECTION)?;
    table.allow_only(&["length", "diameter"]);
    let mut quantity = |key: &str, meaning: &str| {
        let present = table.requires(key, meaning);
        let found = present.then(|| table.quantity(key, &["m"], Allowed::Positive)).flatten()?;
        sources.insert(format!("{SECTION}.{key}"), found.source);
        Some(found.value)
    };
    let length = quantity("length", "the length of the hull (m)");
    let diameter = quantity("diameter", "the largest diameter of the hull (m)");
    let (length, diameter) = (length?, diameter?);
    let geometry = Geometry::new(length, diameter);
    if geometry.is_none() {
        table.not_allowed("diameter", format!("{} m", number(diameter)), Geometry::ALLOWED);
    }
    geometry
}
