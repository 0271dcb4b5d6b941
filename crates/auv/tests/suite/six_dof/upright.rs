//! Flights through the vertical.

use super::*;
use crate::common::squid;
use nalgebra::{Matrix3, Vector3};
use squid_auv::{Plant, Pose, Speed, State, trim};

/// Looping: the lower thruster ahead, the upper ones astern, and a command of yaw \[N\].
fn outputs(yaw: f64) -> [f64; 4] {
    [100.0, -60.0, -60.0, yaw]
}

/// Squid with thrusters that do not lag, in water that does not compress it.
fn looping(vehicle: Vehicle) -> Vehicle {
    let mut vehicle = vehicle;
    vehicle.coefficients.buoyancy_gradient = 0.0;
    vehicle.actuators.iter_mut().for_each(|one| one.lag = 0.0);
    vehicle
}

/// The states of a flight from level trim at 1 m/s, every 0.02 s.
fn flown(vehicle: &Vehicle, start: &State, yaw: f64, duration: f64) -> Vec<State> {
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

/// The axes of the body north, east and down, as the columns of a matrix.
fn axes(state: &State) -> Matrix3<f64> {
    let Pose { roll, pitch, heading, .. } = state.pose();
    let turn = nalgebra::Rotation3::from_euler_angles(roll, pitch, heading);
    turn.into_inner()
}

fn level(vehicle: &Vehicle) -> State {
    State::in_plane(trim(&vehicle.in_plane(), Speed::Path(1.0), 200.0).unwrap().motion(), 0.0, 200.0)
}

/// A motion by its attitude as a matrix R, with `R' = R [omega]x`: velocities, R, and the way north, east and down.
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

fn moved((nu, r, way): &ByMatrix, (dnu, dr, dway): &ByMatrix, h: f64) -> ByMatrix {
    (std::array::from_fn(|i| nu[i] + h * dnu[i]), r + dr * h, way + dway * h)
}

/// A loop with yaw is that of the attitude as a matrix, by the Runge-Kutta method of order 4, through the vertical.
#[test]
fn it_loops_as_by_a_matrix() {
    let vehicle = looping(whole("squid"));
    let (start, yaw, h) = (level(&vehicle), 2.0, 2.5e-4);
    let Motion { u, w, q, .. } = start.motion;
    let mut expected: ByMatrix =
        ([u, 0.0, w, 0.0, q, 0.0], axes(&start), Vector3::new(0.0, 0.0, start.depth));
    let mut steepest = 0.0_f64;
    for state in flown(&vehicle, &start, yaw, 8.0) {
        for _ in 0..80 {
            let k1 = rate(&vehicle, &expected, yaw);
            let k2 = rate(&vehicle, &moved(&expected, &k1, 0.5 * h), yaw);
            let k3 = rate(&vehicle, &moved(&expected, &k2, 0.5 * h), yaw);
            let k4 = rate(&vehicle, &moved(&expected, &k3, h), yaw);
            for (k, part) in [(k1, 1.0), (k2, 2.0), (k3, 2.0), (k4, 1.0)] {
                expected = moved(&expected, &k, part * h / 6.0);
            }
        }
        let (_, matrix, way) = &expected;
        let apart =
            (axes(&state) - matrix).amax().max((Vector3::new(state.x, state.east, state.depth) - way).amax());
        assert!(apart < 1e-8, "{apart} at {state:?}");
        assert!(state.motion.theta.abs() <= std::f64::consts::FRAC_PI_2);
        steepest = steepest.max(state.motion.theta);
    }
    assert!(steepest > 1.5, "{steepest} rad");
}

/// A loop that hardly leaves the vertical plane is that of the vehicle in the plane, whose pitch goes on beyond 90 deg.
#[test]
fn it_loops_as_in_the_plane() {
    let (plane, vehicle) = (looping(squid()), looping(whole("squid")));
    let start = level(&vehicle);
    let whole = flown(&vehicle, &start, 1e-10, 5.0);
    let pitch = |state: &State| (axes(state)[(2, 0)], axes(state)[(2, 2)]);
    for (state, expected) in whole.iter().zip(flown(&plane, &start, 0.0, 5.0)) {
        let theta = expected.motion.theta;
        let ((up, down), depth) = (pitch(state), state.depth - expected.depth);
        let apart = [up + theta.sin(), down - theta.cos(), state.x - expected.x, depth];
        assert!(apart.iter().all(|one| one.abs() < 1e-8), "{apart:?} at {state:?}");
    }
    let last = flown(&plane, &start, 0.0, 5.0).pop().unwrap();
    assert!(last.motion.theta > 1.6, "{} rad", last.motion.theta);
}
