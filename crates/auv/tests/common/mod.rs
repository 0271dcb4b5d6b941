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

fn vehicle(name: &str) -> Vehicle {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../vehicles");
    Vehicle::read(&root.join(name).join("vehicle.toml")).unwrap_or_else(|error| panic!("{error}"))
}

/// A box-shaped vehicle with a forward and two vertical thrusters, without lift: the vertical plane of the BlueROV2
/// Heavy, M. von Benzon et al., J. Mar. Sci. Eng. 10(12), 2022, 1898.
pub fn box_rov() -> Vehicle {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/cases/box_rov/vehicle.toml");
    Vehicle::read(&file).unwrap_or_else(|error| panic!("{error}"))
}
