//! Changes of single numbers of a true certificate, thousands of times: claims that are still proved must be true.

use crate::common::golden_text;
use crate::independent::{Loop, claims};
use proptest::prelude::*;
use proptest::test_runner::{Config, TestRunner};
use serde_json::Value;
use squid_certificate::{Certificate, Failure};
use std::cell::Cell;

/// Largest wrong-signed eigenvalue of the scaled inequality, in floating point, that rounding explains.
const ROUNDING: f64 = 1e-9;

#[derive(Debug, Clone, Copy)]
enum Change {
    /// Flips a bit of the upper half of the mantissa.
    Bit(u32),
    Sign,
    /// Scales by a power of ten.
    Order(i32),
    Zero,
    Ulp,
}

impl Change {
    fn of(self, x: f64) -> f64 {
        match self {
            Self::Bit(bit) => f64::from_bits(x.to_bits() ^ (1 << bit)),
            Self::Sign => -x,
            Self::Order(k) => x * 10f64.powi(k),
            Self::Zero => 0.0,
            Self::Ulp => x.next_up(),
        }
    }
}

fn change() -> impl Strategy<Value = Change> {
    prop_oneof![
        4 => (26_u32..52).prop_map(Change::Bit),
        2 => Just(Change::Sign),
        2 => prop_oneof![-3..0, 1..4].prop_map(Change::Order),
        1 => Just(Change::Zero),
        1 => Just(Change::Ulp),
    ]
}

/// Returns pointers to all numbers of each part: plant, controller, model errors, and each field of each claim.
fn numbers(file: &Value) -> Vec<Vec<String>> {
    let claims = file["claims"].as_array().unwrap().iter().enumerate();
    let fields = claims.flat_map(|(i, claim)| {
        let gain = claim["gain"].as_object().unwrap();
        gain.keys().map(move |key| format!("/claims/{i}/gain/{key}")).collect::<Vec<_>>()
    });
    let parts = ["/plant", "/controller", "/errors"].map(str::to_owned);
    let all = parts.into_iter().chain(fields).map(|pointer| {
        let mut found = Vec::new();
        leaves(file.pointer(&pointer).unwrap_or(&Value::Null), &pointer, &mut found);
        found
    });
    all.filter(|found| !found.is_empty()).collect()
}

fn leaves(value: &Value, at: &str, found: &mut Vec<String>) {
    match value {
        Value::Number(_) => found.push(at.to_string()),
        Value::Array(items) => {
            items.iter().enumerate().for_each(|(i, v)| leaves(v, &format!("{at}/{i}"), found));
        }
        Value::Object(items) => items.iter().for_each(|(k, v)| leaves(v, &format!("{at}/{k}"), found)),
        _ => (),
    }
}

/// Changes one number; with `mirrored`, also the one across the diagonal of X, S or T, so that the structure is kept.
fn tamper(file: &Value, pointer: &str, change: Change, mirrored: bool) -> Value {
    let mut lie = file.clone();
    let old = lie.pointer(pointer).unwrap().as_f64().unwrap();
    let new = change.of(old);
    *lie.pointer_mut(pointer).unwrap() = new.into();
    let parts: Vec<&str> = pointer.split('/').collect();
    if let ([.., matrix @ ("X" | "S" | "T"), i, j], true) = (parts.as_slice(), mirrored) {
        let across = format!("{}/{j}/{i}", &pointer[..pointer.len() - i.len() - j.len() - 2]);
        if i != j {
            *lie.pointer_mut(&across).unwrap() = (if *matrix == "T" { -new } else { new }).into();
        }
    }
    lie
}

/// Tampers `cases` times with a golden certificate.
fn survives(name: &str, cases: u32) {
    let file: Value = serde_json::from_str(&golden_text(name)).unwrap();
    let fields = numbers(&file);
    let pointers = any::<prop::sample::Index>().prop_flat_map(move |field| {
        let field = fields[field.index(fields.len())].clone();
        prop::sample::select(field)
    });
    let [accepted, structure, refused] = [Cell::new(0), Cell::new(0), Cell::new(0)];
    let count = |c: &Cell<u32>| c.set(c.get() + 1);
    let mut runner = TestRunner::new(Config {
        cases,
        max_global_rejects: 10 * cases,
        failure_persistence: None,
        ..Config::default()
    });
    let outcome = runner.run(&(pointers, change(), any::<bool>()), |(pointer, change, mirrored)| {
        let lie = tamper(&file, &pointer, change, mirrored);
        // A changed sign or scale of a zero is no change.
        prop_assume!(lie != file && lie.pointer(&pointer) != Some(&Value::from(-0.0)));
        let c = Certificate::from_json(&lie.to_string()).unwrap();
        let closed = Loop::new(&c);
        let worst = claims(&c).iter().map(|claim| closed.inequality(claim)).fold(f64::NEG_INFINITY, f64::max);
        match c.prove() {
            Ok(_) => {
                count(&accepted);
                prop_assert!(worst < ROUNDING, "accepted, but an eigenvalue is {worst:e}");
                for claim in claims(&c) {
                    prop_assert_eq!(closed.contradiction(&claim), None);
                }
            }
            Err(Failure::Structure { .. }) => {
                count(&structure);
                prop_assert!(["/X/", "/S/", "/T/"].iter().any(|m| pointer.contains(m)));
            }
            Err(failure) => {
                count(&refused);
                let positive = claims(&c)
                    .iter()
                    .all(|claim| claim.gamma > 0.0 && claim.delta.is_none_or(|(lambda, _)| lambda > 0.0));
                prop_assert!(!positive || worst > -ROUNDING, "true, but: {failure}; eigenvalue {worst:e}");
            }
        }
        Ok(())
    });
    println!(
        "{name}: {cases} changed, {} still true and accepted, {} refused for their structure, {} for definiteness",
        accepted.get(),
        structure.get(),
        refused.get()
    );
    outcome.unwrap();
    assert!(accepted.get() > 0 && structure.get() > 0 && refused.get() > 0);
}

#[test]
fn one_parameter() {
    survives("lpv01", 4000);
}

#[test]
fn two_parameters_and_a_model_error() {
    survives("lpv03", 1000);
}

#[test]
fn a_vehicle_and_a_model_error() {
    survives("squid_surrogate", 150);
}

#[test]
fn another_vehicle() {
    survives("remus100", 300);
}

#[test]
fn no_parameter() {
    survives("hs04", 300);
}
