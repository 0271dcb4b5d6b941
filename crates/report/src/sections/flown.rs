//! The loop as it flies, frozen at a speed: margins, steps, a gust, noise.

use crate::error::Error;
use crate::page::section::{Part, Table};
use crate::subject::Subject;
use crate::threads::side_by_side;
use squid_design::check::CHECKED_SPEEDS;
use squid_design::check::flown::{FOLLOWED, Flown, GUST};
use squid_design::check::margins::Margins;
use squid_design::linearise::linearise_at;
use squid_design::numbers::readable;

/// A row of the table.
struct Figure {
    name: String,
    decimals: usize,
    /// Whether the smallest is the worst.
    least: bool,
    of: Box<dyn Fn(&Flown) -> f64>,
}

/// The section on the frozen loops as they fly.
///
/// # Errors
/// Those of trim, linearisation and freezing.
pub fn flown(subject: &Subject) -> Result<Vec<Part>, Error> {
    let speeds = subject.inputs.design.spread(CHECKED_SPEEDS);
    let at = |(i, speed): (usize, &f64)| -> Result<(usize, Option<Flown>), Error> {
        let l = linearise_at(&subject.inputs.vehicle, &subject.inputs.design, *speed)?;
        Ok((i, Flown::of(&subject.sampling(), &l, &subject.frozen(&subject.controller, &l)?)))
    };
    let found = side_by_side(speeds.iter().enumerate(), at);
    let mut found = found.into_iter().collect::<Result<Vec<_>, Error>>()?;
    found.sort_by_key(|(i, _)| *i);
    let found: Vec<Option<Flown>> = found.into_iter().map(|(_, flown)| flown).collect();
    // The six speeds of the page are among those of the check.
    let shown: Vec<usize> =
        (0..subject.speeds.len()).map(|i| i * (speeds.len() - 1) / (subject.speeds.len() - 1)).collect();
    let mut table = Table::new(["at a speed of (m/s)"]);
    table.head.extend(shown.iter().map(|i| format!("{:.2}", speeds[*i])));
    table.head.push(format!("worst of {}", speeds.len()));
    for figure in figures(subject) {
        let values: Vec<f64> = found.iter().map(|f| f.as_ref().map_or(f64::NAN, &figure.of)).collect();
        let text = |v: f64| number(v, figure.decimals);
        let worse = |a: &f64, b: &f64| if figure.least { b.total_cmp(a) } else { a.total_cmp(b) };
        // Not-a-number is worst.
        let unknown = values.iter().position(|v| v.is_nan());
        let worst = unknown.or_else(|| (0..values.len()).max_by(|i, j| worse(&values[*i], &values[*j])));
        let mut row = vec![figure.name];
        row.extend(shown.iter().map(|i| text(values[*i])));
        let alike = values.iter().all(|v| text(*v) == text(values[0]));
        row.push(worst.map_or_else(String::new, |i| match alike {
            true => text(values[i]),
            false => format!("{} at {:.2}", text(values[i]), speeds[i]),
        }));
        table.rows.push(row);
    }
    Ok(vec![Part::Words(words()), Part::Table(table)])
}

fn words() -> String {
    format!(
        "The linear loop at a frozen speed with everything that flies: true linearisation, sampled controller, commands \
            held, lags of the actuators, trim that follows the speed reference. Each margin is the smallest of all \
            places at which the loop can be opened while it stays closed elsewhere, each measurement and each command: \
            with L = 1/S - 1 there, the gain margins are 1/|L| where L crosses the negative real axis, the phase margin is \
            |arg(-L)| where |L| = 1, the delay margin is arg(-L)/w there, with arg from 0 to 2 pi. The disk margin is alpha = \
            1/max|S - 1/2| (P. Seiler, A. Packard, P. Gahinet, IEEE Control Systems Magazine 40(5), 2020), with the \
            phase 2 atan(alpha/2): gain and phase may be off by as much at the same time. Steps are of the reference \
            of each output, followed for {FOLLOWED:.0} s; settled: within 2 %; the steady error is |1 - T| at z = 1. Gust: the \
            water begins to move vertically by {GUST} m/s at once, and heave through the water jumps by as much. Noise: \
            white at each sample, 0.05 deg rms on angles, 0.05 deg/s on the rate, 0.01 m/s on speeds; the rms of \
            a command follows from a Lyapunov equation."
    )
}

fn figures(subject: &Subject) -> Vec<Figure> {
    let mut all: Vec<Figure> = vec![];
    let mut add = |name: String, decimals, least, of: Box<dyn Fn(&Flown) -> f64>| {
        all.push(Figure { name, decimals, least, of });
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
        let name = tracked.signal().name;
        let of = |what: &str| format!("{name} step: {what}");
        add(of("overshoot (%)"), 2, false, Box::new(move |f| 100.0 * f.steps[i].overshoot));
        add(of("rise, 10 to 90 % (s)"), 2, false, Box::new(move |f| f.steps[i].rise_time));
        add(of("settled (s)"), 2, false, Box::new(move |f| f.steps[i].settling_time));
        add(of("steady error (%)"), 3, false, Box::new(move |f| 100.0 * f.steps[i].steady_error));
        let late = of(&format!("error after {FOLLOWED:.0} s (%)"));
        add(late, 3, false, Box::new(move |f| 100.0 * f.steps[i].late_error));
    }
    let gust = format!("pitch after a gust of {GUST} m/s (deg)");
    add(gust, 2, false, Box::new(|f| f.gust_pitch.to_degrees()));
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
