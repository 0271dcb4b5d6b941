//! Gains at a bounded rate against published and analytic ones.

use crate::common;

use nalgebra::dmatrix;
use serde_json::Value;
use squid_lpv::error::SynthesisError;
use squid_lpv::matrix::Mat;
use squid_lpv::rate::{RateBound, RateError, RateOptions, rate_bounded_gain, rate_bounded_stability};
use squid_lpv::state_space::StateSpace;

type Samples = Vec<(f64, StateSpace)>;

/// Returns `count` samples with theta evenly spaced over [-1, 1].
fn samples(count: usize, system: impl Fn(f64) -> StateSpace) -> Samples {
    let theta = |i: usize| -1.0 + 2.0 * i as f64 / (count - 1) as f64;
    (0..count).map(|i| (theta(i), system(theta(i)))).collect()
}

/// Returns `delta G - G delta` with G = 1/(s + 1): zero when delta is constant.
fn commutator(delta: f64) -> StateSpace {
    StateSpace {
        a: dmatrix![-1.0, 0.0; 0.0, -1.0],
        b: dmatrix![1.0; delta],
        c: dmatrix![delta, -1.0],
        d: dmatrix![0.0],
    }
}

/// Returns `x'' + 0.2 x' + (1 + k theta) x = w`, z = x.
fn oscillator(k: f64) -> impl Fn(f64) -> StateSpace {
    move |theta| StateSpace {
        a: dmatrix![0.0, 1.0; -1.0 - k * theta, -0.2],
        b: dmatrix![0.0; 1.0],
        c: dmatrix![1.0, 0.0],
        d: dmatrix![0.0],
    }
}

fn numbers(value: &Value) -> Vec<f64> {
    serde_json::from_value(value.clone()).unwrap()
}

/// Checks the inequality, written independently, at all samples: X(theta) > 0 and both signs of the rate.
fn assert_holds(samples: &Samples, bound: &RateBound) {
    for (theta, s) in samples {
        let (x, slope) = (bound.proof.lyapunov.value(*theta), bound.proof.lyapunov.slope(*theta));
        assert!(x.clone().cholesky().is_some(), "X({theta}) > 0");
        for rate in [bound.rate, -bound.rate] {
            let drift = if rate.is_finite() { &slope * rate } else { slope.clone() };
            let lyapunov = s.a.transpose() * &x + &x * &s.a + drift;
            let gamma = bound.gamma;
            let dd = Mat::identity(s.b.ncols(), s.b.ncols()) * gamma - s.d.transpose() * &s.d / gamma;
            let xb = &x * &s.b + s.c.transpose() * &s.d / gamma;
            let rest =
                lyapunov + s.c.transpose() * &s.c / gamma + &xb * dd.try_inverse().unwrap() * xb.transpose();
            assert!((-rest).cholesky().is_some(), "theta = {theta}, rate {rate}");
        }
    }
}

#[test]
fn the_gain_of_the_commutator_is_bounded_by_its_rate() {
    let case = common::case("lpv08_delta_commutator");
    let expected = &case["expected"];
    let rtol = expected["rate_rtol"].as_f64().unwrap();
    let system = samples(21, commutator);
    let options = RateOptions { order: 3, stride: 1, ..RateOptions::default() };
    let mut before = 0.0;
    for (rate, gamma) in numbers(&expected["rate"]).into_iter().zip(numbers(&expected["gamma_rate_poly3"])) {
        let found = rate_bounded_gain(&system, rate, options).unwrap();
        println!("rate {rate}: {:.6}, expected {gamma}, {:.1e}", found.gamma, found.proof.largest_eigenvalue);
        assert!((found.gamma / gamma - 1.0).abs() <= rtol, "rate {rate}: {} against {gamma}", found.gamma);
        assert!(found.gamma > before, "more rate, more gain");
        assert_holds(&system, &found);
        before = found.gamma;
    }
    let fast = rate_bounded_gain(&system, f64::INFINITY, options).unwrap();
    let gamma = expected["gamma_unbounded_rate"].as_f64().unwrap();
    println!("arbitrarily fast: {:.6}, expected {gamma}", fast.gamma);
    assert!((fast.gamma / gamma - 1.0).abs() <= expected["rtol"].as_f64().unwrap());
    assert!(fast.gamma > before);
    assert_holds(&system, &fast);
}

/// Returns the largest k up to `most` for which `exists` holds, by bisection to 1e-6.
fn largest(most: f64, exists: impl Fn(f64) -> bool) -> f64 {
    let (mut yes, mut no) = (0.0, most);
    while no - yes > 1e-6 {
        let middle = 0.5 * (yes + no);
        if exists(middle) { yes = middle } else { no = middle }
    }
    yes
}

#[test]
fn the_oscillator_is_quadratically_stable_up_to_the_closed_form() {
    let case = common::case("lpv10_oscillator_quadratic");
    let expected = &case["expected"];
    let rtol = expected["rtol"].as_f64().unwrap();
    let options = RateOptions { order: 4, stride: 1, ..RateOptions::default() };
    let stable = |points: usize, rate: f64| {
        move |k: f64| match rate_bounded_stability(&samples(points, oscillator(k)), rate, options) {
            Ok(proof) => proof.largest_eigenvalue < 0.0,
            Err(RateError::Inequality(SynthesisError::Infeasible { .. }) | RateError::Unstable { .. }) => {
                false
            }
            Err(other) => panic!("k = {k}: {other}"),
        }
    };
    let quadratic = largest(0.5, stable(2, f64::INFINITY));
    let known = expected["k_quadratic"].as_f64().unwrap();
    println!("k, constant X: {quadratic:.6}, expected {known:.6}");
    assert!((quadratic / known - 1.0).abs() <= rtol);
    let frozen = largest(2.0, stable(9, 0.0));
    println!("k, frozen: {frozen:.6}");
    assert!((frozen / expected["k_frozen"].as_f64().unwrap() - 1.0).abs() <= rtol);
    let slow = largest(2.0, stable(9, 1.0));
    println!("k, rate 1: {slow:.6}");
    assert!(quadratic < slow && slow < frozen);
}

#[test]
fn gains_rise_with_the_rate_from_frozen_to_arbitrarily_fast() {
    let system = samples(17, oscillator(0.15));
    let frozen = system.iter().map(|(_, s)| s.hinf_norm().value).fold(0.0, f64::max);
    let gain = |rate: f64| {
        rate_bounded_gain(&system, rate, RateOptions { order: 3, stride: 4, ..RateOptions::default() })
            .unwrap()
    };
    let mut before = frozen;
    for rate in [0.0, 0.01, 0.1, 1.0, 100.0, f64::INFINITY] {
        let found = gain(rate);
        println!("rate {rate}: {:.6} (frozen {frozen:.6}), imposed at {:?}", found.gamma, found.proof.grid);
        assert!(found.gamma >= before * (1.0 - 1e-3), "rate {rate}: {} after {before}", found.gamma);
        assert_holds(&system, &found);
        before = found.gamma;
    }
    let still = gain(0.0).gamma;
    assert!((still / frozen - 1.0).abs() < 0.02, "{still} against {frozen}");
}

/// A sharp resonance between the points at which the inequality is imposed first.
#[test]
fn a_peak_between_the_points_is_found() {
    let resonant = |theta: f64| {
        let damping = 0.1 + (theta - 0.25).powi(2);
        StateSpace {
            a: dmatrix![0.0, 1.0; -1.0, -2.0 * damping],
            b: dmatrix![0.0; 1.0],
            c: dmatrix![1.0, 0.0],
            d: dmatrix![0.1],
        }
    };
    let system = samples(33, resonant);
    let frozen = system.iter().map(|(_, s)| s.hinf_norm().value).fold(0.0, f64::max);
    let found =
        rate_bounded_gain(&system, 0.0, RateOptions { order: 2, stride: 32, ..RateOptions::default() })
            .unwrap();
    println!("{:.5}, frozen {frozen:.5}, imposed at {:?}", found.gamma, found.proof.grid);
    assert!(found.gamma > frozen);
    assert!(found.proof.grid.len() > 2);
    assert_holds(&system, &found);
}

#[test]
fn the_gain_does_not_depend_on_units() {
    let options = RateOptions { order: 2, stride: 1, ..RateOptions::default() };
    let plain = rate_bounded_gain(&samples(9, oscillator(0.15)), 0.1, options).unwrap().gamma;
    // States are 1e4 and 1e-3 times as large, time is in ms, the gain in millionths, theta from 4 to 10.
    let (t, ti) = (dmatrix![1e4, 0.0; 0.0, 1e-3], dmatrix![1e-4, 0.0; 0.0, 1e3]);
    let odd: Samples = samples(9, oscillator(0.15))
        .into_iter()
        .map(|(theta, s)| {
            let a = &ti * s.a * &t * 1e-3;
            let (b, c) = (&ti * s.b * 1e-3, s.c * &t * 1e-6);
            (7.0 + 3.0 * theta, StateSpace { a, b, c, d: s.d * 1e-6 })
        })
        .collect();
    let found = rate_bounded_gain(&odd, 0.3e-3, options).unwrap().gamma;
    println!("{plain:.7}, {:.7}", found * 1e6);
    assert!((found * 1e6 / plain - 1.0).abs() < 1e-4);
}

#[test]
fn invalid_input_is_rejected() {
    let gain =
        |samples: &Samples, rate| rate_bounded_gain(samples, rate, RateOptions::default()).unwrap_err();
    assert_eq!(gain(&vec![], 1.0), RateError::NoSamples);
    let mut system = samples(3, commutator);
    assert_eq!(gain(&system, -1.0), RateError::NegativeRate { rate: -1.0 });
    assert!(matches!(gain(&system, f64::NAN), RateError::NegativeRate { .. }));
    system[2].1.b = Mat::zeros(2, 2);
    assert!(matches!(gain(&system, 1.0), RateError::Shape { theta: 1.0, .. }));
    system[2] = (1.0, StateSpace { a: Mat::identity(2, 2), ..commutator(1.0) });
    assert_eq!(gain(&system, 1.0), RateError::Unstable { theta: 1.0, re: 1.0 });
    system.swap(0, 1);
    assert_eq!(gain(&system, 1.0), RateError::NotAscending { theta: -1.0 });
}

/// No constant Lyapunov function exists above the k of the closed form, and the error reports that.
#[test]
fn infeasibility_is_not_reported_as_a_numerical_failure() {
    for k in [0.21, 0.25, 0.3, 0.4, 0.5, 0.7] {
        for count in [2, 3, 5] {
            let found =
                rate_bounded_gain(&samples(count, oscillator(k)), f64::INFINITY, RateOptions::default());
            assert!(
                matches!(found, Err(RateError::Inequality(SynthesisError::Infeasible { .. }))),
                "k = {k}, {count} samples: {found:?}"
            );
        }
    }
}
