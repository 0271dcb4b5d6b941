//! Reads the tracked outputs and the measurements: the tables `[[track]]` and `[[measure]]`.

use crate::inputs::design_file::values::{rising, within};
use crate::inputs::design_file::{
    BANDWIDTH, DAMPING, FOLLOW, FREQUENCY, Measured, NOISE, PEAK, SCALE, Tracked,
};
use squid_auv::VIEWS;
use squid_auv::readable;
use squid_auv::toml_file::Table;
use squid_lpv::weights::{ReferenceModel, ReferenceWeight, TrackingWeight};
use squid_signals::{Interface, Level, Signal};

/// Relative tolerance of an angle for rounding.
const ROUNDING: f64 = 1e-9;

/// Reads the tracked outputs. They may have reference models if references and measurements are separate.
pub(super) fn tracked(
    root: &Table<'_>,
    interface: &'static Interface,
    separate: bool,
) -> Option<Vec<Tracked>> {
    if !root.requires("track", "the tracked outputs, one [[track]] for each") {
        return None;
    }
    let tables = root.tables("track");
    let mut used: Vec<usize> = Vec::new();
    let each: Vec<Option<Tracked>> =
        tables.iter().map(|table| track(table, interface, separate, &mut used)).collect();
    each.into_iter().collect()
}

fn track(
    table: &Table<'_>,
    interface: &'static Interface,
    separate: bool,
    used: &mut Vec<usize>,
) -> Option<Tracked> {
    let mut keys = vec!["output", "scale", "unit", "follow", "corner", "peak", "steady_error", "bandwidth"];
    keys.extend(separate.then_some(["frequency", "damping"]).into_iter().flatten());
    table.allow_only(&keys);
    let (index, signal, unit) = signal(table, "output", interface, used)?;
    let scale = within(table, "scale", SCALE).filter(|scale| is_possible_error(table, signal, unit * scale));
    let peak = within(table, "peak", PEAK);
    let steady_error = table.number("steady_error", |v| v > 0.0 && v < 1.0, "above 0 and below 1");
    let bandwidth = within(table, "bandwidth", BANDWIDTH);
    let references = references(table);
    let model = if separate { reference_model(table, signal) } else { Some(None) };
    Some(Tracked {
        index,
        signal,
        scale: unit * scale?,
        references: references?,
        weight: TrackingWeight { peak: peak?, steady_error: steady_error?, bandwidth: bandwidth? },
        model: model?,
    })
}

/// Checks that the unit of the error is in the range of the signal; records a mistake otherwise.
fn is_possible_error(table: &Table<'_>, signal: &Signal, scale: f64) -> bool {
    let [_, most] = signal.range.unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
    let allowed = scale <= most * (1.0 + ROUNDING);
    if !allowed {
        let Signal { name, unit, .. } = signal;
        let (factor, readable) = readable(unit);
        let (found, doubt) = match *unit {
            "rad" => {
                let degrees = squid_auv::rounded(scale * factor);
                (
                    format!("{} rad ({degrees} deg)", squid_auv::rounded(scale)),
                    " (is the angle in degrees, with the unit \"rad\"?)",
                )
            }
            _ => (format!("{} {unit}", squid_auv::rounded(scale)), ""),
        };
        let most = squid_auv::rounded(most * factor);
        table.not_allowed(
            "scale",
            found,
            format!("at most {most} {readable}, because it is the unit of the {name} error{doubt}"),
        );
    }
    allowed
}

/// Emphasis of slow references; neutral if not given.
fn references(table: &Table<'_>) -> Option<ReferenceWeight> {
    if !table.has("follow") && !table.has("corner") {
        return Some(ReferenceWeight { follow: 1.0, corner: 1.0 });
    }
    let (follow, corner) = (within(table, "follow", FOLLOW), within(table, "corner", FREQUENCY));
    Some(ReferenceWeight { follow: follow?, corner: corner? })
}

/// Reference model of an output. The model of the speed is of first order, because the trim moves with it.
fn reference_model(table: &Table<'_>, signal: &Signal) -> Option<Option<ReferenceModel>> {
    if signal.level == Level::Scheduled {
        let frequency = within(table, "frequency", FREQUENCY);
        if table.has("damping") {
            table.not_allowed(
                "damping",
                "given",
                "omitted for the speed, whose reference model is of first order",
            );
            return None;
        }
        return Some(Some(ReferenceModel { frequency: frequency?, damping: None }));
    }
    if !table.has("frequency") && !table.has("damping") {
        return Some(None);
    }
    let frequency = within(table, "frequency", FREQUENCY);
    let damping = table.or("damping", None, |table, key| within(table, key, DAMPING).map(Some));
    Some(Some(ReferenceModel { frequency: frequency?, damping: damping? }))
}

/// Reads the measurements; empty without such a table.
pub(super) fn measured(root: &Table<'_>, interface: &'static Interface) -> Option<Vec<Measured>> {
    let mut used: Vec<usize> = Vec::new();
    let each: Vec<Option<Measured>> =
        root.tables("measure").iter().map(|table| measure(table, interface, &mut used)).collect();
    each.into_iter().collect()
}

fn measure(table: &Table<'_>, interface: &'static Interface, used: &mut Vec<usize>) -> Option<Measured> {
    table.allow_only(&["signal", "scale", "unit", "noise", "rise", "corner"]);
    let (index, signal, unit) = signal(table, "signal", interface, used)?;
    let scale = within(table, "scale", SCALE);
    let noise = scale.and_then(|scale| rising(table, "noise", NOISE, 1.0 / scale));
    Some(Measured { index, signal, scale: unit * scale?, noise: noise? })
}

/// Index of a signal in the interface, the signal, and its unit in SI; each may be named once. Allowed are signals that
/// depend on the states of the axis, for an output also with a reference.
fn signal(
    table: &Table<'_>,
    key: &str,
    interface: &'static Interface,
    used: &mut Vec<usize>,
) -> Option<(usize, &'static Signal, f64)> {
    let is_allowed = |signal: &&Signal| {
        signal.is_among(interface.states) && (key != "output" || signal.reference.is_some())
    };
    let names = |of: &Interface| of.signals.iter().filter(is_allowed).map(|signal| signal.name);
    let mut allowed: Vec<&str> = names(interface).collect();
    if key == "output" && VIEWS.iter().any(|view| view.interface == interface) {
        let tracked = VIEWS.iter().flat_map(|view| view.interface.tracked());
        let mut others: Vec<&str> = vec![];
        for (Signal { name, .. }, _) in tracked {
            if !allowed.contains(name) && !others.contains(name) {
                others.push(name);
            }
        }
        if let Some(other) = others.iter().find(|name| table.is_text(key, name)) {
            let own = format!("in another [[axis]], because this one is of {}", allowed.join(", "));
            table.not_allowed(key, format!("\"{other}\""), own);
            return None;
        }
        allowed.extend(others);
    }
    let name = allowed[table.one_of(key, &allowed)?];
    let index = interface.index(name)?;
    if used.contains(&index) {
        table.not_allowed(key, format!("\"{name}\" again"), "listed only once");
        return None;
    }
    used.push(index);
    let signal = &interface.signals[index];
    let names: Vec<&str> = signal.units.iter().map(|unit| unit.name).collect();
    Some((index, signal, table.one_of("unit", &names).map(|unit| signal.units[unit].factor)?))
}
