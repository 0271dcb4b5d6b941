//! Reads the default manoeuvre: the table `[manoeuvre]`.

use crate::inputs::design_file::values::{ROUNDING, angle};
use auv::toml_file::Table;
use auv::{number, rounded};
use scheduled::{MANOEUVRE_FORMAT, Manoeuvre};
use std::f64::consts::FRAC_PI_2;

/// Time from the end of the flight to the end of the step of the default manoeuvre, s.
const NEVER: f64 = 1e6;

/// The limits of the design on a manoeuvre; `None` for those that could not be read.
pub(super) struct Limits {
    /// The range of speed, m/s.
    pub speeds: Option<(f64, f64)>,
    /// The largest pitch reference of the design, rad; `None` if pitch is not tracked.
    pub pitch: Option<f64>,
    /// The largest depth reference of the design, m; `None` if depth is not tracked.
    pub depth: Option<f64>,
    /// The longest flight, s.
    pub duration: Option<f64>,
}

impl Limits {
    /// The default manoeuvre: a step of at most the scale, at speeds in the range of the design.
    pub fn manoeuvre(&self, table: &Table<'_>) -> Option<Manoeuvre> {
        table.allow_only(&[
            "pitch_step",
            "unit",
            "depth_step",
            "step_time",
            "speed_from",
            "speed_to",
            "ramp_start",
            "ramp_duration",
            "duration",
        ]);
        // A design that tracks neither has a pitch step, because its FMU has that parameter.
        let pitch_step = if self.pitch.is_some() || self.depth.is_none() {
            angle(table).and_then(|factor| self.pitch_step(table, factor))
        } else {
            no_step(table, &["pitch_step", "unit"], "pitch")
        };
        let depth_step = match self.depth {
            Some(scale) => depth_step(table, scale),
            None => no_step(table, &["depth_step"], "depth"),
        };
        let most = self.duration.unwrap_or(f64::INFINITY);
        let words = format!("above 0 and at most {} (s), a million sample times", number(most));
        let duration = table.number("duration", |v| v > 0.0 && v <= most, &words);
        let end = duration.unwrap_or(f64::INFINITY);
        let before = "0 or more, and before the end of the flight (s)";
        let step_time = table.number("step_time", |v| v >= 0.0 && v < end, before);
        let (speed_from, speed_to) = (self.speed(table, "speed_from"), self.speed(table, "speed_to"));
        let ramp_start = table.number("ramp_start", |v| v >= 0.0, "0 or more (s)");
        let ramp_duration = table.number("ramp_duration", |v| v > 0.0, "above 0 (s)");
        Some(Manoeuvre {
            format: MANOEUVRE_FORMAT.into(),
            pitch_step: pitch_step?,
            depth_step: depth_step?,
            step_time: step_time?,
            step_end: duration? + NEVER,
            speed_from: speed_from?,
            speed_to: speed_to?,
            ramp_start: ramp_start?,
            ramp_duration: ramp_duration?,
            duration: duration?,
        })
    }

    fn pitch_step(&self, table: &Table<'_>, factor: f64) -> Option<f64> {
        let Some(scale) = self.pitch.filter(|scale| *scale < FRAC_PI_2) else {
            let words = "other than 0 and below a right angle";
            let step = table.number("pitch_step", |v| v != 0.0 && (v * factor).abs() < FRAC_PI_2, words);
            return step.map(|step| factor * step);
        };
        let unit = if factor == 1.0 { "rad" } else { "deg" };
        let words = format!(
            "other than 0 and at most {} {unit} in size, the 'scale' of pitch: the largest reference that the \
                design is made for",
            rounded(scale / factor)
        );
        let allowed = |v: f64| v != 0.0 && (v * factor).abs() <= scale * (1.0 + ROUNDING);
        table.number("pitch_step", allowed, &words).map(|step| factor * step)
    }

    fn speed(&self, table: &Table<'_>, key: &str) -> Option<f64> {
        let (low, high) = self.speeds.unwrap_or((f64::MIN, f64::MAX));
        let words = match self.speeds {
            Some(_) => format!("from {} to {} (m/s), the range of the design", number(low), number(high)),
            None => "within the range of the design (m/s)".into(),
        };
        table.number(key, |v| (low..=high).contains(&v), &words)
    }
}

/// A step of 0 for an output that is not tracked; its keys must be absent.
fn no_step(table: &Table<'_>, keys: &[&str], output: &str) -> Option<f64> {
    let given = keys.iter().find(|key| table.has(key));
    given.iter().for_each(|key| {
        table.not_allowed(key, "given", format!("left out, since no [[track]] has the output '{output}'"));
    });
    given.is_none().then_some(0.0)
}

/// The step of the depth \[m\], at most its scale.
fn depth_step(table: &Table<'_>, scale: f64) -> Option<f64> {
    let words = format!(
        "other than 0 and at most {} (m) in size, the 'scale' of depth: the largest reference that the design is made \
         for",
        rounded(scale)
    );
    table.number("depth_step", |v| v != 0.0 && v.abs() <= scale * (1.0 + ROUNDING), &words)
}
