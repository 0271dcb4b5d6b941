//! Simulations of Squid's committed design at sea, with the size of its hull.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

use squid_auv::longitudinal::{PITCH, SPEED};
use squid_auv::toml_file::Mistake;
use squid_auv::{Geometry, Vehicle};
use squid_design::inputs::Inputs;
use squid_flight::error::Error;
use squid_flight::flight::{Flight, Row, fly, fly_at_sea};
use squid_flight::sea::Sea;
use squid_scheduled::{ControllerDesign, Manoeuvre};
use std::path::{Path, PathBuf};

fn vehicles() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../vehicles")
}

/// Inputs and design of Squid, and a manoeuvre of 30 s at 1.5 m/s with a pitch step.
struct Squid {
    inputs: Inputs,
    design: ControllerDesign,
    manoeuvre: Manoeuvre,
}

impl Squid {
    fn new() -> Self {
        let folder = vehicles().join("squid");
        let mut inputs = Inputs::read(&folder, "design").unwrap();
        inputs.vehicle.geometry = Geometry::new(2.0, 0.25);
        let frozen = squid_base::files::read(&folder.join("frozen/controller.json")).unwrap();
        let design = ControllerDesign::from_json(&frozen).unwrap();
        let calm = inputs.design.manoeuvre.clone();
        let manoeuvre = Manoeuvre { speed_from: 1.5, speed_to: 1.5, duration: 30.0, step_time: 5.0, ..calm };
        Self { inputs, design, manoeuvre }
    }

    fn at_sea(&self, text: &str) -> Result<Flight, Error> {
        let sea = Sea::parse(text, "sea.toml").unwrap();
        fly_at_sea(&self.inputs.vehicle, &self.design, self.inputs.design.level(), &self.manoeuvre, &sea)
    }

    fn calm(&self) -> Vec<Row> {
        fly(&self.inputs.vehicle, &self.design, self.inputs.design.level(), &self.manoeuvre).unwrap().rows
    }
}

const WAVES: &str =
    "[waves]\nspectrum = \"jonswap\"\nheight = 1.0\nperiod = 6.0\ngamma = 3.3\nheading = 180.0\n";

fn rms(rows: &[Row], of: impl Fn(&Row) -> f64) -> f64 {
    (rows.iter().map(|row| of(row).powi(2)).sum::<f64>() / rows.len() as f64).sqrt()
}

#[test]
fn empty_sea_file_is_still_water() {
    let squid = Squid::new();
    let flight = squid.at_sea("seed = 1").unwrap();
    assert_eq!(flight.rows, squid.calm());
    assert_eq!(flight.sea.len(), flight.rows.len());
    assert!(flight.sea.iter().zip(&flight.rows).all(|(sea, row)| sea.read == row.signals.measured));
}

/// The FMU of a vehicle has only waves with the default number of components and a steady current.
#[test]
fn names_features_beyond_a_steady_sea() {
    let feature = |text: &str| Sea::parse(text, "sea.toml").unwrap().beyond_steady();
    let steady = format!("seed = 1\ndepth = 3.0\n{WAVES}[current]\nhorizontal = 0.2\nvertical = 0.1\n");
    assert_eq!(feature(&steady), None);
    for (part, expected) in [
        ("[current]\nlayers = [[0.0, 0.4], [15.0, 0.1]]\n", "a current in layers"),
        ("[gauss_markov]\nmu = 0.1\nnoise = 0.02\nmin = -0.2\nmax = 0.2\n", "a Gauss-Markov current"),
        ("[[sensor]]\nsignal = \"heave\"\nunit = \"m/s\"\ndelay = 0.1\n", "errors of the heave sensor"),
        (&format!("{WAVES}components = 50\n"), "waves with 50 components, only with 100"),
    ] {
        assert_eq!(feature(&format!("seed = 1\n{part}")).as_deref(), Some(expected));
    }
}

#[test]
fn seed_reproduces_the_flight() {
    let squid = Squid::new();
    let sensor = "[[sensor]]\nsignal = \"pitch\"\nunit = \"deg\"\nnoise = 0.1\n";
    let current = "[gauss_markov]\nmu = 0.1\nnoise = 0.02\nmin = -0.2\nmax = 0.2\n";
    for part in [WAVES, sensor, current] {
        let fly = |seed: u32| squid.at_sea(&format!("seed = {seed}\ndepth = 20.0\n{part}")).unwrap();
        assert_eq!(fly(3), fly(3), "{part}");
        assert_ne!(fly(3).rows, fly(4).rows, "{part}");
    }
}

/// Waves disturb pitch near the surface, and barely at 50 m.
#[test]
fn waves_fade_with_depth() {
    let squid = Squid::new();
    let calm = squid.calm();
    let deviation = |depth: f64| {
        let flight = squid.at_sea(&format!("seed = 1\ndepth = {depth:?}\n{WAVES}")).unwrap();
        let differences = flight
            .rows
            .iter()
            .zip(&calm)
            .map(|(sea, calm)| Row { depth: sea.measured(PITCH) - calm.measured(PITCH), ..sea.clone() });
        rms(&differences.collect::<Vec<_>>(), |row| row.depth).to_degrees()
    };
    let [near, below, deep] = [6.0, 20.0, 50.0].map(deviation);
    assert!(near > 0.05 && near < 5.0, "{near}");
    assert!(below < 0.5 * near && deep < 0.05 * near, "{below}, {deep}");
}

/// A uniform current carries water and vehicle alike: the motion through the water is that in still water.
#[test]
fn steady_current_does_not_disturb() {
    let squid = Squid::new();
    let flight = squid.at_sea("seed = 1\n[current]\nhorizontal = 0.4").unwrap();
    for (found, calm) in flight.rows.iter().zip(squid.calm()) {
        for index in [PITCH, SPEED] {
            assert!((found.measured(index) - calm.measured(index)).abs() < 1e-9);
        }
        assert!((found.depth - calm.depth).abs() < 1e-9);
    }
    assert!(flight.sea.iter().all(|row| row.water.horizontal == 0.4 && row.water.vertical == 0.0));
}

/// A vehicle that climbs into a faster layer initially loses that much speed through the water.
#[test]
fn layers_act_at_their_depth() {
    let squid = Squid::new();
    let layers = "layers = [[0.0, 0.5], [48.0, 0.5], [49.0, 0.0]]";
    let flight = squid.at_sea(&format!("seed = 1\n[current]\n{layers}")).unwrap();
    let calm = squid.calm();
    let deviation = |row: &Row, calm: &Row| (row.measured(SPEED) - calm.measured(SPEED)).abs();
    let (mut deep, mut within) = (0.0f64, 0.0f64);
    for ((row, calm), sea) in flight.rows.iter().zip(&calm).zip(&flight.sea) {
        let expected = 0.5 * (49.0 - row.depth).clamp(0.0, 1.0);
        assert!((sea.water.horizontal - expected).abs() < 1e-12);
        *(if row.depth > 49.0 { &mut deep } else { &mut within }) =
            (if row.depth > 49.0 { deep } else { within }).max(deviation(row, calm));
    }
    assert!(deep < 1e-9 && within > 0.01, "{deep}, {within}");
}

/// The controller uses the sensor reading: a pitch bias appears in the true pitch with the opposite sign.
#[test]
fn autopilot_uses_sensor_readings() {
    let squid = Squid::new();
    let flight = squid
        .at_sea("seed = 1\n[[sensor]]\nsignal = \"pitch\"\nunit = \"deg\"\nbias = 0.5\nquantum = 0.01\nrate = 10.0")
        .unwrap();
    let (row, read) = (flight.rows.last().unwrap(), flight.sea.last().unwrap().read);
    assert!((row.error(PITCH).to_degrees() - 0.5).abs() < 0.05, "{}", row.error(PITCH).to_degrees());
    let steps = read[PITCH].to_degrees() / 0.01;
    assert!((steps - steps.round()).abs() < 1e-6);
    let changes = flight.sea.windows(2).filter(|pair| pair[0].read[PITCH] != pair[1].read[PITCH]);
    assert!(changes.count() <= 300);
}

/// Pitching up 10 degrees at 1.5 m/s from 4 m, the flight ends early, when the hull breaks the surface.
#[test]
fn flight_ends_when_the_hull_breaks_the_surface() {
    let squid = Squid::new();
    let flight = squid.at_sea(&format!("seed = 2\ndepth = 4.0\n{WAVES}")).unwrap();
    let surfacing = flight.surfacing.unwrap();
    assert!((5.0..30.0).contains(&surfacing.time));
    let (row, sea) = (flight.rows.last().unwrap(), flight.sea.last().unwrap());
    let below = row.depth + sea.elevation;
    assert!(below > 0.0 && below < 0.6, "{below}");

    let error = squid.at_sea(&format!("seed = 2\ndepth = 0.1\n{WAVES}")).unwrap_err();
    assert!(matches!(error, Error::AtTheSurface { depth: 0.1 }), "{error}");
}

#[test]
fn waves_require_geometry() {
    let mut squid = Squid::new();
    squid.inputs.vehicle.geometry = None;
    assert!(squid.at_sea("seed = 1\n[current]\nhorizontal = 0.2").is_ok());
    let error = squid.at_sea(&format!("seed = 1\n{WAVES}")).unwrap_err();
    assert!(matches!(error, Error::NoGeometry { .. }), "{error}");
    insta::assert_snapshot!(error);
}

/// A neutrally buoyant vehicle moves with long waves: its vertical speed through the water stays far below that of the
/// water.
#[test]
fn long_waves_carry_the_vehicle() {
    let squid = Squid::new();
    let swell = "[waves]\nspectrum = \"pierson-moskowitz\"\nheight = 1.0\nperiod = 12.0\nheading = 180.0\n";
    let mut still = squid.manoeuvre.clone();
    still = still.without_steps();
    let sea = Sea::parse(&format!("seed = 1\ndepth = 20.0\n{swell}"), "sea.toml").unwrap();
    let vehicle: &Vehicle = &squid.inputs.vehicle;
    let flight = fly_at_sea(vehicle, &squid.design, squid.inputs.design.level(), &still, &sea).unwrap();
    let water = (flight.sea.iter().map(|row| row.water.vertical.powi(2)).sum::<f64>()
        / flight.sea.len() as f64)
        .sqrt();
    let heave = squid_auv::longitudinal::index("heave").unwrap();
    let mean = flight.rows.iter().map(|row| row.measured(heave)).sum::<f64>() / flight.rows.len() as f64;
    let through = rms(&flight.rows, |row| row.measured(heave) - mean);
    assert!(water > 0.04 && through < 0.1 * water, "{through} of {water}");
}

/// The example file is read, and every mistake is reported with its line.
#[test]
fn reads_a_sea_file() {
    let text = std::fs::read_to_string(vehicles().join("sea.toml")).unwrap();
    let text: String =
        text.lines().filter(|line| !line.starts_with('#')).map(|line| line.to_owned() + "\n").collect();
    let sea = Sea::parse(&text, "sea.toml").unwrap();
    assert_eq!((sea.seed, sea.depth, sea.vertical), (1, Some(10.0), 0.0));
    assert_eq!(sea.layers.at(5.0), (0.2, 0.0));
    assert_eq!(sea.waves.as_ref().map(|waves| waves.components), Some(100));
    let pitch = sea.sensors[PITCH];
    assert!((pitch.bias - 0.2f64.to_radians()).abs() < 1e-15);
    assert_eq!((sea.sensors[SPEED].rate, sea.sensors[SPEED].delay, pitch.rate), (5.0, 0.1, f64::INFINITY));

    let mut messages = vec![];
    let mut refused = |text: &str, line: usize, key: &str| {
        let error = Sea::parse(text, "sea.toml").unwrap_err();
        let is_found = |one: &Mistake| (one.line, one.problem.key()) == (line, Some(key));
        assert!(error.mistakes.iter().any(is_found), "{line}, {key}: {error}");
        messages.push(error.to_string());
    };
    for (from, to, line, key) in [
        ("seed = 1\n", "", 1, "seed"),
        ("seed = 1\n", "seed = -1\n", 2, "seed"),
        ("depth = 10.0", "depth = -1.0", 3, "depth"),
        ("\"jonswap\"", "\"jonswop\"", 6, "waves.spectrum"),
        ("\"jonswap\"", "\"pierson-moskowitz\"", 9, "waves.gamma"),
        ("height = 1.0", "height = 0.0", 7, "waves.height"),
        ("period = 6.0", "period = 2.0", 8, "waves.period"),
        ("gamma = 3.3", "gamma = 9.0", 9, "waves.gamma"),
        ("gamma = 3.3\n", "", 5, "waves.gamma"),
        ("heading = 180.0", "heading = inf", 10, "waves.heading"),
        ("components = 100", "components = 5", 11, "waves.components"),
        ("components = 100", "compnents = 5", 11, "waves.compnents"),
        ("horizontal = 0.2", "horizontal = nan", 14, "current.horizontal"),
        ("vertical = 0.0", "layers = [[0.0, 0.1]]", 14, "current.horizontal"),
        ("horizontal = 0.2", "layers = [[5.0, 0.1], [2.0, 0.0]]", 14, "current.layers"),
        ("horizontal = 0.2", "layers = []", 14, "current.layers"),
        ("mu = 0.05", "mu = -0.05", 23, "gauss_markov.mu"),
        ("max = 0.1", "max = -0.2", 26, "gauss_markov.max"),
        ("signal = \"pitch\"", "signal = \"yaw\"", 29, "sensor.signal"),
        (
            "signal = \"pitch\"\nunit = \"deg\"",
            "signal = \"heading_rate\"\nunit = \"deg\"",
            30,
            "sensor.unit",
        ),
        ("signal = \"pitch\"", "signal = \"speed\"", 30, "sensor.unit"),
        ("unit = \"deg/s\"", "unit = \"deg\"", 36, "sensor.unit"),
        ("bias = 0.2", "bias = \"none\"", 32, "sensor.bias"),
        ("horizontal = 0.2", "horizontal = 100.0", 14, "current.horizontal"),
        ("rate = 5.0", "rate = 1e-9", 44, "sensor.rate"),
        ("rate = 5.0", "rate = 0.0", 44, "sensor.rate"),
        ("delay = 0.1", "delay = 11.0", 45, "sensor.delay"),
        ("[current]", "[curent]", 13, "curent"),
    ] {
        assert!(text.contains(from), "{from}");
        refused(&text.replacen(from, to, 1), line, key);
    }
    refused(&format!("{text}\n[[sensor]]\nsignal = \"pitch\"\nunit = \"deg\"\n"), 48, "sensor.signal");
    insta::assert_snapshot!(messages.join("\n"));
}
