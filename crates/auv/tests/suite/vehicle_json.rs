//! A vehicle as JSON: round trips are exact, and mistakes are reported with their key; snapshots hold the
//! messages.

use crate::common::{json_message, remus100, squid};
use proptest::prelude::*;
use serde_json::{Value, json};
use squid_auv::{COEFFICIENTS, CoefficientError, Curve, JsonProblem, Vehicle, VehicleJsonError};

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

/// Changes one value of the JSON of a vehicle and returns the error.
fn rejected(vehicle: &Vehicle, at: &str, value: Value) -> VehicleJsonError {
    let mut json: Value = serde_json::from_str(&vehicle.to_json().unwrap()).unwrap();
    *json.pointer_mut(at).unwrap_or_else(|| panic!("{at}")) = value;
    Vehicle::from_json(&json.to_string(), "v.json").unwrap_err()
}

#[test]
fn reports_mistakes_with_their_key() {
    let (squid, remus) = (squid(), remus100());
    let messages = [
        (&squid, "/format", json!("auv-vehicle/9"), "format"),
        (&squid, "/name", json!("../squid"), "name"),
        (&squid, "/status", json!("guessed"), "status"),
        (&squid, "/coefficients", json!({"Z_wu": 1.0}), "coefficients.Z_wu"),
        (&squid, "/coefficients", json!({"mass": 1.0}), "coefficients.weight"),
        (&squid, "/coefficients/mass", json!(-1.0), "mass"),
        (&squid, "/actuators", json!([]), "actuators"),
        (&squid, "/actuators/0/name", json!("9"), "actuators.name"),
        (&squid, "/actuators/1/name", json!("lower"), "actuators.name"),
        (&squid, "/actuators/0/kind", json!("sail"), "lower.kind"),
        (&squid, "/actuators/0/kind", json!("control_surface"), "lower.direction"),
        (&squid, "/actuators/0/numbers", json!({"min": 0.0}), "lower.max"),
        (&squid, "/actuators/0/numbers/min", json!(1e3), "lower.min"),
        (&squid, "/actuators/0/numbers/lag", json!(-0.5), "lower.lag"),
        (&remus, "/geometry", json!([1.0, 0.6]), "geometry"),
        (&remus, "/actuators/1/numbers/X_uu_delta2", json!(2.0), "stern_planes.X_uu_delta2"),
    ]
    .map(|(vehicle, at, value, key)| {
        json_message(&format!("{at} = {value}"), &rejected(vehicle, at, value.clone()), key)
    });
    insta::assert_snapshot!(messages.join("\n\n"));
    let text = rejected(&squid, "/coefficients/mass", json!("heavy"));
    assert!(matches!(text.problem, JsonProblem::NotJson(_)), "{text}");
    let matrix = rejected(&squid, "/coefficients/z_G", json!(3.0)).problem;
    let JsonProblem::Coefficients(CoefficientError::MassMatrixNotPositiveDefinite {
        least_eigenvalue, ..
    }) = matrix
    else {
        panic!("{matrix}")
    };
    assert!(least_eigenvalue < 0.0);
}

#[test]
fn curve_round_trips_and_is_checked() {
    let mut vehicle = squid();
    vehicle.actuators[0].curve =
        Some(Curve::through(vec![[-1.0, -60.0], [0.5, 0.0], [1.0, 100.0]], "%").unwrap());
    vehicle.actuators[1].curve = Some(Curve::square(0.01, "rad/s").unwrap());
    assert_eq!(Vehicle::from_json(&vehicle.to_json().unwrap(), "v").unwrap(), vehicle);
    let messages = [
        ("/actuators/0/curve/points/1/1", json!(-70.0), ""),
        ("/actuators/0/curve/unit", json!("V"), ""),
        ("/actuators/1/curve/square", json!(-1.0), ""),
        ("/actuators/1/curve", json!({"unit": "rpm"}), ""),
        ("/actuators/0/numbers/max", json!(101.0), "lower.curve"),
    ]
    .map(|(at, value, key)| {
        json_message(&format!("{at} = {value}"), &rejected(&vehicle, at, value.clone()), key)
    });
    insta::assert_snapshot!(messages.join("\n\n"));
}

#[test]
fn rejects_duplicate_numbers_and_incomplete_text() {
    let text = squid().to_json().unwrap();
    let mut messages = vec![];
    for (key, value) in [("mass", "90.0"), ("lag", "5.0"), ("lower.max", "\"guessed\"")] {
        let at = text.find(&format!("\"{key}\": ")).unwrap();
        let duplicated = format!("{}\"{key}\": {value}, {}", &text[..at], &text[at..]);
        let error = Vehicle::from_json(&duplicated, "v.json").unwrap_err();
        messages.push(json_message(&format!("{key} twice"), &error, ""));
    }
    let error = Vehicle::from_json("{", "v.json").unwrap_err();
    messages.push(json_message("{", &error, ""));
    insta::assert_snapshot!(messages.join("\n\n"));
}
