//! Optional section `[surge]` of a vehicle file, for a given speed.

use std::collections::BTreeMap;

use crate::toml_file::Table;
use crate::vehicle::allowed::Allowed;
use crate::vehicle::surge::Surge;

/// Name of the section.
pub(super) const SECTION: &str = "surge";

const LAG: &str = "lag";

/// Default time constant of a given speed \[s\].
const DEFAULT_LAG: f64 = 1.0;

/// Tables, and keys of other tables, of a vehicle with an equation of surge only.
const TABLES: [&str; 3] = ["thruster", "thruster_group", "drag"];
const KEYS: [(&str, &str); 2] = [("damping", "X_u"), ("control_surface", "X_uu_delta2")];

const LEFT_OUT: &str = "omitted if surge.speed is \"given\", because nothing else then acts on the speed";

/// Reads the section, if present, and refuses entries without meaning for a given speed.
pub(super) fn read(root: &Table<'_>, sources: &mut BTreeMap<String, String>) -> Surge {
    let Some(table) = root.table(SECTION) else { return Surge::Free };
    table.allow_only(&["speed", LAG]);
    table.one_of("speed", &["given"]);
    let mut lag = DEFAULT_LAG;
    if table.has(LAG)
        && let Some(found) = table.quantity(LAG, &["s"], Allowed::Positive)
    {
        lag = found.si();
        sources.insert(format!("{SECTION}.{LAG}"), found.source);
    }
    for key in TABLES.into_iter().filter(|key| root.has(key)) {
        root.not_allowed(key, "given", LEFT_OUT);
    }
    for (section, key) in KEYS {
        let tables = if section == "damping" {
            root.table(section).into_iter().collect()
        } else {
            root.tables(section)
        };
        tables
            .iter()
            .filter(|table| table.has(key))
            .for_each(|table| table.not_allowed(key, "given", LEFT_OUT));
    }
    Surge::Given { lag }
}
