//! A made-up second axis with its own states and signals: a double integrator whose thruster becomes more effective
//! with speed. It passes design, proof, freezing, FMU and C like the longitudinal vehicle.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

#[path = "../../fmi2/tests/flight/mod.rs"]
mod flight;

use flight::Flight;
use squid_auv::toml_file::Mistake;
use squid_auv::{Actuator, Effect, Status};
use squid_base::progress::Progress;
use squid_certificate::Certificate;
use squid_design::axis::{Linearisation, OperatingPoint, VehicleModel};
use squid_design::error::ModelError;
use squid_design::inputs::design_file::DesignFile;
use squid_design::inputs::sha256;
use squid_design::run::{FinishedAxis, run_axis};
use squid_embedded::{Real, Standing, export};
use squid_fmi2::Resources;
use squid_fmi2::model_description::Causality;
use squid_fmu_controller::{Controller, describe};
use squid_lpv::matrix::Mat;
use squid_proof::claim::{parse, text};
use squid_scheduled::{ControllerDesign, InputHashes};
use squid_signals::{Interface, LargestStep, Level, Reference, Signal, State, States, Unit};
use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::LazyLock;

static STATES: [State; 2] = [
    State {
        symbol: "y",
        unit: "m",
        name: "offset",
        actuation_hint: "a side thruster",
        measurement_hint: "measure 'offset'",
    },
    State {
        symbol: "v",
        unit: "m/s",
        name: "drift",
        actuation_hint: "a side thruster",
        measurement_hint: "measure 'drift'",
    },
];

const METRE: Unit = Unit { name: "m", factor: 1.0 };
const METRE_PER_SECOND: Unit = Unit { name: "m/s", factor: 1.0 };

static SIGNALS: [Signal; 3] = [
    Signal {
        name: "offset",
        unit: "m",
        units: &[METRE, Unit { name: "cm", factor: 0.01 }],
        measured: "offset from the track",
        reference: Some(Reference { name: "offset_reference", description: "wanted offset from the track" }),
        row: &[("y", 1.0)],
        level: Level::Start,
        range: None,
        circular: false,
        largest_step: LargestStep::Of(5.0),
        nominal: 1.0,
        error: 0.1,
    },
    Signal {
        name: "drift",
        unit: "m/s",
        units: &[METRE_PER_SECOND],
        measured: "speed across the track",
        reference: None,
        row: &[("v", 1.0)],
        level: Level::Zero,
        range: None,
        circular: false,
        largest_step: LargestStep::Range,
        nominal: 0.1,
        error: 0.1,
    },
    Signal {
        name: "speed",
        unit: "m/s",
        units: &[METRE_PER_SECOND],
        measured: "forward speed through the water, along the body axis",
        reference: None,
        row: &[("u", 1.0)],
        level: Level::Scheduled,
        range: None,
        circular: false,
        largest_step: LargestStep::Range,
        nominal: 1.0,
        error: 0.1,
    },
];

static INTERFACE: Interface = Interface { states: &STATES, signals: &SIGNALS };

/// Plant y' = v, v' = k(V) T.
#[derive(Debug)]
struct Sway {
    actuators: Vec<Actuator>,
}

/// Returns k(V) \[m/s^2 per N\].
fn strength(speed: f64) -> f64 {
    0.01 + 0.004 * speed
}

impl Sway {
    fn new() -> Self {
        let effect = Effect::thruster_group(0.0, 0.0, 0.0);
        let (name, curve) = ("side_thruster".to_owned(), None);
        Self {
            actuators: vec![Actuator { name, min: -40.0, max: 40.0, lag: 0.2, rate: None, curve, effect }],
        }
    }

    fn trim(speed: f64) -> OperatingPoint {
        OperatingPoint { speed, signals: vec![0.0, 0.0, speed], actuators: vec![0.0] }
    }
}

impl VehicleModel for Sway {
    fn name(&self) -> &str {
        "squid"
    }

    fn status(&self) -> Status {
        Status::Surrogate
    }

    fn interface(&self) -> &'static Interface {
        &INTERFACE
    }

    fn states(&self) -> States {
        &STATES
    }

    fn actuators(&self) -> &[Actuator] {
        &self.actuators
    }

    fn is_speed_given(&self) -> bool {
        true
    }

    fn trims(&self, speeds: &[f64]) -> Result<Vec<OperatingPoint>, ModelError> {
        Ok(speeds.iter().map(|speed| Self::trim(*speed)).collect())
    }

    fn trim_slopes(&self, speeds: &[f64]) -> Result<Vec<Mat>, ModelError> {
        Ok(vec![Mat::zeros(3, 1); speeds.len()])
    }

    fn linearise(&self, speed: f64) -> Result<Linearisation, ModelError> {
        Ok(Linearisation {
            a: Mat::from_row_slice(2, 2, &[0.0, 1.0, 0.0, 0.0]),
            b: Mat::from_row_slice(2, 1, &[0.0, strength(speed)]),
            states: &STATES,
            trim: Self::trim(speed),
            trim_slope: Mat::zeros(3, 1),
            by_waves: None,
        })
    }
}

const DESIGN: &str = r#"
description = "Holds the vehicle on a track by its side thruster."

[model]
speed_min = 0.5
speed_max = 3.0
speeds = 11
depth = 0.0
order = 1
drop = 1e-3

[[track]]
output = "offset"
scale = 50.0
unit = "cm"
peak = 2.0
steady_error = 0.01
bandwidth = 0.1
frequency = 0.5
damping = 0.9

[[measure]]
signal = "offset"
scale = 50.0
unit = "cm"
noise = 0.01

[[measure]]
signal = "drift"
scale = 0.2
unit = "m/s"
noise = 0.02

[control]
weight = 0.2
disturbance = 0.1
lags = true

[synthesis]
back_off = 0.1

[autopilot]
sample_time = 0.02

[manoeuvre]
offset_step = 0.5
step_time = 2.0
speed_from = 1.0
speed_to = 2.0
ramp_start = 5.0
ramp_duration = 10.0
duration = 60.0
"#;

static AXIS: LazyLock<FinishedAxis> = LazyLock::new(|| {
    let file = DesignFile::parse_for(&INTERFACE, DESIGN, "sway.toml", "sway").unwrap();
    // Attributed to the vehicle file next to it.
    let vehicle = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../vehicles/squid/vehicle.toml");
    let vehicle_sha256 = sha256(&std::fs::read_to_string(vehicle).unwrap());
    let hashes = InputHashes { vehicle_sha256, design_sha256: "11".repeat(32) };
    run_axis(&Sway::new(), &file, &hashes, &Progress::default()).unwrap()
});

/// Returns the controller as read from its file.
fn frozen() -> ControllerDesign {
    let json = AXIS.controller.to_json().unwrap();
    let read = ControllerDesign::from_json(&json).unwrap();
    assert_eq!(read, AXIS.controller);
    read
}

fn squid() -> String {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../vehicles/squid/frozen");
    std::fs::read_to_string(root.join("controller.json")).unwrap()
}

fn alone() -> Resources {
    [(squid_fmu_controller::RESOURCE, frozen().to_json().unwrap())].into_iter().collect()
}

/// Returns the longitudinal axis of Squid and this one in one FMU.
fn together() -> Resources {
    [("controller.json", squid()), ("controller_2.json", frozen().to_json().unwrap())].into_iter().collect()
}

/// Proved in continuous time, sampled, and with saturated commands; verified from the text.
#[test]
fn is_proved() {
    let (proof, sampled) = (AXIS.proof.as_ref().unwrap(), AXIS.sampled.as_ref().unwrap());
    let text = text(&proof.certificate, Path::new("certificate.json")).unwrap();
    let read: Certificate = parse(&text, "certificate.json").unwrap();
    let theorem = read.prove().unwrap();
    assert_eq!(theorem.gamma, Some(frozen().gamma.bound));
    assert!(frozen().gamma.certified && theorem.gamma_with_model_error.unwrap() < 1.0);
    assert!(sampled.theorem.gamma.unwrap() < 1.1 * frozen().gamma.bound);
    let limits = theorem.limits.unwrap();
    assert!(limits.size * 0.5 >= 0.5, "the step of the manoeuvre: {limits:?}");
}

#[test]
fn design_file_names_its_signals() {
    let mut messages = vec![];
    for (from, to, key) in [
        ("output = \"offset\"", "output = \"pitch\"", "track.output"),
        ("output = \"offset\"", "output = \"drift\"", "track.output"),
        ("unit = \"cm\"", "unit = \"deg\"", "track.unit"),
        ("offset_step = 0.5", "offset_step = 0.6", "manoeuvre.offset_step"),
        ("offset_step = 0.5", "pitch_step = 0.5", "manoeuvre.pitch_step"),
    ] {
        let (before, _) = DESIGN.split_once(from).unwrap();
        let line = before.matches('\n').count() + 1;
        let text = DESIGN.replacen(from, to, 1);
        let error = DesignFile::parse_for(&INTERFACE, &text, "sway.toml", "sway").unwrap_err();
        let is_found = |one: &Mistake| (one.line, one.problem.key()) == (line, Some(key));
        assert!(error.mistakes.iter().any(is_found), "{line}, {key}: {error}");
        messages.push(error.to_string());
    }
    insta::assert_snapshot!(messages.join("\n\n"));
}

/// A vehicle with these equations, stepped exactly between ticks.
struct Model {
    time: f64,
    offset: f64,
    drift: f64,
    thrust: f64,
}

impl Model {
    const TICK: f64 = 0.02;

    fn start() -> Self {
        Self { time: 0.0, offset: 100.0, drift: 0.0, thrust: 0.0 }
    }

    fn speed(&self) -> f64 {
        1.0 + (self.time / 20.0).clamp(0.0, 1.0)
    }

    /// Returns the reference: a step of half a metre at 2 s.
    fn wanted(&self) -> f64 {
        if self.time < 2.0 { 100.0 } else { 100.5 }
    }

    fn advance(&mut self, command: f64) {
        // Ten steps of the lag and the two integrators.
        for _ in 0..10 {
            let step = Self::TICK / 10.0;
            self.thrust += step * (command - self.thrust) / 0.2;
            self.drift += step * strength(self.speed()) * self.thrust;
            self.offset += step * self.drift;
        }
        self.time += Self::TICK;
    }
}

/// Simulates the FMU with the model; returns inputs and command of each tick.
fn flown(resources: &Resources, also: &[(&str, f64)]) -> Vec<([f64; 4], f64)> {
    let mut flight = Flight::<Controller>::prepare(describe(resources).unwrap(), 0.0);
    let mut model = Model::start();
    let mut rows = vec![];
    let set = |flight: &mut Flight<Controller>, model: &Model| {
        let inputs = [model.offset, model.drift, model.speed(), model.wanted()];
        for (name, value) in ["offset", "drift", "speed", "offset_reference"].into_iter().zip(inputs) {
            flight.set(name, value);
        }
        also.iter().for_each(|(name, value)| flight.set(name, *value));
        inputs
    };
    set(&mut flight, &model);
    flight.begin().unwrap();
    for tick in 0..3000 {
        let inputs = set(&mut flight, &model);
        flight.instance.step(f64::from(tick) * Model::TICK, Model::TICK, &mut flight.log).unwrap();
        let command = flight.get("side_thruster");
        rows.push((inputs, command));
        model.advance(command);
    }
    assert!(
        (model.offset - 100.5).abs() < 0.01 && model.drift.abs() < 1e-3,
        "{} {}",
        model.offset,
        model.drift
    );
    let largest = rows.iter().map(|(inputs, _)| inputs[0]).fold(0.0, f64::max);
    assert!(largest < 100.5 + 0.1, "overshoot to {largest}");
    rows
}

#[test]
fn fmu_tracks_the_step() {
    let described = describe(&alone()).unwrap();
    let of = |causality| {
        let chosen = described.description.variables.iter().filter(move |one| one.causality == causality);
        chosen.map(|one| one.name.as_str()).collect::<Vec<_>>()
    };
    let engagement = ["side_thruster_applied", "engaged", "applied_given"];
    assert_eq!(of(Causality::Input)[..4], ["offset", "drift", "speed", "offset_reference"]);
    assert_eq!(of(Causality::Input)[4..], engagement);
    assert!(of(Causality::Output).contains(&"side_thruster"));
    let offset = described.description.variables.iter().find(|one| one.name == "offset").unwrap();
    let (name, _) = described.description.description.split_once(", L2").unwrap();
    insta::assert_snapshot!(format!("{name}\n{}", offset.description));
    flown(&alone(), &[]);
}

/// The speed, which both axes measure, is one input; each axis commands the same bits as alone.
#[test]
fn two_axes_share_one_fmu() {
    let described = describe(&together()).unwrap();
    let count = |name: &str| described.description.variables.iter().filter(|one| one.name == name).count();
    for name in ["pitch", "speed", "engaged", "offset", "side_thruster", "upper_port", "gamma", "sway_gamma"]
    {
        assert_eq!(count(name), 1, "{name}");
    }
    for name in ["pitch_reference_used", "reference_limited", "sway_reference_limited"] {
        assert_eq!(count(name), 1, "{name}");
    }
    assert_eq!(count("sway_offset_reference_used"), 1, "two axes may follow one reference");
    let longitudinal =
        [("pitch", 0.02), ("pitch_rate", 0.0), ("pitch_reference", 0.05), ("speed_reference", 1.5)];
    let (both, one) = (flown(&together(), &longitudinal), flown(&alone(), &[]));
    assert_eq!(both, one);

    let squid: Resources = [("controller.json", squid())].into_iter().collect();
    let mut pair = [&together(), &squid].map(|files| {
        let mut flight = Flight::<Controller>::prepare(describe(files).unwrap(), 0.0);
        longitudinal.iter().for_each(|(name, value)| flight.set(name, *value));
        flight.set("speed", 1.2);
        flight.begin().unwrap();
        flight
    });
    for tick in 0..200 {
        let thrusts = pair.each_mut().map(|flight| {
            flight.set("pitch", 0.02 * f64::from(tick % 7));
            flight.instance.step(f64::from(tick) * Model::TICK, Model::TICK, &mut flight.log).unwrap();
            flight.get("upper_port")
        });
        assert_eq!(thrusts[0], thrusts[1]);
    }
}

/// Axes that do not fit together are refused.
#[test]
fn rejects_axes_that_do_not_fit() {
    let changes: [fn(&mut ControllerDesign); 4] = [
        |design| design.sample_time = 0.04,
        |design| design.vehicle.name = "other".into(),
        |design| design.actuators[0].name = "upper_port".into(),
        |design| design.signals[2].unit = "km/h".into(),
    ];
    let messages = changes.map(|change| {
        let mut design = frozen();
        change(&mut design);
        let files = [("controller.json", squid()), ("controller_2.json", design.to_json().unwrap())];
        describe(&files.into_iter().collect()).unwrap_err().to_string()
    });
    insta::assert_snapshot!(messages.join("\n"));
}

const MAIN: &str = r#"
#include "squid.h"
#include <stdio.h>

int main(void)
{
    squid_state state;
    squid_outputs out;
    double row[4];
    for (int is_first = 1; fread(row, sizeof *row, 4, stdin) == 4; is_first = 0) {
        squid_inputs in = {.offset = row[0], .drift = row[1], .speed = row[2], .offset_reference = row[3]};
        if (is_first && squid_reset(&state, &in, &out) != SQUID_OK) return 1;
        if (squid_step(&state, &in, &out) != SQUID_OK) return 1;
        fwrite(&out.side_thruster, sizeof out.side_thruster, 1, stdout);
    }
    return 0;
}
"#;

/// The exported C gives the same commands as the FMU to the bit.
#[test]
fn exported_c_equals_fmu_to_the_bit() {
    let standing = Standing { claims: vec!["Made for a test.".into()], certificate_sha256: None };
    let source = export(&frozen(), &standing, Real::Double).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name);
    let named = |end: &str| format!("{}.{end}", source.name);
    std::fs::write(file(&named("h")), &source.header).unwrap();
    std::fs::write(file(&named("c")), &source.source).unwrap();
    let prefix = format!("{}_", source.name);
    let main = MAIN.replace("squid_", &prefix).replace("SQUID_", &prefix.to_ascii_uppercase());
    std::fs::write(file("main.c"), main.replace("squid.h", &named("h"))).unwrap();
    let done = Command::new("cc")
        .args(["-std=c99", "-O1", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-I"])
        .args([folder.path(), &file(&named("c")), &file("main.c"), Path::new("-o"), &file("main")])
        .status()
        .unwrap();
    assert!(done.success());
    let rows = flown(&alone(), &[]);
    let bytes: Vec<u8> = rows.iter().flat_map(|(inputs, _)| *inputs).flat_map(f64::to_le_bytes).collect();
    let mut child = Command::new(file("main")).stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
    let mut input = child.stdin.take().unwrap();
    let writer = std::thread::spawn(move || input.write_all(&bytes).unwrap());
    let output = child.wait_with_output().unwrap();
    writer.join().unwrap();
    let commands = output.stdout.chunks_exact(8).map(|bytes| f64::from_le_bytes(bytes.try_into().unwrap()));
    let expected: Vec<f64> = rows.into_iter().map(|(_, command)| command).collect();
    assert_eq!(commands.collect::<Vec<_>>(), expected);
}
