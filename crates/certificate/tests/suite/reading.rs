//! Errors and messages of certificates that cannot be read.

use crate::common::{GOLDEN, Refused, add_model_error, gain, golden, golden_text, is_at, scheduled};
use serde_json::{Value, json};
use squid_certificate::{Certificate, Failure, JsonError};

fn refusal(text: &str) -> Failure {
    Certificate::from_json(text).expect_err(text)
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
    let mut refused = Refused::default();
    for pointer in all_fields() {
        let mut c = with_model_error();
        let (parent, key) = pointer.rsplit_once('/').unwrap();
        let Some(object) = c.pointer_mut(parent).unwrap().as_object_mut() else { continue };
        object.remove(key);
        let failure = refusal(&c.to_string());
        let place = match (key, parent) {
            // Without lambda the claim is a second one without the model error.
            ("errors" | "lambda", _) => "claims[1].gain".to_owned(),
            (_, "") => String::new(),
            _ => path(parent),
        };
        if ["errors", "lambda", "gain"].contains(&key) || ["/plant", "/claims/1/gain/X"].contains(&&*pointer)
        {
            refused.add(&place, &failure);
        } else {
            assert!(is_at(&failure, &place), "{pointer}: {failure}");
            assert!(failure.to_string().contains(&format!("`{key}`")), "{failure}");
        }
    }
    insta::assert_snapshot!(refused.0);
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
            let failure = refusal(&c.to_string());
            let Failure::Json(JsonError { path: found, line: 1, is_json: true, .. }) = &failure else {
                panic!("{pointer} {other}: {failure}")
            };
            assert!(found.starts_with(&path(&pointer)), "{pointer} {other}: {failure}");
        }
    }
}

#[test]
fn numbers_that_are_not_finite() {
    let text = scheduled(0.75).to_string();
    for bad in ["NaN", "Infinity", "-Infinity", "1e999", "-1e999", "0x10", ".5", "1.", "01"] {
        let tampered = text.replacen("0.75", bad, 1);
        assert_ne!(tampered, text);
        let failure = refusal(&tampered);
        assert!(matches!(failure, Failure::Json(JsonError { line: 1, is_json: false, .. })), "{failure}");
    }
}

#[test]
fn each_wrong_shape() {
    let mut messages = Refused::default();
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
            messages.add(&path(&pointer), &refused(json!([2])));
            messages.add(&path(&format!("{pointer}/0")), &refused(json!([-1])));
            messages.add(&path(&format!("{pointer}/0")), &refused(json!([1.5])));
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
                let failure = refused(Value::Array(changed));
                assert!(matches!(failure, Failure::Malformed { .. }), "{pointer}: {failure}");
            }
        }
    }
    insta::assert_snapshot!(messages.0);
}

/// Rejects a file of a few thousand numbers whose proof would need gigabytes, or years.
#[test]
fn rejects_loops_too_large_to_prove() {
    let mut c = with_model_error();
    c["plant"]["D11"] = json!([vec![0.0; 3000]]);
    let failure = refusal(&c.to_string());
    assert!(is_at(&failure, "plant"), "{failure}");
    insta::assert_snapshot!(failure);
}

#[test]
fn rejects_parameters_that_do_not_occur() {
    let with = |plant: Value, controller: Value| {
        let mut c = with_model_error();
        c["blocks"] = plant;
        c["controller_blocks"] = controller;
        c.to_string()
    };
    let mut refused = Refused::default();
    let many: Vec<usize> = std::iter::once(1).chain([0; 50]).collect();
    for (plant, controller, field) in [
        (json!(many), json!([1]), "blocks[1]"),
        (json!([1]), json!(many), "controller_blocks[1]"),
        (json!([0, 1]), json!([0, 1]), "blocks[0]"),
    ] {
        refused.add(field, &refusal(&with(plant, controller)));
    }
    insta::assert_snapshot!(refused.0);
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
    let mut refused = Refused::default();
    for d22 in [json!([[0.0]]), json!([])] {
        let read = Certificate::from_json(&with(d22)).unwrap();
        assert_eq!(read.plant.direct_path(), None);
        assert_eq!(read.prove().unwrap(), plain);
    }
    assert!(
        !Certificate::from_json(&scheduled(0.75).to_string()).unwrap().to_json().unwrap().contains("D22")
    );
    for (d22, place) in [
        (json!([[0.5, 0.5]]), "plant.D22"),
        (json!([[0.5], [0.5]]), "plant.D22"),
        (json!([["x"]]), "plant.D22[0][0]"),
        (json!(0.5), "plant.D22"),
    ] {
        refused.add(place, &refusal(&with(d22)));
    }
    insta::assert_snapshot!(refused.0);
}

#[test]
fn other_formats() {
    let mut refused = Refused::default();
    for format in [
        json!("lpv-certificate/2"),
        json!("lpv-constant-certificate/1"),
        json!("LPV-CERTIFICATE/1"),
        json!(1),
    ] {
        let mut c = scheduled(0.75);
        c["format"] = format;
        refused.add("format", &refusal(&c.to_string()));
    }
    insta::assert_snapshot!(refused.0);
}

#[test]
fn unknown_and_repeated_keys() {
    let mut refused = Refused::default();
    for pointer in ["", "/plant", "/controller", "/errors/0", "/claims/1/gain"] {
        let mut c = with_model_error();
        c.pointer_mut(pointer).unwrap().as_object_mut().unwrap().insert("Dyy".into(), json!([[0.0]]));
        refused.add(&path(&format!("{pointer}/Dyy")), &refusal(&c.to_string()));
    }
    let mut c = with_model_error();
    c["claims"][1] = json!({"ball": {}});
    refused.add("claims[1]", &refusal(&c.to_string()));
    let text = scheduled(0.75).to_string();
    let twice = text.replacen("\"gamma\":", "\"gamma\":9.0,\"gamma\":", 1);
    refused.add("claims[0].gain", &refusal(&twice));
    for key in ["By", "format", "claims", "blocks"] {
        let twice = text.replacen(&format!("\"{key}\":"), &format!("\"{key}\":[],\"{key}\":"), 1);
        refusal(&twice);
    }
    // Externally tagged claims keep the path to a number, which an internal tag would lose.
    let mut c = with_model_error();
    c["claims"][1]["gain"]["T"][1][0] = json!(null);
    refused.add("claims[1].gain.T[1][0]", &refusal(&c.to_string()));
    for list in [json!([1]), json!([c])] {
        refused.add("", &refusal(&list.to_string()));
    }
    // A claim is an object with one key.
    let both = text.replacen("{\"gain\":", "{\"rate\":{},\"gain\":", 1);
    assert_ne!(both, text);
    refused.add("claims[0].rate", &refusal(&both));
    insta::assert_snapshot!(refused.0);
}

#[test]
fn rejects_texts_that_are_no_certificate() {
    let text = scheduled(0.75).to_string();
    for bad in ["", "[]", "null", "{", "\"lpv-certificate/1\"", &text[..text.len() - 1], &format!("{text} 1")]
    {
        refusal(bad);
    }
    refusal(&"[".repeat(100_000));
    let mut refused = Refused::default();
    let mut c = scheduled(0.75);
    c["plant"]["D11"] = json!([]);
    refused.add("plant.D11", &refusal(&c.to_string()));
    c["plant"]["D11"] = json!([[]]);
    refused.add("plant.D11", &refusal(&c.to_string()));
    c["blocks"] = json!([999_999, 999_999]);
    c["plant"]["D11"] = json!([[0.0]]);
    refused.add("blocks", &refusal(&c.to_string()));
    insta::assert_snapshot!(refused.0);
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
    for failure in [c.to_json().unwrap_err(), c.prove().unwrap_err()] {
        assert!(is_at(&failure, "claims[0].gain.X[0][0]"), "{failure}");
    }
    let mut c = golden("lpv01");
    c.controller.a.pop();
    assert!(c.prove().is_err());
}
