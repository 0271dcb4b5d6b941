//! Synthesis and proof multipliers for a parameter with a bounded rate.

use crate::common;

use nalgebra::dmatrix;
use serde_json::Value;
use squid_lpv::bounded_rate::{Claim, SlowBound, SlowOptions, finished, intervals, least_gamma, synthesise};
use squid_lpv::error::RateError;
use squid_lpv::matrix::{Mat, from_rows, symmetric_eigenvalues};
use squid_lpv::model_error::LoopError;
use squid_lpv::partition::{Group, PLANT, names};
use squid_lpv::plant::{ClosedLoop, GeneralisedPlant};
use squid_lpv::rate::{RateOptions, rate_bounded_gain, rate_bounded_stability};
use squid_lpv::synthesis::{Options, synthesise as synthesise_fast};

/// Returns `x'' + 0.2 x' + (1 + k theta) x = w`, z = x, as a loop without control: wt = theta x.
fn oscillator(k: f64) -> ClosedLoop {
    use Group::{T, W, X, Z};
    let blocks = [
        (X, X, dmatrix![0.0, 1.0; -1.0, -0.2]),
        (X, T, dmatrix![0.0; -k]),
        (X, W, dmatrix![0.0; 1.0]),
        (T, X, dmatrix![1.0, 0.0]),
        (Z, X, dmatrix![1.0, 0.0]),
    ];
    GeneralisedPlant::new(vec![1], &blocks).unwrap().open()
}

/// Checks the inequality of the loop, at many values of theta and both signs of the rate, written independently:
/// without N and intervals.
fn assert_holds(closed: &ClosedLoop, bound: &SlowBound) {
    for i in 0..=64 {
        let theta = f64::from(i) / 32.0 - 1.0;
        let sum = |weight: &dyn Fn(i32) -> f64| {
            let n = bound.lyapunov[0].nrows();
            let terms = bound.lyapunov.iter().zip(0..);
            terms.fold(Mat::zeros(n, n), |sum, (x, k)| sum + x * weight(k))
        };
        let given = sum(&|k| theta.powi(k));
        let slope = sum(&|k| if k == 0 { 0.0 } else { f64::from(k) * theta.powi(k - 1) });
        assert!(symmetric_eigenvalues(&given)[0] > 0.0, "X({theta}) > 0");
        let (x, slope) = if bound.inverse {
            let inverse = given.try_inverse().unwrap();
            let slope = -&inverse * slope * &inverse;
            (inverse, slope)
        } else {
            (given, slope)
        };
        let s = closed.frozen(&[theta]).unwrap();
        for rate in [bound.rate, -bound.rate] {
            let gamma = bound.gamma;
            let dd = Mat::identity(s.b.ncols(), s.b.ncols()) * gamma - s.d.transpose() * &s.d / gamma;
            let xb = &x * &s.b + s.c.transpose() * &s.d / gamma;
            let whole = s.a.transpose() * &x
                + &x * &s.a
                + &slope * rate
                + s.c.transpose() * &s.c / gamma
                + &xb * dd.try_inverse().unwrap() * xb.transpose();
            assert!((-whole).cholesky().is_some(), "theta = {theta}, rate {rate}");
        }
    }
}

/// Published: stable for every trajectory up to k = 0.199 (circle criterion), frozen up to 1. Between them stability
/// depends on the rate, and a result at samples also holds between them.
#[test]
fn an_oscillator_beyond_the_circle_criterion_is_bounded_at_a_bounded_rate() {
    let case = common::case("lpv10_oscillator_quadratic");
    let quadratic = case["expected"]["k_quadratic"].as_f64().unwrap();
    let k = 1.5 * quadratic;
    let closed = oscillator(k);
    let samples: Vec<_> = (0..=16)
        .map(|i| f64::from(i) / 8.0 - 1.0)
        .map(|theta| (theta, closed.frozen(&[theta]).unwrap()))
        .collect();
    let options = RateOptions { order: 2, stride: 1, accuracy: 1e-2 };
    assert!(rate_bounded_stability(&samples, f64::INFINITY, options).is_err());
    let rate = 0.05;
    let found = rate_bounded_gain(&samples, rate, options).unwrap();
    let (error, lyapunov) = (&LoopError::none(&closed), &found.proof.lyapunov.coefficients);
    let claim =
        |gamma: f64| Claim { closed: &closed, error, inverse: false, lyapunov, rate, gamma, lambda: 0.0 };
    let bound = intervals(claim(1.02 * found.gamma)).unwrap();
    println!("k = {k:.4}: gain {:.3} in {} intervals", bound.gamma, bound.multipliers.len());
    assert_holds(&closed, &bound);
    // No gain below that of a frozen loop is proved.
    let frozen = samples.iter().map(|(_, s)| s.hinf_norm().value).fold(0.0, f64::max);
    assert!(frozen < bound.gamma);
    assert_eq!(intervals(claim(0.99 * frozen)), None);
}

/// The oscillator of Shamma and Athans, for which no constant Lyapunov matrix exists: the bound is near the published
/// ones, holds between all values, is at least the gain of a frozen loop, and grows with the rate.
#[test]
fn a_given_loop_has_the_published_gains_at_every_rate() {
    let case = common::case("lpv11_shamma_athans");
    let list = |key: &str| -> Vec<f64> { serde_json::from_value(case["expected"][key].clone()).unwrap() };
    let closed = oscillator(0.5);
    let frozen = (0..=64).map(|i| closed.frozen(&[f64::from(i) / 32.0 - 1.0]).unwrap().hinf_norm().value);
    let mut before = frozen.fold(0.0, f64::max);
    for (rate, gamma) in list("rate").into_iter().zip(list("gamma")) {
        let bound = finished(&closed, rate).unwrap();
        println!("rate {rate}: {:.4}, order {}", bound.gamma, bound.lyapunov.len() - 1);
        assert!(before < bound.gamma && bound.gamma < 1.02 * gamma, "{rate}: {}", bound.gamma);
        assert_holds(&closed, &bound);
        before = bound.gamma;
    }
    assert!(finished(&closed, 50.0).is_err());
    assert!(matches!(finished(&oscillator(1.5), 0.01), Err(RateError::Unstable { .. })));
}

fn plant_of(certificate: &str) -> GeneralisedPlant {
    let path = format!("{}/../../tests/certificates/{certificate}.json", env!("CARGO_MANIFEST_DIR"));
    let file: Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    let parts: Vec<_> = names(PLANT)
        .filter_map(|(key, row, column)| {
            let list: Vec<Vec<f64>> = serde_json::from_value(file["plant"].get(key)?.clone()).unwrap();
            Some((row, column, from_rows(&list, list.first()?.len())?))
        })
        .collect();
    GeneralisedPlant::new(serde_json::from_value(file["blocks"].clone()).unwrap(), &parts).unwrap()
}

/// REMUS 100 with its errors only, whose gamma for every trajectory is far above that at a frozen speed.
#[test]
fn a_bounded_rate_reduces_gamma_towards_that_at_frozen_speeds() {
    let plant = plant_of("remus100_bounded_rate");
    let fast = synthesise_fast(&plant, Options::default()).unwrap();
    let frozen = [-1.0, 0.0, 1.0].map(|theta| {
        let alone = plant.frozen(&[theta]).unwrap();
        synthesise_fast(&alone, Options::default()).unwrap().gamma_optimum
    });
    let hardest = frozen.into_iter().fold(0.0, f64::max);
    let least = |rate: f64| least_gamma(&plant, SlowOptions::at(rate)).unwrap().gamma;
    let rates = [0.125, 0.3125, 1.25].map(least);
    println!("frozen {hardest:.4}, at rates {rates:.4?}, any {:.4}", fast.gamma_optimum);
    let mut before = hardest;
    for gamma in rates.into_iter().chain([fast.gamma_optimum]) {
        assert!(gamma > before * (1.0 - 5e-3), "{gamma} after {before}");
        before = gamma;
    }
    // Values of a prototype in cvxpy, on a finer grid and with Lyapunov matrices of a higher order.
    for (found, known) in rates.into_iter().zip([0.939, 0.961, 1.082]) {
        assert!((found / known - 1.0).abs() < 1e-2, "{found}, {known} in the prototype");
    }

    let design = synthesise(&plant, SlowOptions::at(0.125)).unwrap();
    let closed = plant.close(&design.controller);
    println!(
        "{:?} proved {:.4} in {} intervals",
        design.least,
        design.bound.gamma,
        design.bound.multipliers.len()
    );
    assert_holds(&closed, &design.bound);
    assert!(design.bound.gamma < 0.75 * fast.certified.gamma);
    assert!(design.fast.is_some_and(|fast| fast.gamma > design.bound.gamma && fast.largest_eigenvalue < 0.0));
}

#[test]
fn plants_without_exactly_one_parameter_are_rejected() {
    let plant = common::plant(&common::case("lpv05_one_param_lossless"));
    let two = GeneralisedPlant { blocks: vec![1, 1], ..plant };
    let error = synthesise(&two, SlowOptions::at(1.0)).unwrap_err();
    assert!(error.to_string().contains("2 parameters"), "{error}");
}
