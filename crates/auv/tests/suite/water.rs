//! Water whose motion varies in space and time.

use crate::common::{remus100, six_dof, squid};
use squid_auv::{
    Current, Load, Motion, Plant, Pose, Slopes, Speed, State, Vehicle, Water, WaterMotion, trim,
};
use std::sync::Arc;

/// Water with a linear velocity `v = by_time t + by_x x + by_y y + by_z (z - 30)`, and a load.
#[derive(Debug, Default)]
struct Linear {
    motion: WaterMotion,
    /// Vehicle whose mass matrix, added mass included, times the acceleration of the water is the load; `None` for no
    /// load.
    loaded_vehicle: Option<Vehicle>,
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
        if let Some(vehicle) = &self.loaded_vehicle {
            let (sin, cos) = pose.pitch.sin_cos();
            let Current { horizontal, vertical, .. } = by_time;
            let along = nalgebra::Vector3::new(
                horizontal * cos - vertical * sin,
                horizontal * sin + vertical * cos,
                0.0,
            );
            motion.load = longitudinal_load(vehicle.coefficients.mass_matrix() * along);
        }
        motion
    }

    fn load_slopes(&self, _: f64, pose: &Pose) -> [Load; 7] {
        let mut slopes = [[0.0; 6]; 7];
        if let Some(vehicle) = &self.loaded_vehicle {
            let (sin, cos) = pose.pitch.sin_cos();
            let Current { horizontal, vertical, .. } = self.motion.by_time;
            let rotated = [-horizontal * sin - vertical * cos, horizontal * cos - vertical * sin, 0.0];
            slopes[5] =
                longitudinal_load(vehicle.coefficients.mass_matrix() * nalgebra::Vector3::from(rotated));
        }
        slopes
    }
}

fn longitudinal_load(load: nalgebra::Vector3<f64>) -> Load {
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

/// Returns the velocities through the water, and the rest of the state.
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
fn accelerating_water_equals_a_current_ramp() {
    for (vehicle, east_rate) in [(squid(), 0.0), (remus100(), 0.0), (six_dof("remus100"), 0.4)] {
        let by_time = east(current(0.3, -0.2), east_rate);
        let motion = WaterMotion { by_time, ..WaterMotion::default() };
        let mut moving_water = started(&vehicle, Some(Linear { motion, loaded_vehicle: None }));
        let mut ramp = started(&vehicle, None);
        let mut slopes = Slopes::held(vehicle.actuators.len());
        slopes.current = by_time;
        ramp.set_slopes(&slopes).unwrap();
        for plant in [&mut moving_water, &mut ramp] {
            plant.advance(2.0).unwrap();
        }
        close(moving_water.state(), ramp.state(), 1e-9);
        assert_eq!(moving_water.flow(), ramp.current());
        assert_eq!(moving_water.earth_velocity(), ramp.earth_velocity());
        assert_eq!(moving_water.state().heading != 0.0, east_rate != 0.0);
    }
}

/// Spatial variation acts on a moving vehicle like a staircase of uniform currents in many small steps.
#[test]
fn spatial_variation_acts_on_a_moving_vehicle() {
    for (vehicle, east_rate) in [(squid(), 0.0), (six_dof("remus100"), 0.05)] {
        let by_place = [
            east(current(0.02, 0.01), east_rate),
            east(current(0.03, -0.02), -east_rate),
            east(current(-0.05, 0.03), east_rate),
        ];
        let motion = WaterMotion { by_place, ..WaterMotion::default() };
        let mut moving_water = started(&vehicle, Some(Linear { motion, loaded_vehicle: None }));
        moving_water.advance(2.0).unwrap();

        let mut stairs = started(&vehicle, None);
        let steps = 4000;
        for step in 1..=steps {
            let State { x, depth, east, .. } = stairs.state();
            let h = 2.0 / f64::from(steps);
            let [across, aside, down] = stairs.earth_velocity().map(|rate| 0.5 * h * rate);
            let pose = Pose { north: x + across, east: east + aside, depth: depth + down, ..Pose::default() };
            stairs.set_current(Linear { motion, loaded_vehicle: None }.at(0.0, &pose).velocity).unwrap();
            stairs.advance(f64::from(step) * h).unwrap();
        }
        let [one, other] = [&moving_water, &stairs].map(Plant::velocity_over_ground);
        assert!(one.iter().zip(other).all(|(one, other)| (one - other).abs() < 1e-6));
        assert_eq!(one[1] != 0.0, east_rate != 0.0);
        let [moving_water, stairs] = [moving_water, stairs].map(|plant| numbers(plant.state()));
        (3..moving_water.len()).for_each(|i| assert!((moving_water[i] - stairs[i]).abs() < 1e-6, "{i}"));
    }
}

/// A vehicle loaded like the surrounding water does not move relative to accelerating water.
#[test]
fn vehicle_loaded_like_water_moves_with_it() {
    for vehicle in [squid(), remus100()] {
        let motion = WaterMotion { by_time: current(0.3, -0.2), ..WaterMotion::default() };
        let water = Linear { motion, loaded_vehicle: Some(vehicle.clone()) };
        let (mut loaded_vehicle, mut calm) = (started(&vehicle, Some(water)), started(&vehicle, None));
        for plant in [&mut loaded_vehicle, &mut calm] {
            plant.advance(2.0).unwrap();
        }
        // The buoyancy of Squid changes with depth, by 1e-3 N/m.
        let there = State { motion: calm.state().motion, ..loaded_vehicle.state() };
        close(loaded_vehicle.state(), there, 1e-5);
        assert!(
            (loaded_vehicle.state().x - calm.state().x - 0.6).abs() < 1e-3,
            "the water has taken it along"
        );
    }
}

#[test]
fn entering_moving_water_keeps_the_velocity_over_ground() {
    let vehicle = remus100();
    let by_place = [current(0.1, 0.2), Current::default(), Current::default()];
    let motion = WaterMotion { by_place, ..WaterMotion::default() };
    let mut plant = started(&vehicle, None);
    plant.advance(3.0).unwrap();
    let before = plant.earth_velocity();
    let entered = plant.with_water(Arc::new(Linear { motion, loaded_vehicle: None }));
    let after = entered.earth_velocity();
    assert!(before.iter().zip(after).all(|(before, after)| (before - after).abs() < 1e-14));
    assert!(entered.flow().horizontal > 0.3);
    let mut restored = entered.clone();
    restored.set_motion_over_ground(&entered.instant());
    close(restored.state(), entered.state(), 1e-14);
}

#[test]
fn still_water_has_no_effect() {
    let vehicle = squid();
    let (mut still, mut none) = (started(&vehicle, Some(Linear::default())), started(&vehicle, None));
    for plant in [&mut still, &mut none] {
        plant.set_current(current(0.2, 0.1)).unwrap();
        plant.advance(3.0).unwrap();
    }
    assert_eq!(still.state(), none.state());
}
