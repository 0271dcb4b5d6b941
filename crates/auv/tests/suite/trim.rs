//! Trim: its results, least norm, and rejected input.

use crate::common::{bluerov2_heavy, remus100, squid};
use nalgebra::DVector;
use squid_auv::{
    COEFFICIENTS, CoefficientError, Dynamics, Effect, Pitch, Speed, Trim, TrimError, Vehicle, actuator_force,
    climb, linearise, trim, trim_with, trims,
};

#[test]
fn trim_is_level_and_steady() {
    for (vehicle, speeds) in
        [(squid(), [0.5, 1.0, 1.5, 2.0, 2.5, 3.0]), (remus100(), [1.0, 1.25, 1.5, 1.75, 2.0, 2.25])]
    {
        let dynamics = Dynamics::new(&vehicle.coefficients).unwrap();
        for speed in speeds {
            let trim =
                trim(&vehicle, Speed::Path(speed), 50.0).unwrap_or_else(|e| panic!("{}: {e}", vehicle.name));
            let motion = trim.motion();
            assert!((motion.u.hypot(motion.w) - speed).abs() < 1e-14);
            assert!((motion.w * motion.theta.cos() - motion.u * motion.theta.sin()).abs() < 1e-15);
            let force = actuator_force(&vehicle.actuators, motion.u, trim.actuators.iter().copied());
            let residual = dynamics.acceleration(&motion, 50.0, force);
            assert!(residual.iter().all(|a| a.abs() < 1e-12), "{residual:?}");
            assert!(trim.residual < 1e-12);
        }
    }
}

/// An incidence that the outputs can hold in level flight only, or that level flight has anyway, is free in a climb.
#[test]
fn climb_from_a_held_trim_is_steady() {
    for (vehicle, speed, holds_incidence) in [(remus100(), 1.8, false), (bluerov2_heavy(), 0.4, true)] {
        let free = trim(&vehicle, Speed::Path(speed), 20.0).unwrap();
        let pitch = if holds_incidence { 0.0 } else { free.pitch };
        let mut at = trim_with(&vehicle, Speed::Path(speed), 20.0, &Pitch::Held(pitch)).unwrap();
        let held = at.incidence;
        let dynamics = Dynamics::new(&vehicle.coefficients).unwrap();
        for step in 1..=10 {
            at = climb(&vehicle, &at, pitch + 0.02 * f64::from(step)).unwrap();
            let motion = at.motion();
            let force = actuator_force(&vehicle.actuators, motion.u, at.actuators.iter().copied());
            let residual = dynamics.acceleration(&motion, 20.0, force);
            assert!(residual.iter().all(|a| a.abs() < 1e-10), "{residual:?}");
        }
        assert_eq!(at.incidence == held, holds_incidence, "{}", vehicle.name);
    }
}

#[test]
fn trims_by_forward_and_path_speed_agree() {
    let vehicle = squid();
    let by_path = trim(&vehicle, Speed::Path(0.6), 50.0).unwrap();
    let by_forward_speed = trim(&vehicle, Speed::Forward(by_path.forward_speed), 50.0).unwrap();
    assert!((by_forward_speed.speed - 0.6).abs() < 1e-12);
    assert!((by_forward_speed.incidence - by_path.incidence).abs() < 1e-11);
}

#[test]
fn redundant_actuators_share_by_least_norm() {
    let mut vehicle = squid();
    // The two upper thrusters are equivalent: they share equally, and any other division of the same force is larger.
    let even = trim(&vehicle, Speed::Path(2.0), 50.0).unwrap();
    assert!((even.actuators[1] - even.actuators[2]).abs() < 1e-10);
    // A thruster of twice the reach takes four times the load: T_i = s_i^2 times the gradient of the same constraint.
    (vehicle.actuators[1].min, vehicle.actuators[1].max) = (-200.0, 200.0);
    let uneven = trim(&vehicle, Speed::Path(2.0), 50.0).unwrap();
    assert!((uneven.actuators[1] - 4.0 * uneven.actuators[2]).abs() < 1e-9);
    assert!((uneven.actuators[1] + uneven.actuators[2] - 2.0 * even.actuators[1]).abs() < 1e-9);
}

fn squid_with_vertical() -> Vehicle {
    let mut vehicle = squid();
    let mut vertical = vehicle.actuators[0].clone();
    vertical.name = "vertical".into();
    vertical.effect = Effect::thruster(0.0, 0.0, std::f64::consts::FRAC_PI_2);
    vehicle.actuators.push(vertical);
    vehicle
}

#[test]
fn vertical_thruster_reduces_the_effort() {
    let vehicle = squid_with_vertical();
    let without = trim(&squid(), Speed::Path(0.5), 50.0).unwrap();
    let with = trim(&vehicle, Speed::Path(0.5), 50.0).unwrap();
    assert!(with.residual < 1e-12);
    let effort = |outputs: &[f64]| outputs.iter().map(|t| (t / 100.0).powi(2)).sum::<f64>();
    assert!(effort(&with.actuators) < effort(&without.actuators), "one more thruster cannot cost effort");
}

#[test]
fn rejects_impossible_trims_with_numbers() {
    let vehicle = squid();
    assert!(matches!(trim(&vehicle, Speed::Forward(f64::NAN), 50.0), Err(TrimError::SpeedNotFinite { .. })));
    assert!(matches!(trim(&vehicle, Speed::Path(1.0), f64::INFINITY), Err(TrimError::DepthNotFinite { .. })));

    let mut weak = squid();
    weak.actuators.iter_mut().for_each(|actuator| actuator.max = 15.0);
    match trim(&weak, Speed::Path(3.0), 50.0) {
        Err(TrimError::BeyondLimits { actuator, needed, excess, max, .. }) => {
            assert!(
                actuator.starts_with("upper_") && max == 15.0,
                "the upper ones carry the most: {actuator}"
            );
            assert!(needed > 15.0 && (needed - 15.0 - excess).abs() < 1e-12);
        }
        other => panic!("{other:?}"),
    }

    // The speed is so low that the planes cannot hold the bow against the buoyancy: a start at zero incidence only
    // would find nothing.
    match trim(&remus100(), Speed::Path(0.3), 50.0) {
        Err(TrimError::BeyondLimits { actuator, needed, max, unit, .. }) => {
            assert_eq!((actuator.as_str(), unit), ("stern_planes", "deg"));
            assert!(needed > max && (max - 13.6).abs() < 1e-13);
        }
        other => panic!("{other:?}"),
    }

    let mut axial = squid();
    axial.actuators.truncate(1);
    axial.actuators[0].effect = Effect::thruster(0.0, 0.0, 0.0);
    let error = trim(&axial, Speed::Path(1.0), 50.0).unwrap_err();
    assert!(matches!(error, TrimError::NotFound { residual, .. } if residual > 1e-4), "{error}");

    let mut broken = squid();
    broken.coefficients.mass = -1.0;
    assert!(matches!(
        trim(&broken, Speed::Path(1.0), 50.0),
        Err(TrimError::Coefficients(CoefficientError::NotAllowed { key: "mass", .. }))
    ));
}

/// The axial force on REMUS 100 without its propeller is unbalanced, with drag or without, at any pitch.
#[test]
fn reports_a_hull_without_axial_thruster() {
    let mut remus = remus100();
    remus.actuators.retain(|a| a.unit() != "N");
    let drag = |vehicle: &Vehicle, pitch: &Pitch| {
        let error = trim_with(vehicle, Speed::Path(1.5), 50.0, pitch).unwrap_err();
        let TrimError::NoThrust { speed: 1.5, depth: 50.0, drag } = error else { panic!("{error}") };
        (drag, error.to_string())
    };
    let (free, message) = drag(&remus, &Pitch::Free);
    assert!((free - 1.62 * 1.5 * 1.5).abs() < 1e-9 && drag(&remus, &Pitch::Held(0.05)).0 == free, "{free}");
    remus.coefficients.X_uu = 0.0;
    let (none, without) = drag(&remus, &Pitch::Free);
    assert_eq!(none, 0.0);
    insta::assert_snapshot!(format!("{message}\n\n{without}"));
}

/// Numbers whose squares overflow give an error, and no endless decomposition.
#[test]
fn rejects_huge_numbers_in_time() {
    let mut vehicle = squid();
    for spec in COEFFICIENTS {
        for huge in [1e308, -1e308, 1e-308, 1e160] {
            let before = (spec.get)(&vehicle.coefficients);
            (spec.set)(&mut vehicle.coefficients, huge);
            if let Ok(found) = trim(&vehicle, Speed::Path(1.0), 50.0) {
                assert!(found.residual.is_finite(), "{}", spec.key);
            }
            (spec.set)(&mut vehicle.coefficients, before);
        }
    }
    assert!(trim(&vehicle, Speed::Path(1e308), 50.0).is_err());
    assert!(trim(&vehicle, Speed::Path(1.0), 1e308).is_err());
}

/// The slope of the trim agrees with trims at neighbouring speeds. Outputs are compared by their forces, since several
/// outputs may have the same force.
#[test]
fn trim_slope_matches_differences() {
    for (vehicle, speeds, depth) in [
        (squid(), [0.5, 1.0, 2.0, 3.0], 50.0),
        (squid_with_vertical(), [0.5, 1.0, 2.0, 3.0], 50.0),
        (remus100(), [1.4, 1.6, 1.9, 2.2], 20.0),
    ] {
        let name = &vehicle.name;
        for speed in speeds {
            let at = |v: f64| trim(&vehicle, Speed::Path(v), depth).unwrap();
            let step = 1e-4;
            let (before, after) = (at(speed - step), at(speed + step));
            let model = linearise(&vehicle, &at(speed)).unwrap();
            let slope = model.trim_slope(&vehicle.actuators);
            let rise = after.forward_speed - before.forward_speed;
            let difference = |of: fn(&Trim) -> f64| (of(&after) - of(&before)) / rise;
            let close = |found: f64, expected: f64| {
                assert!(
                    (found - expected).abs() < 1e-6 * (1.0 + expected.abs()),
                    "{name} {speed}: {found} {expected}"
                );
            };
            close(slope[0], difference(|t| t.forward_speed));
            close(slope[1], difference(|t| t.heave));
            close(slope[2], 0.0);
            close(slope[3], difference(|t| t.pitch));
            let outputs = |t: &Trim| DVector::from_column_slice(&t.actuators);
            let expected = &model.b * (outputs(&after) - outputs(&before)) / rise;
            let found = &model.b * slope.rows(4, vehicle.actuators.len());
            (0..4).for_each(|i| close(found[i], expected[i]));
        }
    }
}

/// Returns `count` speeds from one to another.
fn speed_range(from: f64, to: f64, count: u32) -> Vec<f64> {
    (0..count).map(|i| from + (to - from) * f64::from(i) / f64::from(count - 1)).collect()
}

/// Returns the remaining acceleration, by an evaluation of the equations of motion.
fn residual(vehicle: &Vehicle, trim: &Trim) -> f64 {
    let motion = trim.motion();
    let force = actuator_force(&vehicle.actuators, motion.u, trim.actuators.iter().copied());
    let residual = Dynamics::new(&vehicle.coefficients).unwrap().acceleration(&motion, trim.depth, force);
    residual.iter().fold(0.0, |most, a| a.abs().max(most))
}

#[test]
fn held_pitch_is_held_from_astern_to_ahead() {
    let vehicle = bluerov2_heavy();
    for degrees in [0.0_f64, 5.0, -12.0] {
        let pitch = Pitch::Held(degrees.to_radians());
        for speed in speed_range(-0.5, 0.7, 13) {
            let found = trim_with(&vehicle, Speed::Path(speed), 10.0, &pitch).unwrap();
            assert_eq!((found.pitch, found.speed), (degrees.to_radians(), speed));
            assert!(
                (found.heave * found.pitch.cos() - found.forward_speed * found.pitch.sin()).abs() < 1e-15
            );
            assert!(residual(&vehicle, &found) < 1e-12, "{speed} m/s");
            // Excess weight of 1 N, against two pairs of thrusters that push up.
            let vertical = 2.0 * (found.actuators[1] + found.actuators[2]);
            assert!(degrees != 0.0 || (vertical - (132.57 - 131.588)).abs() < 1e-9, "{vertical}");
        }
        let by_forward_speed = trim_with(&vehicle, Speed::Forward(-0.3), 10.0, &pitch).unwrap();
        assert!((by_forward_speed.forward_speed, by_forward_speed.speed < 0.0) == (-0.3, true));
    }
}

#[test]
fn reports_the_remaining_force_at_a_held_pitch() {
    let error = trim_with(&squid(), Speed::Path(0.5), 50.0, &Pitch::Held(0.0)).unwrap_err();
    // Excess buoyancy of 3.34 N, and no vertical thruster.
    let TrimError::NotHeld { speed, depth, pitch_deg, heave, .. } = error else { panic!("{error}") };
    assert!((speed, pitch_deg) == (0.5, 0.0) && heave < -1.0, "{heave}");
    let rounded = TrimError::NotHeld { speed, depth, pitch_deg, surge: 0.0, heave: -3.0, moment: 0.5 };
    insta::assert_snapshot!(rounded);
}

/// Default pitch: level for the box with vertical thrusters; free, with the trims of least effort, for the others.
#[test]
fn default_pitch_is_level_if_thrusters_can_hold_it() {
    let over = |vehicle: &Vehicle, depth, speeds: &[f64]| Pitch::over(vehicle, depth, speeds, None);
    assert_eq!(over(&bluerov2_heavy(), 10.0, &speed_range(-0.5, 0.7, 25)), Pitch::Held(0.0));
    let (slow, fast) = (speed_range(0.5, 3.0, 26), speed_range(1.4, 2.2, 26));
    for (vehicle, depth, speeds) in [(squid(), 50.0, &slow), (remus100(), 20.0, &fast)] {
        let pitch = over(&vehicle, depth, speeds);
        assert_eq!(pitch, Pitch::Free);
        let least_effort: Vec<Trim> =
            speeds.iter().map(|v| trim(&vehicle, Speed::Path(*v), depth).unwrap()).collect();
        assert_eq!(trims(&vehicle, depth, speeds, &pitch).unwrap(), least_effort);
    }
    // A requested angle is held, even if it will be rejected.
    assert_eq!(Pitch::over(&squid(), 50.0, &slow, Some(&Pitch::Held(0.1))), Pitch::Held(0.1));
}

/// The trims of least effort of the box lie on two branches, bow up and bow down. One continues from the lowest speed
/// to the highest, and is followed.
#[test]
fn finds_a_jump_at_any_spacing_and_follows_the_branch() {
    let mut vehicle = bluerov2_heavy();
    vehicle.actuators.iter_mut().for_each(|a| (a.min, a.max) = (3.0 * a.min, 3.0 * a.max));
    for count in [5, 26, 101] {
        let speeds = speed_range(0.1, 1.0, count);
        let error = trims(&vehicle, 10.0, &speeds, &Pitch::Free).unwrap_err();
        let TrimError::Jump { speed, ref quantity, before, after, .. } = error else { panic!("{error}") };
        assert!((0.3..0.35).contains(&speed) && quantity == "pitch", "{error}");
        assert!((before - after).abs() > 30.0, "{error}");

        let branch_rule = Pitch::over(&vehicle, 10.0, &speeds, Some(&Pitch::Free));
        assert!(matches!(branch_rule, Pitch::Followed(_)), "{branch_rule:?}");
        let found = trims(&vehicle, 10.0, &speeds, &branch_rule).unwrap();
        assert!(found.iter().all(|trim| trim.pitch > 0.0 && residual(&vehicle, trim) < 1e-11), "{found:?}");
    }
}

#[test]
fn rejects_a_range_without_continuous_branch() {
    // The requested branch does not exist: the trims bow up and bow down, joined at 0.5 m/s.
    let mut vehicle = bluerov2_heavy();
    vehicle.actuators.iter_mut().for_each(|a| (a.min, a.max) = (3.0 * a.min, 3.0 * a.max));
    let joined =
        Pitch::Followed([(0.4, 0.45), (0.5, 0.5), (0.5 + 1e-9, -0.5), (0.6, -0.5)].into_iter().collect());
    let error = trims(&vehicle, 10.0, &[0.45, 0.55], &joined).unwrap_err();
    let (TrimError::Jump { speed, .. } | TrimError::ForwardSpeedFalls { speed, .. }) = error else {
        panic!("{error}")
    };
    assert!((0.5..0.51).contains(&speed), "{speed}");
}
