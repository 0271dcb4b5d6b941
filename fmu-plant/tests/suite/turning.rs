//! The plant in six degrees of freedom.

use crate::common::{Flight, remus100, six_dof, start, turning};
use squid_auv::{Current, Plant, Speed, State, trim};
use squid_fmi2::model_description::Causality;
use squid_fmu_plant::{PlantModel, describe};
use std::f64::consts::FRAC_PI_2;

const SPEEDS: [f64; 3] = [1.0, 1.75, 2.5];

/// Simulates ten seconds with the trim commands and the given changes.
fn flown(parameters: &[(&str, f64)], inputs: &[(&str, f64)]) -> Flight<PlantModel> {
    let mut flight = start(&turning(&six_dof("remus100"), SPEEDS), parameters);
    for &(name, by) in inputs {
        let trimmed = flight.instance.table().reference(&format!("trim_{name}"));
        let from = trimmed.map_or(0.0, |_| flight.get(&format!("trim_{name}")));
        flight.set(name, from + by);
    }
    flight.fly_in(10.0, 1000);
    flight
}

fn all(flight: &mut Flight<PlantModel>, names: &[&str]) -> Vec<f64> {
    names.iter().map(|name| flight.get(name)).collect()
}

fn close(one: &[f64], other: &[f64], tolerance: f64) {
    assert!(one.iter().zip(other).all(|(a, b)| (a - b).abs() < tolerance), "{one:?} and {other:?}");
}

#[test]
fn six_dof_has_no_variables_of_vertical_plane_only() {
    let described = describe(&turning(&six_dof("remus100"), SPEEDS)).unwrap();
    let description = described.description;
    let has = |name: &str| description.position(name).is_some();
    for name in ["fidelity", "operating_speed", "current_horizontal", "distance", "external_moment"] {
        assert!(!has(name), "{name}");
    }
    for name in [
        "rudder",
        "current_north",
        "current_east",
        "external_moment_z",
        "N_uv",
        "I_xx",
        "initial_heading",
        "wave_height",
    ] {
        assert!(has(name), "{name}");
    }
    assert_eq!(description.structure().derivatives.len(), 12 + 3);
    let inputs = description.variables.iter().filter(|one| one.causality == Causality::Input);
    assert_eq!(inputs.count(), 3 + 3 + 6);
}

/// Every input acts on the quantity of its name: the motion equals that of the vehicle simulated directly.
#[test]
fn equals_vehicle_simulated_directly() {
    let vehicle = six_dof("remus100");
    let mut flight = flown(
        &[("initial_speed", 1.6), ("initial_depth", 20.0), ("initial_heading", 0.4)],
        &[
            ("rudder", 0.1),
            ("stern_planes", -0.02),
            ("current_north", 0.1),
            ("current_east", 0.3),
            ("current_vertical", 0.05),
            ("external_force_x", 0.5),
            ("external_force_y", -0.7),
            ("external_force_z", 0.6),
            ("external_moment_x", 0.05),
            ("external_moment_y", 0.2),
            ("external_moment_z", -0.3),
        ],
    );
    let plane = vehicle.in_plane();
    let mut level = trim(&plane, Speed::Path(1.6), 20.0).unwrap();
    level.actuators = vehicle.outputs_of_plane(&plane, &level.actuators);
    let mut plant = Plant::new(&vehicle).unwrap();
    plant.start(0.0, &level).unwrap();
    plant.set_state(&State { heading: 0.4, ..plant.state() });
    // The propeller command is that of trim at the default initial speed.
    for (index, actuator) in vehicle.actuators.iter().enumerate() {
        let by = match actuator.name.as_str() {
            "rudder" => 0.1,
            "stern_planes" => -0.02,
            _ => flight.get(&actuator.name) - level.actuators[index],
        };
        plant.set_command(index, level.actuators[index] + by).unwrap();
    }
    plant.set_load([0.5, -0.7, 0.6, 0.05, 0.2, -0.3]).unwrap();
    plant.set_current(Current { horizontal: 0.1, east: 0.3, vertical: 0.05 }).unwrap();
    plant.advance(10.0).unwrap();
    let State { motion, x, depth, heading, east, .. } = plant.state();
    let [roll_rate, pitch_rate, heading_rate] = motion.turning();
    let names = ["speed", "sway", "heave", "angular_velocity_x", "angular_velocity_y", "angular_velocity_z"];
    close(&all(&mut flight, &names), &[motion.u, motion.v, motion.w, motion.p, motion.q, motion.r], 1e-9);
    let names =
        ["roll", "pitch", "heading", "north", "east", "depth", "roll_rate", "pitch_rate", "heading_rate"];
    let expected = [motion.phi, motion.theta, heading, x, east, depth, roll_rate, pitch_rate, heading_rate];
    close(&all(&mut flight, &names), &expected, 1e-9);
    assert!((heading - 0.4).abs() > 0.2 && motion.phi.abs() > 1e-3, "it turned and rolled");
}

/// Returns the parameters of a start five metres below waves with a direction of propagation.
fn sea(heading: f64) -> [(&'static str, f64); 4] {
    [("initial_depth", 5.0), ("wave_height", 0.5), ("wave_period", 5.0), ("wave_heading", heading)]
}

/// Motion without lateral inputs equals that of the vehicle in the vertical plane, in still water and a following sea.
#[test]
fn straight_motion_equals_vertical_plane() {
    for parameters in [&[][..], &sea(0.0)] {
        let mut plane = start(&remus100(), parameters);
        let planes = plane.get("trim_stern_planes");
        plane.set("stern_planes", planes + 0.03);
        plane.set("current_horizontal", 0.2);
        let depth = plane.get("depth");
        plane.fly_in(10.0, 1000);
        let mut flight = flown(parameters, &[("stern_planes", 0.03), ("current_north", 0.2)]);
        let names = ["pitch", "speed", "pitch_rate", "heave", "path_speed", "depth"];
        close(&all(&mut flight, &names), &all(&mut plane, &names), 1e-11);
        assert!((flight.get("north") - plane.get("distance")).abs() < 1e-10);
        let names = ["heading", "roll", "sway", "angular_velocity_x", "angular_velocity_z", "east"];
        assert_eq!(all(&mut flight, &names), [0.0; 6]);
        assert!((flight.get("depth") - depth).abs() > 0.1, "it moved");
    }
}

#[test]
fn motion_is_equivariant_under_mirror_and_quarter_turn() {
    let motion = ["pitch", "speed", "heave", "depth", "roll", "sway", "heading_rate", "angular_velocity_x"];
    let place = ["north", "east", "heading"];
    let mut one = flown(&sea(1.0), &[("rudder", 0.1), ("current_north", 0.2), ("current_east", 0.3)]);
    let mut mirrored = flown(&sea(-1.0), &[("rudder", -0.1), ("current_north", 0.2), ("current_east", -0.3)]);
    let mut turn = flown(
        &[&sea(1.0 + FRAC_PI_2)[..], &[("initial_heading", FRAC_PI_2)]].concat(),
        &[("rudder", 0.1), ("current_north", -0.3), ("current_east", 0.2)],
    );
    let (moved, placed) = (all(&mut one, &motion), all(&mut one, &place));
    let mut other = all(&mut mirrored, &motion);
    other[4..].iter_mut().for_each(|value| *value = -*value);
    assert_eq!(moved, other);
    let [north, east, heading] = placed[..] else { panic!("three") };
    assert_eq!(all(&mut mirrored, &place), [north, -east, -heading]);
    close(&all(&mut turn, &motion), &moved, 1e-9);
    close(&all(&mut turn, &place), &[-east, north, heading + FRAC_PI_2], 1e-9);
    assert!(heading.abs() > 0.2);
}
