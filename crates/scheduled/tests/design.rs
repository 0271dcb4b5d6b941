//! Reading, writing and refusing designs.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

mod example;

use proptest::prelude::*;
use scheduled::ControllerDesign;

#[test]
fn reads_back_what_it_wrote() {
    let design = example::design();
    let json = design.to_json().unwrap();
    assert_eq!(ControllerDesign::from_json(&json).unwrap(), design);
    assert!(json.contains("[0.1, 0.05]"), "a row a line:\n{json}");
}

proptest! {
    #[test]
    fn numbers_read_back_to_the_bit(value in prop::num::f64::NORMAL | prop::num::f64::ZERO | prop::num::f64::SUBNORMAL) {
        let mut design = example::design();
        design.lft.a[0][1] = value;
        let read = ControllerDesign::from_json(&design.to_json().unwrap()).unwrap();
        prop_assert_eq!(read.lft.a[0][1].to_bits(), value.to_bits());
    }
}

#[test]
fn brackets_in_names_survive() {
    let mut design = example::design();
    design.vehicle.name = "Squid [1  2], \"x\"".to_owned();
    assert_eq!(ControllerDesign::from_json(&design.to_json().unwrap()).unwrap(), design);
}

/// Changes the design and asserts that the message names the key.
#[track_caller]
fn assert_refused(change: impl FnOnce(&mut ControllerDesign), expected: &str) {
    let mut design = example::design();
    change(&mut design);
    let message = design.validate().unwrap_err().to_string();
    assert!(message.contains(expected), "{message}");
    assert!(design.to_json().is_err());
}

#[test]
fn refuses_designs_that_make_no_sense() {
    assert_refused(|d| d.format = "squid-controller/2".to_owned(), "only 'squid-controller/1' can be read");
    assert_refused(|d| d.sample_time = 0.0, "sample_time is 0");
    assert_refused(|d| d.sample_time = f64::NAN, "sample_time is NaN");
    assert_refused(|d| d.sample_time = 1e-300, "must be finite and at least 1e-5");
    assert_refused(|d| d.sample_time = f64::INFINITY, "sample_time is inf");
    assert_refused(|d| d.scheduling.quantity = "depth".to_owned(), "scheduling.quantity is 'depth'");
    assert_refused(|d| d.scheduling.maximum = 0.4, "scheduling reaches from 0.5 to 0.4");
    assert_refused(|d| d.scheduling.centre = 1.7, "0.5 m/s gives rho");
    assert_refused(|d| d.tracked.clear(), "tracked is empty");
    assert_refused(|d| d.tracked[1].name = "depth".to_owned(), "tracked[1].name is 'depth'");
    assert_refused(|d| d.tracked[0].unit = "deg".to_owned(), "tracked[0].unit is 'deg'");
    assert_refused(|d| d.tracked[0].scale = -1.0, "tracked[0].scale is -1");
    assert_refused(|d| d.tracked[1] = d.tracked[0].clone(), "tracked[1].name is 'pitch'");
    assert_refused(|d| d.actuators.clear(), "actuators is empty");
    assert_refused(|d| d.actuators[1].name = "thruster_1".to_owned(), "actuators[1].name is 'thruster_1'");
    assert_refused(|d| d.actuators[1].name = "a b".to_owned(), "actuators[1].name is 'a b'");
    assert_refused(|d| d.actuators[2].minimum = 100.0, "actuators[2] reaches from 100 to 100");
    assert_refused(|d| d.lft.blocks = vec![1, 1], "lft.blocks has 2 parameters");
    assert_refused(|d| d.lft.blocks = vec![3], "lft.Bt[0] has 2 entries, but must have 3");
    assert_refused(|d| d.lft.a[1].push(0.0), "lft.A[1] has 3 entries, but must have 2");
    assert_refused(|d| d.lft.cu.truncate(2), "lft.Cu has 2 entries, but must have 3");
    assert_refused(|d| d.lft.dtt[0][1] = f64::INFINITY, "lft.Dtt[0][1] is inf");
    assert_refused(|d| d.trim.speed.truncate(1), "trim.speed has 1 entries");
    assert_refused(
        |d| d.trim.forward_speed[1] = 0.2,
        "trim.forward_speed must increase, but 0.2 follows 0.49",
    );
    assert_refused(|d| d.trim.pitch.truncate(2), "trim.pitch has 2 entries, but must have 3");
    assert_refused(|d| d.trim.pitch[2] = f64::NAN, "trim.pitch[2] is NaN");
    assert_refused(|d| d.trim.actuators[1].truncate(1), "trim.actuators[1] has 1 entries");
    assert_refused(|d| d.trim.actuators[1][2] = 200.0, "trim.actuators[1][2] is 200, outside the limits");
    assert_refused(|d| d.trim.speed[2] = 2.9, "trim.speed covers 0.5 .. 2.9 m/s");
    assert_refused(|d| d.gamma.bound = 0.0, "gamma.bound is 0");
}

#[test]
fn says_where_the_json_is_wrong() {
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
