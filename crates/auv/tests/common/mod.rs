//! The vehicles of this repository.

#![allow(dead_code, reason = "not every test needs every vehicle")]

use std::path::Path;

use auv::Vehicle;

pub fn squid() -> Vehicle {
    vehicle("squid")
}

pub fn remus100() -> Vehicle {
    vehicle("remus100")
}

/// A box with a forward and two vertical groups of thrusters, without lift.
pub fn bluerov2_heavy() -> Vehicle {
    vehicle("bluerov2_heavy")
}

fn vehicle(name: &str) -> Vehicle {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../vehicles");
    let text = std::fs::read_to_string(root.join(name).join("vehicle.toml")).unwrap();
    Vehicle::parse(&text, "vehicle.toml").unwrap_or_else(|error| panic!("{error}"))
}
