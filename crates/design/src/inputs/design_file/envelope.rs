//! Section `[envelope]`: the limits of the references.

use crate::inputs::design_file::values::{angle, within};
use crate::inputs::design_file::{Envelope, Range};
use squid_auv::number;
use squid_auv::toml_file::Table;

/// Fraction of an actuator's limits.
const AUTHORITY: Range =
    Range { least: 0.1, most: 1.0, text: "from 0.1 to 1, as a fraction of the limits of each actuator" };

/// Largest pitch reference, deg: Euler angles and the planar model break down near 90.
const STEEPEST: f64 = 60.0;

/// Fastest turn of a reference, deg/s.
const FASTEST: f64 = 90.0;

impl Envelope {
    /// Reads the section of an axis of heading.
    pub(super) fn of_heading(table: &Table<'_>) -> Option<Self> {
        table.allow_only(&["turn_rate", "unit"]);
        let factor = if table.has("turn_rate") { angle(table) } else { Some(1.0) };
        let default = Self::default();
        let turn_rate = table.or("turn_rate", Some(default.turn_rate), |table, key| {
            let allowed = |v: f64| v > 0.0 && factor.is_none_or(|factor| v * factor <= FASTEST.to_radians());
            let allowed_text = "above 0, at most 90 deg (heading rate, per second)";
            Some(factor.map(|factor| factor * table.number(key, allowed, allowed_text).unwrap_or(f64::NAN)))
        });
        Some(Self { turn_rate: turn_rate?.filter(|rate| !rate.is_nan())?, ..default })
    }

    pub(super) fn of(table: &Table<'_>) -> Option<Self> {
        table.allow_only(&["authority", "pitch", "path_angle", "unit"]);
        let default = Self::default();
        let authority = table.or("authority", default.authority, |table, key| within(table, key, AUTHORITY));
        let factor = if table.has("pitch") || table.has("path_angle") { angle(table) } else { Some(1.0) };
        let steep = move |v: f64| factor.is_none_or(|factor| (v * factor).abs() <= STEEPEST.to_radians());
        let pitch = table.or("pitch", Some(default.pitch), |table, key| {
            let allowed_text = "the range [least, largest] of pitch references, each of a magnitude of at most 60 \
                deg";
            let numbers = table.numbers(key, allowed_text)?;
            match numbers.as_slice() {
                [least, most] if least <= most && steep(*least) && steep(*most) => {
                    Some(factor.map(|factor| [least * factor, most * factor]))
                }
                _ => {
                    let found: Vec<String> = numbers.into_iter().map(number).collect();
                    table.not_allowed(key, format!("[{}]", found.join(", ")), allowed_text);
                    None
                }
            }
        });
        let path_angle = table.or("path_angle", Some(default.path_angle), |table, key| {
            let path_angle = table.number(key, |v| v > 0.0 && steep(v), "above 0, at most 60 deg")?;
            Some(factor.map(|factor| factor * path_angle))
        });
        Some(Self { authority: authority?, pitch: pitch??, path_angle: path_angle??, ..default })
    }
}
