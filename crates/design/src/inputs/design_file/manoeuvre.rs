//! Reads the default manoeuvre: the table `[manoeuvre]`.

use crate::inputs::design_file::Tracked;
use crate::inputs::design_file::values::{ROUNDING, angle};
use squid_auv::toml_file::Table;
use squid_auv::{number, rounded};
use squid_scheduled::{MANOEUVRE_FORMAT, Manoeuvre};
use squid_signals::{Interface, Level, Signal};
use std::collections::BTreeMap;
use std::f64::consts::FRAC_PI_2;

/// Time from the end of the flight to the end of the step of the default manoeuvre, s.
const NEVER: f64 = 1e6;

/// Limits of the design on a manoeuvre; `None` for those that could not be read.
pub(super) struct Limits<'a> {
    /// Range of speed, m/s.
    pub speeds: Option<(f64, f64)>,
    /// States and signals of the axis.
    pub interface: &'static Interface,
    /// Tracked outputs, whose scales are the largest references.
    pub tracked: &'a [Tracked],
    /// Longest flight, s.
    pub duration: Option<f64>,
}

impl Limits<'_> {
    /// Reads the default manoeuvre: a step of at most the scale, at speeds in the range of the design.
    pub fn manoeuvre(&self, table: &Table<'_>) -> Option<Manoeuvre> {
        let steps = self.steps();
        let keys: Vec<String> = steps.iter().map(|signal| format!("{}_step", signal.name)).collect();
        let mut allowed: Vec<&str> = keys.iter().map(String::as_str).collect();
        allowed.extend([
            "unit",
            "step_time",
            "speed_from",
            "speed_to",
            "ramp_start",
            "ramp_duration",
            "duration",
        ]);
        table.allow_only(&allowed);
        let scale =
            |signal: &Signal| self.tracked.iter().find(|t| t.signal.name == signal.name).map(|t| t.scale);
        // A design that tracks no signal steps the first one, because its FMU has that parameter.
        let none = steps.iter().all(|signal| scale(signal).is_none());
        let flown: Vec<bool> =
            steps.iter().enumerate().map(|(i, signal)| scale(signal).is_some() || (none && i == 0)).collect();
        let mut heights = BTreeMap::new();
        let mut complete = true;
        for ((signal, key), flown) in steps.iter().zip(&keys).zip(&flown) {
            let height =
                if *flown { step(table, key, signal, scale(signal)) } else { no_step(table, key, signal) };
            complete &= height.is_some();
            heights.extend(height.filter(|_| *flown).map(|height| (signal.name.to_owned(), height)));
        }
        let mut angles = steps.iter().zip(&flown).filter(|(signal, _)| signal.unit == "rad");
        if let Some((signal, _)) = angles.clone().next().filter(|_| !angles.any(|(_, flown)| *flown)) {
            complete &= no_step(table, "unit", signal).is_some();
        }
        let most = self.duration.unwrap_or(f64::INFINITY);
        let allowed_text = format!("above 0 and at most {} (s), one million samples", number(most));
        let duration = table.number("duration", |v| v > 0.0 && v <= most, &allowed_text);
        let end = duration.unwrap_or(f64::INFINITY);
        let step_time_text = "at least 0 and before the end of the manoeuvre (s)";
        let step_time = table.number("step_time", |v| v >= 0.0 && v < end, step_time_text);
        let (speed_from, speed_to) = (self.speed(table, "speed_from"), self.speed(table, "speed_to"));
        let ramp_start = table.number("ramp_start", |v| v >= 0.0, "at least 0 (s)");
        let ramp_duration = table.number("ramp_duration", |v| v > 0.0, "above 0 (s)");
        Some(Manoeuvre {
            format: MANOEUVRE_FORMAT.into(),
            steps: complete.then_some(heights)?,
            step_time: step_time?,
            step_end: duration? + NEVER,
            speed_from: speed_from?,
            speed_to: speed_to?,
            ramp_start: ramp_start?,
            ramp_duration: ramp_duration?,
            duration: duration?,
        })
    }

    /// Signals that can step: those that can be tracked, besides the scheduled one.
    fn steps(&self) -> Vec<&'static Signal> {
        let steps = self.interface.tracked().map(|(signal, _)| signal);
        steps.filter(|signal| signal.level != Level::Scheduled).collect()
    }

    fn speed(&self, table: &Table<'_>, key: &str) -> Option<f64> {
        let (low, high) = self.speeds.unwrap_or((f64::MIN, f64::MAX));
        let allowed_text = match self.speeds {
            Some(_) => {
                format!("from {} to {} (m/s), the speed range of the design", number(low), number(high))
            }
            None => "within the speed range of the design (m/s)".into(),
        };
        table.number(key, |v| (low..=high).contains(&v), &allowed_text)
    }
}

/// Step of 0 for an output that is not tracked; its key must be absent.
fn no_step(table: &Table<'_>, key: &str, signal: &Signal) -> Option<f64> {
    if table.has(key) {
        let allowed_text = format!("omitted, because no [[track]] has the output '{}'", signal.name);
        table.not_allowed(key, "given", allowed_text);
        return None;
    }
    Some(0.0)
}

/// Step of a signal, SI: an angle in the unit of the table, at most its scale and within its range.
fn step(table: &Table<'_>, key: &str, signal: &Signal, scale: Option<f64>) -> Option<f64> {
    let factor = if signal.unit == "rad" { angle(table)? } else { 1.0 };
    let [_, most] = signal.range.unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
    let Some(scale) = scale.filter(|scale| *scale < most) else {
        let (limit, unit) = (rounded(most / factor), unit(signal, factor));
        let allowed_text = match most {
            FRAC_PI_2 => "other than 0 and of a magnitude below 90 deg".to_owned(),
            f64::INFINITY => "other than 0".to_owned(),
            _ => format!("other than 0 and of a magnitude below {limit} {unit}"),
        };
        return table
            .number(key, |v| v != 0.0 && (v * factor).abs() < most, &allowed_text)
            .map(|step| factor * step);
    };
    let shown = match unit(signal, factor) {
        unit @ ("deg" | "rad") => format!("{} {unit}", rounded(scale / factor)),
        unit => format!("{} ({unit})", rounded(scale / factor)),
    };
    let allowed_text = format!(
        "other than 0 and of a magnitude of at most {shown}, the 'scale' of {}, which is the largest reference of \
         the design",
        signal.name
    );
    let allowed = |v: f64| v != 0.0 && (v * factor).abs() <= scale * (1.0 + ROUNDING);
    table.number(key, allowed, &allowed_text).map(|step| factor * step)
}

/// Unit of a step with a factor to SI.
fn unit(signal: &Signal, factor: f64) -> &'static str {
    if signal.unit == "rad" && factor != 1.0 { "deg" } else { signal.unit }
}
