//! Ball around the fit, and fit of the slope of the trim.

use crate::designs::{Made, committed, inputs, made};
use squid_certificate::ModelError;
use squid_design::augment::{LinearModel, augment};
use squid_design::axis::VehicleModel;
use squid_design::certify::certify;
use squid_design::certify::fit_residual::fit_residual;
use squid_design::check::frozen_controller;
use squid_design::fit::Model;
use squid_design::linearise::TRIM_ROWS;
use squid_lpv::matrix::{Mat, block, eigenvalues, from_rows, largest_singular_value, pseudo_inverse};
use squid_lpv::partition::Group::{U, W, X};
use squid_lpv::plant::GeneralisedPlant;
use squid_lpv::polynomial::MatrixPolynomial;
use squid_proof::claim::parse;
use squid_proof::error::ProofError;
use squid_proof::same_plant::NEAREST_POLE;

/// Matrix `[A B1 B2]` at rho.
fn matrices_at(plant: &GeneralisedPlant, rho: f64) -> Mat {
    let parts = plant.frozen(&[rho]).unwrap().parts;
    block(&[&[&parts.block(X, X), &parts.block(X, W), &parts.block(X, U)]])
}

/// The plant of the true linearisation and trim, with waves if the design has them, is in the ball at speeds between
/// its samples, and the gain of its loop is below the bound for the ball.
#[test]
fn ball_contains_plants_of_vehicle() {
    let at_sea = Made::at_sea("remus100");
    for (name, made) in
        [("squid", made("squid")), ("remus100", made("remus100")), ("remus100 at sea", &at_sea)]
    {
        let Made { inputs, plant, design, .. } = made;
        let certificate = made.proof().certificate;
        let (ball, bound) = (certificate.model_error().unwrap(), certificate.robust_gain().unwrap().gamma);
        let (n, w, u) = (ball.f[0].len(), ball.fw[0].len(), ball.fu[0].len());
        let e = from_rows(&ball.e, ball.e[0].len()).unwrap();
        let input_map =
            [(&ball.f, n), (&ball.fw, w), (&ball.fu, u)].map(|(rows, size)| from_rows(rows, size).unwrap());
        let input_map = block(&[&[&input_map[0], &input_map[1], &input_map[2]]]);
        let (left, right) = (pseudo_inverse(&e, 1e-13), pseudo_inverse(&input_map, 1e-13));
        let mut farthest: f64 = 0.0;
        for speed in inputs.design.spread(38) {
            let actuators = &inputs.vehicle.actuators;
            let truth = LinearModel::at(&inputs.axis().linearise(speed).unwrap(), &inputs.design);
            let truth = augment(actuators, &inputs.design, truth).unwrap();
            let rho = inputs.design.rho(speed);
            let residual = matrices_at(&truth, rho) - matrices_at(plant, rho);
            let delta = &left * &residual * &right;
            assert!(
                (&e * &delta * &input_map - &residual).amax() < 1e-9 * residual.amax(),
                "{name} at {speed} m/s"
            );
            farthest = farthest.max(largest_singular_value(&delta));
            let controller = frozen_controller(&design.controller, rho).unwrap();
            let gain = truth.close(&controller).frozen(&[]).unwrap().hinf_norm().value;
            assert!(gain < bound, "{name} at {speed} m/s: {gain}");
        }
        assert!((0.8..1.0).contains(&farthest), "{name}: {farthest}");
    }
}

/// The vehicle is not in a ball without the part for the slope, or in one that is slightly too small.
#[test]
fn rejects_ball_without_slope() {
    let (inputs, stored) = committed();
    let (vehicle, file) = (&inputs.axis(), &inputs.design);
    let model = Model::new(vehicle, file).unwrap();
    let certificate = parse(&stored.certificate.unwrap(), "certificate.json").unwrap();
    let (ball, held) = (certificate.model_error().unwrap().clone(), certificate.limits().unwrap().delta_rows);
    assert_eq!(held, Some(file.states.len()));
    let residual = fit_residual(vehicle, file, &model).unwrap();
    residual.check(&ball, held).unwrap();
    assert!(residual.check(&ball, Some(2)).is_err(), "[A B] has more rows than two");
    let reach = |ball: &ModelError| {
        let error = residual.check(ball, held).unwrap_err();
        let ProofError::Ball { reach } = error else { panic!("{error}") };
        reach
    };
    let mut smaller = ball.clone();
    smaller
        .fw
        .iter_mut()
        .chain(&mut smaller.f)
        .chain(&mut smaller.fu)
        .flatten()
        .for_each(|entry| *entry *= 0.99);
    assert!((reach(&smaller).unwrap() - 1.0 / 0.99).abs() < 1e-4, "{:?}", reach(&smaller));
    let without = ModelError { fw: vec![], ..ball.clone() };
    assert_eq!(reach(&without), None);
    let mut blind = ball.clone();
    blind.fw.iter_mut().flatten().for_each(|entry| *entry = 0.0);
    assert_eq!(reach(&blind), None);
    let mut flat = ball;
    flat.e.iter_mut().skip(file.states.len()).flatten().for_each(|entry| *entry = 0.0);
    assert_eq!(reach(&flat), None);
    insta::assert_snapshot!(format!(
        "{}\n\n{}",
        ProofError::Ball { reach: None },
        ProofError::Ball { reach: Some(1.0101) }
    ));
}

/// Fits over other ranges and orders, down to rest, have no pole near the range, at most as many channels as the order,
/// and no larger error in the slopes than the polynomial.
#[test]
fn slope_fit_has_no_pole_near_range() {
    let mut rational = 0;
    for (name, from, to) in
        [("squid", 0.5, 3.0), ("squid", 0.2, 3.0), ("sparus2", 0.1, 0.38), ("bluerov2_heavy", 0.0, 0.5)]
    {
        for order in 1..=4 {
            let mut inputs = inputs(name);
            (inputs.design.speed_min, inputs.design.speed_max, inputs.design.order) = (from, to, order);
            let (vehicle, design) = (&inputs.vehicle, &inputs.design);
            let model = Model::new(&inputs.axis(), design).unwrap();
            assert!(model.trim_slope.size() <= order, "{name}, order {order}");
            let poles = eigenvalues(&model.trim_slope.inner).iter().map(|v| v.norm()).fold(0.0, f64::max);
            assert!(poles * NEAREST_POLE <= 1.0, "{name}, order {order}: {poles}");
            let samples = |count: usize| -> Vec<(f64, Mat)> {
                let at = |v| inputs.axis().linearise(v).unwrap().trim_slope;
                design.spread(count).into_iter().map(|v| (design.rho(v), at(v))).collect()
            };
            let polynomial = MatrixPolynomial::fit(&samples(design.speeds), order).unwrap();
            let reach =
                |i: usize| i.checked_sub(design.states.len()).map_or(1.0, |j| vehicle.actuators[j].reach());
            let error = |of: &dyn Fn(f64) -> Mat| {
                let far = |(rho, m): &(f64, Mat)| {
                    let error = of(*rho) - m;
                    error.iter().enumerate().map(|(i, v)| (v / reach(i)).powi(2)).sum::<f64>().sqrt()
                };
                samples(TRIM_ROWS).iter().map(far).fold(0.0, f64::max)
            };
            let found = error(&|rho| model.trim_slope.evaluate(&[rho]).unwrap());
            let before = error(&|rho| polynomial.evaluate(rho));
            // Truncation of the LFT may increase its error.
            assert!(
                found <= 1.1 * before + 1e-9,
                "{name} from {from} m/s, order {order}: {found} against {before}"
            );
            rational += usize::from(found < 0.2 * before);
        }
    }
    assert!(rational >= 4, "poles help at speeds above rest: {rational}");
}

/// The fit is in the ball, so that the bound for the fit is at most that for the ball: also where the search finds the
/// smaller bound for the ball, as it does here from a design with a larger bound for the fit.
#[test]
fn bound_for_the_fit_is_at_most_that_for_the_ball() {
    let Made { inputs, model, plant, design } = made("squid");
    for factor in [1.0, 1.2] {
        let mut design = design.clone();
        design.certified.gamma *= factor;
        let (proof, bound) = certify(&inputs.axis(), &inputs.design, model, plant, &design).unwrap();
        let theorem = proof.theorem;
        let (fit, ball) = (theorem.gamma.unwrap(), theorem.gamma_with_model_error.unwrap());
        assert!(fit <= ball && fit <= design.certified.gamma, "{factor}: {fit} and {ball}");
        assert_eq!(fit < design.certified.gamma, factor > 1.0, "{factor}: {fit}");
        assert_eq!(fit.to_bits(), bound.gamma.to_bits(), "{factor}");
        assert!(bound.largest_eigenvalue < 0.0, "{factor}: {fit}");
    }
}
