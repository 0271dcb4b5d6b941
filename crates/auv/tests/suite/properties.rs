//! Properties that hold for any vehicle, speed or text.

use crate::common::squid;
use proptest::prelude::*;
use squid_auv::{Coefficients, Dynamics, Motion, Plant, Speed, TrimError, Vehicle, trim};

const SQUID: &str = include_str!("../../../../vehicles/squid/vehicle.toml");

prop_compose! {
    /// Any hull with negligible damping, lift, weight and buoyancy; its mass matrix is positive definite.
    fn inviscid()(
        mass in 1.0..500.0,
        x_g in -0.3..0.3,
        z_g in -0.1..0.1,
        gyration in 0.4..2.0,
        added in prop::array::uniform3(0.0_f64..1.5),
        coupling in -0.2..0.2,
    ) -> Coefficients {
        let i_yy = mass * gyration * gyration;
        Coefficients {
            mass,
            x_G: x_g,
            z_G: z_g,
            I_yy: i_yy,
            weight: 1e-300,
            buoyancy: 1e-300,
            density: 1000.0,
            X_u_dot: -added[0] * mass,
            Z_w_dot: -added[1] * mass,
            M_q_dot: -added[2] * i_yy,
            Z_q_dot: coupling * mass * gyration,
            M_w_dot: coupling * mass * gyration,
            ..Coefficients::default()
        }
    }
}

prop_compose! {
    fn motion()(u in -5.0..5.0, w in -2.0..2.0, q in -1.0..1.0, theta in -1.5..1.5) -> Motion {
        Motion::in_plane(u, w, q, theta)
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    /// Kirchhoff's terms do no work: nu' M dnu/dt = 0 without forces.
    #[test]
    fn inertial_forces_do_no_work(c in inviscid(), motion in motion()) {
        prop_assume!(c.check().is_ok());
        let nu = nalgebra::Vector3::new(motion.u, motion.w, motion.q);
        let rate = nalgebra::Vector3::from(Dynamics::new(&c).unwrap().acceleration(&motion, 0.0, [0.0; 3]));
        let force = c.mass_matrix() * rate;
        prop_assert!(nu.dot(&force).abs() <= 1e-11 * (1.0 + nu.norm() * force.norm()));
    }

    /// Friction and drag always oppose the motion.
    #[test]
    fn drag_opposes_motion(u in -5.0_f64..5.0) {
        let dynamics = Dynamics::new(&squid().coefficients).unwrap();
        prop_assert!(dynamics.axial_drag(u) * u <= 0.0);
    }

    /// A trim is within the limits, or its error names the actuator that falls short; the surrogate has no other
    /// outcome.
    #[test]
    fn trim_holds_or_names_the_weak_actuator(speed in 0.3..6.0, depth in 0.0..200.0) {
        let vehicle = squid();
        match trim(&vehicle, Speed::Path(speed), depth) {
            Ok(trim) => {
                prop_assert!(trim.residual < 1e-11);
                for (actuator, output) in vehicle.actuators.iter().zip(&trim.actuators) {
                    prop_assert!((actuator.min..=actuator.max).contains(output));
                }
            }
            Err(TrimError::BeyondLimits { needed, max, min, .. }) => {
                prop_assert!(speed > 3.0, "{} m/s must be within reach", speed);
                prop_assert!(needed > max || needed < min);
            }
            Err(other) => prop_assert!(false, "{}", other),
        }
    }

    /// An output never leaves the range between its start and the saturated command.
    #[test]
    fn outputs_stay_within_limits(start in -60.0..100.0, command in -1e3..1e3, elapsed in 0.0..10.0) {
        let actuator = &squid().actuators[0];
        let output = actuator.output_after(elapsed, start, command);
        prop_assert!((actuator.min..=actuator.max).contains(&output));
        let halfway = actuator.output_after(elapsed / 2.0, start, command);
        prop_assert!((actuator.output_after(elapsed / 2.0, halfway, command) - output).abs() < 1e-12 * 200.0);
    }

    /// An additional division of the interval changes nothing.
    #[test]
    fn dividing_an_interval_changes_nothing(cut in 0.0..8.0, speed in 0.5..3.0, command in -60.0..100.0) {
        let vehicle = squid();
        let start = trim(&vehicle, Speed::Path(speed), 50.0).unwrap();
        let mut undivided = Plant::new(&vehicle).unwrap();
        undivided.start(0.0, &start).unwrap();
        undivided.set_command(0, command).unwrap();
        let mut divided = undivided.clone();
        undivided.advance(8.0).unwrap();
        divided.advance(cut).unwrap();
        divided.advance(8.0).unwrap();
        let (a, b) = (undivided.state(), divided.state());
        prop_assert!((a.motion.theta - b.motion.theta).abs() < 1e-9);
        prop_assert!((a.motion.u - b.motion.u).abs() < 1e-9);
        prop_assert!((a.depth - b.depth).abs() < 1e-9);
        prop_assert!((a.x - b.x).abs() < 1e-9);
    }

    /// No text, however damaged, makes the reader panic, and every error names file and line.
    #[test]
    fn rejects_damaged_files_with_line_numbers(
        at in 0..SQUID.len(),
        length in 0_usize..80,
        junk in "[\\[\\]{}=\"a-z0-9.\n -]{0,6}",
    ) {
        let end = (at + length).min(SQUID.len());
        prop_assume!(SQUID.is_char_boundary(at) && SQUID.is_char_boundary(end));
        let text = format!("{}{junk}{}", &SQUID[..at], &SQUID[end..]);
        if let Err(error) = Vehicle::parse(&text, "damaged.toml") {
            let lines = 1..=text.lines().count() + 1;
            prop_assert!(!error.mistakes.is_empty());
            prop_assert!(error.mistakes.iter().all(|m| lines.contains(&m.line)));
            prop_assert!(error.to_string().starts_with("damaged.toml:"));
        }
    }
}
