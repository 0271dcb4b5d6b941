//! The section `[failsafe]`: what is flown when sensors fail.

use crate::inputs::design_file::values::within;
use crate::inputs::design_file::{Failsafe, Range, Safe};
use auv::toml_file::Table;

/// The time of a sensor that does not change.
const STALE: Range = Range { least: 0.0, most: 60.0, words: "from 0, for never, to 60 (s)" };

impl Failsafe {
    pub(super) fn of(table: &Table<'_>) -> Option<Self> {
        table.allow_only(&["stale_after", "safe"]);
        let Self { stale_after, safe } = Self::default();
        let stale_after = table.or("stale_after", stale_after, |table, key| within(table, key, STALE));
        let words: Vec<&str> = Safe::ALL.iter().map(|safe| safe.word()).collect();
        let safe = table.or("safe", safe, |table, key| Some(Safe::ALL[table.one_of(key, &words)?]));
        Some(Self { stale_after: stale_after?, safe: safe? })
    }
}
