//! Waves about a vehicle in six degrees of freedom.

use crate::common::whole;
use auv::{Motion, Plant, Speed, State, Surroundings, Vehicle, trim};
use squid_sea::{Spectrum, Waves};
use std::f64::consts::PI;
use std::sync::Arc;

/// Ten seconds, 3 m below waves that go to a heading, from another heading and with a rudder \[rad\].
fn flown(vehicle: &Vehicle, waves: f64, heading: f64, rudder: f64) -> State {
    let plane = vehicle.in_plane();
    let mut level = trim(&plane, Speed::Path(1.6), 3.0).unwrap();
    level.actuators = vehicle.outputs_of_plane(&plane, &level.actuators);
    let waves = Waves::new(&Spectrum::jonswap(0.5, 4.0, 3.3).unwrap(), waves, 20, 3).unwrap();
    let (geometry, coefficients) = (vehicle.geometry.unwrap(), &vehicle.coefficients);
    let water = Surroundings::still(coefficients).with_waves(waves, geometry, coefficients).unwrap();
    let mut plant = Plant::new(vehicle).unwrap().with_water(Arc::new(water));
    plant.start(0.0, &level).unwrap();
    if vehicle.coefficients.has_lateral() {
        plant.set_state(&State { heading, ..plant.state() });
    }
    for (index, actuator) in vehicle.actuators.iter().enumerate() {
        let by = if actuator.name == "rudder" { rudder } else { 0.0 };
        plant.set_command(index, level.actuators[index] + by).unwrap();
    }
    plant.advance(10.0).unwrap();
    plant.state()
}

/// \[u w q theta depth\], \[v p r phi\], and the way north and east with the heading.
fn parts(state: State) -> ([f64; 5], [f64; 4], [f64; 3]) {
    let State { motion: Motion { u, v, w, p, q, r, phi, theta }, x, depth, heading, east } = state;
    ([u, w, q, theta, depth], [v, p, r, phi], [x, east, heading])
}

fn close<const N: usize>(found: [f64; N], expected: [f64; N], tolerance: f64) {
    let near = found.iter().zip(expected).all(|(one, other)| (one - other).abs() <= tolerance);
    assert!(near, "{found:?} instead of {expected:?}");
}

/// In waves along its way it flies as the vehicle in the vertical plane does. The sine of pi is 1e-16, and a turn of this
/// vehicle grows a thousandfold in six seconds.
#[test]
fn along_the_waves_it_stays_in_the_plane() {
    let vehicle = whole("remus100");
    for (waves, sideways) in [(0.0, 0.0), (PI, 1e-13)] {
        let (ahead, aside, [north, east, heading]) = parts(flown(&vehicle, waves, 0.0, 0.0));
        let (planar, _, [distance, ..]) = parts(flown(&vehicle.in_plane(), waves, 0.0, 0.0));
        close(ahead, planar, 1e-11);
        close([north], [distance], 1e-11);
        close(aside, [0.0; 4], sideways);
        close([east, heading], [0.0; 2], sideways);
        assert!((ahead[4] - 3.0).abs() > 0.01, "the waves move it");
    }
}

#[test]
fn waves_from_port_are_those_from_starboard_in_a_mirror() {
    let vehicle = whole("remus100");
    let (ahead, aside, [north, east, heading]) = parts(flown(&vehicle, 1.3, 0.4, 0.05));
    let (other, away, place) = parts(flown(&vehicle, -1.3, -0.4, -0.05));
    close(other, ahead, 1e-11);
    close(away, aside.map(|one| -one), 1e-11);
    close(place, [north, -east, -heading], 1e-11);
    assert!(aside.iter().all(|one| one.abs() > 1e-4), "{aside:?}");
}

#[test]
fn north_is_where_one_says() {
    let (vehicle, turn) = (whole("remus100"), 2.0);
    let (ahead, aside, [north, east, heading]) = parts(flown(&vehicle, 1.3, 0.4, 0.05));
    let (other, away, place) = parts(flown(&vehicle, 1.3 + turn, 0.4 + turn, 0.05));
    close(other, ahead, 1e-10);
    close(away, aside, 1e-10);
    let (sin, cos) = turn.sin_cos();
    close(place, [north * cos - east * sin, north * sin + east * cos, heading + turn], 1e-10);
}

/// Waves from the side alone make it sway, roll and turn.
#[test]
fn a_beam_sea_is_felt_sideways() {
    let (_, [sway, roll_rate, yaw_rate, _], [_, east, heading]) =
        parts(flown(&whole("remus100"), PI / 2.0, 0.0, 0.0));
    for one in [sway, roll_rate, yaw_rate, east, heading] {
        assert!(one.abs() > 1e-4, "{one}");
    }
}
