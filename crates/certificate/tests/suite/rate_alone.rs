//! Claim of a bounded rate without one for parameters that vary arbitrarily fast.

use crate::bounded_rate::{commutator, one_interval};
use crate::common::{Refused, add, add_model_error, claim, golden_text, is_at, prove, remove};
use serde_json::{Value, json};
use squid_certificate::{Certificate, Claim, Gain};

/// Certificate of a loop for which no constant Lyapunov matrix exists.
pub const ALONE: &str = "oscillator_bounded_rate";

fn alone(mut file: Value) -> Value {
    remove(&mut file, "gain");
    file
}

#[test]
fn proves_rate_and_excludes_faster_parameters() {
    let theorem = prove(&alone(one_interval(0.75, 0.5))).unwrap();
    let slow = theorem.bounded_rate.unwrap();
    assert_eq!((theorem.gamma, slow.rate, slow.gamma), (None, 3.0, 0.75));
    insta::assert_snapshot!(theorem);
    // The gain of the commutator is the rate.
    for rate in [0.25, 4.0] {
        assert!(prove(&alone(commutator(rate, 1.1 * rate, 64, 0.1 / rate))).is_ok());
        let refusal = prove(&alone(commutator(rate, 0.99 * rate, 64, 0.1 / rate))).unwrap_err();
        assert!(is_at(&refusal, "Rate Bernstein"), "{refusal}");
    }
}

#[test]
fn smaller_bound_holds_at_rate() {
    let read = |file: &Value| Certificate::from_json(&file.to_string()).unwrap().prove().unwrap();
    let both = one_interval(0.75, 0.5);
    assert_eq!(read(&both).gamma_at_rate(), Some(0.75));
    let mut larger = both.clone();
    claim(&mut larger, "rate")["gamma"] = json!(0.8);
    assert_eq!(read(&larger).gamma_at_rate(), Some(0.75));
    claim(&mut larger, "gain")["gamma"] = json!(0.9);
    assert_eq!(read(&larger).gamma_at_rate(), Some(0.8));
    let theorem = read(&alone(larger));
    assert_eq!((theorem.gamma, theorem.gamma_at_rate()), (None, Some(0.8)));
}

/// Checks that a true claim of the rate does not support a false one for arbitrary rates.
#[test]
fn rejects_false_claim_next_to_it() {
    let mut file = one_interval(0.75, 0.5);
    claim(&mut file, "gain")["gamma"] = json!(0.6);
    let refusal = prove(&file).unwrap_err();
    assert!(is_at(&refusal, "Gain inequality"), "{refusal}");
}

#[test]
fn rejects_incomplete_and_missing_claims() {
    let mut refused = Refused::default();
    for key in ["gamma", "S", "T"] {
        let mut file = one_interval(0.75, 0.5);
        claim(&mut file, "gain").as_object_mut().unwrap().remove(key);
        refused.at("claims[0].gain", &file);
    }
    let mut none = alone(one_interval(0.75, 0.5));
    remove(&mut none, "rate");
    refused.at("claims", &none);
    let golden = Certificate::from_json(&golden_text(ALONE)).unwrap();
    let none = Certificate { claims: vec![], ..golden };
    refused.add("claims", &none.prove().unwrap_err());
    assert!(none.to_json().is_err());
    let mut discrete = alone(one_interval(0.75, 0.5));
    discrete["discrete"] = json!(true);
    refused.at("claims[0].rate", &discrete);
    insta::assert_snapshot!(refused.0);
}

#[test]
fn dependent_claims_need_claim_for_any_rate() {
    let model_error = json!({
        "E": [[0.1]], "F": [[1.0]], "Fu": [[0.0]], "lambda": 1.0, "gamma": 3.0, "X": [[1.0]],
        "S": [[1.0, 0.0], [0.0, 0.5]], "T": [[0.0, 0.0], [0.0, 0.0]]
    });
    let mut file = alone(one_interval(0.75, 0.5));
    add_model_error(&mut file, model_error.clone());
    let mut refused = Refused::default();
    refused.at("claims[1].gain", &file);
    // A model error that no claim covers would appear to be covered.
    let mut file = one_interval(0.75, 0.5);
    file["errors"] = json!([{"E": [[0.1]], "F": [[1.0]], "Fu": [[0.0]]}]);
    refused.at("errors", &file);
    // A multiplier belongs to one model error.
    let mut file = one_interval(0.75, 0.5);
    add_model_error(&mut file, model_error);
    let second = file["errors"][0].clone();
    file["errors"].as_array_mut().unwrap().push(second);
    refused.at("claims[2].gain", &file);
    insta::assert_snapshot!(refused.0);
    // An empty list of claims is rejected.
    let mut with = Certificate::from_json(&golden_text(ALONE)).unwrap();
    with.claims.push(Claim::Gain(Gain::default()));
    assert!(with.prove().is_err());
}

/// Rejects two claims of a kind, which readers could not distinguish.
#[test]
fn rejects_duplicate_claims() {
    let mut refused = Refused::default();
    for kind in ["gain", "rate"] {
        let mut file = one_interval(0.75, 0.5);
        let again = claim(&mut file, kind).clone();
        add(&mut file, kind, again);
        refused.at(&format!("claims[2].{kind}"), &file);
    }
    insta::assert_snapshot!(refused.0);
}

#[test]
fn golden_certificate_states_rate_alone() {
    let golden = Certificate::from_json(&golden_text(ALONE)).unwrap();
    let text = golden.to_json().unwrap();
    assert_eq!(Certificate::from_json(&text).unwrap(), golden);
    let file: Value = serde_json::from_str(&text).unwrap();
    assert!(file["claims"].as_array().unwrap().iter().all(|claim| claim.get("gain").is_none()));
    let theorem = golden.prove().unwrap();
    assert_eq!((theorem.gamma, theorem.finished), (None, true));
}
