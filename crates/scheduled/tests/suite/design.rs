//! Reading, writing and rejecting designs.

use crate::example::{self, HEAVE, PITCH, RATE, SPEED};
use proptest::prelude::*;
use squid_scheduled::{ControllerDesign, DesignError, Kind, Level};
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
    let messages: String =
        [("\"measurement\"", "\"integral\""), ("\"signal\"", "\"name\""), ("\"kind\": \"reference\",", "")]
            .map(|(from, to)| unreadable(&json, from, to))
            .concat();
    let later = json.replacen("squid-controller/1", "squid-controller/2", 1);
    let error = ControllerDesign::from_json(&later).unwrap_err();
    assert_eq!(key(&error), "format");
    insta::assert_snapshot!(messages + &error.to_string());
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

/// Returns the path of the key in the JSON file, if the error has one.
pub fn key(error: &DesignError) -> &str {
    match error {
        DesignError::BadNumber { key, .. }
        | DesignError::BadText { key, .. }
        | DesignError::NameTaken { key, .. }
        | DesignError::WrongLength { key, .. }
        | DesignError::EmptyRange { key, .. }
        | DesignError::TrimBeyondLimits { key, .. } => key,
        DesignError::Empty { key } | DesignError::NotIncreasing { key, .. } => key,
        DesignError::WrongFormat { .. } => "format",
        DesignError::SeveralParameters { .. } => "lft.blocks",
        DesignError::SchedulingMismatch { .. } => "scheduling",
        DesignError::TrimTooShort { .. } => "trim.speed",
        DesignError::TooFast { .. } => "sample_time",
        DesignError::Json(_) => "",
    }
}

/// Messages of changes that make a design invalid.
pub struct Rejected {
    pub design: ControllerDesign,
    pub messages: String,
}

impl Rejected {
    pub fn new(design: ControllerDesign) -> Self {
        Self { design, messages: String::new() }
    }

    /// Changes the design and asserts the key of the error.
    #[track_caller]
    pub fn at(&mut self, expected: &str, change: impl FnOnce(&mut ControllerDesign)) {
        let mut design = self.design.clone();
        change(&mut design);
        let error = design.validate().unwrap_err();
        assert_eq!(key(&error), expected, "{error}");
        assert!(design.to_json().is_err());
        self.messages += &format!("{error}\n");
    }
}

/// Returns the trim of the pitch.
fn column(design: &mut ControllerDesign) -> &mut Vec<f64> {
    design.trim.signals.get_mut("pitch").unwrap()
}

#[test]
fn rejects_invalid_signals() {
    let mut rejected = Rejected::new(example::design());
    rejected.at("signals", |d| d.signals.clear());
    rejected.at("signals[3].name", |d| d.signals[3].name = "a b".to_owned());
    rejected.at("signals[3].name", |d| d.signals[3].name = "pitch_reference".to_owned());
    rejected.at("signals[3].name", |d| d.signals.swap(2, 3));
    rejected.at("signals[2].level", |d| d.signals[2].level = Level::Scheduled);
    rejected.at("scheduling.quantity", |d| d.signals[1].level = Level::Zero);
    rejected.at("signals[4].nominal", |d| d.signals[4].nominal = 0.0);
    rejected.at("signals[0].range", |d| d.signals[0].range = Some([1.0, -1.0]));
    rejected.at("trim.signals", |d| drop(d.trim.signals.insert("yaw".to_owned(), vec![0.0; 3])));
    insta::assert_snapshot!(rejected.messages);
}

#[test]
fn rejects_invalid_designs() {
    let mut rejected = Rejected::new(example::design());
    rejected.at("sample_time", |d| d.sample_time = 0.0);
    rejected.at("sample_time", |d| d.sample_time = f64::NAN);
    rejected.at("sample_time", |d| d.sample_time = 1e-6);
    rejected.at("sample_time", |d| d.sample_time = f64::INFINITY);
    rejected.at("scheduling.quantity", |d| d.scheduling.quantity = "depth".to_owned());
    rejected.at("scheduling", |d| d.scheduling.maximum = 0.4);
    rejected.at("scheduling", |d| d.scheduling.centre = 1.7);
    rejected.at("controller_inputs", |d| d.controller_inputs.clear());
    rejected.at("controller_inputs[1].signal", |d| d.controller_inputs[1].signal = "yaw".to_owned());
    rejected.at("controller_inputs[0].unit", |d| d.controller_inputs[0].unit = "deg".to_owned());
    rejected.at("controller_inputs[0].scale", |d| d.controller_inputs[0].scale = -1.0);
    rejected.at("controller_inputs[1].signal", |d| d.controller_inputs[1] = d.controller_inputs[0].clone());
    rejected.at("actuators", |d| d.actuators.clear());
    rejected.at("actuators[1].name", |d| d.actuators[1].name = "thruster_1".to_owned());
    rejected.at("actuators[1].name", |d| d.actuators[1].name = "a b".to_owned());
    rejected.at("actuators[2]", |d| d.actuators[2].minimum = 100.0);
    rejected.at("lft.blocks", |d| d.lft.blocks = vec![1, 1]);
    rejected.at("lft.Bt[0]", |d| d.lft.blocks = vec![3]);
    rejected.at("lft.A[1]", |d| d.lft.a[1].push(0.0));
    rejected.at("lft.Cu", |d| d.lft.cu.truncate(2));
    rejected.at("lft.Dtt[0][1]", |d| d.lft.dtt[0][1] = f64::INFINITY);
    rejected.at("trim.speed", |d| d.trim.speed.truncate(1));
    rejected.at("trim.forward_speed", |d| d.trim.forward_speed[1] = 0.2);
    rejected.at("trim.signals.pitch", |d| column(d).truncate(2));
    rejected.at("trim.signals.pitch[2]", |d| column(d)[2] = f64::NAN);
    rejected.at("trim.actuators[1]", |d| d.trim.actuators[1].truncate(1));
    rejected.at("trim.actuators[1][2]", |d| d.trim.actuators[1][2] = 200.0);
    rejected.at("trim.speed", |d| d.trim.speed[2] = 2.9);
    rejected.at("gamma.bound", |d| d.gamma.bound = 0.0);
    insta::assert_snapshot!(rejected.messages);
}

#[test]
fn rejects_invalid_inputs() {
    let mut rejected = Rejected::new(example::two_degrees());
    rejected.at("controller_inputs[1].signal", |d| d.controller_inputs[1].signal = "yaw".to_owned());
    for kind in [Kind::Reference, Kind::Error] {
        rejected.at("controller_inputs[1].signal", |d| {
            d.controller_inputs[1] = example::input("pitch_rate", kind, 0.1)
        });
    }
    rejected.at("controller_inputs[2].unit", |d| d.controller_inputs[2].unit = "km/h".to_owned());
    rejected.at("controller_inputs[3].scale", |d| d.controller_inputs[3].scale = 0.0);
    rejected.at("controller_inputs[2].signal", |d| d.controller_inputs[2] = d.controller_inputs[0].clone());
    for bandwidth in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        rejected.at("reference_filter", |d| d.reference_filter = Some(bandwidth));
    }
    rejected.at("delay_ticks", |d| d.delay_ticks = 11);
    rejected.at("lft.By[0]", |d| d.lft.by[0].truncate(2));
    insta::assert_snapshot!(rejected.messages);
}

/// Reads a changed text and asserts that the error is one of JSON; returns the message.
fn unreadable(json: &str, from: &str, to: &str) -> String {
    let broken = json.replacen(from, to, 1);
    assert_ne!(broken, json);
    match ControllerDesign::from_json(&broken) {
        Err(DesignError::Json(error)) if error.is_data() => format!("{from} -> {to}:\n{error}\n\n"),
        other => panic!("{other:?}"),
    }
}

#[test]
fn reports_position_of_json_error() {
    let json = example::design().to_json().unwrap();
    let messages: String = [
        ("\"sample_time\"", "\"sampletime\""),
        ("\"design\": \"default\",", ""),
        ("\"surrogate\"", "\"guess\""),
        ("0.02", "\"fast\""),
    ]
    .map(|(from, to)| unreadable(&json, from, to))
    .concat();
    insta::assert_snapshot!(messages);
    let cut = json.trim_end().trim_end_matches('}');
    assert!(matches!(ControllerDesign::from_json(cut), Err(DesignError::Json(error)) if error.is_eof()));
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
    let falling = ControllerDesign::from_json(&falling).unwrap_err();
    assert!(matches!(&falling, DesignError::Json(error) if error.is_data()), "{falling}");
    let mut rejected = Rejected::new(design);
    rejected.at("actuators[0].maximum", |d| d.actuators[0].maximum = 111.0);
    insta::assert_snapshot!(format!("{falling}\n{}", rejected.messages));
}
