//! Section `[failsafe]`: the behaviour when sensors fail.

use crate::inputs::design_file::values::within;
use crate::inputs::design_file::{Failsafe, Range, Safe, SensorKeys};
use squid_auv::toml_file::Table;
use squid_signals::Signal;

/// Time without change after which a measurement counts as lost.
const STALE: Range = Range { least: 0.0, most: 60.0, text: "from 0 (never) to 60 (s)" };

/// Time between two values of a sensor.
const PERIOD: Range = Range { least: 0.0, most: 60.0, text: "from 0 (each tick) to 60 (s)" };

impl Failsafe {
    /// Reads the section; only signals that are `measured` may have a table of their sensor.
    pub(super) fn of(
        table: &Table<'_>,
        signals: &'static [Signal],
        is_measured: impl Fn(&Signal) -> bool,
    ) -> Option<Self> {
        let names = signals.iter().map(|signal| signal.name);
        table.allow_only(&["stale_after", "safe"].into_iter().chain(names).collect::<Vec<_>>());
        for signal in signals.iter().filter(|signal| table.has(signal.name) && !is_measured(signal)) {
            table.not_allowed(signal.name, "given", "omitted, because the controller does not measure it");
        }
        let Self { stale_after, safe, .. } = Self::default();
        let stale_after = table.or("stale_after", stale_after, |table, key| within(table, key, STALE));
        let choices: Vec<&str> = Safe::ALL.iter().map(|safe| safe.word()).collect();
        let safe = table.or("safe", safe, |table, key| Some(Safe::ALL[table.one_of(key, &choices)?]));
        let tables = signals.iter().filter_map(|signal| Some((signal, table.table(signal.name)?)));
        let sensors: Vec<Option<SensorKeys>> = tables.map(|(signal, table)| sensor(signal, &table)).collect();
        Some(Self {
            stale_after: stale_after?,
            safe: safe?,
            sensors: sensors.into_iter().collect::<Option<_>>()?,
        })
    }
}

/// Reads the table of a sensor.
fn sensor(signal: &'static Signal, table: &Table<'_>) -> Option<SensorKeys> {
    table.allow_only(&["resolution", "unit", "period"]);
    let resolution = if table.has("resolution") {
        let units: Vec<&str> = signal.units.iter().map(|unit| unit.name).collect();
        let unit = table.one_of("unit", &units);
        let resolution = table.number("resolution", |v| v >= 0.0 && v.is_finite(), "at least 0 (0 for none)");
        Some(resolution? * signal.units[unit?].factor)
    } else {
        None
    };
    Some(SensorKeys { signal, resolution, period: table.or("period", 0.0, |t, key| within(t, key, PERIOD))? })
}
