//! Row of the verdict.

use crate::inputs::design_file::Sense;
use serde::{Deserialize, Deserializer, Serialize};
use squid_base::numbers::decimals;
use std::fmt::{self, Display, Formatter};

/// Result of comparing a figure with its requirement.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Outcome {
    /// The figure is on the right side of its limit.
    Met,
    /// The figure is on the wrong side of its limit, or unknown.
    Missed,
    /// There is no requirement.
    Reported,
}

/// Figure and its condition; NaN if it is unknown.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Figure {
    /// Value in the unit of its row.
    #[serde(deserialize_with = "or_unknown")]
    pub value: f64,
    /// Speed along the path, m/s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub speed: Option<f64>,
    /// Frequency, rad/s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frequency: Option<f64>,
    /// Remark: the point in the loop, or a reason.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub remark: Option<String>,
}

/// Reads a number, where null is NaN.
fn or_unknown<'de, D: Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
    Ok(Option::deserialize(from)?.unwrap_or(f64::NAN))
}

impl Figure {
    /// Returns a figure without a condition.
    pub(crate) fn new(value: f64) -> Self {
        Self { value, speed: None, frequency: None, remark: None }
    }

    /// Returns a figure at a speed (m/s).
    pub(crate) fn at(value: f64, speed: f64) -> Self {
        Self { speed: Some(speed), ..Self::new(value) }
    }

    /// Adds a remark.
    pub(crate) fn with_remark(self, remark: impl Into<String>) -> Self {
        Self { remark: Some(remark.into()), ..self }
    }

    /// Returns the worst of some figures; NaN is worse than any number.
    pub(crate) fn worst(sense: Sense, figures: impl IntoIterator<Item = Self>) -> Option<Self> {
        let badness = |v: f64| match sense {
            _ if v.is_nan() => f64::INFINITY,
            Sense::Below => v,
            Sense::Above => -v,
        };
        figures
            .into_iter()
            .reduce(|worst, next| if badness(next.value) > badness(worst.value) { next } else { worst })
    }

    /// Describes the condition at which the figure was found, with the remark.
    pub fn condition(&self) -> String {
        let mut parts = vec![];
        parts.extend(self.speed.map(|speed| format!("{speed:.2} m/s")));
        parts.extend(self.frequency.map(|omega| format!("{omega:.3} rad/s")));
        parts.extend(self.remark.clone());
        parts.join(", ")
    }
}

/// Row of the table.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Row {
    /// Key of the limit in `[require]`.
    pub key: &'static str,
    /// Name of the assessed figure.
    #[serde(rename = "what")]
    pub name: String,
    /// Unit of limit and figure.
    pub unit: &'static str,
    /// Required side of the limit.
    pub sense: Sense,
    /// Limit; `None` if there is no requirement.
    pub limit: Option<f64>,
    /// Worst figure found.
    pub achieved: Figure,
    /// Outcome: met, missed or only reported.
    pub outcome: Outcome,
    /// Advice for a missed row, if it was searched for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub advice: Option<Advice>,
}

/// Part of a row in `design.json` that is read back.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct StoredRow {
    /// Key of the limit in `[require]`.
    pub key: String,
    /// Name of the assessed figure.
    #[serde(rename = "what")]
    pub name: String,
    /// Worst figure found.
    pub achieved: Figure,
    /// Outcome: met, missed or only reported.
    pub outcome: Outcome,
    /// Advice for a missed row, if it was searched for.
    pub advice: Option<Advice>,
}

/// Advice on a change of the design file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Advice {
    /// Change of a key; `None` if no key improves the row.
    pub change: Option<KeyChange>,
    /// Text of the advice, with its benefit and its cost.
    pub text: String,
}

/// Change of one key.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct KeyChange {
    /// Name of the key, with the signal of its table.
    pub key: String,
    /// Factor on its number.
    pub factor: f64,
}

impl Display for Outcome {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Met => "met",
            Self::Missed => "MISSED",
            Self::Reported => "-",
        })
    }
}

/// Tolerance of rounding in a figure, in units of its last digit.
const EXACT: f64 = 1e-6;

/// Text of a figure with a suitable number of digits, rounded to the worse side, so that a bound remains a bound and
/// rounding never makes a figure meet its limit.
fn number(value: f64, sense: Sense) -> String {
    let digits = match value.abs() {
        _ if value.is_nan() => return "unknown".into(),
        f64::INFINITY if sense == Sense::Above => return "no limit".into(),
        f64::INFINITY => return "unbounded".into(),
        size if size >= 99.95 => 0,
        size if size >= 9.995 => 1,
        size if size >= 0.9995 => 2,
        _ => 3,
    };
    let unit = 0.1f64.powi(digits);
    let rounded = match sense {
        Sense::Below => (value / unit - EXACT).ceil(),
        Sense::Above => (value / unit + EXACT).floor(),
    };
    decimals(rounded * unit, digits as usize)
}

impl Row {
    /// Returns the requirement with its unit; empty if there is none.
    pub fn required(&self) -> String {
        let side = if self.sense == Sense::Below { "<" } else { ">" };
        self.limit.map_or_else(String::new, |limit| {
            format!("{side} {} {}", squid_auv::number(limit), self.unit).trim_end().to_owned()
        })
    }

    /// Returns the achieved figure with its unit.
    pub fn found(&self) -> String {
        let value = self.achieved.value;
        if value == f64::INFINITY && self.unit == "s" && self.sense == Sense::Below {
            return "not reached".into();
        }
        let unit = if value.is_finite() { self.unit } else { "" };
        format!("{} {unit}", number(value, self.sense)).trim_end().to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounds_figures_to_worse_side() {
        let of = |sense, value| number(value, sense);
        let below = [0.544_487, 0.481, 1.88, 9.996, 100.4, -0.0004, 1e-12].map(|v| of(Sense::Below, v));
        assert_eq!(below, ["0.545", "0.481", "1.88", "10.0", "101", "0.000", "0.000"]);
        let above = [44.98, 45.0, 0.1499, f64::INFINITY, f64::NAN].map(|v| of(Sense::Above, v));
        assert_eq!(above, ["44.9", "45.0", "0.149", "no limit", "unknown"]);
        assert_eq!(of(Sense::Below, f64::INFINITY), "unbounded");
    }

    #[test]
    fn reports_unsettled_step() {
        let achieved = Figure::new(f64::INFINITY);
        let row = Row {
            key: "pitch_settling",
            name: "pitch: settled within 2 %".into(),
            unit: "s",
            sense: Sense::Below,
            limit: Some(10.0),
            achieved,
            outcome: Outcome::Missed,
            advice: None,
        };
        insta::assert_snapshot!(row.found());
    }
}
