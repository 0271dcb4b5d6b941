//! Claim of a bounded rate, on loops whose gain is known.

use crate::common::{Refused, add, add_model_error, claim, golden_text, is_at, prove, scheduled};
use crate::independent::Loop;
use crate::rate_alone::ALONE;
use nalgebra::DMatrix;
use proptest::prelude::*;
use proptest::test_runner::{Config, TestRunner};
use serde_json::{Value, json};
use squid_certificate::{Certificate, Rate, RateTheorem};
use std::cell::Cell;

/// Returns the certificate of `x' = (-3 + 1.5 theta) x + w`, see [`scheduled`], with X = 1 and one interval. With
/// `N = [-1 -m/2 0 0; -1/2 0 -m/2 0]`, columns x, wt, wk, w, the form at theta is, after Schur complements,
/// `-6 + 3 theta + 2/gamma + theta^2 m/2`.
pub fn one_interval(gamma: f64, m: f64) -> Value {
    let mut c = scheduled(0.75);
    let n = json!([[[-1.0, -m / 2.0, 0.0, 0.0], [-0.5, 0.0, -m / 2.0, 0.0]]]);
    add(
        &mut c,
        "rate",
        json!({
            "rate": 3.0, "gamma": gamma, "inverse": false, "X": [[[1.0]]], "breakpoints": [-1.0, 1.0], "N": n
        }),
    );
    c
}

#[test]
fn constant_lyapunov_matrix_by_hand() {
    let theorem = prove(&one_interval(0.75, 0.5)).unwrap();
    let slow = RateTheorem { rate: 3.0, gamma: 0.75, gamma_with_model_error: None };
    assert_eq!(theorem.bounded_rate, Some(slow));
    let mut refused = Refused::default();
    for (gamma, m) in [(0.75, 1.0), (0.66, 1e-9), (0.75, -0.5)] {
        refused.at("Rate Bernstein", &one_interval(gamma, m));
    }
    refused.at("Rate gamma", &one_interval(-0.75, 0.5));
    insta::assert_snapshot!(format!("{}{theorem}", refused.0));
}

/// Returns the certificate of the commutator `theta G - G theta` with `G = 1/(s + 1)`, whose gain is the rate:
/// `x1' = -x1 + w, x2' = -x2 + theta w, z = theta x1 - x2`. The output e = z satisfies `e' = -e + theta' x1`, so that
/// `V = e^2/gamma + gamma x1^2` proves every gamma above the rate.
///
/// The channels are those of w and of x1, `xi = (x1, x2, wt1, wt2, w)`. On an interval with the midpoint m, N follows
/// from V: it cancels the cross terms of `v = wt - m zt` with the other variables, and leaves `-weight v'v`.
pub fn commutator(rate: f64, gamma: f64, intervals: usize, weight: f64) -> Value {
    let (a, b) = (1.0 / gamma, gamma);
    let breakpoints: Vec<f64> = (0..=intervals).map(|i| 2.0 * i as f64 / intervals as f64 - 1.0).collect();
    let multiplier = |m: f64| {
        // In terms of x1, x2, v1, v2, w: x2' depends on v1, z depends on v2, and V' = 2 (a e (m x1' - x2') + b x1 x1')
        // with e = m x1 - x2. v1 is multiplied by -2 a e; v2, from z^2/gamma = (e + v2)^2/gamma, by 2 e/gamma +
        // v2/gamma. N (in x1, x2, v, w) is minus half of that; then v1 = wt1 - m w and v2 = wt2 - m x1 are substituted.
        let (first, second) = ([a * m, -a], [-m / gamma, 1.0 / gamma]);
        let (own1, own2) = (-weight / 2.0, -(weight + 1.0 / gamma) / 2.0);
        json!([[first[0], first[1], own1, 0.0, -m * own1], [second[0] - m * own2, second[1], 0.0, own2, 0.0]])
    };
    let n: Vec<Value> = breakpoints.windows(2).map(|ends| multiplier((ends[0] + ends[1]) / 2.0)).collect();
    json!({
        "format": "lpv-certificate/1", "blocks": [2], "controller_blocks": [],
        "plant": {
            "A": [[-1.0, 0.0], [0.0, -1.0]], "Bt": [[0.0, 0.0], [1.0, 0.0]], "B1": [[1.0], [0.0]],
            "B2": [[0.0], [0.0]], "Ct": [[0.0, 0.0], [1.0, 0.0]], "C1": [[0.0, -1.0]], "C2": [[0.0, 0.0]],
            "Dtt": [[0.0, 0.0], [0.0, 0.0]], "Dt1": [[1.0], [0.0]], "Dt2": [[0.0], [0.0]], "D1t": [[0.0, 1.0]],
            "D11": [[0.0]], "D12": [[0.0]], "D2t": [[0.0, 0.0]], "D21": [[0.0]]
        },
        "controller": {
            "A": [], "By": [], "Bt": [], "Cu": [[]], "Duy": [[0.0]], "Dut": [[]], "Ct": [], "Dty": [], "Dtt": []
        },
        // This gain follows from magnitudes alone: |z| <= |x1| + |x2|.
        "claims": [
            {"gain": {
                "gamma": 8.0, "X": [[1.0, 0.0], [0.0, 1.0]], "S": [[1.0, 0.0], [0.0, 1.0]],
                "T": [[0.0, 0.0], [0.0, 0.0]]
            }},
            {"rate": {
                "rate": rate, "gamma": gamma, "inverse": false,
                "X": [[[b, 0.0], [0.0, a]], [[0.0, -a], [-a, 0.0]], [[a, 0.0], [0.0, 0.0]]],
                "breakpoints": breakpoints, "N": n
            }}
        ]
    })
}

#[test]
fn second_order_lyapunov_matrix_proves_commutator_gain() {
    for rate in [0.25, 1.0, 4.0] {
        let proved = prove(&commutator(rate, 1.1 * rate, 64, 0.1 / rate));
        assert!(proved.is_ok(), "{rate}: {proved:?}");
        assert!(prove(&commutator(rate, 0.99 * rate, 64, 0.1 / rate)).is_err());
        // The same matrices do not prove it for a higher rate.
        let mut faster = commutator(rate, 1.1 * rate, 64, 0.1 / rate);
        claim(&mut faster, "rate")["rate"] = json!(1.2 * rate);
        assert!(prove(&faster).is_err());
    }
}

/// Proves the same gain for the transposed loop of a claim, with the Lyapunov matrix as the inverse of another.
#[test]
fn inverse_lyapunov_matrix_belongs_to_transposed_loop() {
    let transposed = |m: &Value| {
        let rows: Vec<Vec<f64>> = serde_json::from_value(m.clone()).unwrap();
        json!((0..rows[0].len()).map(|j| rows.iter().map(|row| row[j]).collect()).collect::<Vec<Vec<f64>>>())
    };
    for rate in [0.25, 4.0] {
        let given = commutator(rate, 1.1 * rate, 64, 0.1 / rate);
        let mut other = given.clone();
        let pairs = [
            ("A", "A"),
            ("Bt", "Ct"),
            ("Ct", "Bt"),
            ("B1", "C1"),
            ("C1", "B1"),
            ("Dtt", "Dtt"),
            ("Dt1", "D1t"),
            ("D1t", "Dt1"),
        ];
        for (to, from) in pairs {
            other["plant"][to] = transposed(&given["plant"][from]);
        }
        assert!(is_at(&prove(&other).unwrap_err(), "Rate Bernstein"));
        claim(&mut other, "rate")["inverse"] = json!(true);
        assert!(prove(&other).is_ok(), "{:?}", prove(&other));
        claim(&mut other, "rate")["gamma"] = json!(0.99 * rate);
        assert!(prove(&other).is_err());
    }
}

#[test]
fn names_fields_that_do_not_fit() {
    let mut refused = Refused::default();
    let mut at = |key: &str, value: Value, place: &str| {
        let mut c = one_interval(0.75, 0.5);
        claim(&mut c, "rate")[key] = value;
        refused.at(place, &c);
    };
    at("inverse", json!(1), "claims[1].rate.inverse");
    at("rate", json!(-1.0), "Rate rate");
    at("X", json!([]), "claims[1].rate.X");
    at("X", json!([[[-1.0]]]), "Rate X[0]");
    at("X", json!([[[1.0]], [[1.0, 0.0]]]), "claims[1].rate.X[1]");
    for wrong in [
        json!([-1.0, 0.5]),
        json!([-1.0, 1.0, 1.0]),
        json!([1.0, -1.0]),
        json!([]),
        json!([-1.0, 0.9, 0.8, 1.0]),
    ] {
        at("breakpoints", wrong, "claims[1].rate.breakpoints");
    }
    at("breakpoints", json!([-1.0, 0.0, 1.0]), "claims[1].rate.N");
    at("N", json!([[[0.0, 0.0, 0.0, 0.0]]]), "claims[1].rate.N[0]");
    let mut skewed = commutator(1.0, 1.1, 64, 0.1);
    claim(&mut skewed, "rate")["X"][1][0][1] = json!(0.5);
    refused.at("Rate X[1]", &skewed);
    let mut alone = one_interval(0.75, 0.5);
    let mut with_error = claim(&mut alone, "rate").clone();
    with_error["lambda"] = json!(1.0);
    add(&mut alone, "rate", with_error.clone());
    refused.at("claims[2].rate", &alone);
    // The claims with and without model error must have the same rate.
    let mut other = one_interval(0.75, 0.5);
    add_model_error(
        &mut other,
        json!({
            "E": [[0.01]], "F": [[1.0]], "Fu": [[0.0]], "lambda": 0.01, "gamma": 0.8, "X": [[1.0]],
            "S": [[1.0, 0.0], [0.0, 0.5]], "T": [[0.0, 0.0], [0.0, 0.0]]
        }),
    );
    with_error["rate"] = json!(0.5);
    add(&mut other, "rate", with_error);
    refused.at("claims[3].rate.rate", &other);
    let mut two = one_interval(0.75, 0.5);
    two["blocks"] = json!([1, 0]);
    two["controller_blocks"] = json!([0, 1]);
    refused.at("claims[1].rate", &two);
    insta::assert_snapshot!(refused.0);
}

/// Certificate of a controller designed for a bounded rate.
const GOLDEN: &str = "remus100_bounded_rate";

/// Returns the largest eigenvalue, scaled to a unit diagonal, of the inequality of the frozen loops in floating point,
/// at 65 values of theta and both signs of the rate; neither the multipliers nor the intervals are used.
fn largest_eigenvalue(c: &Certificate) -> f64 {
    let bounded = c.rate().unwrap();
    let Rate { gamma, inverse, x, .. } = bounded;
    let closed = Loop::new(c);
    let n = x[0].len();
    let matrix = |rows: &squid_certificate::Rows| DMatrix::from_fn(n, n, |i, j| rows[i][j]);
    let mut worst = f64::NEG_INFINITY;
    for step in 0..=64 {
        let theta = f64::from(step) / 32.0 - 1.0;
        let sum = |weight: &dyn Fn(i32) -> f64| {
            x.iter().zip(0..).fold(DMatrix::zeros(n, n), |sum, (x, k)| sum + matrix(x) * weight(k))
        };
        let (lyapunov, slope) =
            (sum(&|k| theta.powi(k)), sum(&|k| if k == 0 { 0.0 } else { f64::from(k) * theta.powi(k - 1) }));
        let Some((_, system)) = closed.frozen(&[theta], None) else { return f64::INFINITY };
        let system = if *inverse { system.transpose() } else { system };
        let part = |i, j, rows, cols| system.view((i, j), (rows, cols)).into_owned();
        let (w, z) = (system.ncols() - n, system.nrows() - n);
        let (a, b, of_c, d) = (part(0, 0, n, n), part(0, n, n, w), part(n, 0, z, n), part(n, n, z, w));
        for rate in [bounded.rate, -bounded.rate] {
            let mut whole = DMatrix::zeros(n + w + z, n + w + z);
            let lyapunov_part = a.transpose() * &lyapunov + &lyapunov * &a + &slope * rate;
            whole.view_mut((0, 0), (n, n)).copy_from(&lyapunov_part);
            whole.view_mut((0, n), (n, w)).copy_from(&(&lyapunov * &b));
            whole.view_mut((0, n + w), (n, z)).copy_from(&of_c.transpose());
            whole.view_mut((n, n + w), (w, z)).copy_from(&d.transpose());
            whole.view_mut((n, n), (w + z, w + z)).fill_diagonal(-gamma);
            whole.fill_lower_triangle_with_upper_triangle();
            worst = worst.max(scaled(&whole)).max(scaled(&-&lyapunov));
        }
    }
    worst
}

fn scaled(m: &DMatrix<f64>) -> f64 {
    if m.diagonal().iter().any(|d| *d >= 0.0 || d.is_nan()) {
        return f64::INFINITY;
    }
    let scale = DMatrix::from_diagonal(&m.diagonal().map(|d| 1.0 / (-d).sqrt()));
    (&scale * m * &scale).symmetric_eigenvalues().max()
}

/// Largest wrong-signed eigenvalue in floating point that rounding explains.
const ROUNDING: f64 = 1e-9;

#[test]
fn golden_certificate_is_proved_and_holds_in_floating_point() {
    let golden = Certificate::from_json(&golden_text(GOLDEN)).unwrap();
    let theorem = golden.prove().unwrap();
    let slow = theorem.bounded_rate.unwrap();
    assert!(slow.gamma < theorem.gamma.unwrap() && slow.gamma_with_model_error.unwrap() > slow.gamma);
    assert!(largest_eigenvalue(&golden) < 0.0);
    assert_eq!(Certificate::from_json(&golden.to_json().unwrap()).unwrap(), golden);
}

#[test]
fn golden_certificate_of_rate_alone_holds_in_floating_point() {
    assert!(largest_eigenvalue(&Certificate::from_json(&golden_text(ALONE)).unwrap()) < 0.0);
}

#[test]
#[ignore = "night: alters every number of a certificate"]
fn tampering_is_rejected_or_harmless() {
    survives(GOLDEN, "controller", 60);
    survives(ALONE, "plant", 600);
}

/// Changes one number of the section, or of another part: claims that are still proved must hold in floating point.
fn survives(name: &str, part: &str, cases: u32) {
    let file: Value = serde_json::from_str(&golden_text(name)).unwrap();
    let mut pointers = vec![];
    let at = file["claims"].as_array().unwrap().iter().position(|claim| claim.get("rate").is_some()).unwrap();
    for key in ["rate", "gamma", "X", "N", "breakpoints"] {
        leaves(&file["claims"][at]["rate"][key], &format!("/claims/{at}/rate/{key}"), &mut pointers);
    }
    leaves(&file[part], &format!("/{part}"), &mut pointers);
    let change = prop_oneof![Just(-1.0), Just(0.0), Just(10.0), Just(0.1), Just(1.01), Just(1.0 + 1e-9)];
    let (accepted, refused) = (Cell::new(0), Cell::new(0));
    let mut runner = TestRunner::new(Config { cases, failure_persistence: None, ..Config::default() });
    let outcome = runner.run(&(prop::sample::select(pointers), change), |(pointer, factor)| {
        let mut lie = file.clone();
        let old = lie.pointer(&pointer).unwrap().as_f64().unwrap();
        prop_assume!(old != 0.0);
        *lie.pointer_mut(&pointer).unwrap() = json!(old * factor);
        let Ok(c) = Certificate::from_json(&lie.to_string()) else {
            prop_assert!(pointer.contains("breakpoints"), "{pointer}");
            refused.set(refused.get() + 1);
            return Ok(());
        };
        match c.prove() {
            Ok(_) => {
                accepted.set(accepted.get() + 1);
                prop_assert!(largest_eigenvalue(&c) < ROUNDING, "{pointer} times {factor} is accepted");
            }
            Err(_) => refused.set(refused.get() + 1),
        }
        Ok(())
    });
    println!("{} accepted, {} refused", accepted.get(), refused.get());
    outcome.unwrap();
    assert!(accepted.get() > 0 && refused.get() > 0);
}

fn leaves(value: &Value, at: &str, found: &mut Vec<String>) {
    match value {
        Value::Number(_) => found.push(at.to_string()),
        Value::Array(items) => {
            items.iter().enumerate().for_each(|(i, v)| leaves(v, &format!("{at}/{i}"), found))
        }
        Value::Object(items) => items.iter().for_each(|(k, v)| leaves(v, &format!("{at}/{k}"), found)),
        _ => (),
    }
}
