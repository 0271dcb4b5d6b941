//! Errors and messages of certificates that cannot be read.

use crate::common::{GOLDEN, add_model_error, gain, golden, golden_text, scheduled};
use serde_json::{Value, json};
use squid_certificate::Certificate;

fn refusal(text: &str) -> String {
    Certificate::from_json(text).expect_err(text).to_string()
}

fn with_model_error() -> Value {
    let mut c = scheduled(0.75);
    add_model_error(
        &mut c,
        json!({"E": [[0.01]], "F": [[1.0]], "Fu": [[0.0]], "lambda": 0.01, "gamma": 0.8, "X": [[1.0]],
        "S": [[1.0, 0.0], [0.0, 0.5]], "T": [[0.0, 0.0], [0.0, 0.0]]}),
    );
    assert!(crate::common::prove(&c).is_ok());
    c
}

/// Collects the JSON pointers of all fields: objects and their members, not the entries of matrices.
fn fields(value: &Value, at: &str, found: &mut Vec<String>) {
    let members = value.as_object().into_iter().flatten().map(|(key, member)| (key.clone(), member));
    let objects = value.as_array().into_iter().flatten().enumerate().filter(|(_, entry)| entry.is_object());
    for (key, member) in members.chain(objects.map(|(i, entry)| (i.to_string(), entry))) {
        let here = format!("{at}/{key}");
        fields(member, &here, found);
        found.push(here);
    }
}

/// Converts a JSON pointer to a path: `/errors/0/E` to `errors[0].E`.
fn path(pointer: &str) -> String {
    let part =
        |part: &str| if part.parse::<usize>().is_ok() { format!("[{part}]") } else { format!(".{part}") };
    pointer[1..].split('/').map(part).collect::<String>().trim_start_matches('.').to_owned()
}

fn all_fields() -> Vec<String> {
    let mut found = Vec::new();
    fields(&with_model_error(), "", &mut found);
    // The count includes the keys of the file, of plant, controller and error, and two claims, each with its kind.
    assert_eq!(found.len(), 7 + 15 + 9 + (1 + 3) + (2 + 4) + (2 + 5));
    found
}

#[test]
fn each_field_removed() {
    for pointer in all_fields() {
        let mut c = with_model_error();
        let (parent, key) = pointer.rsplit_once('/').unwrap();
        let Some(object) = c.pointer_mut(parent).unwrap().as_object_mut() else { continue };
        object.remove(key);
        let message = refusal(&c.to_string());
        let expected = match (key, parent) {
            ("errors", _) => "claims[1].gain: needs one model error".to_owned(),
            // The claim is then one without the model error.
            ("lambda", _) => "claims[1].gain: the claim is made twice".to_owned(),
            ("X", _) => format!("{}: missing field `X`, or `V`", path(parent)),
            ("gain", _) => format!("{}: ", path(parent)),
            (_, "") => format!("missing field `{key}`"),
            _ => format!("{}: missing field `{key}`", path(parent)),
        };
        assert!(message.starts_with(&expected), "{pointer}: {message}");
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
        let original = with_model_error().pointer(&pointer).unwrap().clone();
        for other in others.iter().filter(|other| !(original.is_number() && other.is_number())) {
            let mut c = with_model_error();
            *c.pointer_mut(&pointer).unwrap() = other.clone();
            let message = refusal(&c.to_string());
            assert!(message.starts_with(&path(&pointer)), "{pointer} {other}: {message}");
            assert!(message.contains("expected") || message.contains("missing"), "{message}");
            assert!(message.contains("(line 1, column "), "{message}");
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
        let c = with_model_error();
        let original = c.pointer(&pointer).unwrap();
        if !original.is_array() || ["/claims", "/errors"].contains(&pointer.as_str()) {
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
            assert!(
                refused(json!([-1])).contains("invalid value: integer `-1`, expected a whole number from 0")
            );
            assert!(
                refused(json!([1.5]))
                    .contains("invalid type: floating point `1.5`, expected a whole number from 0")
            );
            continue;
        }
        let longer: Vec<Value> = rows.iter().cloned().chain([json!([0.0])]).collect();
        let wider: Vec<Value> = rows
            .iter()
            .map(|r| r.as_array().unwrap().iter().cloned().chain([json!(0.0)]).collect())
            .collect();
        // The number of columns of E is free: a wider E is valid.
        let wider_is_wrong = !rows.is_empty() && pointer != "/errors/0/E";
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

/// Rejects a file of a few thousand numbers whose proof would need gigabytes, or years.
#[test]
fn rejects_loops_too_large_to_prove() {
    let mut c = with_model_error();
    c["plant"]["D11"] = json!([vec![0.0; 3000]]);
    assert!(refusal(&c.to_string()).contains("the inequality has 30"), "{}", refusal(&c.to_string()));
    assert!(refusal(&c.to_string()).contains("at most 1000 are proved"));
}

#[test]
fn rejects_parameters_that_do_not_occur() {
    let with = |plant: Value, controller: Value| {
        let mut c = with_model_error();
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
fn direct_path_may_be_omitted() {
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
    for (d22, expected) in [
        (json!([[0.5, 0.5]]), "plant.D22: row 0 has 2 numbers, must have 1 (controls u)"),
        (json!([[0.5], [0.5]]), "plant.D22: found 2 rows, must have 1 (measurements y)"),
        (json!([["x"]]), "plant.D22[0][0]: invalid type: string \"x\", expected a number"),
        (json!(0.5), "plant.D22: invalid type: floating point `0.5`, expected a list"),
    ] {
        let message = refusal(&with(d22));
        assert!(message.starts_with(expected), "{message}");
    }
}

#[test]
fn other_formats() {
    for (format, found) in [
        (json!("lpv-certificate/2"), "unknown variant `lpv-certificate/2`, expected `lpv-certificate/1`"),
        (json!("lpv-constant-certificate/1"), "unknown variant `lpv-constant-certificate/1`, expected"),
        (json!("LPV-CERTIFICATE/1"), "unknown variant `LPV-CERTIFICATE/1`"),
        (json!(1), "expected"),
    ] {
        let mut c = scheduled(0.75);
        c["format"] = format;
        let message = refusal(&c.to_string());
        assert!(message.starts_with("format: ") && message.contains(found), "{message}");
    }
}

#[test]
fn unknown_and_repeated_keys() {
    for pointer in ["", "/plant", "/controller", "/errors/0", "/claims/1/gain"] {
        let mut c = with_model_error();
        c.pointer_mut(pointer).unwrap().as_object_mut().unwrap().insert("Dyy".into(), json!([[0.0]]));
        let message = refusal(&c.to_string());
        let expected = if pointer.is_empty() { String::new() } else { path(pointer) };
        let expected = format!("{expected}.Dyy: ");
        assert!(message.starts_with(expected.trim_start_matches('.')), "{message}");
        assert!(message.contains("unknown field `Dyy`, expected one of `"), "{message}");
    }
    let mut c = with_model_error();
    c["claims"][1] = json!({"ball": {}});
    let message = refusal(&c.to_string());
    assert!(
        message.starts_with("claims[1]: unknown variant `ball`, expected one of `gain`, `rate`"),
        "{message}"
    );
    let text = scheduled(0.75).to_string();
    let twice = text.replacen("\"gamma\":", "\"gamma\":9.0,\"gamma\":", 1);
    assert!(refusal(&twice).contains("duplicate field `gamma`"), "{}", refusal(&twice));
    for key in ["By", "format", "claims", "blocks"] {
        let twice = text.replacen(&format!("\"{key}\":"), &format!("\"{key}\":[],\"{key}\":"), 1);
        let message = refusal(&twice);
        let is_refused = message.contains("duplicate field") || message.starts_with("format: ");
        assert!(is_refused, "{message}");
    }
    // Externally tagged claims keep the path to a number, which an internal tag would lose.
    let mut c = with_model_error();
    c["claims"][1]["gain"]["T"][1][0] = json!(null);
    let message = refusal(&c.to_string());
    assert!(
        message.starts_with("claims[1].gain.T[1][0]: invalid type: null, expected a number (line 1"),
        "{message}"
    );
    for list in [json!([1]), json!([c])] {
        assert!(refusal(&list.to_string()).starts_with("found a list, must be an object"));
    }
    // A claim is an object with one key.
    let both = text.replacen("{\"gain\":", "{\"rate\":{},\"gain\":", 1);
    assert_ne!(both, text);
    assert!(refusal(&both).starts_with("claims[0]"), "{}", refusal(&both));
}

#[test]
fn rejects_texts_that_are_no_certificate() {
    let text = scheduled(0.75).to_string();
    for bad in ["", "[]", "null", "{", "\"lpv-certificate/1\"", &text[..text.len() - 1], &format!("{text} 1")]
    {
        assert!(!refusal(bad).is_empty());
    }
    assert!(!refusal(&"[".repeat(100_000)).is_empty());
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
fn numbers_round_trip() {
    for name in GOLDEN {
        let c = golden(name);
        assert_eq!(Certificate::from_json(&c.to_json().unwrap()).unwrap(), c);
        assert_eq!(c.to_json().unwrap(), golden_text(name).trim_end());
    }
}

#[test]
fn checks_certificate_built_in_memory() {
    let mut c = golden("lpv01");
    gain(&mut c).x.as_mut().unwrap()[0][0] = f64::NAN;
    assert!(c.to_json().unwrap_err().to_string().starts_with("claims[0].gain.X[0][0]: found NaN"));
    assert!(c.prove().unwrap_err().to_string().starts_with("claims[0].gain.X[0][0]: found NaN"));
    let mut c = golden("lpv01");
    c.controller.a.pop();
    assert!(c.prove().is_err());
}
