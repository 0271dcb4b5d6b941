//! Water that moves from place to place and from time to time.

use crate::common::{remus100, squid, whole};
use squid_auv::{
    Current, Load, Motion, Plant, Pose, Slopes, Speed, State, Vehicle, Water, WaterMotion, trim,
};
use std::sync::Arc;

/// Water with a linear velocity `v = by_time t + by_x x + by_y y + by_z (z - 30)`, and a load.
#[derive(Debug, Default)]
struct Linear {
    motion: WaterMotion,
    /// Whether the load is that of the water's acceleration on the vehicle's mass and added mass, by its mass matrix.
    carried: Option<Vehicle>,
}

impl Water for Linear {
    fn at(&self, time: f64, pose: &Pose) -> WaterMotion {
        let WaterMotion { by_time, by_place: [x, y, z], .. } = self.motion;
        let parts = [(by_time, time), (x, pose.north), (y, pose.east), (z, pose.depth - 30.0)];
        let sum = |sum: [f64; 3], (slope, by): (Current, f64)| {
            let slope = slope.in_earth();
            [0, 1, 2].map(|i| sum[i] + slope[i] * by)
        };
        let velocity = parts.into_iter().fold([0.0; 3], sum).into();
        let mut motion = WaterMotion { velocity, ..self.motion };
        if let Some(vehicle) = &self.carried {
            let (sin, cos) = pose.pitch.sin_cos();
            let Current { horizontal, vertical, .. } = by_time;
            let along = nalgebra::Vector3::new(
                horizontal * cos - vertical * sin,
                horizontal * sin + vertical * cos,
                0.0,
            );
            motion.load = of_plane(vehicle.coefficients.mass_matrix() * along);
        }
        motion
    }

    fn load_slopes(&self, _: f64, pose: &Pose) -> [Load; 7] {
        let mut slopes = [[0.0; 6]; 7];
        if let Some(vehicle) = &self.carried {
            let (sin, cos) = pose.pitch.sin_cos();
            let Current { horizontal, vertical, .. } = self.motion.by_time;
            let turned = [-horizontal * sin - vertical * cos, horizontal * cos - vertical * sin, 0.0];
            slopes[5] = of_plane(vehicle.coefficients.mass_matrix() * nalgebra::Vector3::from(turned));
        }
        slopes
    }
}

fn of_plane(load: nalgebra::Vector3<f64>) -> Load {
    [load[0], 0.0, load[1], 0.0, load[2], 0.0]
}

fn current(horizontal: f64, vertical: f64) -> Current {
    Current { horizontal, vertical, ..Current::default() }
}

fn started(vehicle: &Vehicle, water: Option<Linear>) -> Plant {
    let mut plant = Plant::new(vehicle).unwrap();
    if let Some(water) = water {
        plant = plant.with_water(Arc::new(water));
    }
    plant.start(0.0, &trim(vehicle, Speed::Path(1.5), 30.0).unwrap()).unwrap();
    plant.set_command(0, 0.4 * vehicle.actuators[0].max).unwrap();
    plant
}

/// The velocities through the water, and the rest.
fn numbers(state: State) -> [f64; 12] {
    let State { motion: Motion { u, v, w, p, q, r, phi, theta }, x, depth, heading, east, .. } = state;
    [u, w, v, q, theta, x, depth, p, r, phi, heading, east]
}

fn close(found: State, expected: State, tolerance: f64) {
    for (i, (found, expected)) in numbers(found).into_iter().zip(numbers(expected)).enumerate() {
        assert!((found - expected).abs() < tolerance, "{i}: {found} instead of {expected}");
    }
}

fn east(mut current: Current, east: f64) -> Current {
    current.east = east;
    current
}

#[test]
fn water_that_gains_speed_is_a_current_on_a_ramp() {
    for (vehicle, side) in [(squid(), 0.0), (remus100(), 0.0), (whole("remus100"), 0.4)] {
        let by_time = east(current(0.3, -0.2), side);
        let motion = WaterMotion { by_time, ..WaterMotion::default() };
        let mut moved = started(&vehicle, Some(Linear { motion, carried: None }));
        let mut ramp = started(&vehicle, None);
        let mut slopes = Slopes::held(vehicle.actuators.len());
        slopes.current = by_time;
        ramp.set_slopes(&slopes).unwrap();
        for plant in [&mut moved, &mut ramp] {
            plant.advance(2.0).unwrap();
        }
        close(moved.state(), ramp.state(), 1e-9);
        assert_eq!(moved.flow(), ramp.current());
        assert_eq!(moved.earth_velocity(), ramp.earth_velocity());
        assert_eq!(moved.state().heading != 0.0, side != 0.0);
    }
}

/// What changes with the place changes for who moves: as many small steps of a current that is uniform.
#[test]
fn water_that_changes_with_the_place_is_met() {
    for (vehicle, side) in [(squid(), 0.0), (whole("remus100"), 0.05)] {
        let by_place = [
            east(current(0.02, 0.01), side),
            east(current(0.03, -0.02), -side),
            east(current(-0.05, 0.03), side),
        ];
        let motion = WaterMotion { by_place, ..WaterMotion::default() };
        let mut moved = started(&vehicle, Some(Linear { motion, carried: None }));
        moved.advance(2.0).unwrap();

        let mut stairs = started(&vehicle, None);
        let steps = 4000;
        for step in 1..=steps {
            let State { x, depth, east, .. } = stairs.state();
            let h = 2.0 / f64::from(steps);
            let [across, aside, down] = stairs.earth_velocity().map(|rate| 0.5 * h * rate);
            let pose = Pose { north: x + across, east: east + aside, depth: depth + down, ..Pose::default() };
            stairs.set_current(Linear { motion, carried: None }.at(0.0, &pose).velocity).unwrap();
            stairs.advance(f64::from(step) * h).unwrap();
        }
        let [one, other] = [&moved, &stairs].map(Plant::velocity_over_ground);
        assert!(one.iter().zip(other).all(|(one, other)| (one - other).abs() < 1e-6));
        assert_eq!(one[1] != 0.0, side != 0.0);
        let [moved, stairs] = [moved, stairs].map(|plant| numbers(plant.state()));
        (3..moved.len()).for_each(|i| assert!((moved[i] - stairs[i]).abs() < 1e-6, "{i}"));
    }
}

/// Pushed like the water about it, a vehicle does not notice that the water gains speed.
#[test]
fn a_vehicle_that_is_carried_stays_where_it_is_in_the_water() {
    for vehicle in [squid(), remus100()] {
        let motion = WaterMotion { by_time: current(0.3, -0.2), ..WaterMotion::default() };
        let water = Linear { motion, carried: Some(vehicle.clone()) };
        let (mut carried, mut calm) = (started(&vehicle, Some(water)), started(&vehicle, None));
        for plant in [&mut carried, &mut calm] {
            plant.advance(2.0).unwrap();
        }
        // The buoyancy of Squid changes with depth, by 1e-3 N/m.
        let there = State { motion: calm.state().motion, ..carried.state() };
        close(carried.state(), there, 1e-5);
        assert!((carried.state().x - calm.state().x - 0.6).abs() < 1e-3, "the water has taken it along");
    }
}

#[test]
fn water_does_not_move_a_vehicle_that_enters_it() {
    let vehicle = remus100();
    let by_place = [current(0.1, 0.2), Current::default(), Current::default()];
    let motion = WaterMotion { by_place, ..WaterMotion::default() };
    let mut plant = started(&vehicle, None);
    plant.advance(3.0).unwrap();
    let before = plant.earth_velocity();
    let entered = plant.with_water(Arc::new(Linear { motion, carried: None }));
    let after = entered.earth_velocity();
    assert!(before.iter().zip(after).all(|(before, after)| (before - after).abs() < 1e-14));
    assert!(entered.flow().horizontal > 0.3);
    let mut again = entered.clone();
    again.set_motion_over_ground(&entered.instant());
    close(again.state(), entered.state(), 1e-14);
}

#[test]
fn still_water_is_no_water() {
    let vehicle = squid();
    let (mut still, mut none) = (started(&vehicle, Some(Linear::default())), started(&vehicle, None));
    for plant in [&mut still, &mut none] {
        plant.set_current(current(0.2, 0.1)).unwrap();
        plant.advance(3.0).unwrap();
    }
    assert_eq!(still.state(), none.state());
}
