//! Vehicles of this repository.

#![allow(dead_code, reason = "not every test needs every vehicle")]

use std::path::Path;

use squid_auv::Vehicle;

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
