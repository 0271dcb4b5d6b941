//! Verdict on the committed design of Squid: every figure is recomputed in another way, and every requirement can be
//! missed.

use crate::designs::{committed, message};
use squid_auv::longitudinal::{PITCH, SPEED};
use squid_design::axis::VehicleModel;
use squid_design::certify::controller_of;
use squid_design::check::flown::Flown;
use squid_design::check::margins::Margins;
use squid_design::check::sampled::Sampling;
use squid_design::inputs::Inputs;
use squid_design::inputs::design_file::{DesignFile, REQUIREMENTS, Sense};
use squid_design::store::Stored;
use squid_design::verdict::Verdict;
use squid_design::verdict::corners::Corners;
use squid_design::verdict::found::{Effort, Found};
use squid_design::verdict::row::{Outcome, Row};
use squid_flight::flight::{Row as Tick, fly};
use squid_scheduled::{ControllerDesign, Manoeuvre};
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

const EFFORT: Effort = Effort { frozen: 3, sampled: true, flown: 2, mu: 2 };

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../vehicles/squid")
}

/// Input files, and verdict with the default limits; computed once.
static SQUID: LazyLock<(Inputs, Stored, Verdict)> = LazyLock::new(|| {
    let (inputs, stored) = committed();
    let verdict = Verdict::of(&inputs, &stored.controller, EFFORT).unwrap();
    (inputs, stored, verdict)
});

/// Assesses the same figures by the limits of a section [require].
fn judged(section: &str) -> Verdict {
    let (inputs, stored, verdict) = &*SQUID;
    let text = squid_base::files::read(&folder().join("design.toml")).unwrap() + "\n[require]\n" + section;
    let design = DesignFile::parse(&text, "design.toml", "design").unwrap();
    let inputs = Inputs { design, ..inputs.clone() };
    Verdict::judge(&inputs, stored.controller.gamma.bound, verdict.found.clone())
}

fn row<'v>(verdict: &'v Verdict, what: &str) -> &'v Row {
    verdict.rows.iter().find(|row| row.name == what).unwrap()
}

fn near(found: f64, expected: f64) {
    assert!((found - expected).abs() <= 1e-9 * expected.abs().max(1e-6), "{found} {expected}");
}

/// Section with the same limit under every key.
fn all(limit: impl Fn(Sense) -> f64) -> String {
    REQUIREMENTS.iter().map(|r| format!("{} = {:?}\n", r.key, limit(r.sense))).collect()
}

/// The unsaturated rate of a lag is recomputed by a plant with the commands of the flight; it is assessed if there is a
/// limit.
#[test]
fn rate_use_equals_that_of_plant() {
    let (mut inputs, stored, _) = SQUID.clone();
    inputs.vehicle.actuators[0].rate = Some(200.0);
    let effort = Effort { frozen: 2, sampled: false, flown: 2, mu: 2 };
    let verdict = Verdict::of(&inputs, &stored.controller, effort).unwrap();
    let manoeuvre = &inputs.design.manoeuvre;
    let level = inputs.design.level();
    let flight = fly(&inputs.vehicle, &stored.controller, level, manoeuvre).unwrap();
    let start = squid_auv::Speed::Path(manoeuvre.speed_from);
    let trim = squid_auv::trim_with(&inputs.vehicle, start, level.0, level.1).unwrap();
    let mut plant = squid_auv::Plant::new(&inputs.vehicle).unwrap();
    plant.start(0.0, &trim).unwrap();
    let plain = squid_auv::Actuator { rate: None, ..inputs.vehicle.actuators[0].clone() };
    let mut most = 0.0_f64;
    for row in &flight.rows {
        plant.set_command(0, row.commands[0]).unwrap();
        most = most.max(plain.output_rate(plant.outputs()[0], row.commands[0]).abs());
        plant.advance(row.time + inputs.design.sample_time).unwrap();
    }
    let uses = &verdict.found.flight.uses;
    near(uses[0].rate.unwrap(), most / 200.0);
    assert!(most > 200.0 && uses[1].rate.is_none());
    let judged = row(&verdict, "rate of lower in the default manoeuvre");
    assert_eq!((judged.key, judged.outcome), ("actuator_use", Outcome::Missed));
    assert!(judged.achieved.remark.as_ref().unwrap().ends_with(" N/s, limit 200 N/s"), "{judged:?}");
    assert_eq!(verdict.rows.iter().filter(|row| row.name.starts_with("rate of")).count(), 1);
}

#[test]
fn default_design_meets_default_limits() {
    let (_, _, verdict) = &*SQUID;
    assert_eq!(verdict.missed().count(), 0, "{verdict}");
    let required = verdict.rows.iter().filter(|row| row.outcome == Outcome::Met).count();
    // Overshoot of two steps, three actuators, three margins, mu, two beyond the envelope, two held, one of corners,
    // three noises, the modes.
    assert_eq!(required, 18, "{verdict}");
    insta::assert_snapshot!(verdict.to_string().lines().next().unwrap());
}

/// Every row is missed with the largest limits on margins and the smallest on the rest, and met the other way round.
#[test]
fn every_requirement_can_be_missed_and_met() {
    let (_, _, verdict) = &*SQUID;
    let hard = judged(&all(|sense| if sense == Sense::Above { 1e6 } else { 0.0 }));
    assert_eq!(hard.missed().count(), hard.rows.len(), "{hard}");
    assert_eq!(hard.rows.len(), verdict.rows.len());
    // The design of Squid tracks neither depth nor heading.
    let own = |key: &str| !key.starts_with("depth") && !key.starts_with("heading");
    for requirement in REQUIREMENTS.iter().filter(|one| own(one.key)) {
        assert!(hard.rows.iter().any(|row| row.key == requirement.key), "{}", requirement.key);
    }
    let easy = judged(&all(|sense| if sense == Sense::Above { 0.0 } else { 1e6 }));
    assert!(easy.rows.iter().all(|row| row.outcome == Outcome::Met), "{easy}");
    let text = hard.to_string();
    assert!(text.contains("MISSED") && text.contains("> 1000000 deg"), "{text}");
}

#[test]
fn rejects_wrong_limits_with_line() {
    let text = squid_base::files::read(&folder().join("design.toml")).unwrap();
    let line = text.matches('\n').count() + 2;
    let messages =
        [("phase_margin = -1", "phase_margin"), ("mu = \"one\"", "mu"), ("overshot = 5", "overshot")].map(
            |(section, key)| {
                let text = format!("{text}[require]\n{section}");
                let error = DesignFile::parse(&text, "design.toml", "design").unwrap_err();
                message(section, &error, (line, &format!("require.{key}")))
            },
        );
    insta::assert_snapshot!(messages.join("\n\n"));
}

/// Margins, gust, steady errors and noise are those of the frozen loops; gamma is the proved one.
#[test]
fn frozen_figures_are_those_of_the_check() {
    let (inputs, stored, verdict) = &*SQUID;
    let k = controller_of(&stored.controller.lft).unwrap();
    let sampling = Sampling::of(&inputs.vehicle.actuators, &inputs.design);
    let at = |speed: f64| {
        let l = inputs.axis().linearise(speed).unwrap();
        Flown::of(&sampling, &l, &k.frozen(&[inputs.design.rho(speed)]).unwrap()).unwrap()
    };
    let loops: Vec<Flown> = inputs.design.spread(EFFORT.frozen).into_iter().map(at).collect();
    let least =
        |of: fn(&Margins) -> f64| loops.iter().flat_map(Flown::margins).map(of).fold(f64::INFINITY, f64::min);
    let most = |of: &dyn Fn(&Flown) -> f64| loops.iter().map(of).fold(f64::NEG_INFINITY, f64::max);
    let found = |what: &str| row(verdict, what).achieved.value;
    near(found("phase margin"), least(|m| m.phase).to_degrees());
    near(found("disk margin (as a phase)"), least(|m| m.disk_phase()).to_degrees());
    near(found("delay margin"), least(|m| m.delay).min(-most(&|f| -f.common_delay)));
    let decibels =
        least(|m| m.gain_up).min(1.0 / most(&|f| f.margins().map(|m| m.gain_down).fold(0.0, f64::max)));
    near(found("gain margin"), 20.0 * decibels.log10());
    near(found("pitch after a gust of 0.3 m/s"), most(&|f| f.gust).to_degrees());
    near(found("pitch: steady error"), 100.0 * most(&|f| f.steps[0].steady_error));
    let reach = inputs.vehicle.actuators[1].reach();
    near(found("upper_port under noise, rms"), 100.0 * most(&|f| f.noise_rms[1]) / reach);
    near(found("gain of the weighted loop (gamma)"), stored.controller.gamma.bound);
}

/// Steps and the use of actuators equal those of separate flights.
#[test]
fn flown_figures_are_those_of_flights() {
    let (inputs, stored, verdict) = &*SQUID;
    let design = &inputs.design;
    let flown = |manoeuvre: &Manoeuvre| -> Vec<Tick> {
        let controller: &ControllerDesign = &stored.controller;
        fly(&inputs.vehicle, controller, design.level(), manoeuvre).unwrap().rows
    };
    // The speed steps from the slow end to 0.25 m/s more, a fifth of half the range.
    let (low, step) = (design.speed_min, 0.25);
    let speed = Manoeuvre {
        speed_from: low,
        speed_to: low + step,
        ramp_start: 2.0,
        ramp_duration: 1e-9,
        duration: 30.0,
        ..design.manoeuvre.without_steps()
    };
    let rows = flown(&speed);
    let (from, to) = (rows[0].reference(SPEED), rows.last().unwrap().reference(SPEED));
    let when = |part: f64| rows.iter().find(|r| r.measured(SPEED) >= from + part * (to - from)).unwrap().time;
    let found = verdict.found.steps.iter().find(|s| s.output == "speed" && s.speed == low).unwrap();
    assert!((found.rise_time - (when(0.9) - when(0.1))).abs() < 1e-9, "{found:?}");
    near(found.height, to - from);

    let rows = flown(&Manoeuvre {
        speed_from: low,
        speed_to: low,
        step_time: 2.0,
        ramp_start: 0.0,
        duration: 30.0,
        ..design.manoeuvre.clone()
    });
    let step = design.manoeuvre.step("pitch");
    let beyond = rows.iter().filter(|r| r.time > 2.0).map(|r| -r.error(PITCH) / step).fold(0.0, f64::max);
    let found = verdict.found.steps.iter().find(|s| s.output == "pitch" && s.speed == low).unwrap();
    assert!((found.overshoot - beyond).abs() < 1e-6, "{found:?} {beyond}");

    let rows = flown(&design.manoeuvre);
    let most =
        rows.iter().map(|r| (r.commands[0] / inputs.vehicle.actuators[0].max).abs()).fold(0.0, f64::max);
    near(row(verdict, "lower in the default manoeuvre").achieved.value, 100.0 * most);
}

/// A vehicle that surfaces in its default flight misses the requirement on its actuators.
#[test]
fn flight_cut_short_is_missed() {
    let (inputs, stored, _) = &*SQUID;
    let mut shallow = inputs.clone();
    shallow.design.depth = 1.0;
    let effort = Effort { frozen: 2, sampled: false, flown: 0, mu: 0 };
    let found = Found::of(&shallow, &stored.controller, effort).unwrap();
    let verdict = Verdict::judge(&shallow, 0.5, found);
    let missed = row(&verdict, "lower in the default manoeuvre");
    assert_eq!(missed.outcome, Outcome::Missed);
    assert!(missed.achieved.remark.is_some(), "{verdict}");
    assert_eq!(missed.found(), "unknown");
}

/// Corners of vanishing ranges are the vehicle itself, whose step is that of the verdict.
#[test]
fn steps_at_vanishing_corners_equal_those_of_vehicle() {
    let (inputs, stored, verdict) = &*SQUID;
    let with = |factor: f64| {
        let mut inputs = inputs.clone();
        inputs.uncertain.iter_mut().for_each(|one| one.half_range *= factor);
        inputs.design.uncertainty.as_mut().unwrap().actuator_gain *= factor;
        Corners::of(&inputs, &stored.controller, EFFORT.flown).unwrap()
    };
    let declared = with(1.0);
    assert_eq!(declared, verdict.found.corners);
    for (at, declared) in with(1e-9).iter().zip(&declared) {
        let mut steps = verdict.found.steps.iter().filter(|step| step.output == "pitch");
        let step = steps.find(|step| step.speed == at.speed).unwrap();
        assert_eq!((at.flown, at.untrimmed), (12, 0));
        assert!((at.overshoot - step.overshoot).abs() < 1e-6, "{at:?} {step:?}");
        assert!((at.remaining_error - step.steady_error).abs() < 1e-6, "{at:?} {step:?}");
        assert!(at.overshoot < declared.overshoot, "{at:?} {declared:?}");
    }
}

/// Actuators that just hold level flight at the highest speed do not hold that of a vehicle with more drag.
#[test]
fn counts_corners_without_level_flight() {
    let (inputs, stored, _) = &*SQUID;
    let mut weak = inputs.clone();
    let trim = weak.axis().at(weak.design.speed_max).unwrap().trim;
    for (actuator, output) in weak.vehicle.actuators.iter_mut().zip(&trim.actuators) {
        actuator.max = actuator.max.min(1.02 * output.abs());
    }
    let found = Corners::of(&weak, &stored.controller, 2).unwrap();
    let counts: Vec<_> =
        found.iter().map(|at| (at.speed, at.flown + at.untrimmed, at.untrimmed > 0)).collect();
    assert_eq!(counts, [(weak.design.speed_min, 12, false), (weak.design.speed_max, 12, true)]);
    // A verdict without any flown corner has no figure to compare with a limit.
    let none = Corners {
        flown: 0,
        untrimmed: 12,
        overshoot: f64::INFINITY,
        remaining_error: f64::INFINITY,
        ..found[1].clone()
    };
    let judged = |corners: Vec<Corners>| {
        let found = Found { corners, ..SQUID.2.found.clone() };
        Verdict::judge(inputs, stored.controller.gamma.bound, found)
    };
    let missed = |verdict: &Verdict| verdict.missed().count();
    assert_eq!(missed(&judged(vec![none])), missed(&judged(SQUID.2.found.corners.clone())) + 1);
}
