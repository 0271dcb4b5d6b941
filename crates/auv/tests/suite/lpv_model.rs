//! LPV model: agreement with the nonlinear equations, scheduling, files, rejected input.

use crate::common::{remus100, squid};
use squid_auv::{Fidelity, LpvModel, LpvModelError, Plant, Speed, Trim, Vehicle, linearise, trim};

const DEPTH: f64 = 50.0;

fn constant_lpv(vehicle: &Vehicle, speed: f64) -> (LpvModel, Trim) {
    let trim = trim(vehicle, Speed::Path(speed), DEPTH).unwrap();
    let linear = linearise(vehicle, &trim).unwrap();
    let model = LpvModel::new(
        &vehicle.name,
        DEPTH,
        (1.75, 1.25),
        &[linear.a],
        &[linear.b],
        std::slice::from_ref(&trim),
    )
    .unwrap();
    (model, trim)
}

#[test]
fn lpv_model_agrees_with_the_nonlinear_one_near_trim() {
    let vehicle = squid();
    let (model, trim) = constant_lpv(&vehicle, 1.0);
    let deviation = |fidelity: Fidelity, step: f64| {
        let mut plant = Plant::new(&vehicle).unwrap().with_lpv(model.clone()).unwrap();
        plant.set_fidelity(fidelity).unwrap();
        plant.start(0.0, &trim).unwrap();
        plant.set_command(0, trim.actuators[0] + step).unwrap();
        plant.advance(10.0).unwrap();
        plant.state().motion.theta - trim.pitch
    };
    let gap = |step: f64| (deviation(Fidelity::Nonlinear, step) - deviation(Fidelity::Lpv, step)).abs();
    assert!(deviation(Fidelity::Nonlinear, 0.01) > 1e-5, "the lower thruster lifts the bow");
    // The difference is of second order: a tenth of the step gives a hundredth of it (dB/dz leaves a small remainder).
    assert!(gap(0.1) < 0.02 * deviation(Fidelity::Lpv, 0.1), "{}", gap(0.1));
    assert!(gap(0.01) < 0.03 * gap(0.1), "{} {}", gap(0.01), gap(0.1));
    assert!((deviation(Fidelity::Lpv, 0.02) - 2.0 * deviation(Fidelity::Lpv, 0.01)).abs() < 1e-12);
}

#[test]
fn lpv_model_schedules_on_the_operating_speed() {
    let vehicle = squid();
    let trims: Vec<Trim> = [0.5, 1.75, 3.0].map(|v| trim(&vehicle, Speed::Path(v), DEPTH).unwrap()).to_vec();
    let linear: Vec<_> = trims.iter().map(|t| linearise(&vehicle, t).unwrap()).collect();
    // The parabola through three speeds: at each of them the model is the linearisation.
    let fit = |get: &dyn Fn(usize) -> nalgebra::DMatrix<f64>| {
        let (low, mid, high) = (get(0), get(1), get(2));
        [mid.clone(), (&high - &low) * 0.5, (&high + &low) * 0.5 - &mid]
    };
    let (a, b) = (fit(&|i| linear[i].a.clone()), fit(&|i| linear[i].b.clone()));
    let model = LpvModel::new("squid", DEPTH, (1.75, 1.25), &a, &b, &trims).unwrap();
    let read = LpvModel::from_json(&model.to_json().unwrap(), "model.json").unwrap();
    assert_eq!(read, model, "numbers read back to the same f64");
    for (i, t) in trims.iter().enumerate() {
        let fly = |model: LpvModel| {
            let mut plant = Plant::new(&vehicle).unwrap().with_lpv(model).unwrap();
            plant.set_fidelity(Fidelity::Lpv).unwrap();
            plant.start(0.0, t).unwrap();
            plant.set_command(0, t.actuators[0] + 2.0).unwrap();
            plant.advance(5.0).unwrap();
            plant.state()
        };
        let frozen = LpvModel::new(
            "squid",
            DEPTH,
            (1.75, 1.25),
            &[linear[i].a.clone()],
            &[linear[i].b.clone()],
            &trims[i..=i],
        );
        let (scheduled, frozen) = (fly(read.clone()), fly(frozen.unwrap()));
        assert!((scheduled.motion.theta - frozen.motion.theta).abs() < 1e-9);
        assert!((scheduled.motion.theta - t.pitch).abs() > 1e-3);
    }
    assert_eq!(model.rho(9.0), 1.0);
    assert_eq!(model.rho(0.0), -1.0);
}

#[test]
fn rejects_invalid_lpv_models() {
    let vehicle = squid();
    let (model, _) = constant_lpv(&vehicle, 1.0);
    let rejection = |change: &dyn Fn(&mut LpvModel)| {
        let mut broken = model.clone();
        change(&mut broken);
        Plant::new(&vehicle).unwrap().with_lpv(broken).expect_err("must be refused")
    };
    assert!(matches!(rejection(&|m| m.format = "auv-lpv-model/9".into()), LpvModelError::Format { .. }));
    assert!(matches!(rejection(&|m| m.a.clear()), LpvModelError::Empty { matrix: "a" }));
    assert!(matches!(rejection(&|m| m.trim.clear()), LpvModelError::Empty { matrix: "trim" }));
    assert!(matches!(rejection(&|m| m.b[0].truncate(3)), LpvModelError::Shape { matrix: "b", order: 0, .. }));
    assert!(matches!(rejection(&|m| m.a[0][2][1] = f64::NAN), LpvModelError::NotFinite { key: "a", .. }));
    assert!(matches!(rejection(&|m| m.speed_half_range = 0.0), LpvModelError::HalfRange { .. }));
    assert!(matches!(
        rejection(&|m| m.trim.push(m.trim[0].clone())),
        LpvModelError::SpeedsNotRising { row: 1, .. }
    ));
    let (other, _) = constant_lpv(&remus100(), 1.54);
    let error = Plant::new(&vehicle).unwrap().with_lpv(other).err().unwrap();
    assert!(matches!(error, LpvModelError::Actuators { found: 2, expected: 3, .. }));
    let text = model.to_json().unwrap().replace("\"depth\"", "\"dpth\"");
    let error = LpvModel::from_json(&text, "model.json").unwrap_err();
    assert!(
        matches!(&error, LpvModelError::NotJson { message, .. } if message.contains("`dpth`")),
        "{error}"
    );
}
