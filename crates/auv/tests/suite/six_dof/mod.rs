//! Six degrees of freedom: sway, roll and yaw beside the vertical plane.

mod file;
mod model;
mod turns;

use crate::common::text;
use auv::{Dynamics, Motion, Vehicle, actuator_force, lateral_actuator_force};

/// Prestero's numbers for sway, roll and yaw, by section; all others are those of an axisymmetric hull.
const LATERAL: [(&str, &str); 4] = [
    ("[mass]", "I_xx = { value = 0.177, unit = \"kg.m2\", source = \"Prestero (2001)\" }"),
    ("[added_mass]", "K_p_dot = { value = -0.0704, unit = \"kg.m2\", source = \"Prestero (2001)\" }"),
    ("[damping]", "K_pp = { value = -0.13, unit = \"kg.m2\", source = \"Prestero (2001)\" }"),
    ("[damping]", "N_rr = { value = -94.0, unit = \"kg.m2\", source = \"Prestero (2001)\" }"),
];

const RUDDER: &str = r#"
[[control_surface]]
name = "rudder"
Y_uu_delta = { value = 9.64, unit = "kg/(m.rad)", source = "Prestero (2001)" }
N_uu_delta = { value = -6.15, unit = "kg/rad", source = "Prestero (2001)" }
min = { value = -13.6, unit = "deg", source = "Prestero (2001)" }
max = { value = 13.6, unit = "deg", source = "Prestero (2001)" }
lag = { value = 0.1, unit = "s", source = "assumed" }
"#;

/// Damping of roll by the fins.
const K_UP: &str = r#"K_up = { value = -0.722, unit = "kg.m", source = "of four fins" }"#;

/// The file of the REMUS 100 with more lines below the headers of its sections.
fn with(lines: &[(&str, &str)]) -> String {
    let text = lines.iter().fold(text("remus100"), |text, (section, line)| {
        assert!(text.contains(section), "{section}");
        text.replacen(section, &format!("{section}\n{line}"), 1)
    });
    text + RUDDER
}

/// The REMUS 100 with a rudder, and more lines.
fn remus_with(lines: &[(&str, &str)]) -> Vehicle {
    let lines: Vec<(&str, &str)> = LATERAL.iter().chain(lines).copied().collect();
    Vehicle::parse(&with(&lines), "vehicle.toml").unwrap_or_else(|error| panic!("{error}"))
}

fn remus() -> Vehicle {
    remus_with(&[])
}

/// \[u' v' w' p' q' r'\] of the REMUS 100 under thrust \[N\], stern planes and rudder \[rad\].
fn acceleration(vehicle: &Vehicle, motion: &Motion, outputs: [f64; 3]) -> [f64; 6] {
    let dynamics = Dynamics::new(&vehicle.coefficients).unwrap();
    let force = actuator_force(&vehicle.actuators, motion.u, outputs);
    let lateral = lateral_actuator_force(&vehicle.actuators, motion.u, outputs);
    let [du, dw, dq] = dynamics.acceleration(motion, 0.0, force);
    let [dv, dp, dr] = dynamics.lateral_acceleration(motion, 0.0, lateral);
    [du, dv, dw, dp, dq, dr]
}

/// The state \[u v w p q r phi theta psi depth\] a step of the Runge-Kutta method of order 4 later.
fn step(vehicle: &Vehicle, x: [f64; 10], outputs: [f64; 3], h: f64) -> [f64; 10] {
    let rate = |x: [f64; 10]| {
        let [u, v, w, p, q, r, phi, theta, ..] = x;
        let motion = Motion { u, v, w, p, q, r, phi, theta };
        let [du, dv, dw, dp, dq, dr] = acceleration(vehicle, &motion, outputs);
        let [roll, pitch, heading] = motion.turning();
        [du, dv, dw, dp, dq, dr, roll, pitch, heading, motion.sinking()]
    };
    let ahead = |k: [f64; 10], h: f64| std::array::from_fn(|i| x[i] + h * k[i]);
    let k1 = rate(x);
    let k2 = rate(ahead(k1, 0.5 * h));
    let k3 = rate(ahead(k2, 0.5 * h));
    let k4 = rate(ahead(k3, h));
    std::array::from_fn(|i| x[i] + h / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]))
}
