//! Plant: energy, convergence, division of intervals, current, actuators, rejected input.

use crate::common::{remus100, six_dof, squid};
use squid_auv::{
    Coefficients, Current, Dynamics, Fidelity, IntegrationError, Motion, Plant, SimulationError, Speed,
    State, Trim, Vehicle, actuator_force, trim,
};

const DEPTH: f64 = 50.0;

fn plant_at_trim(vehicle: &Vehicle, speed: f64) -> (Plant, Trim) {
    let trim = trim(vehicle, Speed::Path(speed), DEPTH).unwrap();
    let mut plant = Plant::new(vehicle).unwrap();
    plant.start(0.0, &trim).unwrap();
    (plant, trim)
}

/// Returns the kinetic energy, added mass included, plus the potential energy of weight and buoyancy.
fn energy(c: &Coefficients, state: &State) -> f64 {
    let Motion { u, w, q, theta, .. } = state.motion;
    let nu = nalgebra::Vector3::new(u, w, q);
    let (sin, cos) = theta.sin_cos();
    let depth_of = |x: f64, z: f64| state.depth - x * sin + z * cos;
    0.5 * nu.dot(&(c.mass_matrix() * nu)) - c.weight * depth_of(c.x_G, c.z_G)
        + c.buoyancy * depth_of(c.x_B, c.z_B)
}

#[test]
fn undamped_motion_conserves_energy() {
    let mut vehicle = squid();
    let c = &mut vehicle.coefficients;
    (c.Z_uw, c.Z_uq, c.M_uw, c.M_uq, c.Z_w, c.M_q, c.M_uu) = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
    (c.Z_ww, c.Z_qq, c.M_ww, c.M_qq, c.X_uu, c.wetted_area, c.drag_area) =
        (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
    (c.buoyancy_gradient, c.x_G) = (0.0, 0.02);
    let c = vehicle.coefficients.clone();
    for (label, weight, buoyancy) in [("neutral", 0.0, 0.0), ("weight alone", c.weight, 0.98 * c.weight)] {
        (vehicle.coefficients.weight, vehicle.coefficients.buoyancy) = (weight.max(1e-9), buoyancy.max(1e-9));
        let mut plant = Plant::new(&vehicle).unwrap();
        let start = State::in_plane(Motion::in_plane(1.2, 0.3, -0.2, 0.4), 0.0, 10.0);
        plant.set_state(&start);
        let before = energy(&vehicle.coefficients, &start);
        plant.advance(3.0).unwrap();
        assert!((plant.state().motion.theta - 0.4).abs() > 0.1, "the vehicle must have moved");
        plant.advance(60.0).unwrap();
        let after = energy(&vehicle.coefficients, &plant.state());
        let kinetic =
            energy(&Coefficients { weight: 0.0, buoyancy: 0.0, ..vehicle.coefficients.clone() }, &start);
        println!("{label}: drift {:.2e} of the kinetic energy in 60 s", (after - before).abs() / kinetic);
        assert!((after - before).abs() < 1e-9 * kinetic, "{label}: {before} J became {after} J");
    }
}

/// Integrates body and actuators together by the classical fourth-order Runge-Kutta method, as an independent check.
fn rk4(vehicle: &Vehicle, trim: &Trim, commands: &[f64], duration: f64, steps: usize) -> Vec<f64> {
    let dynamics = Dynamics::new(&vehicle.coefficients).unwrap();
    let rate = |y: &[f64]| -> Vec<f64> {
        let motion = Motion::in_plane(y[0], y[1], y[2], y[3]);
        let force = actuator_force(&vehicle.actuators, y[0], y[6..].iter().copied());
        let [du, dw, dq] = dynamics.acceleration(&motion, y[5], force);
        let (sin, cos) = y[3].sin_cos();
        let mut rate = vec![du, dw, dq, y[2], y[0] * cos + y[1] * sin, -y[0] * sin + y[1] * cos];
        for (i, actuator) in vehicle.actuators.iter().enumerate() {
            rate.push((commands[i].clamp(actuator.min, actuator.max) - y[6 + i]) / actuator.lag);
        }
        rate
    };
    let add =
        |y: &[f64], k: &[f64], h: f64| -> Vec<f64> { y.iter().zip(k).map(|(y, k)| y + h * k).collect() };
    let mut y = vec![trim.forward_speed, trim.heave, 0.0, trim.pitch, 0.0, trim.depth];
    y.extend(&trim.actuators);
    let h = duration / steps as f64;
    for _ in 0..steps {
        let k1 = rate(&y);
        let k2 = rate(&add(&y, &k1, h / 2.0));
        let k3 = rate(&add(&y, &k2, h / 2.0));
        let k4 = rate(&add(&y, &k3, h));
        for (i, value) in y.iter_mut().enumerate() {
            *value += h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]);
        }
    }
    y
}

#[test]
fn independent_method_finds_the_same_motion() {
    for (vehicle, speed, commands) in [
        (squid(), 1.0, vec![12.0, 1.0, 3.0]),
        (squid(), 2.5, vec![40.0, -80.0, 20.0]),
        (remus100(), 1.54, vec![5.0, 0.05]),
    ] {
        let (mut plant, trim) = plant_at_trim(&vehicle, speed);
        for (i, command) in commands.iter().enumerate() {
            plant.set_command(i, *command).unwrap();
        }
        plant.advance(60.0).unwrap();
        let expected = rk4(&vehicle, &trim, &commands, 60.0, 60_000);
        let State { motion: Motion { u, w, q, theta, .. }, x, depth, .. } = plant.state();
        for (found, expected) in [u, w, q, theta, x, depth].iter().chain(plant.outputs()).zip(&expected) {
            assert!(
                (found - expected).abs() < 2e-9 * (1.0 + expected.abs()),
                "{found} instead of {expected}"
            );
        }
    }
}

#[test]
fn division_of_an_interval_does_not_matter() {
    let vehicle = squid();
    let fly = |instants: &dyn Fn(usize) -> f64, count: usize| {
        let (mut plant, _) = plant_at_trim(&vehicle, 1.0);
        let mut commanded = false;
        for i in 1..=count {
            let to = instants(i);
            plant.advance(to).unwrap();
            if !commanded && to >= 1.0 - 1e-12 {
                plant.set_command(0, 20.0).unwrap();
                plant
                    .set_current(Current { horizontal: 0.3, vertical: -0.05, ..Current::default() })
                    .unwrap();
                commanded = true;
            }
        }
        plant.state()
    };
    let undivided = fly(&|i| [1.0, 60.0][i - 1], 2);
    let fine = fly(&|i| i as f64 / 100.0, 6000);
    let uneven = fly(&|i| if i <= 8 { i as f64 / 8.0 } else { (1.0 + 0.37 * (i - 8) as f64).min(60.0) }, 168);
    for other in [fine, uneven] {
        let (a, b) = (undivided.motion, other.motion);
        for (a, b) in [
            (a.u, b.u),
            (a.w, b.w),
            (a.q, b.q),
            (a.theta, b.theta),
            (undivided.x, other.x),
            (undivided.depth, other.depth),
        ] {
            assert!((a - b).abs() < 1e-9, "{a} {b}");
        }
    }
}

/// Co-simulation masters send times such as 0.30000000000000004: the remaining sliver of time must not fail.
#[test]
fn crosses_slivers_of_time() {
    let (mut plant, _) = plant_at_trim(&squid(), 1.0);
    plant.set_command(0, 20.0).unwrap();
    let mut undivided = plant.clone();
    for i in 1..=100 {
        let to = f64::from(i) * 0.1;
        plant.advance(to - 1e-12).unwrap();
        plant.advance(to - 1e-15).unwrap();
        plant.advance(to).unwrap();
        plant.advance(to).unwrap();
    }
    undivided.advance(10.0).unwrap();
    assert!((plant.state().motion.theta - undivided.state().motion.theta).abs() < 1e-11);
    assert!((plant.state().x - undivided.state().x).abs() < 1e-11);
    assert_eq!(plant.time(), 10.0);
}

#[test]
fn trim_stays_trim() {
    for (vehicle, speed) in [(squid(), 0.5), (squid(), 3.0), (remus100(), 1.54)] {
        let (mut plant, trim) = plant_at_trim(&vehicle, speed);
        plant.advance(20.0).unwrap();
        let state = plant.state();
        assert!((state.motion.theta - trim.pitch).abs() < 1e-9);
        assert!((state.depth - DEPTH).abs() < 1e-8, "{}", state.depth);
        assert!((state.x - 20.0 * speed).abs() < 1e-7, "{}", state.x);
    }
}

#[test]
fn steady_current_displaces_the_vehicle() {
    let vehicle = squid();
    let (mut still, trim) = plant_at_trim(&vehicle, 1.0);
    let (mut displaced, _) = plant_at_trim(&vehicle, 1.0);
    displaced.set_current(Current { horizontal: 0.7, vertical: 0.0, ..Current::default() }).unwrap();
    displaced.start(0.0, &trim).unwrap();
    for plant in [&mut still, &mut displaced] {
        plant.set_command(0, 15.0).unwrap();
        plant.advance(30.0).unwrap();
    }
    let (a, b) = (still.state(), displaced.state());
    for (a, b) in [
        (a.motion.u, b.motion.u),
        (a.motion.w, b.motion.w),
        (a.motion.q, b.motion.q),
        (a.motion.theta, b.motion.theta),
    ] {
        assert!((a - b).abs() < 1e-10, "{a} {b}");
    }
    assert!((b.x - a.x - 0.7 * 30.0).abs() < 1e-8);
    assert!((displaced.earth_velocity()[0] - still.earth_velocity()[0] - 0.7).abs() < 1e-9);
}

#[test]
fn sudden_current_keeps_the_velocity_over_ground() {
    let (mut plant, _) = plant_at_trim(&squid(), 1.0);
    plant.advance(1.0).unwrap();
    let before = plant.earth_velocity();
    plant.set_current(Current { horizontal: -0.4, vertical: 0.1, ..Current::default() }).unwrap();
    let after = plant.earth_velocity();
    assert!(before.iter().zip(after).all(|(before, after)| (before - after).abs() < 1e-14));
    assert!(plant.state().motion.u > 1.3, "against the stream the water comes faster");
    let [u, _, w] = plant.velocity_over_ground();
    assert!((u.hypot(w) - 1.0).abs() < 1e-9);
}

#[test]
fn actuators_lag_and_saturate() {
    let vehicle = squid();
    let (mut plant, trim) = plant_at_trim(&vehicle, 1.0);
    plant.set_command(1, 1e6).unwrap();
    plant.advance(0.2).unwrap();
    let expected = 100.0 + (trim.actuators[1] - 100.0) * (-1.0_f64).exp();
    assert!((plant.outputs()[1] - expected).abs() < 1e-12);
    plant.set_command(1, -1e6).unwrap();
    plant.advance(10.0).unwrap();
    assert!((plant.outputs()[1] + 60.0).abs() < 1e-12);
    let mut direct = vehicle.clone();
    direct.actuators[0].lag = 0.0;
    let (mut plant, _) = plant_at_trim(&direct, 1.0);
    plant.set_command(0, 7.0).unwrap();
    plant.advance(1e-3).unwrap();
    assert_eq!(plant.outputs()[0], 7.0);
}

#[test]
fn rejects_invalid_input_without_side_effects() {
    let (mut plant, trim) = plant_at_trim(&squid(), 1.0);
    plant.advance(1.0).unwrap();
    let before = plant.state();
    assert!(matches!(plant.set_command(0, f64::NAN), Err(SimulationError::InputNotFinite { .. })));
    assert!(matches!(
        plant.set_command(3, 1.0),
        Err(SimulationError::NoSuchActuator { index: 3, actuators: 3 })
    ));
    let infinite = Current { horizontal: f64::INFINITY, vertical: 0.0, ..Current::default() };
    assert!(matches!(plant.set_current(infinite), Err(SimulationError::InputNotFinite { .. })));
    assert!(matches!(plant.set_operating_speed(f64::NAN), Err(SimulationError::InputNotFinite { .. })));
    assert!(matches!(plant.set_fidelity(Fidelity::Lpv), Err(SimulationError::NoLpvModel)));
    assert!(matches!(plant.advance(0.5), Err(SimulationError::Backwards { .. })));
    assert!(matches!(plant.advance(f64::NAN), Err(SimulationError::InputNotFinite { .. })));
    let wrong = Trim { actuators: vec![0.0], ..trim };
    assert!(matches!(
        plant.start(0.0, &wrong),
        Err(SimulationError::TrimActuators { found: 1, expected: 3 })
    ));
    assert_eq!(plant.state(), before);
    assert_eq!(plant.time(), 1.0);
    plant.advance(1.0).unwrap();
    assert_eq!(plant.state(), before);
}

/// Buoyancy that falls by 1e6 N per metre makes the depth diverge; the plant reports it and keeps its state.
#[test]
fn reports_a_diverging_motion() {
    let mut vehicle = squid();
    let (nominal, _) = plant_at_trim(&vehicle, 1.0);
    let c = &mut vehicle.coefficients;
    (c.buoyancy_gradient, c.Z_ww, c.M_ww, c.Z_uw, c.Z_w) = (-1e6, 0.0, 0.0, 0.0, 0.0);
    let mut plant = Plant::new(&vehicle).unwrap();
    plant.set_state(&State { depth: DEPTH + 1e-3, ..nominal.state() });
    let (mut before, mut error) = (plant.state(), None);
    for i in 1..=400 {
        error = plant.advance(f64::from(i) * 0.05).err();
        if error.is_some() {
            break;
        }
        before = plant.state();
    }
    let error = error.expect("must run away within 20 s");
    assert!(matches!(error, SimulationError::Integration { .. }), "{error}");
    assert_eq!(plant.state(), before);
    plant.set_state(&nominal.state());
    plant.advance(plant.time() + 1e-4).unwrap();
}

/// A speed or a rate that no vehicle reaches, or that is not finite, ends a step with its name and value.
#[test]
fn rejects_impossible_motions() {
    let vehicle = six_dof("squid");
    let assert_impossible = |load: [f64; 6], symbol: &str| {
        let mut plant = Plant::new(&vehicle).unwrap();
        plant.set_load(load).unwrap();
        match plant.advance(1.0).unwrap_err() {
            SimulationError::Integration {
                source: IntegrationError::Impossible { state, found, most, .. },
                ..
            } => {
                assert!(found.abs() > most && found.abs() < 1.5 * most, "{found}");
                assert!(state.split(' ').any(|word| word == symbol), "{state}");
            }
            other => panic!("{other}"),
        }
    };
    assert_impossible([1e6, 0.0, 0.0, 0.0, 0.0, 0.0], "u");
    assert_impossible([0.0, 0.0, 0.0, 1e5, 0.0, 0.0], "p");
    let mut plant = Plant::new(&vehicle).unwrap();
    let state = plant.state();
    plant.set_state(&State { motion: Motion { w: f64::NAN, ..state.motion }, ..state });
    insta::assert_snapshot!(plant.advance(1e-12).unwrap_err());
}
