//! Loops in discrete time: hand calculation at and next to the limits, comparison with the norm on the unit circle, and
//! rejected files.

use crate::common::{add_model_error, claim, integrator, is_at, prove, scheduled};
use nalgebra::{Complex, dmatrix};
use proptest::prelude::*;
use serde_json::{Value, json};
use squid_certificate::{Certificate, Failure};

/// Returns the certificate of `x+ = u + w`, `z = x` with `u = k y`, that is `x+ = k x + w`: the gain is `1/(1 - |k|)`.
fn lagged(k: f64, x: f64, gamma: f64) -> Value {
    let mut c = integrator(gamma);
    c["discrete"] = json!(true);
    c["controller"]["Duy"] = json!([[k]]);
    claim(&mut c, "gain")["X"] = json!([[x]]);
    c
}

/// Checks `k = 1/2` and X = 1: after Schur complements the inequality requires `3/4 gamma + 1/gamma > 2`, that is
/// `gamma > 2`, the gain itself. In continuous time `x' = x/2 + w` is not stable, and `x' = -2 x + w` has the gain 1/2,
/// while `x+ = -2 x + w` is not stable.
#[test]
fn bound_is_strict_and_depends_on_kind_of_time() {
    let theorem = prove(&lagged(0.5, 1.0, 2.0_f64.next_up())).unwrap();
    assert_eq!((theorem.discrete, theorem.gamma), (true, Some(2.0_f64.next_up())));
    insta::assert_snapshot!(theorem);
    let refusal = prove(&lagged(0.5, 1.0, 2.0)).unwrap_err();
    assert!(matches!(refusal, Failure::NotDefinite { pivot: Some(0.0), .. }), "{refusal}");
    assert!(prove(&lagged(0.5, 1.0, 2.0_f64.next_down())).is_err());
    for k in [1.0, -1.0, -2.0] {
        assert!(prove(&lagged(k, 1.0, 1e6)).is_err(), "{k}");
    }
    let continuous = |k: f64, gamma: f64| {
        let mut c = lagged(k, 1.0, gamma);
        c["discrete"] = json!(false);
        prove(&c)
    };
    assert!(continuous(0.5, 2.1).is_err() && continuous(-2.0, 0.6).is_ok());
}

/// Checks `x+ = (k + theta/4) x + w` with `k = 1/4`, with theta measured and not: the gain is 2 at frozen theta = 1.
#[test]
fn one_parameter() {
    let with = |gamma: f64| {
        let mut c = scheduled(gamma);
        c["discrete"] = json!(true);
        c["plant"]["A"] = json!([[1.25]]);
        c["plant"]["Bt"] = json!([[0.25]]);
        c["controller"]["Dut"] = json!([[0.0]]);
        claim(&mut c, "gain")["S"] = json!([[0.375, 0.0], [0.0, 1e-9]]);
        prove(&c)
    };
    insta::assert_snapshot!(with(2.5).unwrap());
    assert!(with(1.99).is_err());
}

#[test]
fn rejects_other_claims_and_keeps_kind_of_time() {
    let plain = lagged(0.5, 1.0, 2.5);
    let certificate = Certificate::from_json(&plain.to_string()).unwrap();
    assert!(certificate.discrete);
    assert_eq!(Certificate::from_json(&certificate.to_json().unwrap()).unwrap(), certificate);
    let mut with = plain;
    add_model_error(
        &mut with,
        json!({"E": [[0.1]], "F": [[1.0]], "Fu": [[0.0]], "lambda": 1.0, "gamma": 3.0, "X": [[1.0]],
        "S": [], "T": []}),
    );
    let refusal = prove(&with).unwrap_err();
    assert!(is_at(&refusal, "claims[1].gain"), "{refusal}");
    insta::assert_snapshot!(refusal);
}

proptest! {
    /// Checks that proved claims about loops with two states hold on the unit circle; X is that of the loop's own
    /// inequality at half the gain, or arbitrary.
    #[test]
    fn proved_claims_hold_on_unit_circle(
        f in prop::array::uniform4(-0.7..0.7_f64),
        gamma in 1.0..30.0_f64,
        x in (1.0..8.0_f64, -0.5..0.5_f64, 1.0..8.0_f64),
    ) {
        let mut c = lagged(0.0, 1.0, gamma);
        c["plant"] = json!({
            "A": [[f[0], f[1]], [f[2], f[3]]], "Bt": [[], []], "B1": [[1.0], [0.5]], "B2": [[0.0], [0.0]], "Ct": [],
            "C1": [[1.0, -0.3]], "C2": [[1.0, 0.0]], "Dtt": [], "Dt1": [], "Dt2": [], "D1t": [[]], "D11": [[0.1]],
            "D12": [[0.0]], "D2t": [[]], "D21": [[0.0]]
        });
        claim(&mut c, "gain")["X"] = json!([[x.0, x.1], [x.1, x.2]]);
        if prove(&c).is_ok() {
            let a = dmatrix![f[0], f[1]; f[2], f[3]].map(|v| Complex::new(v, 0.0));
            let b = dmatrix![1.0; 0.5].map(|v| Complex::new(v, 0.0));
            for step in 0..=64 {
                let z = Complex::from_polar(1.0, std::f64::consts::PI * f64::from(step) / 64.0);
                let inner = (nalgebra::DMatrix::identity(2, 2) * z - &a).lu().solve(&b).unwrap();
                let gain = (inner[0] - inner[1] * 0.3 + 0.1).norm();
                prop_assert!(gain < gamma, "{gain} at {z}");
            }
        }
    }
}
