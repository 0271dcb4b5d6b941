//! Sampled loop as flown, frozen at a speed: margins, steps, a gust and noise.

use crate::error::Error;
use crate::page::{Chart, Curve, Figure, Key, Part, Table};
use crate::subject::Subject;
use squid_auv::Actuator;
use squid_auv::readable;
use squid_design::check::flown::{DURATION, Flown, GUST};
use squid_design::check::margins::Margins;
use squid_design::verdict::frozen::AtSpeed;

/// Row of the table.
struct Row {
    name: String,
    decimals: usize,
    /// `true` if the smallest value is the worst.
    least: bool,
    of: Box<dyn Fn(&Flown) -> f64>,
}

/// Returns the section on the loops as flown, frozen at speeds.
///
/// # Errors
/// Errors of trim, linearisation and freezing.
pub fn flown(subject: &Subject) -> Result<Vec<Part>, Error> {
    let frozen = &subject.verdict()?.found.frozen;
    let speeds: Vec<f64> = frozen.iter().map(|at| at.speed).collect();
    let found: Vec<Option<&Flown>> = frozen.iter().map(|at| at.flown.as_ref()).collect();
    // The six speeds of the page are among those of the verdict.
    let shown: Vec<usize> =
        (0..subject.speeds.len()).map(|i| i * (speeds.len() - 1) / (subject.speeds.len() - 1)).collect();
    let mut table = Table::new(["at a speed of (m/s)"]);
    table.head.extend(shown.iter().map(|i| format!("{:.2}", speeds[*i])));
    table.head.push(format!("worst of {}", speeds.len()));
    for line in rows(subject) {
        let values: Vec<f64> = found.iter().map(|f| f.map_or(f64::NAN, &line.of)).collect();
        let text = |v: f64| number(v, line.decimals);
        let worse = |a: &f64, b: &f64| if line.least { b.total_cmp(a) } else { a.total_cmp(b) };
        // An unknown value counts as the worst.
        let unknown = values.iter().position(|v| v.is_nan());
        let worst = unknown.or_else(|| (0..values.len()).max_by(|i, j| worse(&values[*i], &values[*j])));
        let mut row = vec![line.name];
        row.extend(shown.iter().map(|i| text(values[*i])));
        let alike = values.iter().all(|v| text(*v) == text(values[0]));
        row.push(worst.map_or_else(String::new, |i| {
            if alike { text(values[i]) } else { format!("{} at {:.2}", text(values[i]), speeds[i]) }
        }));
        table.rows.push(row);
    }
    let figures = [margins(subject, frozen), noise(subject, frozen)].map(Part::Figure);
    Ok(figures.into_iter().chain([Part::Table(table), Part::Text(explanation(subject))]).collect())
}

/// Returns the curve of a figure over the speeds at which the loop is stable.
fn curve(frozen: &[AtSpeed], key: usize, of: &dyn Fn(&Flown) -> f64) -> Curve {
    let points = frozen.iter().filter_map(|at| Some((at.speed, of(at.flown.as_ref()?))));
    Curve { key, points: points.collect() }
}

fn keys(names: &[&str]) -> Vec<Key> {
    names.iter().enumerate().map(|(i, name)| Key::coloured(i, *name)).collect()
}

/// Plots the smallest margins over speed, with their requirements.
fn margins(subject: &Subject, frozen: &[AtSpeed]) -> Figure {
    let mut keys = keys(&[
        "phase margin",
        "phase of the disk margin",
        "more gain",
        "less gain",
        "delay at one point",
        "delay in all commands at once",
        "|S|, largest of all points",
    ]);
    let limits = keys.len();
    keys.push(Key::reference("required"));
    let design = &subject.inputs.design;
    let limit_curve = |key: &&str| {
        let limit = design.require.limit(key)?;
        Some(Curve { key: limits, points: [design.speed_min, design.speed_max].map(|v| (v, limit)).into() })
    };
    let with = |curves: [Curve; 2], required: &[&str]| -> Vec<Curve> {
        curves.into_iter().chain(required.iter().filter_map(limit_curve)).collect()
    };
    let least = |f: &Flown, of: fn(&Margins) -> f64| f.margins().map(of).fold(f64::INFINITY, f64::min);
    let decibels = |factor: f64| 20.0 * factor.log10();
    let curve = |key, of: &dyn Fn(&Flown) -> f64| curve(frozen, key, of);
    let phases = [
        curve(0, &|f| least(f, |m| m.phase.to_degrees())),
        curve(1, &|f| least(f, |m| m.disk_phase().to_degrees())),
    ];
    let gains = [
        curve(2, &|f| decibels(least(f, |m| m.gain_up))),
        curve(3, &|f| decibels(least(f, |m| 1.0 / m.gain_down))),
    ];
    let delays = [curve(4, &|f| least(f, |m| m.delay)), curve(5, &|f| f.common_delay)];
    Figure {
        name: "margins-over-speed".into(),
        caption: format!(
            "Smallest margins of {} over speed, over all points at which the loop can be opened.",
            subject.name()
        ),
        keys,
        charts: vec![
            Chart::over_speed("phase (deg)", with(phases, &["phase_margin", "disk_margin"])),
            Chart::over_speed("gain margin (dB)", with(gains, &["gain_margin"])),
            Chart::over_speed("delay margin (s)", with(delays, &["delay_margin"])),
            Chart::over_speed("peak of |S| (-)", vec![curve(6, &|f| f.peak)]),
        ],
    }
}

/// Plots the noise in each command over speed.
fn noise(subject: &Subject, frozen: &[AtSpeed]) -> Figure {
    let actuators = &subject.inputs.vehicle.actuators;
    // Dashes distinguish the coincident curves of paired actuators.
    let keys = actuators.iter().enumerate().map(|(j, a)| Key::nth(j, a.name.as_str())).collect();
    let rms = |(j, a): (usize, &Actuator)| curve(frozen, j, &|f| 100.0 * f.noise_rms[j] / a.reach());
    let curves = actuators.iter().enumerate().map(rms).collect();
    Figure {
        name: "noise-over-speed".into(),
        caption: format!("Rms of each command of {} under sensor noise, over speed.", subject.name()),
        keys,
        charts: vec![Chart::over_speed("commands under noise, rms (% of reach)", curves)],
    }
}

fn explanation(subject: &Subject) -> String {
    let which = subject.speed_reference();
    format!(
        "The linear loop at a frozen speed as implemented: true linearisation, sampled controller with zero-order \
            hold, lags of the actuators, and a trim that follows the {which}. Each margin is the smallest over all \
            points at which the loop can be opened while it remains closed elsewhere, that is, each measurement and \
            each command: with L = 1/S - 1 at this point, the gain margins are 1/|L| where L crosses the negative \
            real axis, the phase margin is |arg(-L)| where |L| = 1, and the delay margin is arg(-L)/w at the same \
            frequency, with arg from 0 to 2 pi. The disk margin is alpha = 1/max|S - 1/2| (P. Seiler, A. Packard, P. \
            Gahinet, IEEE Control Systems Magazine 40(5), 2020), with the phase 2 atan(alpha/2): gain and phase may \
            change by this amount simultaneously. Steps are applied to the reference of each output and simulated \
            for {DURATION:.0} s; settled: within 2 %; the steady error is |1 - T| at z = 1. Gust: a vertical \
            velocity of the water of {GUST} m/s starts as a step, and heave relative to the water jumps by the same \
            amount. Noise: white at each sample, 0.05 deg rms on angles, 0.05 deg/s on the rate, 0.01 m/s on speeds, \
            0.01 m on the depth; the rms of a command follows from a Lyapunov equation."
    )
}

fn rows(subject: &Subject) -> Vec<Row> {
    let mut all: Vec<Row> = vec![];
    let mut add = |name: String, decimals, least, of: Box<dyn Fn(&Flown) -> f64>| {
        all.push(Row { name, decimals, least, of });
    };
    let decibels = |factor: f64| 20.0 * factor.log10();
    let smallest = |of: fn(&Margins) -> f64| {
        Box::new(move |f: &Flown| f.margins().map(of).fold(f64::INFINITY, f64::min))
            as Box<dyn Fn(&Flown) -> f64>
    };
    let up = smallest(|m| m.gain_up);
    add("gain margin, more gain (dB)".into(), 1, true, Box::new(move |f| decibels(up(f))));
    let down = |f: &Flown| f.margins().map(|m| m.gain_down).fold(0.0, f64::max);
    add("gain margin, less gain (dB)".into(), 1, false, Box::new(move |f| decibels(down(f))));
    add("phase margin (deg)".into(), 1, true, smallest(|m| m.phase.to_degrees()));
    add("disk margin alpha".into(), 3, true, smallest(|m| m.disk));
    add("phase of the disk margin (deg)".into(), 1, true, smallest(|m| m.disk_phase().to_degrees()));
    add("peak of |S|".into(), 3, false, Box::new(|f| f.peak));
    add("delay margin (s)".into(), 3, true, smallest(|m| m.delay));
    add("delay margin, all commands at once (s)".into(), 3, true, Box::new(|f| f.common_delay));
    for (i, tracked) in subject.inputs.design.tracked.iter().enumerate() {
        let name = tracked.signal.name;
        let of = |what: &str| format!("{name} step: {what}");
        add(of("overshoot (%)"), 2, false, Box::new(move |f| 100.0 * f.steps[i].overshoot));
        add(of("rise, 10 to 90 % (s)"), 2, false, Box::new(move |f| f.steps[i].rise_time));
        add(of("settled (s)"), 2, false, Box::new(move |f| f.steps[i].settling_time));
        add(of("steady error (%)"), 3, false, Box::new(move |f| 100.0 * f.steps[i].steady_error));
        let late = of(&format!("error after {DURATION:.0} s (%)"));
        add(late, 3, false, Box::new(move |f| 100.0 * f.steps[i].remaining_error));
    }
    let design = &subject.inputs.design;
    for turned in ["pitch", "heading"].into_iter().filter(|name| design.tracks(name).is_some()) {
        let gust = format!("{turned} after a gust of {GUST} m/s (deg)");
        add(gust, 2, false, Box::new(|f| f.gust.to_degrees()));
    }
    for (j, actuator) in subject.inputs.vehicle.actuators.iter().enumerate() {
        let (factor, unit) = readable(actuator.unit());
        let name = format!("{} under noise, rms ({unit})", actuator.name);
        add(name, 3, false, Box::new(move |f| factor * f.noise_rms[j]));
    }
    all
}

fn number(v: f64, decimals: usize) -> String {
    match v {
        _ if v.is_nan() => "unknown".into(),
        _ if v == f64::INFINITY => "none".into(),
        _ if v == f64::NEG_INFINITY => "any".into(),
        _ => format!("{v:.decimals$}"),
    }
}
