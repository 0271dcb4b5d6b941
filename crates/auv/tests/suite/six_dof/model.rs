//! Equations of motion: another implementation, symmetries, energy.

use super::*;
use proptest::prelude::*;
use squid_auv::{COEFFICIENTS, Coefficients, Dual64, Effect, Hull, Scalar, Subsystem};
use std::sync::LazyLock;

/// Reference values: another implementation of the same equations, with the full mass matrix.
#[test]
fn acceleration_matches_another_implementation() {
    let motion = Motion { u: 1.5, v: 0.2, w: -0.1, p: 0.3, q: -0.2, r: 0.4, phi: 0.1, theta: -0.05 };
    let found = acceleration(&remus(), &motion, &[4.0, 0.05, -0.08]);
    let expected = [0.09687616, -1.34691217, -0.07600131, -4.14029523, 0.60840192, -2.94320342];
    for (found, expected) in found.iter().zip(expected) {
        assert!((found - expected).abs() < 1e-8, "{found} instead of {expected}");
    }
}

/// A coefficient affects only the part of the motion named in its row of the table.
#[test]
fn coefficients_act_on_their_subsystem() {
    let mut vehicle = remus();
    vehicle.coefficients.hull = Hull::new(&[[-0.6, 0.1], [0.7, 0.19]]).unwrap();
    let c = &mut vehicle.coefficients;
    for spec in COEFFICIENTS {
        let small = [0.01, -0.01].into_iter().find(|value| spec.allowed.contains(*value)).unwrap();
        (spec.set)(c, if (spec.get)(c) == 0.0 { small } else { (spec.get)(c) });
    }
    let all = Motion { u: 1.5, v: 0.2, w: -0.1, p: 0.3, q: -0.2, r: 0.4, phi: 0.1, theta: -0.05 };
    let in_plane = Motion::in_plane(1.5, -0.1, -0.2, -0.05);
    for spec in COEFFICIENTS {
        let mut other = vehicle.clone();
        (spec.set)(&mut other.coefficients, 1.01 * (spec.get)(&vehicle.coefficients));
        let moves = |motion: &Motion, indices: [usize; 3]| {
            let [before, after] =
                [&vehicle, &other].map(|one| acceleration_at(7.0, one, motion, &[4.0, 0.05, -0.08]));
            indices.into_iter().any(|index| before[index] != after[index])
        };
        let found = (moves(&in_plane, [0, 2, 4]), moves(&all, [1, 3, 5]));
        let expected = match spec.subsystem {
            Subsystem::Longitudinal => (true, false),
            Subsystem::Lateral => (false, true),
            Subsystem::Both => (true, true),
        };
        assert_eq!(found, expected, "{}", spec.key);
    }
}

/// Returns an axisymmetric vehicle: without gravity, and with a rudder like the stern planes turned by 90 deg.
fn axisymmetric() -> Vehicle {
    let mut vehicle = six_dof("remus100");
    let c = &mut vehicle.coefficients;
    (c.z_G, c.weight, c.N_rr) = (0.0, c.buoyancy, c.M_qq);
    vehicle
}

prop_compose! {
    fn motion()(
        u in -2.0..2.0, v in -0.5..0.5, w in -0.5..0.5,
        p in -1.0..1.0, q in -1.0..1.0, r in -1.0..1.0,
        phi in -1.5..1.5, theta in -1.5..1.5,
    ) -> Motion {
        Motion { u, v, w, p, q, r, phi, theta }
    }
}

proptest! {
    /// Port and starboard are symmetric, to the last bit.
    #[test]
    fn port_and_starboard_are_symmetric(motion in motion(), stern in -0.2..0.2, rudder in -0.2..0.2) {
        let vehicle = remus();
        let Motion { v, p, r, phi, .. } = motion;
        let mirrored = Motion { v: -v, p: -p, r: -r, phi: -phi, ..motion };
        let [du, dv, dw, dp, dq, dr] = acceleration(&vehicle, &motion, &[3.0, stern, rudder]);
        prop_assert_eq!(acceleration(&vehicle, &mirrored, &[3.0, stern, -rudder]), [du, -dv, dw, -dp, dq, -dr]);
    }

    /// An axisymmetric hull behaves in sway as in heave: a turn of 90 deg about its axis maps y to z.
    #[test]
    fn axisymmetric_hull_sways_as_it_heaves(motion in motion(), stern in -0.2..0.2, rudder in -0.2..0.2) {
        let vehicle = axisymmetric();
        let Motion { v, w, q, r, .. } = motion;
        let rotated = Motion { v: w, w: -v, q: r, r: -q, ..motion };
        let [du, dv, dw, dp, dq, dr] = acceleration(&vehicle, &motion, &[3.0, stern, rudder]);
        // Stern planes push up as the rudder pushes to port.
        let found = acceleration(&vehicle, &rotated, &[3.0, rudder, -stern]);
        for (found, expected) in found.iter().zip([du, dw, -dv, dp, dr, -dq]) {
            prop_assert!((found - expected).abs() < 1e-12 * (1.0 + expected.abs()), "{} {}", found, expected);
        }
    }

    /// Motion in the vertical plane stays in it, and is independent of the lateral coefficients.
    #[test]
    fn motion_stays_in_the_vertical_plane(motion in motion(), stern in -0.2..0.2) {
        let Motion { u, w, q, theta, .. } = motion;
        let motion = Motion::in_plane(u, w, q, theta);
        let [du, dv, dw, dp, dq, dr] = acceleration(&remus(), &motion, &[3.0, stern, 0.0]);
        prop_assert_eq!([dv, dp, dr], [0.0; 3]);
        let planar = crate::common::remus100();
        let force = actuator_force(&planar.actuators, u, [3.0, stern]);
        let planar_rates = Dynamics::new(&planar.coefficients).unwrap().acceleration(&motion, 0.0, force);
        prop_assert_eq!(planar_rates, [du, dw, dq]);
        prop_assert_eq!(motion.turning(), [0.0, q, 0.0]);
    }

    /// Forces of a thruster with an azimuth, by cross products.
    #[test]
    fn thruster_forces_match_cross_products(
        [x, y, z] in [-1.0..1.0, -1.0..1.0, -1.0..1.0], direction in -3.0..3.0, azimuth in -3.0..3.0,
        torque in -0.2..0.2,
    ) {
        let mut actuator = remus().actuators[0].clone();
        actuator.effect = Effect::Thruster { x, y, z, direction, azimuth, torque };
        let e = nalgebra::Vector3::new(
            direction.cos() * azimuth.cos(), direction.cos() * azimuth.sin(), direction.sin(),
        );
        let moment = nalgebra::Vector3::new(x, y, z).cross(&e) + e * torque;
        let ([ahead, down, pitch], [across, roll, yaw]) = (actuator.force(1.3, 2.0), actuator.lateral_force(1.3, 2.0));
        let found = [ahead, across, down, roll, pitch, yaw];
        for (found, expected) in found.iter().zip(e.iter().chain(moment.iter())) {
            prop_assert!((found - 2.0 * expected).abs() < 1e-12, "{} {}", found, 2.0 * expected);
        }
    }
}

/// Returns the kinetic energy, that of the water included, plus the potential energy of weight and buoyancy, at a state
/// \[u v w p q r phi theta psi depth\].
fn energy<D: Scalar>(c: &Coefficients<D>, [u, v, w, p, q, r, phi, theta, _, depth]: [D; 10]) -> D {
    let (plane, lateral) = (c.mass_matrix(), c.lateral_mass_matrix());
    let (x, y) = (nalgebra::Vector3::new(u, w, q), nalgebra::Vector3::new(v, p, r));
    let kinetic = (x.dot(&(plane * x)) + y.dot(&(lateral * y))) * 0.5;
    let below = |x: D, z: D| depth - theta.sin() * x + theta.cos() * phi.cos() * z;
    kinetic - c.weight * below(c.x_G, c.z_G) + c.buoyancy * below(c.x_B, c.z_B)
}

prop_compose! {
    /// Velocity of any size from 0.1 mm/s, or rate from 0.1 mrad/s, to 3 in either direction.
    fn any_size()(size in -4.0..0.5_f64, ahead in prop::bool::ANY) -> f64 {
        if ahead { 10_f64.powf(size) } else { -10_f64.powf(size) }
    }
}

static SHIPPED: LazyLock<[Vehicle; 6]> =
    LazyLock::new(|| ["squid", "remus100", "lauv", "tethys", "sparus2", "bluerov2_heavy"].map(six_dof));

proptest! {
    /// The energy of a vehicle without thrust never grows: ahead, astern and across, at any attitude, in six degrees of
    /// freedom and in the vertical plane. The power counts every force through the accelerations; undeflected fins are
    /// part of the hull.
    #[test]
    fn energy_never_grows_without_thrust(
        [u, v, w, p, q, r] in prop::array::uniform6(any_size()),
        [phi, theta] in prop::array::uniform2(-3.1..3.1f64),
    ) {
        let motion = Motion { u, v, w, p, q, r, phi, theta };
        for vehicle in SHIPPED.iter() {
            let out_of_plane = vehicle.coefficients.leaves_plane().then_some(motion);
            for motion in [Some(Motion::in_plane(u, w, q, theta)), out_of_plane].into_iter().flatten() {
                let (found, size) = power(vehicle, &motion, &vec![0.0; vehicle.actuators.len()]);
                prop_assert!(found <= 1e-12 * size, "{}: {} W of {} W", vehicle.name, found, size);
            }
        }
    }
}

/// Returns the rate of the energy of a vehicle \[W\], and the sum of the absolute gains and losses.
fn power(vehicle: &Vehicle, motion: &Motion, outputs: &[f64]) -> (f64, f64) {
    let Motion { u, v, w, p, q, r, phi, theta } = *motion;
    let [roll, pitch, heading] = motion.turning();
    let [du, dv, dw, dp, dq, dr] = acceleration(vehicle, motion, outputs);
    let state = [u, v, w, p, q, r, phi, theta, 0.0, vehicle.coefficients.reference_depth];
    let rates = [du, dv, dw, dp, dq, dr, roll, pitch, heading, motion.depth_rate()];
    let constant = vehicle.coefficients.map(|_, value| Dual64::from(value));
    let by = |i: usize| {
        let dual_state = std::array::from_fn(|j| Dual64::new(state[j], if i == j { rates[j] } else { 0.0 }));
        energy(&constant, dual_state).eps
    };
    let all: [f64; 10] = std::array::from_fn(by);
    (all.iter().sum(), all.iter().map(|one| one.abs()).sum())
}

/// The energy of a tumbling vehicle without damping, lift and thrust is constant, apart from the integration error.
#[test]
fn energy_is_conserved_without_damping() {
    let mut vehicle = remus();
    let acts = |spec: &&squid_auv::CoefficientSpec| {
        ["lift", "damping"].contains(&spec.section) || spec.key == "X_uu"
    };
    for spec in squid_auv::COEFFICIENTS.iter().filter(acts) {
        (spec.set)(&mut vehicle.coefficients, 0.0);
    }
    let energy_error = |steps: usize| {
        let start = [1.5, 0.2, -0.1, 0.3, -0.2, 0.4, 0.1, -0.05, 0.0, 10.0];
        let end = (0..steps).fold(start, |x, _| step(&vehicle, x, [0.0; 3], 20.0 / steps as f64));
        assert!(end.iter().zip(start).all(|(x, start)| (x - start).abs() > 1e-2), "{end:?}");
        (energy(&vehicle.coefficients, end) - energy(&vehicle.coefficients, start)).abs()
    };
    let (coarse, fine) = (energy_error(4000), energy_error(8000));
    assert!(coarse < 1e-4 && fine < coarse / 12.0, "{coarse} J, {fine} J");
}

/// Returns M nu' from the nonlinear table of T. Prestero (MSc thesis, MIT/WHOI, 2001), chapter 4 and appendix, with the
/// misprint of Z_ww corrected and without propeller torque; `cross` is M_rp, and -N_pq.
fn prestero(m: &Motion, [thrust, stern, rudder]: [f64; 3], cross: f64) -> [f64; 6] {
    let (weight, buoyancy, z_g, i_xx, i_yy, i_zz) = (299.0, 308.0, 0.0196, 0.177, 3.45, 3.45);
    let mass = weight / 9.81;
    let Motion { u, v, w, p, q, r, phi, theta } = *m;
    let (uu, light) = (u * u, weight - buoyancy);
    [
        -light * theta.sin() - 1.62 * u * u.abs() - 35.5 * w * q - 1.93 * q * q + 35.5 * v * r - 1.93 * r * r
            + thrust
            - mass * (-v * r + w * q + z_g * p * r),
        light * theta.cos() * phi.sin() - 1310.0 * v * v.abs() + 0.632 * r * r.abs() - 28.6 * u * v
            + 5.22 * u * r
            + 35.5 * w * p
            + 1.93 * p * q
            + 9.64 * uu * rudder
            - mass * (-w * p + u * r + z_g * q * r),
        light * theta.cos() * phi.cos()
            - 1310.0 * w * w.abs()
            - 0.632 * q * q.abs()
            - 28.6 * u * w
            - 5.22 * u * q
            - 35.5 * v * p
            + 1.93 * r * p
            - 9.64 * uu * stern
            - mass * (-u * q + v * p - z_g * (p * p + q * q)),
        -z_g * weight * theta.cos() * phi.sin() - 0.13 * p * p.abs() - (i_zz - i_yy) * q * r
            + mass * z_g * (-w * p + u * r),
        -z_g * weight * theta.sin() + 3.18 * w * w.abs() - 188.0 * q * q.abs() + 24.0 * u * w
            - 2.0 * u * q
            - 1.93 * v * p
            + cross * r * p
            - 6.15 * uu * stern
            - (i_xx - i_zz) * r * p
            - mass * z_g * (-v * r + w * q),
        -3.18 * v * v.abs()
            - 94.0 * r * r.abs()
            - 24.0 * u * v
            - 2.0 * u * r
            - 1.93 * w * p
            - cross * p * q
            - 6.15 * uu * rudder
            - (i_yy - i_xx) * p * q,
    ]
}

proptest! {
    /// All terms of the table follow from the fewer coefficients of the vehicle file, except M_rp = -N_pq: printed as
    /// 4.86, while K_p' - N_r' of the same table is 4.8096, which conservation of energy requires.
    #[test]
    fn forces_match_the_table_of_prestero(motion in motion(), stern in -0.2..0.2, rudder in -0.2..0.2) {
        // Astern our fin forces reverse; the u^2 of the thesis does not.
        let motion = Motion { u: motion.u.abs(), ..motion };
        let vehicle = remus();
        let outputs = [3.0, stern, rudder];
        let [du, dv, dw, dp, dq, dr] = acceleration(&vehicle, &motion, &outputs);
        let c = &vehicle.coefficients;
        let plane = c.mass_matrix() * nalgebra::Vector3::new(du, dw, dq);
        let lateral = c.lateral_mass_matrix() * nalgebra::Vector3::new(dv, dp, dr);
        let found = [plane[0], lateral[0], plane[1], lateral[1], plane[2], lateral[2]];
        for (found, expected) in found.iter().zip(prestero(&motion, outputs, 4.88 - 0.0704)) {
            prop_assert!((found - expected).abs() < 1e-11 * (1.0 + expected.abs()), "{} {}", found, expected);
        }
        let printed = prestero(&motion, outputs, 4.86);
        let difference = [0.0, 0.0, 0.0, 0.0, 0.0504 * motion.r * motion.p, -0.0504 * motion.p * motion.q];
        for ((found, printed), difference) in found.iter().zip(printed).zip(difference) {
            prop_assert!((printed - found - difference).abs() < 1e-11 * (1.0 + found.abs()), "{} {}", found, printed);
        }
    }
}

/// Returns the LAUV of DUNE (github.com/LSTS/dune, vsim-models.ini), about its centre of buoyancy, with the mass of 18
/// kg that corresponds to its inertia of 19 and 34 kg with the water; its file also gives 24 kg.
fn lauv_of_dune() -> Coefficients {
    let weight = 18.0 * 9.82;
    #[rustfmt::skip]
    let c = Coefficients {
        mass: 18.0, weight, buoyancy: weight + 1.0, z_G: 0.009, I_xx: 0.04, I_yy: 2.1, I_zz: 2.1, density: 1025.0,
        X_u_dot: -1.0, Z_w_dot: -16.0, Y_v_dot: -16.0,
        Z_uw: -20.6, Z_uq: -3.84, M_uw: -6.0, M_uq: -1.53, Y_uv: -20.6, Y_ur: 3.84, N_uv: 6.0, N_ur: -1.53,
        X_u: -2.4, Z_w: -23.0, Y_v: -23.0, K_p: -0.3, M_q: -9.7, N_r: -9.7, Z_q: 11.5, Y_r: -11.5, M_w: -3.1, N_v: 3.1,
        X_uu: -2.4, Z_ww: -80.0, Y_vv: -80.0, K_pp: -0.0006, M_qq: -9.1, N_rr: -9.1, Z_qq: 0.3, Y_rr: -0.3, M_ww: -1.5,
        N_vv: 1.5,
        ..Coefficients::default()
    };
    c
}

/// Returns the forces of that simulator on a body without fins and propeller: damping along each axis and across,
/// weight and buoyancy (without their x component, which it omits), those of a rotating frame, and lift.
fn forces_of_dune(m: &Motion) -> [f64; 6] {
    let Motion { u, v, w, p, q, r, phi, theta } = *m;
    let damped = |linear: f64, quadratic: f64, x: f64| (linear + quadratic * x.abs()) * x;
    let (mass, z_g, ahead, across) = (18.0, 0.009, 18.0 + 1.0, 18.0 + 16.0);
    let (roll, turn) = (0.04, 2.1);
    [
        damped(-2.4, -2.4, u) - mass * z_g * r * p - across * w * q + across * v * r,
        damped(-23.0, -80.0, v) + damped(-11.5, -0.3, r) - theta.cos() * phi.sin() + across * w * p
            - mass * z_g * r * q
            - ahead * u * r
            + (-20.6 * v + 3.84 * r) * u,
        damped(-23.0, -80.0, w) + damped(11.5, 0.3, q) - theta.cos() * phi.cos()
            + mass * z_g * (p * p + q * q)
            - across * v * p
            + ahead * u * q
            + (-20.6 * w - 3.84 * q) * u,
        damped(-0.3, -0.0006, p) - z_g * mass * 9.82 * theta.cos() * phi.sin() + mass * z_g * (r * u - p * w),
        damped(-9.7, -9.1, q) + damped(-3.1, -1.5, w) - z_g * mass * 9.82 * theta.sin()
            + (across - ahead) * w * u
            + mass * z_g * (r * v - q * w)
            + (turn - roll) * r * p
            + (-6.0 * w - 1.53 * q) * u,
        damped(-9.7, -9.1, r) + damped(3.1, 1.5, v) - (across - ahead) * v * u - (turn - roll) * p * q
            + (6.0 * v - 1.53 * r) * u,
    ]
}

proptest! {
    /// Weight and buoyancy differ by 1 N.
    #[test]
    fn forces_match_dune(motion in motion()) {
        // Astern the lift of the simulator, proportional to u, feeds energy to the motion.
        let motion = Motion { u: motion.u.abs(), ..motion };
        let c = lauv_of_dune();
        let dynamics = Dynamics::new(&c).unwrap();
        let [du, dw, dq] = dynamics.acceleration(&motion, 0.0, [0.0; 3]);
        let [dv, dp, dr] = dynamics.lateral_acceleration(&motion, 0.0, [0.0; 3]);
        let plane = c.mass_matrix() * nalgebra::Vector3::new(du, dw, dq);
        let lateral = c.lateral_mass_matrix() * nalgebra::Vector3::new(dv, dp, dr);
        let along = motion.theta.sin();
        let found = [plane[0] - along, lateral[0], plane[1], lateral[1], plane[2], lateral[2]];
        for (found, expected) in found.iter().zip(forces_of_dune(&motion)) {
            prop_assert!((found - expected).abs() < 1e-11 * (1.0 + expected.abs()), "{} {}", found, expected);
        }
    }
}
