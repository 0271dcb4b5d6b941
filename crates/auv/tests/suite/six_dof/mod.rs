//! Six degrees of freedom: sway, roll and yaw in addition to the vertical plane.

mod file;
mod model;
mod turns;
mod upright;
mod waves;

use crate::common::{six_dof, text};
use squid_auv::{Dynamics, Motion, Vehicle, actuator_force, lateral_actuator_force};

/// Returns the text of the file of REMUS 100 with lines added below the headers of its sections.
fn with(lines: &[(&str, &str)]) -> String {
    lines.iter().fold(text("remus100"), |text, (section, line)| {
        assert!(text.contains(section), "{section}");
        text.replacen(section, &format!("{section}\n{line}"), 1)
    })
}

/// Returns the text of that file without the lines that begin with `key = `.
fn without(keys: &[&str]) -> String {
    let is_other_line = |line: &&str| !keys.iter().any(|key| line.starts_with(&format!("{key} = ")));
    text("remus100").lines().filter(is_other_line).map(|line| format!("{line}\n")).collect()
}

fn read(text: &str) -> Vehicle {
    Vehicle::parse(text, "vehicle.toml").unwrap_or_else(|error| panic!("{error}"))
}

/// Returns REMUS 100 as published by Prestero, without roll damping proportional to the speed.
fn remus() -> Vehicle {
    let mut vehicle = six_dof("remus100");
    vehicle.coefficients.K_up = 0.0;
    vehicle
}

/// Returns \[u' v' w' p' q' r'\] under the outputs of the actuators \[N or rad\], at the reference depth of the
/// buoyancy.
fn acceleration(vehicle: &Vehicle, motion: &Motion, outputs: &[f64]) -> [f64; 6] {
    acceleration_at(vehicle.coefficients.reference_depth, vehicle, motion, outputs)
}

/// Returns the same at a depth \[m\].
fn acceleration_at(depth: f64, vehicle: &Vehicle, motion: &Motion, outputs: &[f64]) -> [f64; 6] {
    let dynamics = Dynamics::new(&vehicle.coefficients).unwrap();
    let outputs = || outputs.iter().copied();
    let force = actuator_force(&vehicle.actuators, motion.u, outputs());
    let lateral = lateral_actuator_force(&vehicle.actuators, motion.u, outputs());
    let [du, dw, dq] = dynamics.acceleration(motion, depth, force);
    let [dv, dp, dr] = dynamics.lateral_acceleration(motion, depth, lateral);
    [du, dv, dw, dp, dq, dr]
}

/// Returns the state \[u v w p q r phi theta psi depth\] after a step of the Runge-Kutta method of order 4.
fn step(vehicle: &Vehicle, x: [f64; 10], outputs: [f64; 3], h: f64) -> [f64; 10] {
    let rate = |x: [f64; 10]| {
        let [u, v, w, p, q, r, phi, theta, ..] = x;
        let motion = Motion { u, v, w, p, q, r, phi, theta };
        let [du, dv, dw, dp, dq, dr] = acceleration(vehicle, &motion, &outputs);
        let [roll, pitch, heading] = motion.turning();
        [du, dv, dw, dp, dq, dr, roll, pitch, heading, motion.depth_rate()]
    };
    let advanced = |k: [f64; 10], h: f64| std::array::from_fn(|i| x[i] + h * k[i]);
    let k1 = rate(x);
    let k2 = rate(advanced(k1, 0.5 * h));
    let k3 = rate(advanced(k2, 0.5 * h));
    let k4 = rate(advanced(k3, h));
    std::array::from_fn(|i| x[i] + h / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]))
}
