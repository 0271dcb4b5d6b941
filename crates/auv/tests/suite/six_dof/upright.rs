//! Flights through the vertical.

use super::*;
use crate::common::squid;
use nalgebra::{Matrix3, Vector3};
use squid_auv::{Plant, Pose, Speed, State, trim};

/// Returns the outputs for a loop: lower thruster ahead, upper ones astern, and a yaw command \[N\].
fn outputs(yaw: f64) -> [f64; 4] {
    [100.0, -60.0, -60.0, yaw]
}

/// Returns Squid with thrusters without lag, and with constant buoyancy.
fn looping(vehicle: Vehicle) -> Vehicle {
    let mut vehicle = vehicle;
    vehicle.coefficients.buoyancy_gradient = 0.0;
    vehicle.actuators.iter_mut().for_each(|one| one.lag = 0.0);
    vehicle
}

/// Returns the states of a flight from level trim at 1 m/s, every 0.02 s.
fn fly(vehicle: &Vehicle, start: &State, yaw: f64, duration: f64) -> Vec<State> {
    let mut plant = Plant::new(vehicle).unwrap();
    plant.set_state(start);
    for (index, output) in outputs(yaw).iter().take(vehicle.actuators.len()).enumerate() {
        plant.set_command(index, *output).unwrap();
    }
    let ticks = 1..=(duration / 0.02).round() as u32;
    let state = |tick: u32| {
        plant.advance(0.02 * f64::from(tick)).unwrap();
        plant.state()
    };
    ticks.map(state).collect()
}

/// Returns the body axes in north, east and down, as the columns of a matrix.
fn axes(state: &State) -> Matrix3<f64> {
    let Pose { roll, pitch, heading, .. } = state.pose();
    let turn = nalgebra::Rotation3::from_euler_angles(roll, pitch, heading);
    turn.into_inner()
}

fn level(vehicle: &Vehicle) -> State {
    State::in_plane(trim(&vehicle.in_plane(), Speed::Path(1.0), 200.0).unwrap().motion(), 0.0, 200.0)
}

/// Motion with the attitude as a matrix R, `R' = R [omega]x`: velocities, R, and the distance north, east and down.
type ByMatrix = ([f64; 6], Matrix3<f64>, Vector3<f64>);

fn rate(vehicle: &Vehicle, (nu, r, _): &ByMatrix, yaw: f64) -> ByMatrix {
    let [u, v, w, p, q, yawing] = *nu;
    let theta = (-r[(2, 0)]).atan2(r[(2, 1)].hypot(r[(2, 2)]));
    let motion = Motion { u, v, w, p, q, r: yawing, phi: r[(2, 1)].atan2(r[(2, 2)]), theta };
    (
        acceleration(vehicle, &motion, &outputs(yaw)),
        r * Vector3::new(p, q, yawing).cross_matrix(),
        r * Vector3::new(u, v, w),
    )
}

fn advanced((nu, r, position): &ByMatrix, (dnu, dr, dway): &ByMatrix, h: f64) -> ByMatrix {
    (std::array::from_fn(|i| nu[i] + h * dnu[i]), r + dr * h, position + dway * h)
}

/// A loop with yaw, through the vertical, agrees with the attitude as a matrix, by the Runge-Kutta method of order 4.
#[test]
fn loop_matches_the_attitude_matrix() {
    let vehicle = looping(six_dof("squid"));
    let (start, yaw, h) = (level(&vehicle), 2.0, 2.5e-4);
    let Motion { u, w, q, .. } = start.motion;
    let mut expected: ByMatrix =
        ([u, 0.0, w, 0.0, q, 0.0], axes(&start), Vector3::new(0.0, 0.0, start.depth));
    let mut greatest_pitch = 0.0_f64;
    for state in fly(&vehicle, &start, yaw, 8.0) {
        for _ in 0..80 {
            let k1 = rate(&vehicle, &expected, yaw);
            let k2 = rate(&vehicle, &advanced(&expected, &k1, 0.5 * h), yaw);
            let k3 = rate(&vehicle, &advanced(&expected, &k2, 0.5 * h), yaw);
            let k4 = rate(&vehicle, &advanced(&expected, &k3, h), yaw);
            for (k, part) in [(k1, 1.0), (k2, 2.0), (k3, 2.0), (k4, 1.0)] {
                expected = advanced(&expected, &k, part * h / 6.0);
            }
        }
        let (_, matrix, position) = &expected;
        let difference = (axes(&state) - matrix)
            .amax()
            .max((Vector3::new(state.x, state.east, state.depth) - position).amax());
        assert!(difference < 1e-8, "{difference} at {state:?}");
        assert!(state.motion.theta.abs() <= std::f64::consts::FRAC_PI_2);
        greatest_pitch = greatest_pitch.max(state.motion.theta);
    }
    assert!(greatest_pitch > 1.5, "{greatest_pitch} rad");
}

/// A loop that barely leaves the vertical plane agrees with the vehicle in the plane, whose pitch exceeds 90 deg.
#[test]
fn loop_matches_the_vertical_plane() {
    let (plane, vehicle) = (looping(squid()), looping(six_dof("squid")));
    let start = level(&vehicle);
    let flight = fly(&vehicle, &start, 1e-10, 5.0);
    let pitch = |state: &State| (axes(state)[(2, 0)], axes(state)[(2, 2)]);
    for (state, expected) in flight.iter().zip(fly(&plane, &start, 0.0, 5.0)) {
        let theta = expected.motion.theta;
        let ((up, down), depth) = (pitch(state), state.depth - expected.depth);
        let difference = [up + theta.sin(), down - theta.cos(), state.x - expected.x, depth];
        assert!(difference.iter().all(|one| one.abs() < 1e-8), "{difference:?} at {state:?}");
    }
    let last = fly(&plane, &start, 0.0, 5.0).pop().unwrap();
    assert!(last.motion.theta > 1.6, "{} rad", last.motion.theta);
}
