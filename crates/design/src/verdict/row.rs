//! A row of the verdict.

use crate::inputs::design_file::Sense;
use crate::numbers::decimals;
use serde::{Deserialize, Deserializer, Serialize};
use std::fmt::{self, Display, Formatter};

/// Whether a figure is what was asked.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Outcome {
    /// On the right side of its limit.
    Met,
    /// Not so, or not known.
    Missed,
    /// Nothing was asked.
    Reported,
}

/// A figure, and where it was found; not-a-number for one that is not known.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Figure {
    /// In the unit of its row.
    #[serde(deserialize_with = "or_unknown")]
    pub value: f64,
    /// Speed along the path, m/s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub speed: Option<f64>,
    /// rad/s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frequency: Option<f64>,
    /// What else there is to say: the place in the loop, a reason.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub remark: Option<String>,
}

/// A number; what JSON has for one that is none is not-a-number.
fn or_unknown<'de, D: Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
    Ok(Option::deserialize(from)?.unwrap_or(f64::NAN))
}

impl Figure {
    /// A figure of the whole.
    pub(crate) fn new(value: f64) -> Self {
        Self { value, speed: None, frequency: None, remark: None }
    }

    /// One at a speed (m/s).
    pub(crate) fn at(value: f64, speed: f64) -> Self {
        Self { speed: Some(speed), ..Self::new(value) }
    }

    /// The same with a remark.
    pub(crate) fn because(self, remark: impl Into<String>) -> Self {
        Self { remark: Some(remark.into()), ..self }
    }

    /// The worst of some figures, where not-a-number is worse than any number.
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

    /// Where it was found, and what else there is to say.
    pub fn place(&self) -> String {
        let mut words = vec![];
        words.extend(self.speed.map(|speed| format!("{speed:.2} m/s")));
        words.extend(self.frequency.map(|omega| format!("{omega:.3} rad/s")));
        words.extend(self.remark.clone());
        words.join(", ")
    }
}

/// A row of the table.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Row {
    /// The key of `[require]` that has its limit.
    pub key: &'static str,
    /// What is judged, in words.
    pub what: String,
    /// The unit of limit and figure.
    pub unit: &'static str,
    /// Which side of the limit is asked for.
    pub sense: Sense,
    /// The limit; `None` where nothing is asked.
    pub limit: Option<f64>,
    /// The worst of what was found.
    pub achieved: Figure,
    /// Met or missed.
    pub outcome: Outcome,
    /// What to turn, of a row that is missed, where that has been looked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub advice: Option<Advice>,
}

/// A row as `design.json` has it, as far as its figure goes.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct StoredRow {
    /// The key of `[require]` that has its limit.
    pub key: String,
    /// What is judged, in words.
    pub what: String,
    /// The worst of what was found.
    pub achieved: Figure,
    /// What to turn, of a row that is missed, where that has been looked for.
    pub advice: Option<Advice>,
}

/// What to turn in the design file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Advice {
    /// `None` where no key moves the row the right way.
    pub turn: Option<Turn>,
    /// The same for people, with what it gains and what it costs.
    pub words: String,
}

/// A key that was turned.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Turn {
    /// Its name, with the signal of its table.
    pub key: String,
    /// By what its number was multiplied; above 1: raise it.
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

/// What rounding may add to a figure without moving its last digit, in units of that digit.
const EXACT: f64 = 1e-6;

/// A figure with so many digits as tell it from its neighbours, rounded to the side that is worse: a bound stays one,
/// and no limit is met by rounding.
fn number(value: f64, sense: Sense) -> String {
    let digits = match value.abs() {
        _ if value.is_nan() => return "unknown".into(),
        f64::INFINITY => return "no limit".into(),
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
    /// What is asked, with its unit; empty where nothing is.
    pub fn asked(&self) -> String {
        let side = if self.sense == Sense::Below { "<" } else { ">" };
        self.limit.map_or_else(String::new, |limit| {
            format!("{side} {} {}", auv::number(limit), self.unit).trim_end().to_owned()
        })
    }

    /// What is achieved, with its unit.
    pub fn found(&self) -> String {
        let value = self.achieved.value;
        let unit = if value.is_finite() { self.unit } else { "" };
        format!("{} {unit}", number(value, self.sense)).trim_end().to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_are_rounded_to_the_side_that_is_worse() {
        let of = |sense, value| number(value, sense);
        let below = [0.544_487, 0.481, 1.88, 9.996, 100.4, -0.0004, 1e-12].map(|v| of(Sense::Below, v));
        assert_eq!(below, ["0.545", "0.481", "1.88", "10.0", "101", "0.000", "0.000"]);
        let above = [44.98, 45.0, 0.1499, f64::INFINITY, f64::NAN].map(|v| of(Sense::Above, v));
        assert_eq!(above, ["44.9", "45.0", "0.149", "no limit", "unknown"]);
    }
}
