//! Findings: values of a file, a model or a loop that are improbable, insufficient or not proved.

use serde::{Deserialize, Serialize};
use std::fmt::{self, Display, Formatter};

/// Finding: what was found, as data for programs, with the sentence for people.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Finding {
    /// Kind of the finding, in snake case.
    pub kind: String,
    /// File of the key.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub file: Option<String>,
    /// Key in a file, or name of the quantity or component.
    pub key: String,
    /// Value of the quantity, if there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub value: Option<f64>,
    /// Unit of value and limit, as in the file; empty for a ratio.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub unit: String,
    /// Value that would not be reported.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub limit: Option<f64>,
    /// Speed at which the finding is worst, m/s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub speed: Option<f64>,
    /// Sentence for people: the finding, the cause, and the remedy.
    pub why: String,
}

impl Finding {
    /// Returns a finding without a value.
    pub fn new(kind: &str, key: &str, why: impl Into<String>) -> Self {
        Self { kind: kind.into(), key: key.into(), why: why.into(), ..Self::default() }
    }

    /// Sets the value and its unit.
    #[must_use]
    pub fn value(self, value: f64, unit: &str) -> Self {
        Self { value: Some(value), unit: unit.into(), ..self }
    }

    /// Sets the limit, in the unit of the value.
    #[must_use]
    pub fn limit(self, limit: f64) -> Self {
        Self { limit: Some(limit), ..self }
    }

    /// Sets the speed, m/s.
    #[must_use]
    pub fn speed(self, speed: f64) -> Self {
        Self { speed: Some(speed), ..self }
    }

    /// Sets the file of the key.
    #[must_use]
    pub fn file(self, file: &str) -> Self {
        Self { file: Some(file.into()), ..self }
    }
}

impl Display for Finding {
    /// Writes the sentence, after the name of the file if there is one.
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        self.file.iter().try_for_each(|file| write!(f, "{file}: "))?;
        f.write_str(&self.why)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Missing parts are not written, and written ones are read back.
    #[test]
    fn json_has_only_what_is_known() {
        let bare = Finding::new("not_proved", "depth", "the proof fails");
        let json = serde_json::to_value(&bare).unwrap();
        assert_eq!(json.as_object().unwrap().len(), 3);
        let full = bare.value(40.0, "deg").limit(30.0).speed(1.5).file("design.toml");
        let text = serde_json::to_string(&full).unwrap();
        assert_eq!(serde_json::from_str::<Finding>(&text).unwrap(), full);
        assert_eq!((full.value, full.limit, full.speed), (Some(40.0), Some(30.0), Some(1.5)));
    }
}

/// The example of the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
