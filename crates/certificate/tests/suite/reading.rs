//! What is refused when a certificate is read, and in which words.

use crate::common::{GOLDEN, golden, golden_text, scheduled};
use certificate::Certificate;
use serde_json::{Value, json};

fn refusal(text: &str) -> String {
    Certificate::from_json(text).expect_err(text).to_string()
}

fn with_residual() -> Value {
    let mut c = scheduled(0.75);
    c["residual"] = json!({"E": [[0.01]], "F": [[1.0]], "Fu": [[0.0]], "lambda": 0.01, "gamma": 0.8, "X": [[1.0]],
        "S": [[1.0, 0.0], [0.0, 0.5]], "T": [[0.0, 0.0], [0.0, 0.0]]});
    assert!(crate::common::prove(&c).is_ok());
    c
}

/// The JSON pointer of every field: objects and their members, not the entries of matrices.
fn fields(value: &Value, at: &str, found: &mut Vec<String>) {
    for (key, member) in value.as_object().into_iter().flatten() {
        let here = format!("{at}/{key}");
        fields(member, &here, found);
        found.push(here);
    }
}

/// `plant.A` for `/plant/A`.
fn path(pointer: &str) -> String {
    pointer[1..].replace('/', ".")
}

fn all_fields() -> Vec<String> {
    let mut found = Vec::new();
    fields(&with_residual(), "", &mut found);
    assert_eq!(found.len(), 9 + 1 + 15 + 9 + 8);
    found
}

#[test]
fn each_field_removed() {
    for pointer in all_fields() {
        let mut c = with_residual();
        let (parent, key) = pointer.rsplit_once('/').unwrap();
        c.pointer_mut(parent).unwrap().as_object_mut().unwrap().remove(key);
        if pointer == "/residual" {
            assert!(crate::common::prove(&c).is_ok());
            continue;
        }
        let message = refusal(&c.to_string());
        let expected = if key == "format" {
            "format: found nothing".to_string()
        } else {
            format!("{}: missing", path(&pointer))
        };
        assert!(message.starts_with(&expected), "{message}");
    }
}

#[test]
fn each_field_of_another_kind() {
    let others = [
        json!(null),
        json!(true),
        json!("1.0"),
        json!({"a": 1}),
        json!([["1.0"]]),
        json!([[null]]),
        json!(-0.5),
    ];
    for pointer in all_fields() {
        let original = with_residual().pointer(&pointer).unwrap().clone();
        for other in others.iter().filter(|other| !(original.is_number() && other.is_number())) {
            let mut c = with_residual();
            *c.pointer_mut(&pointer).unwrap() = other.clone();
            let message = refusal(&c.to_string());
            assert!(message.starts_with(&path(&pointer)), "{pointer} {other}: {message}");
            assert!(message.contains("found") || message.contains("missing"), "{message}");
        }
    }
}

#[test]
fn numbers_that_are_not_finite() {
    let text = scheduled(0.75).to_string();
    for bad in ["NaN", "Infinity", "-Infinity", "1e999", "-1e999", "0x10", ".5", "1.", "01"] {
        let tampered = text.replacen("0.75", bad, 1);
        assert_ne!(tampered, text);
        let message = refusal(&tampered);
        assert!(message.contains("not JSON with finite numbers") && message.contains("line 1"), "{message}");
    }
}

#[test]
fn each_wrong_shape() {
    for pointer in all_fields() {
        let c = with_residual();
        let original = c.pointer(&pointer).unwrap();
        if !original.is_array() {
            continue;
        }
        let refused = |changed: Value| {
            let mut c = c.clone();
            *c.pointer_mut(&pointer).unwrap() = changed;
            refusal(&c.to_string())
        };
        let rows = original.as_array().unwrap();
        if pointer.ends_with("blocks") {
            assert!(refused(json!([2])).starts_with(&format!("{}: adds up to 2", path(&pointer))));
            assert!(refused(json!([-1])).contains("a whole number"));
            assert!(refused(json!([1.5])).contains("a whole number"));
            continue;
        }
        let longer: Vec<Value> = rows.iter().cloned().chain([json!([0.0])]).collect();
        let wider: Vec<Value> = rows
            .iter()
            .map(|r| r.as_array().unwrap().iter().cloned().chain([json!(0.0)]).collect())
            .collect();
        // The columns of E are a size of their own: a wider E is another error, and fits.
        let wider_is_wrong = !rows.is_empty() && pointer != "/residual/E";
        for (changed, wrong) in [(longer, true), (wider, wider_is_wrong)] {
            if wrong {
                let message = refused(Value::Array(changed));
                assert!(
                    message.contains("must have") || message.contains("adds up to"),
                    "{pointer}: {message}"
                );
            }
        }
    }
}

/// A few thousand numbers would ask for gigabytes, or for years.
#[test]
fn loops_too_large_to_be_proved() {
    let mut c = with_residual();
    c["plant"]["D11"] = json!([vec![0.0; 3000]]);
    assert!(refusal(&c.to_string()).contains("the inequality has 30"), "{}", refusal(&c.to_string()));
    assert!(refusal(&c.to_string()).contains("at most 1000 are proved"));
}

#[test]
fn parameters_that_occur_nowhere() {
    let with = |plant: Value, controller: Value| {
        let mut c = with_residual();
        c["blocks"] = plant;
        c["controller_blocks"] = controller;
        c.to_string()
    };
    let many: Vec<usize> = std::iter::once(1).chain([0; 50]).collect();
    for (plant, controller, field) in [
        (json!(many), json!([1]), "blocks[1]: "),
        (json!([1]), json!(many), "controller_blocks[1]: "),
        (json!([0, 1]), json!([0, 1]), "blocks[0]: "),
    ] {
        let message = refusal(&with(plant, controller));
        assert!(message.starts_with(field) && message.contains("must be above 0"), "{message}");
    }
    assert!(Certificate::from_json(&with(json!([1]), json!([0, 1]))).is_ok());
}

#[test]
fn a_direct_path_may_be_left_out() {
    let with = |d22: Value| {
        let mut c = scheduled(0.75);
        c["plant"]["D22"] = d22;
        c.to_string()
    };
    let plain = crate::common::prove(&scheduled(0.75)).unwrap();
    for d22 in [json!([[0.0]]), json!([])] {
        let read = Certificate::from_json(&with(d22)).unwrap();
        assert_eq!(read.plant.direct_path(), None);
        assert_eq!(read.prove().unwrap().to_string(), plain);
    }
    assert!(
        !Certificate::from_json(&scheduled(0.75).to_string()).unwrap().to_json().unwrap().contains("D22")
    );
    for (d22, words) in [
        (json!([[0.5, 0.5]]), "plant.D22: row 0 has 2 numbers, must have 1 (controls u)"),
        (json!([[0.5], [0.5]]), "plant.D22: found 2 rows, must have 1 (measurements y)"),
        (json!([["x"]]), "plant.D22[0][0]: found the string"),
        (json!(0.5), "plant.D22: found the number 0.5"),
    ] {
        let message = refusal(&with(d22));
        assert!(message.starts_with(words), "{message}");
    }
}

#[test]
fn other_formats() {
    for (format, found) in [
        (json!("lpv-certificate/2"), "the string \"lpv-certificate/2\""),
        (json!("LPV-CERTIFICATE/1"), "the string"),
        (json!(1), "the number 1"),
    ] {
        let mut c = scheduled(0.75);
        c["format"] = format;
        let message = refusal(&c.to_string());
        assert!(message.starts_with(&format!("format: found {found}")), "{message}");
        assert!(message.contains("allowed is \"lpv-certificate/1\""), "{message}");
    }
}

#[test]
fn unknown_and_repeated_keys() {
    for place in ["", "/plant", "/controller", "/residual"] {
        let mut c = with_residual();
        c.pointer_mut(place).unwrap().as_object_mut().unwrap().insert("Dyy".into(), json!([[0.0]]));
        let message = refusal(&c.to_string());
        assert!(message.contains("Dyy: unknown key") && message.contains("may have the keys"), "{message}");
    }
    let text = scheduled(0.75).to_string();
    let twice = text.replacen("\"gamma\":", "\"gamma\":9.0,\"gamma\":", 1);
    assert!(refusal(&twice).contains("\"gamma\" stands twice"));
    assert!(refusal(&text.replacen("\"By\":", "\"By\":[],\"By\":", 1)).contains("stands twice"));
}

#[test]
fn texts_that_are_no_certificate() {
    let text = scheduled(0.75).to_string();
    for bad in ["", "[]", "null", "{", "\"lpv-certificate/1\"", &text[..text.len() - 1], &format!("{text} 1")]
    {
        assert!(!refusal(bad).is_empty());
    }
    assert!(refusal(&"[".repeat(100_000)).contains("recursion"));
    let mut c = scheduled(0.75);
    c["plant"]["D11"] = json!([]);
    assert!(refusal(&c.to_string()).contains("must have at least one (outputs z)"));
    c["plant"]["D11"] = json!([[]]);
    assert!(refusal(&c.to_string()).contains("must have at least one (inputs w)"));
    c["blocks"] = json!([999_999, 999_999]);
    c["plant"]["D11"] = json!([[0.0]]);
    assert!(refusal(&c.to_string()).starts_with("blocks: adds up to 1999998"));
}

#[test]
fn what_is_written_reads_back_to_the_same_numbers() {
    for name in GOLDEN {
        let c = golden(name);
        assert_eq!(Certificate::from_json(&c.to_json().unwrap()).unwrap(), c);
        assert_eq!(c.to_json().unwrap(), golden_text(name).trim_end());
    }
}

#[test]
fn a_certificate_made_in_a_program_is_checked_too() {
    let mut c = golden("lpv01");
    c.any_rate.as_mut().unwrap().x[0][0] = f64::NAN;
    assert!(c.to_json().unwrap_err().to_string().starts_with("X[0][0]: found NaN"));
    assert!(c.prove().unwrap_err().to_string().starts_with("not proved: X[0][0]: found NaN"));
    let mut c = golden("lpv01");
    c.controller.a.pop();
    assert!(c.prove().is_err());
}
