//! Rows of the verdict, from its figures and the limits of the design.

use crate::check::flown::{Flown, GUST};
use crate::check::margins::Margins;
use crate::inputs::Inputs;
use crate::inputs::design_file::{REQUIREMENTS, Require, Requirement, Sense};
use crate::verdict::beyond::{Beyond, after};
use crate::verdict::corners::Corners;
use crate::verdict::flown::{StepAtSpeed, Use};
use crate::verdict::found::Found;
use crate::verdict::frozen::{AtSpeed, gain_margin};
use crate::verdict::held::{AFTER, HELD, Held};
use crate::verdict::mu::MuAtSpeed;
use crate::verdict::row::{Figure, Outcome, Row, StoredRow};
use squid_auv::readable;
use squid_auv::rounded;
use std::f64::consts::TAU;

/// Conversion to per cent.
const PER_CENT: f64 = 100.0;

/// Returns all rows, in the order of [`REQUIREMENTS`]. If nothing was found for one, the stored rows are used.
pub(super) fn rows(inputs: &Inputs, gamma: f64, found: &Found, stored: &[StoredRow]) -> Vec<Row> {
    let row = |requirement: &'static Requirement| -> Vec<Row> {
        let mut assessed = figures_of(requirement.key, inputs, gamma, found);
        if assessed.iter().all(|(_, figures)| figures.is_empty()) {
            let of_this = stored.iter().filter(|row| row.key == requirement.key);
            assessed = of_this.map(|row| (row.name.clone(), vec![row.achieved.clone()])).collect();
        }
        let worst = |(what, figures): (String, Vec<Figure>)| {
            Some(row(requirement, &inputs.design.require, what, Figure::worst(requirement.sense, figures)?))
        };
        assessed.into_iter().filter_map(worst).collect()
    };
    REQUIREMENTS.iter().flat_map(row).collect()
}

fn row(requirement: &Requirement, require: &Require, name: String, achieved: Figure) -> Row {
    let Requirement { key, unit, sense, .. } = *requirement;
    let limit = require.limit(key);
    let outcome = match (limit, sense) {
        (None, _) => Outcome::Reported,
        (Some(limit), Sense::Below) if achieved.value < limit => Outcome::Met,
        (Some(limit), Sense::Above) if achieved.value > limit => Outcome::Met,
        _ => Outcome::Missed,
    };
    Row { key, name, unit, sense, limit, achieved, outcome, advice: None }
}

/// Figures for a requirement by description; the worst of each determines the row.
fn figures_of(key: &str, inputs: &Inputs, gamma: f64, found: &Found) -> Vec<(String, Vec<Figure>)> {
    let one = |what: &str, figures: Vec<Figure>| vec![(what.to_owned(), figures)];
    match key {
        "gamma" => one("gain of the weighted loop (gamma)", vec![nearest(gamma, found)]),
        "sampled_gain" => one("gain of the sampled loop at constant speed", sampled_gains(found)),
        "overshoot" => steps(inputs, None, "overshoot", found, |s| PER_CENT * s.overshoot),
        "pitch_rise" => steps(inputs, Some("pitch"), "rise, 10 to 90 %", found, |s| s.rise_time),
        "pitch_settling" => steps(inputs, Some("pitch"), "settled within 2 %", found, |s| s.settling_time),
        "depth_rise" => steps(inputs, Some("depth"), "rise, 10 to 90 %", found, |s| s.rise_time),
        "depth_settling" => steps(inputs, Some("depth"), "settled within 2 %", found, |s| s.settling_time),
        "heading_rise" => steps(inputs, Some("heading"), "rise, 10 to 90 %", found, |s| s.rise_time),
        "heading_settling" => {
            steps(inputs, Some("heading"), "settled within 2 %", found, |s| s.settling_time)
        }
        "speed_rise" => steps(inputs, Some("speed"), "rise, 10 to 90 %", found, |s| s.rise_time),
        "speed_settling" => steps(inputs, Some("speed"), "settled within 2 %", found, |s| s.settling_time),
        "steady_error" => steady_errors(inputs, found),
        "actuator_use" => [uses(found), rates(inputs, found)].concat(),
        "gain_margin" => one("gain margin", margins(inputs, found, gain_margin)),
        "phase_margin" => one("phase margin", margins(inputs, found, |m| m.phase.to_degrees())),
        "disk_margin" => {
            one("disk margin (as a phase)", margins(inputs, found, |m| m.disk_phase().to_degrees()))
        }
        "delay_margin" => one("delay margin", delays(inputs, found)),
        "mu" => one("mu of the declared uncertainty", mu(found)),
        "gust" => gust(inputs, found),
        // A design that does not follow the speed does not claim to hold it.
        "beyond_speed" if inputs.design.tracked_speed().is_none() => vec![],
        "beyond_speed" => beyond(found, "largest loss of speed", |b| b.lost_speed),
        "beyond_recovery" => {
            let what = format!("pitch error after {:.0} s", after(inputs));
            beyond(found, &what, |b| b.remaining_error)
        }
        "held_speed" if inputs.design.tracked_speed().is_none() => vec![],
        "held_speed" => held(found, "largest loss of speed", |one| one.lost_speed),
        "held_recovery" => {
            let output = found.held.first().map_or("", |one| one.output);
            held(found, &format!("{output} error after {AFTER:.0} s"), |one| one.remaining_error)
        }
        "corner_overshoot" => corners(found, "overshoot", |one| one.overshoot),
        "corner_error" => corners(found, "error after one minute", |one| one.remaining_error),
        "noise" => noise(inputs, found),
        "controller_mode" => one("fastest controller mode over sampling rate", modes(inputs, found)),
        _ => vec![],
    }
}

/// Proved or computed bound, with the condition at which the frozen loop comes closest to it.
fn nearest(bound: f64, found: &Found) -> Figure {
    let most = found.frozen.iter().max_by(|a, b| a.gain.value.total_cmp(&b.gain.value));
    Figure {
        speed: most.map(|f| f.speed),
        frequency: most.map(|f| f.gain.frequency).filter(|omega| omega.is_finite()),
        ..Figure::new(bound)
    }
}

/// Upper bounds, each with the gain in continuous time.
fn sampled_gains(found: &Found) -> Vec<Figure> {
    let figure = |at: &AtSpeed| {
        let remark = format!("{:.3} in continuous time", at.gain.value);
        Some(Figure::at(at.sampled_gain?.upper, at.speed).with_remark(remark))
    };
    found.frozen.iter().filter_map(figure).collect()
}

/// Figure of the steps of each output, or of one output.
fn steps(
    inputs: &Inputs,
    only: Option<&str>,
    what: &str,
    found: &Found,
    of: impl Fn(&StepAtSpeed) -> f64,
) -> Vec<(String, Vec<Figure>)> {
    let outputs = inputs.design.tracked.iter().map(|t| t.signal.name);
    let outputs = outputs.filter(|name| only.is_none_or(|only| only == *name));
    let row = |name: &'static str| {
        let steps = found.steps.iter().filter(|step| step.output == name);
        (format!("{name} step: {what}"), steps.map(|step| Figure::at(of(step), step.speed)).collect())
    };
    outputs.map(row).collect()
}

fn steady_errors(inputs: &Inputs, found: &Found) -> Vec<(String, Vec<Figure>)> {
    let row = |(i, name): (usize, &str)| {
        let error = |f: &Flown| PER_CENT * f.steps[i].steady_error;
        (format!("{name}: steady error"), frozen(found, error))
    };
    inputs.design.tracked.iter().map(|t| t.signal.name).enumerate().map(row).collect()
}

/// Figure of each frozen loop.
fn frozen(found: &Found, of: impl Fn(&Flown) -> f64) -> Vec<Figure> {
    found.frozen.iter().map(|f| Figure::at(f.flown.as_ref().map_or(f64::NAN, &of), f.speed)).collect()
}

fn uses(found: &Found) -> Vec<(String, Vec<Figure>)> {
    let row = |used: &Use| {
        let (value, remark) = match &found.flight.lost {
            Some(reason) => (f64::NAN, reason.clone()),
            None => {
                (PER_CENT * used.most, format!("{:.0} % in level trim at these speeds", PER_CENT * used.trim))
            }
        };
        (format!("{} in the default manoeuvre", used.actuator), vec![Figure::new(value).with_remark(remark)])
    };
    found.flight.uses.iter().map(row).collect()
}

/// Unsaturated rates of actuators relative to their rate limits: above 100 % the rate is saturated.
fn rates(inputs: &Inputs, found: &Found) -> Vec<(String, Vec<Figure>)> {
    let row = |(used, a): (&Use, &squid_auv::Actuator)| {
        let ((rate, limit), (factor, unit)) = (used.rate.zip(a.rate)?, readable(a.unit()));
        let (value, remark) = match &found.flight.lost {
            Some(reason) => (f64::NAN, reason.clone()),
            None => {
                let [used, limit] = [rate * limit, limit].map(|rate| rounded(factor * rate));
                (PER_CENT * rate, format!("{used} {unit}/s, limit {limit} {unit}/s"))
            }
        };
        Some((
            format!("rate of {} in the default manoeuvre", used.actuator),
            vec![Figure::new(value).with_remark(remark)],
        ))
    };
    found.flight.uses.iter().zip(&inputs.vehicle.actuators).filter_map(row).collect()
}

/// Names of the points at which the loop can be opened: the measurements, or the errors, and the commands.
fn opening_points(inputs: &Inputs) -> Vec<String> {
    let commands = inputs.vehicle.actuators.iter().map(|a| a.name.clone());
    inputs.design.fed_back().into_iter().map(|(signal, _)| signal.name.to_owned()).chain(commands).collect()
}

/// Margin at each point and speed.
fn margins(inputs: &Inputs, found: &Found, of: impl Fn(&Margins) -> f64) -> Vec<Figure> {
    let opening_points = opening_points(inputs);
    let mut all = vec![];
    for at in &found.frozen {
        match &at.flown {
            None => all.push(Figure::at(f64::NAN, at.speed).with_remark("unstable")),
            Some(flown) => all.extend(
                opening_points
                    .iter()
                    .zip(flown.margins())
                    .map(|(point, m)| Figure::at(of(m), at.speed).with_remark(format!("opened at {point}"))),
            ),
        }
    }
    all
}

fn delays(inputs: &Inputs, found: &Found) -> Vec<Figure> {
    let mut all = margins(inputs, found, |m| m.delay);
    let common = frozen(found, |f| f.common_delay);
    all.extend(common.into_iter().map(|figure| figure.with_remark("in all commands at once")));
    all
}

fn mu(found: &Found) -> Vec<Figure> {
    let figure = |m: &MuAtSpeed| Figure {
        value: m.upper,
        speed: Some(m.speed),
        frequency: Some(m.frequency).filter(|omega| omega.is_finite()),
        remark: m.reason.clone(),
    };
    // There is no row without declared uncertainty.
    found.mu.iter().filter(|m| m.declared).map(figure).collect()
}

fn gust(inputs: &Inputs, found: &Found) -> Vec<(String, Vec<Figure>)> {
    let Some(turned) = ["pitch", "heading"].into_iter().find(|name| inputs.design.tracks(name).is_some())
    else {
        return vec![];
    };
    let what = format!("{turned} after a gust of {GUST} m/s");
    vec![(what, frozen(found, |f| f.gust.to_degrees()))]
}

/// Figure of the flights with a pitch reference beyond the envelope.
fn beyond(found: &Found, what: &str, of: impl Fn(&Beyond) -> f64) -> Vec<(String, Vec<Figure>)> {
    let figure = |flown: &Beyond| {
        let remark = format!(
            "{:.0} deg requested, limited to {:.1} deg",
            flown.requested.to_degrees(),
            flown.end.to_degrees()
        );
        Figure::at(PER_CENT * of(flown), flown.speed).with_remark(remark)
    };
    vec![(format!("beyond the envelope: {what}"), found.beyond.iter().map(figure).collect())]
}

/// Figure of the flights under loads that the actuators cannot hold.
fn held(found: &Found, what: &str, of: impl Fn(&Held) -> f64) -> Vec<(String, Vec<Figure>)> {
    let figure = |flown: &Held| {
        let remark = format!("{} N m for {HELD:.0} s", rounded(flown.load));
        Figure::at(PER_CENT * of(flown), flown.speed).with_remark(remark)
    };
    vec![(format!("load beyond the actuators: {what}"), found.held.iter().map(figure).collect())]
}

/// Figure of the steps at corners of the declared uncertainty; without any there is no row.
fn corners(found: &Found, what: &str, of: impl Fn(&Corners) -> f64) -> Vec<(String, Vec<Figure>)> {
    let figure = |at: &Corners| {
        let remark = match at.untrimmed {
            0 => format!("{} corners", at.flown),
            untrimmed => format!("{} corners; {untrimmed} more without level trim", at.flown),
        };
        Figure::at(PER_CENT * of(at), at.speed).with_remark(remark)
    };
    let output = found.corners.first().map_or("", |one| one.output);
    let figures = found.corners.iter().map(figure).collect();
    vec![(format!("declared uncertainty, {output} step: {what}"), figures)]
}

fn noise(inputs: &Inputs, found: &Found) -> Vec<(String, Vec<Figure>)> {
    let row = |(j, a): (usize, &squid_auv::Actuator)| {
        let rms = |f: &Flown| PER_CENT * f.noise_rms[j] / a.reach();
        (format!("{} under noise, rms", a.name), frozen(found, rms))
    };
    inputs.vehicle.actuators.iter().enumerate().map(row).collect()
}

fn modes(inputs: &Inputs, found: &Found) -> Vec<Figure> {
    let rate = TAU / inputs.design.sample_time;
    found.frozen.iter().map(|f| Figure::at(PER_CENT * f.fastest_mode / rate, f.speed)).collect()
}
