//! Reading, writing and rejecting designs.

use crate::example::{self, HEAVE, PITCH, RATE, SPEED};
use proptest::prelude::*;
use squid_scheduled::{ControllerDesign, Kind, Level};
use squid_signals::Curve;

#[test]
fn round_trips_through_json() {
    let design = example::design();
    let json = design.to_json().unwrap();
    assert_eq!(ControllerDesign::from_json(&json).unwrap(), design);
    assert!(json.contains("[0.1, 0.05]"), "a row a line:\n{json}");
}

proptest! {
    #[test]
    fn numbers_read_back_to_the_bit(
        value in prop::num::f64::NORMAL | prop::num::f64::ZERO | prop::num::f64::SUBNORMAL,
    ) {
        let mut design = example::design();
        design.lft.a[0][1] = value;
        let read = ControllerDesign::from_json(&design.to_json().unwrap()).unwrap();
        prop_assert_eq!(read.lft.a[0][1].to_bits(), value.to_bits());
    }
}

/// Checks that the committed design is written as it was read, byte for byte.
#[test]
fn writes_committed_design_unchanged() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../vehicles/squid/frozen/controller.json");
    let text = std::fs::read_to_string(path).unwrap();
    assert_eq!(ControllerDesign::from_json(&text).unwrap().to_json().unwrap(), text);
}

#[test]
fn optional_keys_are_omitted_and_read_back() {
    let json = example::two_degrees().to_json().unwrap();
    for key in ["delay_ticks", "reference_filter", "speed_given", "anti_windup", "start"] {
        assert!(!json.contains(&format!("\"{key}\":")), "{json}");
    }
    let mut design = example::two_degrees();
    design.reference_filter = Some(0.3);
    let json = design.to_json().unwrap();
    assert_eq!(ControllerDesign::from_json(&json).unwrap(), design);
    for (from, to, expected) in [
        ("squid-controller/1", "squid-controller/2", "format is 'squid-controller/2', but only"),
        ("\"measurement\"", "\"integral\"", "unknown variant `integral`"),
        ("\"signal\"", "\"name\"", "unknown field `name`"),
        ("\"kind\": \"reference\",", "", "missing field `kind`"),
    ] {
        let wrong = json.replacen(from, to, 1);
        assert_ne!(wrong, json);
        let message = ControllerDesign::from_json(&wrong).unwrap_err().to_string();
        assert!(message.contains(expected), "{message}");
    }
}

#[test]
fn measures_and_follows_the_signals_of_its_inputs() {
    let of = |design: &ControllerDesign| {
        (
            [PITCH, SPEED, RATE, HEAVE].map(|one| design.measures(one)),
            [PITCH, SPEED].map(|one| design.follows(one)),
        )
    };
    assert_eq!(of(&example::design()), ([true, true, false, false], [true, true]));
    let mut design = example::two_degrees();
    design.controller_inputs[0] = example::input("pitch_rate", Kind::Measurement, 0.1);
    assert_eq!(of(&design), ([true, true, true, false], [false, true]));
    design.controller_inputs.truncate(1);
    assert_eq!(of(&design), ([false, true, true, false], [false, true]), "rho and the trim take the speed");
}

#[test]
fn keeps_brackets_in_names() {
    let mut design = example::design();
    design.vehicle.name = "Squid [1  2], \"x\"".to_owned();
    assert_eq!(ControllerDesign::from_json(&design.to_json().unwrap()).unwrap(), design);
}

/// Changes the design and asserts that the message names the key.
#[track_caller]
fn assert_rejected(change: impl FnOnce(&mut ControllerDesign), expected: &str) {
    assert_design_rejected(example::design(), change, expected);
}

#[track_caller]
fn assert_design_rejected(
    mut design: ControllerDesign,
    change: impl FnOnce(&mut ControllerDesign),
    expected: &str,
) {
    change(&mut design);
    let message = design.validate().unwrap_err().to_string();
    assert!(message.contains(expected), "{message}");
    assert!(design.to_json().is_err());
}

/// Returns the trim of the pitch.
fn column(design: &mut ControllerDesign) -> &mut Vec<f64> {
    design.trim.signals.get_mut("pitch").unwrap()
}

#[test]
fn rejects_invalid_signals() {
    assert_rejected(|d| d.signals.clear(), "signals is empty");
    assert_rejected(|d| d.signals[3].name = "a b".to_owned(), "signals[3].name is 'a b'");
    assert_rejected(
        |d| d.signals[3].name = "pitch_reference".to_owned(),
        "signals[3].name is 'pitch_reference', which occurs twice",
    );
    assert_rejected(
        |d| d.signals.swap(2, 3),
        "signals[3].name is 'depth', but must be before the signals without",
    );
    assert_rejected(
        |d| d.signals[2].level = Level::Scheduled,
        "signals[2].level is 'scheduled', but must be the level",
    );
    assert_rejected(
        |d| d.signals[1].level = Level::Zero,
        "scheduling.quantity is 'speed', but must be the signal with",
    );
    assert_rejected(|d| d.signals[4].nominal = 0.0, "signals[4].nominal is 0");
    assert_rejected(|d| d.signals[0].range = Some([1.0, -1.0]), "signals[0].range ranges from 1 to -1");
    assert_rejected(
        |d| drop(d.trim.signals.insert("yaw".to_owned(), vec![0.0; 3])),
        "trim.signals is 'yaw', but must be 'pitch' or 'heave'",
    );
}

#[test]
fn rejects_invalid_designs() {
    assert_rejected(|d| d.sample_time = 0.0, "sample_time is 0");
    assert_rejected(|d| d.sample_time = f64::NAN, "sample_time is NaN");
    assert_rejected(|d| d.sample_time = 1e-300, "must be finite and at least 1e-5");
    assert_rejected(|d| d.sample_time = f64::INFINITY, "sample_time is inf");
    assert_rejected(|d| d.scheduling.quantity = "depth".to_owned(), "scheduling.quantity is 'depth'");
    assert_rejected(|d| d.scheduling.maximum = 0.4, "scheduling ranges from 0.5 to 0.4");
    assert_rejected(|d| d.scheduling.centre = 1.7, "0.5 m/s gives rho");
    assert_rejected(|d| d.controller_inputs.clear(), "controller_inputs is empty");
    assert_rejected(
        |d| d.controller_inputs[1].signal = "yaw".to_owned(),
        "controller_inputs[1].signal is 'yaw'",
    );
    assert_rejected(|d| d.controller_inputs[0].unit = "deg".to_owned(), "controller_inputs[0].unit is 'deg'");
    assert_rejected(|d| d.controller_inputs[0].scale = -1.0, "controller_inputs[0].scale is -1");
    assert_rejected(
        |d| d.controller_inputs[1] = d.controller_inputs[0].clone(),
        "controller_inputs[1].signal is 'pitch', which occurs twice",
    );
    assert_rejected(|d| d.actuators.clear(), "actuators is empty");
    assert_rejected(|d| d.actuators[1].name = "thruster_1".to_owned(), "actuators[1].name is 'thruster_1'");
    assert_rejected(|d| d.actuators[1].name = "a b".to_owned(), "actuators[1].name is 'a b'");
    assert_rejected(|d| d.actuators[2].minimum = 100.0, "actuators[2] ranges from 100 to 100");
    assert_rejected(|d| d.lft.blocks = vec![1, 1], "lft.blocks has 2 parameters");
    assert_rejected(|d| d.lft.blocks = vec![3], "lft.Bt[0] has 2 entries, but must have 3");
    assert_rejected(|d| d.lft.a[1].push(0.0), "lft.A[1] has 3 entries, but must have 2");
    assert_rejected(|d| d.lft.cu.truncate(2), "lft.Cu has 2 entries, but must have 3");
    assert_rejected(|d| d.lft.dtt[0][1] = f64::INFINITY, "lft.Dtt[0][1] is inf");
    assert_rejected(|d| d.trim.speed.truncate(1), "trim.speed has 1 entries");
    assert_rejected(
        |d| d.trim.forward_speed[1] = 0.2,
        "trim.forward_speed must increase, but 0.2 follows 0.49",
    );
    assert_rejected(|d| column(d).truncate(2), "trim.signals.pitch has 2 entries, but must have 3");
    assert_rejected(|d| column(d)[2] = f64::NAN, "trim.signals.pitch[2] is NaN");
    assert_rejected(|d| d.trim.actuators[1].truncate(1), "trim.actuators[1] has 1 entries");
    assert_rejected(|d| d.trim.actuators[1][2] = 200.0, "trim.actuators[1][2] is 200, outside the limits");
    assert_rejected(|d| d.trim.speed[2] = 2.9, "trim.speed covers 0.5 .. 2.9 m/s");
    assert_rejected(|d| d.gamma.bound = 0.0, "gamma.bound is 0");
}

#[test]
fn rejects_invalid_inputs() {
    let of = |change: fn(&mut ControllerDesign), expected: &str| {
        assert_design_rejected(example::two_degrees(), change, expected)
    };
    of(
        |d| d.controller_inputs[1].signal = "yaw".to_owned(),
        "controller_inputs[1].signal is 'yaw', but must be 'pitch', 'speed', 'depth', 'pitch_rate' or 'heave'",
    );
    for kind in [Kind::Reference, Kind::Error] {
        let change =
            |d: &mut ControllerDesign| d.controller_inputs[1] = example::input("pitch_rate", kind, 0.1);
        assert_design_rejected(
            example::two_degrees(),
            change,
            "controller_inputs[1].signal is 'pitch_rate', but must be 'pitch', 'speed' or 'depth'",
        );
    }
    of(
        |d| d.controller_inputs[2].unit = "km/h".to_owned(),
        "controller_inputs[2].unit is 'km/h', but must be m/s",
    );
    of(
        |d| d.controller_inputs[3].scale = 0.0,
        "controller_inputs[3].scale is 0, but must be finite and above 0",
    );
    of(
        |d| d.controller_inputs[2] = d.controller_inputs[0].clone(),
        "controller_inputs[2].signal is 'pitch', which occurs twice",
    );
    for bandwidth in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let expected = format!("reference_filter is {bandwidth}, but must be finite and above 0");
        assert_design_rejected(example::two_degrees(), |d| d.reference_filter = Some(bandwidth), &expected);
    }
    of(|d| d.delay_ticks = 11, "delay_ticks is 11, but must be at most 10");
    of(|d| d.lft.by[0].truncate(2), "lft.By[0] has 2 entries, but must have 4");
}

#[test]
fn reports_position_of_json_error() {
    let json = example::design().to_json().unwrap();
    for (from, to, expected) in [
        ("\"sample_time\"", "\"sampletime\"", "unknown field `sampletime`"),
        ("\"design\": \"default\",", "", "missing field `design`"),
        ("\"surrogate\"", "\"guess\"", "unknown variant `guess`"),
        ("0.02", "\"fast\"", "invalid type: string \"fast\", expected f64 at line"),
        ("}", "", "EOF"),
    ] {
        let broken = match from {
            "}" => json.trim_end().trim_end_matches('}').to_owned(),
            _ => json.replacen(from, to, 1),
        };
        let message = ControllerDesign::from_json(&broken).unwrap_err().to_string();
        assert!(message.contains(expected), "{message}");
    }
}

#[test]
fn thruster_curve_round_trips_and_reaches_limits() {
    let mut design = example::design();
    assert!(!design.to_json().unwrap().contains("curve"), "no curve, no key");
    let points = vec![[1100.0, -60.0], [1470.0, 0.0], [1530.0, 0.0], [1900.0, 110.0]];
    design.actuators[0].curve = Some(Curve::through(points, "us").unwrap());
    assert_eq!(ControllerDesign::from_json(&design.to_json().unwrap()).unwrap(), design);
    assert_eq!((design.actuators[0].input_unit(), design.actuators[1].input_unit()), ("us", "N"));
    assert_eq!(
        (design.actuators[0].input_for(-60.0).0, design.actuators[1].input_for(-60.0)),
        (1100.0, (-60.0, 1.0))
    );

    let falling = design.to_json().unwrap().replace("[1530.0, 0.0]", "[1530.0, -1.0]");
    let message = ControllerDesign::from_json(&falling).unwrap_err().to_string();
    assert!(
        message.contains("the points of a curve must be two pairs [command, thrust] or more"),
        "{message}"
    );
    design.actuators[0].maximum = 111.0;
    let message = design.validate().unwrap_err().to_string();
    assert_eq!(message, "actuators[0].maximum is 111, but must be a thrust on its curve");
}
