//! Trim: what it returns, least norm, and what it refuses.

use crate::common::{remus100, squid};
use auv::{
    COEFFICIENTS, CoefficientError, Dynamics, Effect, Speed, Trim, TrimError, actuator_force, linearise, trim,
};
use nalgebra::DVector;

#[test]
fn a_trim_is_level_and_steady() {
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
            let left = dynamics.acceleration(&motion, 50.0, force);
            assert!(left.iter().all(|a| a.abs() < 1e-12), "{left:?}");
            assert!(trim.residual < 1e-12);
        }
    }
}

#[test]
fn trim_by_forward_speed_meets_trim_by_path_speed() {
    let vehicle = squid();
    let by_path = trim(&vehicle, Speed::Path(0.6), 50.0).unwrap();
    let by_forward = trim(&vehicle, Speed::Forward(by_path.forward_speed), 50.0).unwrap();
    assert!((by_forward.speed - 0.6).abs() < 1e-12);
    assert!((by_forward.incidence - by_path.incidence).abs() < 1e-11);
}

#[test]
fn redundant_actuators_share_in_the_least_norm() {
    let mut vehicle = squid();
    // The two upper thrusters do the same: they share alike, and any other split of the same force is larger.
    let even = trim(&vehicle, Speed::Path(2.0), 50.0).unwrap();
    assert!((even.actuators[1] - even.actuators[2]).abs() < 1e-10);
    // A thruster of twice the reach takes four times the load: T_i = s_i^2 times the gradient of the same constraint.
    (vehicle.actuators[1].min, vehicle.actuators[1].max) = (-200.0, 200.0);
    let uneven = trim(&vehicle, Speed::Path(2.0), 50.0).unwrap();
    assert!((uneven.actuators[1] - 4.0 * uneven.actuators[2]).abs() < 1e-9);
    assert!((uneven.actuators[1] + uneven.actuators[2] - 2.0 * even.actuators[1]).abs() < 1e-9);
}

#[test]
fn a_vertical_thruster_may_carry_the_buoyancy() {
    let mut vehicle = squid();
    let mut vertical = vehicle.actuators[0].clone();
    vertical.name = "vertical".into();
    vertical.effect = Effect::Thruster { x: 0.0, z: 0.0, direction: std::f64::consts::FRAC_PI_2 };
    vehicle.actuators.push(vertical);
    let without = trim(&squid(), Speed::Path(0.5), 50.0).unwrap();
    let with = trim(&vehicle, Speed::Path(0.5), 50.0).unwrap();
    assert!(with.residual < 1e-12);
    let effort = |outputs: &[f64]| outputs.iter().map(|t| (t / 100.0).powi(2)).sum::<f64>();
    assert!(effort(&with.actuators) < effort(&without.actuators), "one more thruster cannot cost effort");
}

#[test]
fn what_cannot_be_trimmed_is_refused_with_numbers() {
    let vehicle = squid();
    assert!(matches!(
        trim(&vehicle, Speed::Forward(f64::NAN), 50.0),
        Err(TrimError::SpeedNotFinite { .. })
    ));
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

    // So slow that the planes cannot hold the bow against the buoyancy: a start at zero incidence alone would find
    // nothing.
    match trim(&remus100(), Speed::Path(0.3), 50.0) {
        Err(TrimError::BeyondLimits { actuator, needed, max, unit, .. }) => {
            assert_eq!((actuator.as_str(), unit), ("stern_planes", "rad"));
            assert!(needed > max && (max - 13.6_f64.to_radians()).abs() < 1e-15);
        }
        other => panic!("{other:?}"),
    }

    let mut axial = squid();
    axial.actuators.truncate(1);
    axial.actuators[0].effect = Effect::Thruster { x: 0.0, z: 0.0, direction: 0.0 };
    let error = trim(&axial, Speed::Path(1.0), 50.0).unwrap_err();
    assert!(matches!(error, TrimError::NotFound { residual, .. } if residual > 1e-4), "{error}");
    let text = error.to_string();
    assert!(text.starts_with("no level trim at 1 m/s and 50 m: lift and actuators do not balance"), "{text}");

    let mut broken = squid();
    broken.coefficients.mass = -1.0;
    assert!(matches!(
        trim(&broken, Speed::Path(1.0), 50.0),
        Err(TrimError::Coefficients(CoefficientError::NotAllowed { key: "mass", .. }))
    ));
}

/// Numbers so large that their squares overflow: a refusal, and no decomposition that goes on for ever.
#[test]
fn absurd_numbers_are_refused_in_time() {
    let mut vehicle = squid();
    for spec in COEFFICIENTS {
        for absurd in [1e308, -1e308, 1e-308, 1e160] {
            let before = (spec.get)(&vehicle.coefficients);
            (spec.set)(&mut vehicle.coefficients, absurd);
            if let Ok(found) = trim(&vehicle, Speed::Path(1.0), 50.0) {
                assert!(found.residual.is_finite(), "{}", spec.key);
            }
            (spec.set)(&mut vehicle.coefficients, before);
        }
    }
    assert!(trim(&vehicle, Speed::Path(1e308), 50.0).is_err());
    assert!(trim(&vehicle, Speed::Path(1.0), 1e308).is_err());
}

/// The slope of the trim against trims at neighbouring speeds. Outputs are compared by the forces that they make,
/// since several may make the same.
#[test]
fn the_slope_of_the_trim_is_its_derivative() {
    for (vehicle, speeds, depth) in
        [(squid(), [0.5, 1.0, 2.0, 3.0], 50.0), (remus100(), [1.4, 1.6, 1.9, 2.2], 20.0)]
    {
        let name = &vehicle.name;
        for speed in speeds {
            let at = |u: f64| trim(&vehicle, Speed::Forward(u), depth).unwrap();
            let step = 1e-4;
            let (before, after) = (at(speed - step), at(speed + step));
            let model = linearise(&vehicle, &at(speed)).unwrap();
            let slope = model.trim_slope(&vehicle.actuators);
            let difference = |of: fn(&Trim) -> f64| (of(&after) - of(&before)) / (2.0 * step);
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
            let expected = &model.b * (outputs(&after) - outputs(&before)) / (2.0 * step);
            let found = &model.b * slope.rows(4, vehicle.actuators.len());
            (0..4).for_each(|i| close(found[i], expected[i]));
        }
    }
}
