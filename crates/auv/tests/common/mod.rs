//! Vehicles of this repository.

#![allow(dead_code, reason = "not every test needs every vehicle")]

use std::path::Path;

use squid_auv::toml_file::FileError;
use squid_auv::{CoefficientError, JsonProblem, Vehicle, VehicleJsonError};

pub fn squid() -> Vehicle {
    vehicle("squid")
}

pub fn remus100() -> Vehicle {
    vehicle("remus100")
}

/// Returns a box with a forward and two vertical groups of thrusters, without lift.
pub fn bluerov2_heavy() -> Vehicle {
    vehicle("bluerov2_heavy")
}

/// Returns a vehicle in the vertical plane.
fn vehicle(name: &str) -> Vehicle {
    six_dof(name).in_plane()
}

/// Returns a vehicle in six degrees of freedom, if its file has the coefficients.
pub fn six_dof(name: &str) -> Vehicle {
    Vehicle::parse(&text(name), "vehicle.toml").unwrap_or_else(|error| panic!("{error}"))
}

/// Returns the text of a vehicle file.
pub fn text(name: &str) -> String {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../vehicles");
    std::fs::read_to_string(root.join(name).join("vehicle.toml")).unwrap()
}

/// Returns line and key of each mistake in a file.
pub fn places(error: &FileError) -> Vec<(usize, &str)> {
    error.mistakes.iter().map(|one| (one.line, one.problem.key().unwrap_or_default())).collect()
}

/// Checks line and key of the only mistake in a file, and returns its message below what caused it.
#[track_caller]
pub fn message(what: &str, error: &FileError, place: (usize, &str)) -> String {
    assert_eq!(places(error), [place], "{error}");
    let what = if what.is_empty() { "left out" } else { what };
    format!("{what}:\n{}", error.mistakes[0].problem)
}

/// Checks the key of a mistake in the JSON of a vehicle, `""` in text that is none, and returns its message below what
/// caused it.
#[track_caller]
pub fn json_message(what: &str, error: &VehicleJsonError, key: &str) -> String {
    let found = match &error.problem {
        JsonProblem::NotAllowed { key, .. } | JsonProblem::Missing(key) | JsonProblem::Unknown(key) => key,
        JsonProblem::Coefficients(CoefficientError::NotAllowed { key, .. }) => *key,
        JsonProblem::Coefficients(_) => panic!("{error}"),
        JsonProblem::NotJson(_) => "",
    };
    assert_eq!(found, key, "{error}");
    // Line and column change with the digits of the vehicle file.
    format!("{what}:\n{}", error.to_string().split(" at line ").next().unwrap())
}
