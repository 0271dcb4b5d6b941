//! Lyapunov matrix given as `X = V'V`.

use crate::common::{claim, gain, golden, integrator, is_at, prove};
use serde_json::{Value, json};
use squid_certificate::{Certificate, Rows};

/// Returns the integrator with V in place of X.
fn by_factor(gamma: f64, v: &Value) -> Value {
    let mut file = integrator(gamma);
    let gain = claim(&mut file, "gain");
    gain.as_object_mut().unwrap().remove("X");
    gain["V"] = v.clone();
    file
}

/// Checks `X = V'V = x`, for which the inequality is `[-2x x 1; x -gamma 0; 1 0 -gamma] < 0`, that is
/// `2 gamma x > x^2 + 1`.
#[test]
fn factor_proves_same_as_its_square() {
    for (v, gamma, holds) in [(1.0, 1.01, true), (1.0, 1.0, false), (-1.0, 1.01, true), (1.5, 1.348, true)] {
        let found = prove(&by_factor(gamma, &json!([[v]])));
        assert_eq!(found.is_ok(), holds, "{v} {gamma}: {found:?}");
    }
    for (v, gamma, place) in [(1.5, 1.347, "Gain inequality"), (0.0, 1.01, "Gain X")] {
        let refusal = prove(&by_factor(gamma, &json!([[v]]))).unwrap_err();
        assert!(is_at(&refusal, place), "{refusal}");
    }
}

/// Checks V = 1 + 2^-30, whose square has a digit beyond the f64.
#[test]
fn square_of_factor_is_not_rounded() {
    let v = 1.0 + 2f64.powi(-30);
    let x = v * v;
    // At the limit of X = V'V, x^2 + 1 = 2 gamma x, the last digit decides; a gamma slightly above is proved, one
    // slightly below is not.
    let limit = (x * x + 1.0) / (2.0 * x);
    assert!(prove(&by_factor(limit * (1.0 + 1e-15), &json!([[v]]))).is_ok());
    assert!(prove(&by_factor(limit * (1.0 - 1e-15), &json!([[v]]))).is_err());
}

#[test]
fn rejects_both_neither_and_wrong_size() {
    let mut both = integrator(1.01);
    claim(&mut both, "gain")["V"] = json!([[1.0]]);
    let both = prove(&both).unwrap_err();
    assert!(is_at(&both, "claims[0].gain"), "{both}");
    for wrong in [json!([]), json!([[1.0, 0.0], [0.0, 1.0]]), json!([[1.0, 2.0]]), json!([["1"]]), json!(1.0)]
    {
        assert!(prove(&by_factor(1.01, &wrong)).is_err(), "{wrong}");
    }
    let mut none = by_factor(1.01, &json!([[1.0]]));
    claim(&mut none, "gain").as_object_mut().unwrap().remove("V");
    let none = prove(&none).unwrap_err();
    assert!(is_at(&none, "claims[0].gain"), "{none}");
    insta::assert_snapshot!(format!("X and V:\n{both}\n\nneither:\n{none}"));
}

/// Returns the upper triangular V of a golden X, by Cholesky's method in floating point.
fn factor(x: &Rows) -> Rows {
    let n = x.len();
    let mut v = vec![vec![0.0; n]; n];
    for i in 0..n {
        for j in i..n {
            let sum: f64 = (0..i).map(|k| v[k][i] * v[k][j]).sum();
            v[i][j] = if i == j { (x[i][i] - sum).sqrt() } else { (x[i][j] - sum) / v[i][i] };
        }
    }
    v
}

#[test]
fn golden_certificates_prove_with_factor_and_round_trip() {
    for name in ["hs04", "lpv03"] {
        let given = golden(name);
        let mut changed = given.clone();
        let claim = gain(&mut changed);
        claim.v = claim.x.take().as_ref().map(factor);
        assert_eq!(changed.prove().unwrap().gamma, given.prove().unwrap().gamma);
        let text = changed.to_json().unwrap();
        assert_eq!(Certificate::from_json(&text).unwrap(), changed);
        // A changed entry of V changes X.
        let mut tampered = changed.clone();
        gain(&mut tampered).v.as_mut().unwrap()[0][1] += 1e3;
        assert!(tampered.prove().is_err());
    }
}
