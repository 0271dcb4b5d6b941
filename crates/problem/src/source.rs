//! JSON text with its name in messages.

use crate::error::Error;
use serde::de::DeserializeOwned;
use squid_base::files;
use squid_certificate::{JsonError, from_json};
use std::fmt::Display;
use std::path::Path;

/// JSON text and its name.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Source {
    /// Name of the file or function, for messages.
    pub name: String,
    /// The text.
    pub text: String,
}

impl Source {
    /// Reads a file.
    ///
    /// # Errors
    /// [`Error::File`] if the file cannot be read.
    pub fn read(path: &Path) -> Result<Self, Error> {
        Ok(Self { name: path.display().to_string(), text: files::read(path)? })
    }

    /// Returns an error about `key`; an empty key is omitted.
    pub fn wrong(&self, key: &str, reason: impl Display) -> Error {
        let shown = if key.is_empty() { String::new() } else { format!("'{key}' ") };
        let reason = format!("{shown}{reason}");
        Error::Problem { file: self.name.clone(), line: None, key: key.into(), reason }
    }

    /// Returns an error about a key in the wrong object; `place` names the right one.
    pub fn misplaced(&self, key: &str, place: &str) -> Error {
        self.wrong(key, format!("is misplaced; it belongs {place}"))
    }

    /// Parses the text as strictly as a certificate.
    ///
    /// # Errors
    /// [`Error::Problem`] with line and path.
    pub fn json<T: DeserializeOwned>(&self) -> Result<T, Error> {
        from_json(&self.text).map_err(|error| {
            let JsonError { path, line, column, reason, is_json } = error;
            let reason = match (is_json, unknown(&reason)) {
                (true, Some(reason)) => format!("'{path}' {reason}"),
                (true, None) if path.is_empty() => format!("{reason} (column {column})"),
                (true, None) => format!("'{path}': {reason} (column {column})"),
                (false, _) => {
                    format!("invalid JSON: {reason} (column {column}){}", self.advice(line, column, &reason))
                }
            };
            // An unknown part of the path is a question mark.
            let key = path.trim_end_matches(['.', '?']).to_owned();
            Error::Problem { file: self.name.clone(), line: Some(line), key, reason }
        })
    }

    /// Returns a hint for a number that is not finite: JSON has none, but Python writes `Infinity`, others 1e999.
    fn advice(&self, line: usize, column: usize, reason: &str) -> &'static str {
        let line = self.text.lines().nth(line.saturating_sub(1)).unwrap_or_default();
        let here: String = line.chars().skip(column.saturating_sub(4)).take(12).collect();
        let infinite = ["Infinity", "NaN", "nan", "inf"].iter().any(|word| here.contains(word));
        if infinite || reason.starts_with("number out of range") {
            "; all numbers must be finite (a weight that is infinite at high frequency is improper)"
        } else {
            ""
        }
    }
}

/// First comment key in the list of known keys.
const FIRST_NOTE: &str = "kind";

/// Keys, and the object that they belong to.
const PLACES: [(&[&str], &str); 3] = [
    (&["blocks", "rate"], "next to a plant 'P' with parameters, in 'data'"),
    (&["dt"], "next to the plant, in 'data'"),
    (&["K", "sample_time", "delay", "held"], "in the file of a sampled loop"),
];

/// Returns the message about an unknown key, with a similar known key or the object that it belongs to; `None` for
/// other errors. Comment keys are not suggested.
fn unknown(reason: &str) -> Option<String> {
    let mut keys = reason.strip_prefix("unknown field `")?.split('`').step_by(2);
    let key = keys.next().unwrap_or_default();
    let known: Vec<&str> = keys.take_while(|known| !known.is_empty() && *known != FIRST_NOTE).collect();
    let place = PLACES.iter().find(|(keys, _)| keys.contains(&key)).map(|(_, place)| *place);
    let near = known.iter().find(|known| is_near(key, known));
    let advice = match (near, place) {
        (Some(near), _) => format!("; did you mean '{near}'?"),
        (None, Some(place)) => format!("; it belongs {place}"),
        (None, None) => String::new(),
    };
    Some(format!("is unknown{advice} (allowed: {})", known.join(", ")))
}

/// Returns `true` if two text differ only in case or, if long enough, in one letter.
fn is_near(found: &str, word: &str) -> bool {
    const LONG: usize = 4;
    found.eq_ignore_ascii_case(word) || (word.len() >= LONG && strsim::levenshtein(found, word) == 1)
}
