//! A vehicle as JSON: round trips are exact, and mistakes are reported with their key.

use crate::common::{remus100, squid};
use proptest::prelude::*;
use serde_json::{Value, json};
use squid_auv::{COEFFICIENTS, Curve, Vehicle};

#[test]
fn vehicle_round_trips_to_the_bit() {
    for mut vehicle in [squid(), remus100()] {
        // The JSON omits the published model: it is for the report only.
        vehicle.published_linear_model = None;
        let text = vehicle.to_json().unwrap();
        assert_eq!(Vehicle::from_json(&text, "v").unwrap(), vehicle);
        assert!(text.contains("\"surrogate\"") || text.contains("\"published\""), "{text}");
    }
}

/// Files of earlier versions lack the coefficients that were added later.
#[test]
fn absent_coefficients_have_their_defaults() {
    let vehicle = squid();
    let mut json: Value = serde_json::from_str(&vehicle.to_json().unwrap()).unwrap();
    for key in ["X_u", "Z_q", "M_w", "x_G", "form_factor"] {
        assert!(json["coefficients"].as_object_mut().unwrap().remove(key).is_some(), "{key}");
    }
    let read = Vehicle::from_json(&json.to_string(), "v").unwrap();
    assert_eq!((read.coefficients.M_w, read.coefficients.form_factor), (0.0, 1.0));
    assert_eq!(read.coefficients.Z_uw, vehicle.coefficients.Z_uw);
}

proptest! {
    /// Numbers are unchanged by JSON, for any digits.
    #[test]
    fn every_number_round_trips(scale in 1e-6..1e6f64, row in 0..COEFFICIENTS.len()) {
        let mut vehicle = squid();
        let spec = &COEFFICIENTS[row];
        let value = (spec.get)(&vehicle.coefficients) * scale;
        (spec.set)(&mut vehicle.coefficients, value);
        prop_assume!(vehicle.coefficients.check().is_ok());
        let back = Vehicle::from_json(&vehicle.to_json().unwrap(), "v").unwrap();
        prop_assert_eq!((spec.get)(&back.coefficients).to_bits(), value.to_bits());
    }
}

/// Changes one value of the JSON of a vehicle and returns the error message.
fn error_message(vehicle: &Vehicle, at: &str, value: Value) -> String {
    let mut json: Value = serde_json::from_str(&vehicle.to_json().unwrap()).unwrap();
    *json.pointer_mut(at).unwrap_or_else(|| panic!("{at}")) = value;
    Vehicle::from_json(&json.to_string(), "v.json").unwrap_err().to_string()
}

#[test]
fn rejects_a_hull_that_is_not_slender() {
    let found = error_message(&remus100(), "/geometry", json!([1.0, 0.6]));
    assert!(found.contains("`geometry` is [1, 0.6], and must be above zero, and at most half"), "{found}");
}

#[test]
fn reports_mistakes_with_their_key() {
    let squid = squid();
    for (at, value, expected) in [
        ("/format", json!("auv-vehicle/9"), "`format` is auv-vehicle/9, and must be auv-vehicle/1"),
        ("/name", json!("../squid"), "`name` is ../squid, and must be the name of a vehicle"),
        ("/status", json!("guessed"), "`status` is guessed, and must be surrogate, published or measured"),
        ("/coefficients", json!({"Z_wu": 1.0}), "`coefficients.Z_wu` is unknown"),
        ("/coefficients", json!({"mass": 1.0}), "`coefficients.weight` is missing"),
        ("/coefficients/mass", json!(-1.0), "mass is -1 kg, and must be a number above zero"),
        ("/coefficients/mass", json!("heavy"), "not a vehicle: invalid type: string"),
        ("/actuators", json!([]), "`actuators` is empty, and must be one actuator or more"),
        ("/actuators/0/name", json!("9"), "`actuators.name` is 9, and must be a name of its own"),
        ("/actuators/1/name", json!("lower"), "`actuators.name` is lower, and must be a name of its own"),
        (
            "/actuators/0/kind",
            json!("sail"),
            "`lower.kind` is sail, and must be thruster, thruster_group or control_surface",
        ),
        ("/actuators/0/kind", json!("control_surface"), "`lower.direction` is unknown"),
        ("/actuators/0/numbers", json!({"min": 0.0}), "`lower.max` is missing"),
        ("/actuators/0/numbers/min", json!(1e3), "`lower.min` is 1000, and must be below max"),
        (
            "/actuators/0/numbers/lag",
            json!(-0.5),
            "`lower.lag` is -0.5, and must be zero or a positive number",
        ),
    ] {
        let message = error_message(&squid, at, value);
        assert!(message.starts_with(&format!("v.json: {expected}")), "{at}: {message}");
    }
}

#[test]
fn curve_round_trips_and_is_checked() {
    let mut vehicle = squid();
    vehicle.actuators[0].curve =
        Some(Curve::through(vec![[-1.0, -60.0], [0.5, 0.0], [1.0, 100.0]], "%").unwrap());
    vehicle.actuators[1].curve = Some(Curve::square(0.01, "rad/s").unwrap());
    assert_eq!(Vehicle::from_json(&vehicle.to_json().unwrap(), "v").unwrap(), vehicle);
    for (at, value, expected) in [
        (
            "/actuators/0/curve/points/1/1",
            json!(-70.0),
            "not a vehicle: the points of a curve must be two pairs",
        ),
        (
            "/actuators/0/curve/unit",
            json!("V"),
            "not a vehicle: the commands of a curve are in 'V', and must be in",
        ),
        (
            "/actuators/1/curve/square",
            json!(-1.0),
            "not a vehicle: the square law of a curve has the factor -1",
        ),
        ("/actuators/1/curve", json!({"unit": "rpm"}), "not a vehicle: a curve must have either `points` or"),
        (
            "/actuators/0/numbers/max",
            json!(101.0),
            "`lower.curve` is for other outputs than -60 to 101, and must be that of a thruster, and reach its limits",
        ),
    ] {
        let message = error_message(&vehicle, at, value);
        assert!(message.starts_with(&format!("v.json: {expected}")), "{at}: {message}");
    }
}

#[test]
fn rejects_duplicate_numbers() {
    let text = squid().to_json().unwrap();
    for (key, value) in [("mass", "90.0"), ("lag", "5.0"), ("lower.max", "\"guessed\"")] {
        let at = text.find(&format!("\"{key}\": ")).unwrap();
        let duplicated = format!("{}\"{key}\": {value}, {}", &text[..at], &text[at..]);
        let message = Vehicle::from_json(&duplicated, "v.json").unwrap_err().to_string();
        assert!(
            message.starts_with("v.json: not a vehicle: invalid entry: found duplicate key"),
            "{message}"
        );
    }
}

#[test]
fn rejects_indefinite_mass_matrix_and_fin_with_thrust() {
    let message = error_message(&squid(), "/coefficients/z_G", json!(3.0));
    assert!(message.starts_with("v.json: the mass matrix"), "{message}");
    let message = error_message(&remus100(), "/actuators/1/numbers/X_uu_delta2", json!(2.0));
    assert!(message.contains(".X_uu_delta2` is 2, and must be zero or a negative number"), "{message}");
    let message = Vehicle::from_json("{", "v.json").unwrap_err().to_string();
    assert!(message.starts_with("v.json: not a vehicle: EOF"), "{message}");
}
