//! Strict JSON reader: types must match, no key may occur twice or be unknown, and every number must be a finite f64.

use serde::de::{Deserialize, DeserializeOwned, Deserializer};
use std::fmt;

/// First error of a text.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct JsonError {
    /// Path to the value, such as `plant.A[0][1]`; empty for the document itself.
    pub path: String,
    /// Line of the text, from 1.
    pub line: usize,
    /// Column, from 1.
    pub column: usize,
    /// Found value and allowed values.
    pub reason: String,
    /// `true` if the text is JSON with finite numbers.
    pub is_json: bool,
}

impl std::error::Error for JsonError {}

impl fmt::Display for JsonError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { path, line, column, reason, is_json } = self;
        let path = if path.is_empty() { String::new() } else { format!("{path}: ") };
        let not_json = if *is_json { "" } else { "this is not JSON with finite numbers: " };
        write!(f, "{path}{not_json}{reason} (line {line}, column {column})")
    }
}

/// Reads a text.
///
/// # Errors
/// [`JsonError`], the first error.
pub fn from_json<T: DeserializeOwned>(text: &str) -> Result<T, JsonError> {
    // serde would read a list as a struct with its fields in order.
    if text.trim_start().starts_with('[') {
        let (path, reason) = (String::new(), "found a list; it must be an object".into());
        return Err(JsonError { path, line: 1, column: 1, reason, is_json: true });
    }
    let mut json = serde_json::Deserializer::from_str(text);
    let read = serde_path_to_error::deserialize(&mut json)
        .map_err(|error| (known_part(&error.path().to_string()).to_owned(), error.into_inner()));
    let read = read.and_then(|value| json.end().map(|()| value).map_err(|error| (String::new(), error)));
    read.map_err(|(path, error)| {
        let (line, column) = (error.line(), error.column());
        let reason = error.to_string();
        let position = format!(" at line {line} column {column}");
        // Serde takes a value of another type than its enum for an error of syntax.
        let is_json = error.is_data() || serde_json::from_str::<serde_json::Value>(text).is_ok();
        let reason = match reason.strip_suffix(&position).unwrap_or(&reason) {
            "expected value" if is_json => "expected a string, or an object with one key".to_owned(),
            reason => in_json_terms(reason),
        };
        JsonError { path, line, column, reason, is_json }
    })
}

/// Returns a path without a separator in front, and without unknown parts, `?`, at its end.
fn known_part(path: &str) -> &str {
    path.trim_start_matches('.').trim_end_matches(['.', '?'])
}

/// Replaces the type names of serde by those of JSON.
fn in_json_terms(reason: &str) -> String {
    const TERMS: [(&str, &str); 6] = [
        ("expected f64", "expected a number"),
        ("expected usize", "expected a non-negative integer"),
        ("expected a sequence", "expected a list"),
        ("an array of length", "a list of length"),
        ("type: sequence", "type: a list"),
        ("type: map", "type: an object"),
    ];
    let reason = match reason.split_once("expected struct ") {
        Some((found, _)) => format!("{found}expected an object"),
        None => reason.to_owned(),
    };
    TERMS.iter().fold(reason, |reason, (serde_name, json_name)| reason.replace(serde_name, json_name))
}

/// Reads a value that may be missing but not `null`; for `deserialize_with` on a field with `default`.
///
/// # Errors
/// Errors of the value.
pub fn given<'de, T: Deserialize<'de>, D: Deserializer<'de>>(json: D) -> Result<Option<T>, D::Error> {
    T::deserialize(json).map(Some)
}
