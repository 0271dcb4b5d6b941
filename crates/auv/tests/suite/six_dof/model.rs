//! The equations of motion: another implementation, symmetries, energy.

use super::*;
use auv::{Coefficients, Effect};
use proptest::prelude::*;

/// Another implementation of the same equations, with the full mass matrix.
#[test]
fn acceleration_is_that_of_another_implementation() {
    let motion = Motion { u: 1.5, v: 0.2, w: -0.1, p: 0.3, q: -0.2, r: 0.4, phi: 0.1, theta: -0.05 };
    let found = acceleration(&remus(), &motion, [4.0, 0.05, -0.08]);
    let expected = [0.09687616, -1.34691217, -0.07600131, -4.14029523, 0.60840192, -2.94320342];
    for (found, expected) in found.iter().zip(expected) {
        assert!((found - expected).abs() < 1e-8, "{found} instead of {expected}");
    }
}

/// Without gravity and with the rudder of the stern planes turned by 90 deg: a vehicle that is the same all round.
fn axisymmetric() -> Vehicle {
    let mut vehicle = whole("remus100");
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
    /// What happens to port happens to starboard, to the last bit.
    #[test]
    fn port_is_starboard_in_a_mirror(motion in motion(), stern in -0.2..0.2, rudder in -0.2..0.2) {
        let vehicle = remus();
        let Motion { v, p, r, phi, .. } = motion;
        let mirrored = Motion { v: -v, p: -p, r: -r, phi: -phi, ..motion };
        let [du, dv, dw, dp, dq, dr] = acceleration(&vehicle, &motion, [3.0, stern, rudder]);
        prop_assert_eq!(acceleration(&vehicle, &mirrored, [3.0, stern, -rudder]), [du, -dv, dw, -dp, dq, -dr]);
    }

    /// A hull that is the same all round moves across as it moves down: turned by 90 deg about its axis, y is z.
    #[test]
    fn an_axisymmetric_hull_moves_across_as_down(motion in motion(), stern in -0.2..0.2, rudder in -0.2..0.2) {
        let vehicle = axisymmetric();
        let Motion { v, w, q, r, .. } = motion;
        let turned = Motion { v: w, w: -v, q: r, r: -q, ..motion };
        let [du, dv, dw, dp, dq, dr] = acceleration(&vehicle, &motion, [3.0, stern, rudder]);
        // Stern planes push up as the rudder pushes to port.
        let found = acceleration(&vehicle, &turned, [3.0, rudder, -stern]);
        for (found, expected) in found.iter().zip([du, dw, -dv, dp, dr, -dq]) {
            prop_assert!((found - expected).abs() < 1e-12 * (1.0 + expected.abs()), "{} {}", found, expected);
        }
    }

    /// In the vertical plane nothing moves out of it, and the rest moves as if there were nothing out of it.
    #[test]
    fn the_vertical_plane_is_left_alone(motion in motion(), stern in -0.2..0.2) {
        let Motion { u, w, q, theta, .. } = motion;
        let motion = Motion::in_plane(u, w, q, theta);
        let [du, dv, dw, dp, dq, dr] = acceleration(&remus(), &motion, [3.0, stern, 0.0]);
        prop_assert_eq!([dv, dp, dr], [0.0; 3]);
        let planar = crate::common::remus100();
        let force = actuator_force(&planar.actuators, u, [3.0, stern]);
        let alone = Dynamics::new(&planar.coefficients).unwrap().acceleration(&motion, 0.0, force);
        prop_assert_eq!(alone, [du, dw, dq]);
        prop_assert_eq!(motion.turning(), [0.0, q, 0.0]);
    }

    /// The force of a thruster turned about z and of a group of one, by cross products.
    #[test]
    fn thrusters_act_by_their_place_and_direction(
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

/// Kinetic energy with that of the water, and what weight and buoyancy store.
fn energy(c: &Coefficients, [u, v, w, p, q, r, phi, theta, _, depth]: [f64; 10]) -> f64 {
    let (plane, lateral) = (c.mass_matrix(), c.lateral_mass_matrix());
    let (x, y) = (nalgebra::Vector3::new(u, w, q), nalgebra::Vector3::new(v, p, r));
    let kinetic = 0.5 * (x.dot(&(plane * x)) + y.dot(&(lateral * y)));
    let below = |[x, z]: [f64; 2]| depth - theta.sin() * x + theta.cos() * phi.cos() * z;
    kinetic - c.weight * below([c.x_G, c.z_G]) + c.buoyancy * below([c.x_B, c.z_B])
}

/// Without damping, lift and thrust the energy of a tumbling vehicle stays, but for what the integrator loses.
#[test]
fn energy_stays_without_damping() {
    let mut vehicle = remus();
    let acts =
        |spec: &&auv::CoefficientSpec| ["lift", "damping"].contains(&spec.section) || spec.key == "X_uu";
    for spec in auv::COEFFICIENTS.iter().filter(acts) {
        (spec.set)(&mut vehicle.coefficients, 0.0);
    }
    let lost = |steps: usize| {
        let start = [1.5, 0.2, -0.1, 0.3, -0.2, 0.4, 0.1, -0.05, 0.0, 10.0];
        let flown = (0..steps).fold(start, |x, _| step(&vehicle, x, [0.0; 3], 20.0 / steps as f64));
        assert!(flown.iter().zip(start).all(|(x, start)| (x - start).abs() > 1e-2), "{flown:?}");
        (energy(&vehicle.coefficients, flown) - energy(&vehicle.coefficients, start)).abs()
    };
    let (coarse, fine) = (lost(4000), lost(8000));
    assert!(coarse < 1e-4 && fine < coarse / 12.0, "{coarse} J, {fine} J");
}
