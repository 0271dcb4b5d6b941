//! Checks that the frozen files of a design are those that vehicle and design file give.
//!
//! A certificate is about the controller's matrices. The FMU also multiplies by scales, adds trims, saturates at limits
//! and runs at a sample time. This module recomputes these, so that no proof is reported for a controller flown with
//! other values.

use crate::error::{Error, StoreError};
use crate::fit::Model;
use crate::inputs::Inputs;
use crate::store::freeze::{Frozen, frozen};
use crate::synthesise::given::matrices;
use serde::Serialize;
use serde_json::{Map, Value};
use squid_auv::LpvModel;
use squid_scheduled::ControllerDesign;

/// Tolerance of a number against the recomputed one, for rounding on another processor.
const ROUNDING_TOLERANCE: f64 = 1e-8;

/// Number of characters of a value shown in a message.
const SHOWN_CHARACTERS: usize = 80;

/// Compares all frozen values except gamma and the matrices of a computed controller, which are in the certificate, the
/// anti-windup, which is in its claim `limits` if there is one, and the gains of following, about which nothing is
/// claimed.
///
/// # Errors
/// [`StoreError::Edited`] with the first key that differs; the errors of freezing.
pub fn check(
    controller: &ControllerDesign,
    plant: Option<&LpvModel>,
    inputs: &Inputs,
    model: &Model,
) -> Result<(), Error> {
    let given = matrices(&inputs.vehicle.actuators, &inputs.design)?;
    let (lft, gamma) = (given.unwrap_or_else(|| controller.lft.clone()), controller.gamma.clone());
    let mut expected: Frozen = frozen(inputs, model, lft, gamma)?;
    expected.controller.anti_windup.clone_from(&controller.anti_windup);
    expected.controller.follow.clone_from(&controller.follow);
    compare("controller.json", controller, &expected.controller)?;
    compare("plant.json", &plant, &expected.plant.as_ref())
}

fn compare<T: Serialize>(file: &'static str, found: &T, expected: &T) -> Result<(), Error> {
    let json = |value: &T| serde_json::to_value(value).unwrap_or(Value::Null);
    match first_difference("", &json(found), &json(expected)) {
        None => Ok(()),
        Some((key, found, expected)) => Err(StoreError::Edited { file, key, found, expected }.into()),
    }
}

/// Returns the first key at which two values differ, with both values.
fn first_difference(key: &str, found: &Value, expected: &Value) -> Option<(String, String, String)> {
    let differs = || Some((key.to_owned(), shown(found), shown(expected)));
    match (found, expected) {
        (Value::Object(a), Value::Object(b)) => {
            let missing = b.iter().filter(|(name, _)| !a.contains_key(*name));
            a.iter().chain(missing).find_map(|(name, _)| {
                let of = |object: &Map<String, Value>| object.get(name).cloned().unwrap_or_default();
                let below = if key.is_empty() { name.clone() } else { format!("{key}.{name}") };
                first_difference(&below, &of(a), &of(b))
            })
        }
        (Value::Array(a), Value::Array(b)) if a.len() == b.len() => {
            let mut pairs = a.iter().zip(b).enumerate();
            pairs.find_map(|(index, (a, b))| first_difference(&format!("{key}[{index}]"), a, b))
        }
        (Value::Number(a), Value::Number(b)) => {
            let (a, b) = (a.as_f64()?, b.as_f64()?);
            if (a - b).abs() > ROUNDING_TOLERANCE * b.abs().max(1.0) { differs() } else { None }
        }
        _ if found == expected => None,
        _ => differs(),
    }
}

/// Text of a value in a message: a long value is cut, a missing one is null.
fn shown(value: &Value) -> String {
    let text = value.to_string();
    match text.char_indices().nth(SHOWN_CHARACTERS) {
        Some((end, _)) => format!("{} ...", &text[..end]),
        None => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn names_first_difference() {
        let value = json!({"a": 1.0, "b": [{"c": "x"}, {"c": 2.0}]});
        assert_eq!(first_difference("", &value, &value), None);
        let rounded = json!({"a": 1.0 + 1e-12, "b": [{"c": "x"}, {"c": 2.0}]});
        assert_eq!(first_difference("", &rounded, &value), None);
        for (other, key) in [
            (json!({"a": 1.1, "b": [{"c": "x"}, {"c": 2.0}]}), "a"),
            (json!({"a": 1.0, "b": [{"c": "y"}, {"c": 2.0}]}), "b[0].c"),
            (json!({"a": 1.0, "b": [{"c": "x"}, {"c": 2.1}]}), "b[1].c"),
            (json!({"a": 1.0, "b": [{"c": "x"}]}), "b"),
            (json!({"a": 1.0}), "b"),
            (json!({"a": 1.0, "b": [{"c": "x"}, {"c": 2.0}], "d": vec![1; 99]}), "d"),
        ] {
            let (named, found, expected) = first_difference("", &other, &value).unwrap();
            assert_eq!(named, key);
            assert!(found.len() < 100 && expected.len() < 100, "{found} {expected}");
        }
    }
}
