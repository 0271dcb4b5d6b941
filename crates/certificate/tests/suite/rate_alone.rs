//! A claim of a bounded rate without one for parameters that move however fast.

use crate::bounded_rate::{commutator, one_interval};
use crate::common::{golden_text, prove};
use certificate::{AnyRate, Certificate, Failure, ReadError, Residual};
use serde_json::{Value, json};

/// The certificate of a loop for which no constant Lyapunov matrix exists.
pub const ALONE: &str = "oscillator_bounded_rate";

/// The keys of the claim for parameters that move however fast.
const ANY_RATE: [&str; 4] = ["gamma", "X", "S", "T"];

fn alone(mut file: Value) -> Value {
    ANY_RATE.iter().for_each(|key| drop(file.as_object_mut().unwrap().remove(*key)));
    file
}

#[test]
fn it_proves_and_says_that_nothing_is_claimed_of_a_faster_parameter() {
    let theorem = prove(&alone(one_interval(0.75, 0.5))).unwrap();
    assert!(
        theorem.starts_with(
            "For every Lipschitz continuous trajectory of the parameter in [-1, 1] that moves by at most 3 in a unit \
             of time the closed loop of 1 state is exponentially stable and its L2 gain from w to z is below 0.75. \
             Nothing is proved of a parameter that moves faster."
        ),
        "{theorem}"
    );
    // The gain of the commutator is the rate.
    for rate in [0.25, 4.0] {
        assert!(prove(&alone(commutator(rate, 1.1 * rate, 64, 0.1 / rate))).is_ok());
        let refusal = prove(&alone(commutator(rate, 0.99 * rate, 64, 0.1 / rate))).unwrap_err();
        assert!(refusal.starts_with("the claim of a bounded rate is not proved"), "{refusal}");
    }
}

#[test]
fn the_smaller_of_both_bounds_holds_at_the_rate() {
    let read = |file: &Value| Certificate::from_json(&file.to_string()).unwrap().prove().unwrap();
    let both = one_interval(0.75, 0.5);
    assert_eq!(read(&both).gamma_at_rate(), Some(0.75));
    let mut larger = both.clone();
    larger["bounded_rate"]["gamma"] = json!(0.8);
    assert_eq!(read(&larger).gamma_at_rate(), Some(0.75));
    larger["gamma"] = json!(0.9);
    assert_eq!(read(&larger).gamma_at_rate(), Some(0.8));
    let theorem = read(&alone(larger));
    assert_eq!((theorem.gamma, theorem.gamma_at_rate()), (None, Some(0.8)));
}

/// The true claim of the rate does not carry a false one for any rate.
#[test]
fn a_false_claim_beside_it_is_refused() {
    let mut file = one_interval(0.75, 0.5);
    file["gamma"] = json!(0.6);
    let refusal = prove(&file).unwrap_err();
    assert!(refusal.starts_with("the claim is not proved"), "{refusal}");
}

#[test]
fn part_of_a_claim_or_none_is_refused() {
    for key in ANY_RATE {
        let mut file = one_interval(0.75, 0.5);
        file.as_object_mut().unwrap().remove(key);
        let refusal = prove(&file).unwrap_err();
        assert!(refusal.starts_with(&format!("{key}: missing")), "{refusal}");
        let mut file = alone(one_interval(0.75, 0.5));
        file[key] = one_interval(0.75, 0.5)[key].clone();
        assert!(prove(&file).unwrap_err().contains("missing"));
    }
    let mut none = alone(one_interval(0.75, 0.5));
    none.as_object_mut().unwrap().remove("bounded_rate");
    assert!(prove(&none).unwrap_err().starts_with("gamma: missing"));
    let golden = Certificate::from_json(&golden_text(ALONE)).unwrap();
    let none = Certificate { bounded_rate: None, ..golden };
    assert!(matches!(none.prove(), Err(Failure::Malformed(ReadError::NoClaim))));
    assert!(none.to_json().is_err());
    let mut discrete = alone(one_interval(0.75, 0.5));
    discrete["discrete"] = json!(true);
    assert!(prove(&discrete).unwrap_err().starts_with("bounded_rate: is of a loop in continuous time"));
}

#[test]
fn what_is_built_on_the_claim_for_any_rate_needs_it() {
    let mut file = alone(one_interval(0.75, 0.5));
    file["residual"] = json!({
        "E": [[0.1]], "F": [[1.0]], "Fu": [[0.0]], "lambda": 1.0, "gamma": 3.0, "X": [[1.0]],
        "S": [[1.0, 0.0], [0.0, 0.5]], "T": [[0.0, 0.0], [0.0, 0.0]]
    });
    let refusal = prove(&file).unwrap_err();
    assert!(
        refusal.starts_with("residual: needs the claim for parameters that move however fast"),
        "{refusal}"
    );
    let golden = Certificate::from_json(&golden_text(ALONE)).unwrap();
    let with = Certificate { residual: Some(Residual::default()), ..golden.clone() };
    assert!(matches!(with.prove(), Err(Failure::Malformed(ReadError::NoAnyRate { field: "residual" }))));
    // An empty claim is none.
    let with = Certificate { any_rate: Some(AnyRate::default()), ..golden };
    assert!(with.prove().is_err());
}

#[test]
fn the_golden_certificate_states_the_rate_alone() {
    let golden = Certificate::from_json(&golden_text(ALONE)).unwrap();
    let text = golden.to_json().unwrap();
    assert_eq!(Certificate::from_json(&text).unwrap(), golden);
    let file: Value = serde_json::from_str(&text).unwrap();
    assert!(ANY_RATE.iter().all(|key| file.get(key).is_none()));
    let theorem = golden.prove().unwrap();
    assert_eq!((theorem.gamma, theorem.finished), (None, true));
}
