//! Equations of motion against hand computation, closed forms, finite differences, and the thesis on REMUS.

use crate::common::{remus100, squid};
use nalgebra::{Matrix4, Vector3};
use squid_auv::{
    Coefficients, Dynamics, Linearisation, Motion, Pitch, Speed, Trim, Vehicle, actuator_force, linearise,
    trim,
};

const NO_FORCE: [f64; 3] = [0.0; 3];

/// Returns a vehicle with the diagonal mass matrix diag(12, 20, 5).
fn plain() -> Coefficients {
    Coefficients {
        mass: 10.0,
        weight: 98.0,
        buoyancy: 98.0,
        I_yy: 4.0,
        density: 1000.0,
        X_u_dot: -2.0,
        Z_w_dot: -10.0,
        M_q_dot: -1.0,
        ..Coefficients::default()
    }
}

fn close(found: [f64; 3], expected: [f64; 3], tolerance: f64) {
    for (a, b) in found.iter().zip(expected) {
        assert!((a - b).abs() <= tolerance * (1.0 + b.abs()), "{found:?} instead of {expected:?}");
    }
}

#[test]
fn acceleration_matches_hand_computation() {
    let c = Coefficients { Z_uw: -3.0, M_uw: -2.0, M_q: -1.0, X_uu: -0.25, ..plain() };
    let motion = Motion::in_plane(2.0, 1.0, 0.5, 0.0);
    // X = -(m - Z_w') w q + X_uu u|u|                    = -20 * 0.5 - 0.25 * 4 = -11
    // Z = (m - X_u') u q + Z_uw u w                      =  12 * 1 - 3 * 2      =   6
    // M = -(Z_w' - X_u') u w + M_uw u w + M_q q          =   8 * 2 - 2 * 2 - 0.5 = 11.5
    let found = Dynamics::new(&c).unwrap().acceleration(&motion, 0.0, NO_FORCE);
    close(found, [-11.0 / 12.0, 6.0 / 20.0, 11.5 / 5.0], 1e-14);
}

#[test]
fn coupled_acceleration_matches_hand_computation() {
    let c = Coefficients {
        z_G: 0.1,
        x_G: 0.2,
        Z_q_dot: -1.0,
        M_w_dot: -1.0,
        buoyancy: 100.0,
        z_B: -0.05,
        x_B: 0.03,
        Z_uq: -4.0,
        M_uq: -5.0,
        Z_w: -1.5,
        Z_ww: -6.0,
        Z_qq: -7.0,
        M_qq: -8.0,
        M_ww: 0.5,
        M_uu: 0.3,
        X_u: -2.5,
        Z_q: 3.5,
        M_w: -4.5,
        ..plain()
    };
    let motion = Motion::in_plane(1.5, -0.4, 0.2, std::f64::consts::FRAC_PI_6);
    let (sin, cos) = (0.5, 0.75_f64.sqrt());
    // m z_G = 1, m x_G + Z_q' = m x_G + M_w' = 1.
    let x = -20.0 * -0.4 * 0.2 + 0.2 * 0.2 - (98.0 - 100.0) * sin - 2.5 * 1.5;
    let z = 12.0 * 1.5 * 0.2 + 0.2 * 0.2 + (98.0 - 100.0) * cos - 4.0 * 1.5 * 0.2 + 1.5 * 0.4 + 6.0 * 0.16
        - 7.0 * 0.04
        + 3.5 * 0.2;
    let m = 8.0 * 1.5 * -0.4
        - 1.0 * -0.4 * 0.2
        - 1.0 * 1.5 * 0.2
        - (0.1 * 98.0 + 0.05 * 100.0) * sin
        - (0.2 * 98.0 - 0.03 * 100.0) * cos
        - 5.0 * 1.5 * 0.2
        - 8.0 * 0.04
        - 0.5 * 0.16
        + 0.3 * 2.25
        + 4.5 * 0.4;
    let found = Vector3::from(Dynamics::new(&c).unwrap().acceleration(&motion, 0.0, [0.7, -0.2, 0.1]));
    let mass = nalgebra::Matrix3::new(12.0, 0.0, 1.0, 0.0, 20.0, -1.0, 1.0, -1.0, 5.0);
    let force = mass * found;
    close([force[0], force[1], force[2]], [x + 0.7, z - 0.2, m + 0.1], 1e-13);
}

#[test]
fn friction_follows_the_ittc_line() {
    let c = Coefficients {
        density: 1000.0,
        length: 2.0,
        kinematic_viscosity: 1e-6,
        wetted_area: 1.5,
        form_factor: 1.1,
        drag_area: 0.02,
        ..plain()
    };
    let dynamics = Dynamics::new(&c).unwrap();
    // Re = 1e6 at 0.5 m/s: C_f = 0.075 / 16; astern the same with the opposite sign.
    let drag: f64 = 0.5 * 1000.0 * (0.075 / 16.0 * 1.1 * 1.5 + 0.02) * 0.25;
    assert!((dynamics.axial_drag(0.5_f64) + drag).abs() < 1e-12);
    assert!((dynamics.axial_drag(-0.5_f64) - drag).abs() < 1e-12);
    // Below Re = 1e4 the coefficient is held at 0.075 / 4.
    let slow: f64 = 0.5 * 1000.0 * (0.075 / 4.0 * 1.1 * 1.5 + 0.02) * 1e-6;
    assert!((dynamics.axial_drag(1e-3_f64) + slow).abs() < 1e-15);
}

#[test]
fn signs_follow_convention() {
    let dynamics = |c: &Coefficients| Dynamics::new(c).unwrap();
    let rest = Motion::in_plane(0.0, 0.0, 0.0, 0.0);
    let heavy = Coefficients { weight: 99.0, ..plain() };
    assert!(dynamics(&heavy).acceleration(&rest, 0.0, NO_FORCE)[1] > 0.0, "a heavy vehicle sinks");
    let low = Coefficients { z_G: 0.05, ..plain() };
    let bow_up = Motion { theta: 0.2, ..rest };
    assert!(
        dynamics(&low).acceleration(&bow_up, 0.0, NO_FORCE)[2] < 0.0,
        "a low centre of gravity rights it"
    );
    assert!(
        dynamics(&heavy).acceleration(&bow_up, 0.0, NO_FORCE)[0] < 0.0,
        "a heavy vehicle slides off the bow"
    );
    let incidence = Motion { u: 1.0, w: 0.1, ..rest };
    assert!(
        dynamics(&plain()).acceleration(&incidence, 0.0, NO_FORCE)[2] > 0.0,
        "the Munk moment destabilises"
    );
    let deep = Coefficients { buoyancy_gradient: 0.01, ..plain() };
    assert!(dynamics(&deep).acceleration(&rest, 10.0, NO_FORCE)[1] < 0.0, "more buoyancy at depth lifts");

    let squid = squid();
    assert_eq!(squid.actuators[0].name, "lower");
    let force = squid.actuators[0].force(1.0, 10.0);
    assert!(force[0] > 0.0 && force[2] > 0.0, "the lower thruster pushes on and lifts the bow");
    let planes = remus100().actuators[1].force(1.5, 0.1);
    assert!(planes[1] < 0.0 && planes[2] < 0.0, "positive stern planes lift the stern and put the bow down");
    let vertical = squid_auv::Effect::thruster(0.5, 0.0, std::f64::consts::FRAC_PI_2);
    let force = squid_auv::Actuator { effect: vertical, ..squid.actuators[0].clone() }.force(0.0, 1.0);
    close(force, [0.0, 1.0, -0.5], 1e-15);
}

/// Printed linear form about level trim without incidence: `M x' = C_d x + D u`.
#[test]
fn linearisation_without_incidence_matches_the_closed_form() {
    let mut vehicle = squid();
    let c = &mut vehicle.coefficients;
    (c.buoyancy, c.buoyancy_gradient, c.M_uu) = (c.weight, 0.0, 0.0);
    (c.wetted_area, c.x_G) = (0.0, 0.0);
    let c = vehicle.coefficients.clone();
    let speed = 1.75;
    let Linearisation { a, b, trim, .. } =
        linearise(&vehicle, &trim(&vehicle, Speed::Path(speed), 50.0).unwrap()).unwrap();
    assert!(trim.incidence.abs() < 1e-12);
    let m = c.mass;
    let mass = Matrix4::new(
        m - c.X_u_dot,
        0.0,
        m * c.z_G,
        0.0,
        0.0,
        m - c.Z_w_dot,
        -(m * c.x_G + c.Z_q_dot),
        0.0,
        m * c.z_G,
        -(m * c.x_G + c.M_w_dot),
        c.I_yy - c.M_q_dot,
        0.0,
        0.0,
        0.0,
        0.0,
        1.0,
    );
    let a00 = -c.density * c.drag_area * speed;
    let (c1, c2) = (c.Z_uw * speed + c.Z_w, c.Z_uq * speed);
    let (e1, e2) = (c.M_uw * speed, c.M_uq * speed + c.M_q);
    let damping = Matrix4::new(
        a00,
        0.0,
        0.0,
        -(c.weight - c.buoyancy),
        0.0,
        c1,
        speed * (m - c.X_u_dot) + c2,
        0.0,
        0.0,
        -(c.Z_w_dot - c.X_u_dot) * speed + e1,
        -speed * (m * c.x_G + c.Z_q_dot) + e2,
        -c.z_G * c.weight,
        0.0,
        0.0,
        1.0,
        0.0,
    );
    let inverse = mass.try_inverse().unwrap();
    let expected = inverse * damping;
    for i in 0..4 {
        for j in 0..4 {
            assert!(
                (a[(i, j)] - expected[(i, j)]).abs() < 1e-10,
                "A[{i}][{j}]: {} {}",
                a[(i, j)],
                expected[(i, j)]
            );
        }
        for (j, z) in [0.2, -0.1, -0.1].into_iter().enumerate() {
            assert!((b[(i, j)] - inverse[(i, 0)] - inverse[(i, 2)] * z).abs() < 1e-14);
        }
    }
}

#[test]
fn linearisation_matches_central_differences() {
    for (vehicle, speed) in [(squid(), 0.5), (squid(), 2.3), (remus100(), 1.54)] {
        let trim = trim(&vehicle, Speed::Path(speed), 50.0).unwrap();
        let linear = linearise(&vehicle, &trim).unwrap();
        let inputs = vehicle.actuators.len();
        for seed in 0..4 + inputs {
            let at = |step: f64| perturbed(&vehicle, &trim, seed, step);
            // q|q| has no second derivative at q = 0: the error of a central difference is of first order there, and
            // vanishes when extrapolated with a half step.
            let step = 1e-4;
            let difference = |i: usize, h: f64| (at(h)[i] - at(-h)[i]) / (2.0 * h);
            for i in 0..4 {
                let difference = 2.0 * difference(i, 0.5 * step) - difference(i, step);
                let exact = if seed < 4 { linear.a[(i, seed)] } else { linear.b[(i, seed - 4)] };
                assert!(
                    (difference - exact).abs() < 1e-8 * (1.0 + exact.abs()),
                    "{i} {seed}: {difference} {exact}"
                );
            }
        }
    }
}

fn perturbed(vehicle: &Vehicle, trim: &Trim, seed: usize, step: f64) -> [f64; 4] {
    let mut values = vec![trim.forward_speed, trim.heave, 0.0, trim.pitch];
    values.extend(&trim.actuators);
    values[seed] += step;
    let motion = Motion::in_plane(values[0], values[1], values[2], values[3]);
    let force = actuator_force(&vehicle.actuators, motion.u, values[4..].iter().copied());
    let [du, dw, dq] = Dynamics::new(&vehicle.coefficients).unwrap().acceleration(&motion, trim.depth, force);
    [du, dw, dq, motion.q]
}

/// Reference: Prestero (2001), tables 9.2 and 9.3 at 1.54 m/s, as far as they follow from his printed coefficients:
/// added-mass and restoring terms. (His linear lift and fin terms do not follow from his nonlinear coefficients.)
#[test]
fn remus_added_mass_and_restoring_terms_match_the_thesis() {
    let mut vehicle = remus100();
    let c = &mut vehicle.coefficients;
    (c.Z_uw, c.Z_uq, c.M_uw, c.M_uq) = (0.0, 0.0, 0.0, 0.0);
    let speed = 1.54;
    let level = Trim {
        speed,
        forward_speed: speed,
        heave: 0.0,
        incidence: 0.0,
        pitch: 0.0,
        rule: Pitch::Free,
        depth: 0.0,
        actuators: vec![0.0, 0.0],
        residual: 0.0,
    };
    let linear = linearise(&vehicle, &level).unwrap();
    let force = vehicle.coefficients.mass_matrix() * linear.a.fixed_view::<3, 4>(0, 0);
    let z_q = force[(1, 2)] - vehicle.coefficients.mass * speed;
    for (name, found, printed) in [
        ("Munk moment M_wa", force[(2, 1)], 53.4),
        ("Z_qa", z_q, 1.44),
        ("M_qa, with -m z_G w q none", force[(2, 2)], 2.97),
        ("X_theta", force[(0, 3)], 8.9),
        ("M_theta", force[(2, 3)], -5.77),
    ] {
        assert!(
            (found - printed).abs() < 0.02 * printed.abs(),
            "{name}: {found}, the thesis prints {printed}"
        );
    }
}
