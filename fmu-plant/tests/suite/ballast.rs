//! External loads, and weight, buoyancy and centre of gravity that change in flight.

use crate::common::flight::masked;
use crate::common::{Flight, prepare, remus100, squid, squid_with_given_speed, start, vehicle};
use squid_fmi2::{Experiment, Instance, Interface, Refusal, Resources, Silent};
use squid_fmu_plant::{PlantModel, describe};

const OUTPUTS: [&str; 7] = ["pitch", "speed", "heave", "pitch_rate", "path_speed", "depth", "distance"];
const TUNABLE: [&str; 4] = ["weight", "buoyancy", "x_G", "z_G"];

fn outputs(flight: &mut Flight<PlantModel>) -> [f64; 7] {
    OUTPUTS.map(|name| flight.get(name))
}

/// Sets several variables in one call of `fmi2SetReal`.
fn set_all(flight: &mut Flight<PlantModel>, values: &[(&str, f64)]) -> Result<(), Refusal> {
    let references: Vec<u32> = values.iter().map(|(name, _)| flight.reference(name)).collect();
    flight.instance.set(&references, |index| values[index].1)
}

/// Dropping a weight changes the derivatives of velocities and position, but not their values.
#[test]
fn dropped_weight_keeps_velocity_and_position() {
    for files in [squid(), remus100()] {
        let mut flight = start(&files, &[]);
        flight.set("current_vertical", 0.05);
        flight.fly_in(2.0, 20);
        let (before, weight, mass) = (outputs(&mut flight), flight.get("weight"), flight.get("mass"));
        let rates = ["der(surge_over_ground)", "der(heave_over_ground)", "der(pitch_rate)"];
        let held = rates.map(|name| flight.get(name));
        set_all(&mut flight, &[("weight", 0.95 * weight), ("z_G", 0.9 * z_g(&files))]).unwrap();
        assert_eq!(outputs(&mut flight), before);
        assert_eq!((flight.get("weight"), flight.get("mass")), (0.95 * weight, mass));
        assert!(flight.get("der(heave_over_ground)") < held[1] - 0.1);
        let inside = flight.instance.model().settings.coefficients.clone();
        assert_eq!((inside.mass, inside.I_yy), (mass, vehicle_of(&files).coefficients.I_yy));
        // Restoring the weight restores the vehicle to the last bit.
        set_all(&mut flight, &[("weight", weight), ("z_G", z_g(&files))]).unwrap();
        assert_eq!(rates.map(|name| flight.get(name)), held);
    }
}

fn vehicle_of(files: &Resources) -> squid_auv::Vehicle {
    squid_auv::Vehicle::from_json(files.text(squid_fmu_plant::VEHICLE_RESOURCE).unwrap(), "vehicle").unwrap()
}

fn z_g(files: &Resources) -> f64 {
    vehicle_of(files).coefficients.z_G
}

/// Changing the weight in flight gives the same accelerations as that mass from the start.
#[test]
fn weight_change_equals_vehicle_of_that_mass() {
    let rates = ["der(surge_over_ground)", "der(heave_over_ground)", "der(pitch_rate)"];
    let c = vehicle("squid").coefficients;
    let moving = |parameters: &[(&str, f64)]| {
        let mut instance = Instance::made_for(Interface::ModelExchange, describe(&squid()).unwrap());
        instance.set_up(Experiment::default()).unwrap();
        let mut flight = Flight { instance, log: Default::default() };
        parameters.iter().for_each(|&(name, value)| flight.set(name, value));
        flight.begin().unwrap();
        flight
    };
    let mut dropped = moving(&[]);
    let weight = 0.9 * c.weight;
    dropped.set("weight", weight);
    let mut light = moving(&[("weight", weight), ("mass", c.mass * 0.9)]);
    for flight in [&mut dropped, &mut light] {
        flight.instance.new_discrete_states(&mut Silent).unwrap();
        flight.instance.enter_continuous_time_mode().unwrap();
        let mut states = [1.3, 0.1, -0.05, 0.1, 0.0, 20.0, 5.0, 1.0, 2.0];
        assert_eq!(flight.instance.table().states().len(), states.len());
        states[4] = 3.0;
        flight.instance.set_continuous_states(&states).unwrap();
    }
    for name in rates {
        let (one, other) = (dropped.get(name), light.get(name));
        assert!((one - other).abs() < 1e-14 + 1e-13 * other.abs(), "{name}: {one} and {other}");
    }
    // Continuous-time mode allows no discontinuities.
    let weight = dropped.reference("weight");
    let refused = dropped.instance.set(&[weight], |_| 600.0).unwrap_err();
    assert!(matches!(&refused, Refusal::NotSettable { name, .. } if name == "weight"), "{refused}");
}

/// `fmi2SetReal` sets states and parameters in one call, or none of them.
#[test]
fn event_mode_sets_weight_and_state_together() {
    let mut instance = Instance::made_for(Interface::ModelExchange, describe(&squid()).unwrap());
    instance.set_up(Experiment::default()).unwrap();
    let mut flight = Flight { instance, log: Default::default() };
    flight.begin().unwrap();
    let references = ["pitch", "weight"].map(|name| flight.reference(name));
    let before = [flight.get("pitch"), flight.get("weight")];
    let refused = flight.instance.set_real(&references, &[0.2, -1.0]).unwrap_err();
    assert!(matches!(refused, Refusal::NotTuned { .. }), "{refused}");
    assert_eq!([flight.get("pitch"), flight.get("weight")], before);
    flight.instance.set_real(&references, &[0.2, 640.0]).unwrap();
    assert_eq!([flight.get("pitch"), flight.get("weight")], [0.2, 640.0]);
    assert_eq!(flight.instance.model().settings.coefficients.weight, 640.0);
}

#[test]
fn external_load_moves_vehicle_in_its_direction() {
    for fidelity in [1.0, 2.0] {
        for (name, load, moved) in [
            ("external_force_x", 2.0, "speed"),
            ("external_force_z", 2.0, "depth"),
            ("external_moment", 0.5, "pitch"),
        ] {
            let [mut plain, mut pushed] = [0.0, load].map(|load| {
                let mut flight = prepare(&squid(), &[("fidelity", fidelity)]);
                assert_eq!(flight.get(name), 0.0);
                flight.set(name, load);
                flight.exit().unwrap();
                flight.fly_in(2.0, 20);
                assert_eq!(flight.get(name), load);
                flight
            });
            assert!(pushed.get(moved) > plain.get(moved) + 1e-3, "{name} at fidelity {fidelity}");
        }
    }
    let mut given = start(&squid_with_given_speed(), &[]);
    assert!(given.instance.table().reference("external_force_x").is_none(), "it would have no effect");
    let heave = given.get("heave");
    given.set("external_force_z", 20.0);
    given.fly_in(0.2, 2);
    assert!(given.get("heave") > heave + 0.01);
}

#[test]
fn rejects_invalid_ballast_and_continues() {
    let (mut flight, mut plain) = (start(&squid(), &[]), start(&squid(), &[]));
    for flight in [&mut flight, &mut plain] {
        flight.fly_in(1.0, 10);
        flight.set("weight", 640.0);
    }
    let mut messages = vec![];
    for (name, value) in [("weight", 0.0), ("weight", -650.0), ("buoyancy", -1.0), ("x_G", 10.0)] {
        let values = [("lower", 3.0), ("z_G", 0.5), (name, value), ("external_force_z", 7.0)];
        let refused = set_all(&mut flight, &values).unwrap_err();
        assert!(matches!(refused, Refusal::NotTuned { .. }), "{refused}");
        // The least eigenvalue of the mass matrix is computed.
        messages.push(if name == "x_G" { masked(&refused.to_string()) } else { refused.to_string() });
        assert_eq!(flight.get("weight"), 640.0);
    }
    for value in [f64::NAN, f64::INFINITY] {
        let refused = set_all(&mut flight, &[("external_moment", 1.0), ("weight", value)]).unwrap_err();
        assert!(matches!(&refused, Refusal::NotFinite { name, .. } if name == "weight"), "{refused}");
    }
    insta::assert_snapshot!(messages.join("\n"));
    for name in ["lower", "external_force_z", "external_moment"].into_iter().chain(TUNABLE) {
        assert_eq!(flight.get(name), plain.get(name), "{name}");
    }
    for flight in [&mut flight, &mut plain] {
        flight.fly_in(5.0, 40);
    }
    assert_eq!(outputs(&mut flight), outputs(&mut plain));
}

/// The LPV model depends on the coefficients of the file, and cannot represent a change.
#[test]
fn lpv_model_rejects_ballast_change() {
    let mut flight = start(&squid(), &[("fidelity", 2.0), ("buoyancy", 660.0)]);
    let weight = flight.get("weight");
    set_all(&mut flight, &[("weight", weight), ("buoyancy", 660.0)]).expect("nothing changes");
    insta::assert_snapshot!(set_all(&mut flight, &[("weight", 0.95 * weight)]).unwrap_err());
    assert_eq!(flight.get("weight"), weight);
    flight.fly_in(1.0, 10);
}

#[test]
fn reset_restores_start_values() {
    let mut flight = start(&squid(), &[]);
    let start_values = TUNABLE.map(|name| flight.get(name));
    flight.fly_in(1.0, 10);
    let flown = outputs(&mut flight);
    let values = [("weight", 600.0), ("buoyancy", 640.0), ("x_G", 0.01), ("external_force_z", 3.0)];
    set_all(&mut flight, &values).unwrap();
    flight.fly_in(2.0, 10);
    flight.instance.reset().unwrap();
    flight.instance.set_up(Experiment::default()).unwrap();
    flight.begin().unwrap();
    assert_eq!(TUNABLE.map(|name| flight.get(name)), start_values);
    assert_eq!(flight.get("external_force_z"), 0.0);
    flight.fly_in(1.0, 10);
    assert_eq!(outputs(&mut flight), flown);
}
