//! Waves around a vehicle in six degrees of freedom.

use crate::common::six_dof;
use squid_auv::{Motion, Plant, Pose, Speed, State, Surroundings, Vehicle, Water, trim};
use squid_sea::{Spectrum, Waves};
use std::f64::consts::PI;
use std::sync::Arc;

/// Returns waves of a heading around a vehicle.
fn sea(vehicle: &Vehicle, heading: f64) -> Surroundings {
    let waves = Waves::new(&Spectrum::jonswap(0.5, 4.0, 3.3).unwrap(), heading, 20, 3).unwrap();
    let (geometry, coefficients) = (vehicle.geometry.unwrap(), &vehicle.coefficients);
    Surroundings::still(coefficients).with_waves(waves, geometry, coefficients).unwrap()
}

/// Simulates ten seconds, 3 m below waves of a heading, from another heading and with a rudder \[rad\].
fn fly(vehicle: &Vehicle, waves: f64, heading: f64, rudder: f64) -> State {
    let plane = vehicle.in_plane();
    let mut level = trim(&plane, Speed::Path(1.6), 3.0).unwrap();
    level.actuators = vehicle.outputs_of_plane(&plane, &level.actuators);
    let mut plant = Plant::new(vehicle).unwrap().with_water(Arc::new(sea(vehicle, waves)));
    plant.start(0.0, &level).unwrap();
    if vehicle.coefficients.leaves_plane() {
        plant.set_state(&State { heading, ..plant.state() });
    }
    for (index, actuator) in vehicle.actuators.iter().enumerate() {
        let by = if actuator.name == "rudder" { rudder } else { 0.0 };
        plant.set_command(index, level.actuators[index] + by).unwrap();
    }
    plant.advance(10.0).unwrap();
    plant.state()
}

/// Returns \[u w q theta depth\], \[v p r phi\], and the distance north and east with the heading.
fn parts(state: State) -> ([f64; 5], [f64; 4], [f64; 3]) {
    let State { motion: Motion { u, v, w, p, q, r, phi, theta }, x, depth, heading, east, .. } = state;
    ([u, w, q, theta, depth], [v, p, r, phi], [x, east, heading])
}

fn close<const N: usize>(found: [f64; N], expected: [f64; N], tolerance: f64) {
    let near = found.iter().zip(expected).all(|(one, other)| (one - other).abs() <= tolerance);
    assert!(near, "{found:?} instead of {expected:?}");
}

/// The vehicle moves as in the vertical plane in waves along its heading. The sine of pi is 1e-16, and a turn of this
/// vehicle grows a thousandfold in six seconds.
#[test]
fn motion_along_the_waves_stays_in_the_plane() {
    let vehicle = six_dof("remus100");
    for (waves, sideways) in [(0.0, 0.0), (PI, 1e-13)] {
        let (ahead, lateral, [north, east, heading]) = parts(fly(&vehicle, waves, 0.0, 0.0));
        let (planar, _, [distance, ..]) = parts(fly(&vehicle.in_plane(), waves, 0.0, 0.0));
        close(ahead, planar, 1e-11);
        close([north], [distance], 1e-11);
        close(lateral, [0.0; 4], sideways);
        close([east, heading], [0.0; 2], sideways);
        assert!((ahead[4] - 3.0).abs() > 0.01, "the waves move it");
    }
}

#[test]
fn waves_from_port_and_starboard_are_symmetric() {
    let vehicle = six_dof("remus100");
    let (ahead, lateral, [north, east, heading]) = parts(fly(&vehicle, 1.3, 0.4, 0.05));
    let (other, other_lateral, position) = parts(fly(&vehicle, -1.3, -0.4, -0.05));
    close(other, ahead, 1e-11);
    close(other_lateral, lateral.map(|one| -one), 1e-11);
    close(position, [north, -east, -heading], 1e-11);
    assert!(lateral.iter().all(|one| one.abs() > 1e-4), "{lateral:?}");
}

#[test]
fn motion_does_not_depend_on_the_direction_of_north() {
    let (vehicle, turn) = (six_dof("remus100"), 2.0);
    let (ahead, lateral, [north, east, heading]) = parts(fly(&vehicle, 1.3, 0.4, 0.05));
    let (other, other_lateral, position) = parts(fly(&vehicle, 1.3 + turn, 0.4 + turn, 0.05));
    close(other, ahead, 1e-10);
    close(other_lateral, lateral, 1e-10);
    let (sin, cos) = turn.sin_cos();
    close(position, [north * cos - east * sin, north * sin + east * cos, heading + turn], 1e-10);
}

/// Beam waves make the vehicle sway, roll and turn.
#[test]
fn beam_sea_moves_the_vehicle_laterally() {
    let (_, [sway, roll_rate, yaw_rate, _], [_, east, heading]) =
        parts(fly(&six_dof("remus100"), PI / 2.0, 0.0, 0.0));
    for one in [sway, roll_rate, yaw_rate, east, heading] {
        assert!(one.abs() > 1e-4, "{one}");
    }
}

/// An axisymmetric hull, with axisymmetric added mass, is loaded in heave after a quarter turn of roll as in sway
/// before it.
#[test]
fn quarter_turn_of_roll_turns_heave_into_sway() {
    let mut vehicle = six_dof("remus100");
    let c = &mut vehicle.coefficients;
    (c.Y_v_dot, c.Y_r_dot, c.N_r_dot) = (c.Z_w_dot, -c.Z_q_dot, c.M_q_dot);
    (c.M_w_dot, c.x_B, c.z_B) = (c.Z_q_dot, 0.0, 0.0);
    assert!(c.Z_q_dot != 0.0);
    let water = sea(&vehicle, 0.7);
    let pose = Pose { north: 1.0, east: 2.0, depth: 3.0, roll: 0.3, pitch: -0.2, heading: 1.9 };
    let [x, y, z, k, m, n] = water.at(4.0, &pose).load;
    let rolled = water.at(4.0, &Pose { roll: pose.roll + PI / 2.0, ..pose }).load;
    close(rolled, [x, z, -y, k, n, -m], 1e-12);
    assert!(y.abs() > 0.1 && n.abs() > 0.01, "{y} {n}");
}

/// Clearance and centre of buoyancy do not depend on the direction of north.
#[test]
fn clearance_does_not_depend_on_north() {
    let mut vehicle = six_dof("remus100");
    (vehicle.coefficients.x_B, vehicle.coefficients.z_B) = (0.1, -0.05);
    let pose = Pose { roll: 0.4, ..Pose::in_plane(0.0, 1.0, 0.3) };
    let ahead = sea(&vehicle, 0.7).clearance(4.0, &pose);
    let rotated = sea(&vehicle, 0.7 + 1.9).clearance(4.0, &Pose { heading: 1.9, ..pose });
    close([rotated], [ahead], 1e-12);
    let other_heading = sea(&vehicle, 0.7).clearance(4.0, &Pose { heading: 1.9, ..pose });
    assert!((other_heading - ahead).abs() > 1e-3, "{other_heading} {ahead}");
}
