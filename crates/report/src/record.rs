//! Plot of a record.

use crate::page::{Kind, Line, Panel};
use squid_auv::Actuator;
use squid_flight::record::Record;

/// Returns panels of pitch, heading, roll, speed, commands and depth over time, if recorded, and of the track if the
/// heading is controlled. Commands are shown as actuator outputs, in one panel per unit.
pub fn panels(record: &Record, actuators: &[Actuator]) -> Vec<Panel> {
    let mapped = |name: &str, key: &str, kind: Kind, of: &dyn Fn(f64) -> f64| {
        let points = record.get("time")?.iter().zip(record.get(key)?).map(|(t, v)| (*t, of(*v))).collect();
        Some(Line { name: name.into(), points, kind })
    };
    let line = |name: &str, key: &str, factor: f64, kind: Kind| mapped(name, key, kind, &|v| factor * v);
    let panel = |label: &str, lines: Vec<Option<Line>>| {
        Panel::over_time(label, lines.into_iter().flatten().collect())
    };
    let commands = |unit: &str, factor: f64| {
        let of_unit = actuators.iter().filter(|a| a.unit() == unit);
        of_unit.map(|a| mapped(&a.name, &a.name, Kind::Own, &|v| factor * a.requested_output(v).0)).collect()
    };
    let deg = 1f64.to_degrees();
    let pitch = vec![
        line("reference", "pitch_reference_used", deg, Kind::Reference),
        line("pitch", "pitch", deg, Kind::Own),
    ];
    let heading = vec![
        line("reference", "heading_reference_used", deg, Kind::Reference),
        line("heading", "heading", deg, Kind::Own),
    ];
    let roll = vec![
        line("reference", "roll_reference_used", deg, Kind::Reference),
        line("roll", "roll", deg, Kind::Own),
    ];
    let speed_reference = line("reference", "speed_reference_used", 1.0, Kind::Reference);
    let speed = vec![speed_reference, line("forward speed", "speed", 1.0, Kind::Own)];
    let panels = [
        panel("pitch (deg)", pitch),
        panel("heading (deg)", heading),
        panel("roll (deg)", roll),
        panel("speed (m/s)", speed),
        panel("thrust (N)", commands("N", 1.0)),
        panel("deflection (deg)", commands("rad", deg)),
        panel(
            "depth (m)",
            vec![
                line("reference", "depth_reference_used", 1.0, Kind::Reference),
                line("depth", "depth", 1.0, Kind::Own),
            ],
        ),
        panel("surface (m)", vec![line("elevation", "wave_elevation", 1.0, Kind::Own)]),
        Panel::from_above(track(record).into_iter().collect()),
    ];
    panels.into_iter().filter(|panel| !panel.lines.is_empty()).collect()
}

/// Returns the track of a vehicle whose heading is controlled.
fn track(record: &Record) -> Option<Line> {
    record.get("heading_reference_used")?;
    let points = record.get("east")?.iter().copied().zip(record.get("north")?.iter().copied()).collect();
    Some(Line { name: "track".into(), points, kind: Kind::Own })
}
