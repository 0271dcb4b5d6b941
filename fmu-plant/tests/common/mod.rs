//! Resources made from the vehicle files of this repository, and an FMU simulated without the C interface.

#![allow(dead_code, reason = "not every test needs everything")]

#[path = "../../../crates/fmi2/tests/flight/mod.rs"]
pub mod flight;

use std::path::Path;

use squid_auv::{Curve, Effect, LpvModel, Speed, Surge, Trim, Vehicle, linearise, trim};
use squid_fmi2::Resources;
use squid_fmu_plant::{LPV_RESOURCE, PlantModel, VEHICLE_RESOURCE, describe};

pub use flight::Flight;

pub const DEPTH: f64 = 50.0;

pub fn vehicle(name: &str) -> Vehicle {
    six_dof(name).in_plane()
}

/// Returns a vehicle of this repository in six degrees of freedom.
pub fn six_dof(name: &str) -> Vehicle {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../vehicles");
    let text = std::fs::read_to_string(root.join(name).join("vehicle.toml")).unwrap();
    Vehicle::parse(&text, "vehicle.toml").unwrap()
}

/// Returns Squid in six degrees of freedom, with the rudder of REMUS 100.
pub fn squid_with_rudder() -> Vehicle {
    let mut vehicle = six_dof("squid");
    vehicle.actuators.extend(six_dof("remus100").actuators.into_iter().filter(|one| one.name == "rudder"));
    vehicle
}

/// Returns an LPV model: parabolas in A and B through the linearisations at the ends and the centre of the speed range.
pub fn lpv(vehicle: &Vehicle, speeds: [f64; 3]) -> LpvModel {
    let trims: Vec<Trim> = speeds.map(|v| trim(vehicle, Speed::Path(v), DEPTH).unwrap()).to_vec();
    let [low, mid, high] = [0, 1, 2].map(|i: usize| linearise(vehicle, &trims[i]).unwrap());
    let a = [mid.a.clone(), (&high.a - &low.a) * 0.5, (&high.a + &low.a) * 0.5 - &mid.a];
    let b = [mid.b.clone(), (&high.b - &low.b) * 0.5, (&high.b + &low.b) * 0.5 - &mid.b];
    LpvModel::new(&vehicle.name, DEPTH, (speeds[1], speeds[2] - speeds[1]), &a, &b, &trims).unwrap()
}

/// Returns the files of a vehicle, with the LPV model of its motion in the vertical plane.
pub fn turning(vehicle: &Vehicle, speeds: [f64; 3]) -> Resources {
    let mut resources = of(&vehicle.in_plane(), speeds);
    resources.insert(VEHICLE_RESOURCE, vehicle.to_json().unwrap());
    resources
}

pub fn squid() -> Resources {
    resources("squid", [0.5, 1.75, 3.0])
}

/// Returns Squid with a last actuator without lag.
pub fn squid_without_lag() -> Resources {
    let mut vehicle = vehicle("squid");
    vehicle.actuators.last_mut().unwrap().lag = 0.0;
    of(&vehicle, [0.5, 1.75, 3.0])
}

/// Returns Squid with one thruster commanded by pulse width (with a dead band, and with reserve beyond the limits) and
/// one commanded by speed of rotation.
pub fn squid_with_curves() -> Resources {
    let mut vehicle = vehicle("squid");
    let points = vec![[1100.0, -80.0], [1470.0, 0.0], [1530.0, 0.0], [1900.0, 130.0]];
    vehicle.actuators[0].curve = Some(Curve::through(points, "us").unwrap());
    vehicle.actuators[1].curve = Some(Curve::square(1e-4, "rpm").unwrap());
    of(&vehicle, [0.5, 1.75, 3.0])
}

/// Returns Squid with planes in place of its thrusters, and a prescribed speed.
pub fn squid_with_given_speed() -> Resources {
    let mut vehicle = vehicle("squid");
    vehicle.coefficients.surge = Surge::Given { lag: 0.8 };
    for actuator in &mut vehicle.actuators {
        actuator.effect = Effect::planes(-9.0, -7.0, 0.0);
        (actuator.min, actuator.max) = (-0.6, 0.6);
    }
    of(&vehicle, [0.5, 1.75, 3.0])
}

pub fn remus100() -> Resources {
    resources("remus100", [1.0, 1.75, 2.5])
}

fn resources(name: &str, speeds: [f64; 3]) -> Resources {
    of(&vehicle(name), speeds)
}

fn of(vehicle: &Vehicle, speeds: [f64; 3]) -> Resources {
    let model = lpv(vehicle, speeds).to_json().unwrap();
    [(VEHICLE_RESOURCE, vehicle.to_json().unwrap()), (LPV_RESOURCE, model)].into_iter().collect()
}

/// Returns a plant in initialisation mode with the given parameters; `fidelity` by its number.
pub fn prepare(resources: &Resources, parameters: &[(&str, f64)]) -> Flight<PlantModel> {
    let mut flight = Flight::prepare(describe(resources).unwrap(), 0.0);
    for &(name, value) in parameters {
        match name {
            "fidelity" => flight.set(name, value as i32),
            _ => flight.set(name, value),
        }
    }
    flight.instance.enter_initialization().unwrap();
    flight
}

/// Returns a plant ready to step.
pub fn start(resources: &Resources, parameters: &[(&str, f64)]) -> Flight<PlantModel> {
    let mut flight = prepare(resources, parameters);
    flight.exit().unwrap();
    flight
}
