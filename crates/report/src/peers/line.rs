//! Row of a comparison: a figure of several control laws or designs, and the better of them.

/// Largest difference, relative to the larger figure, that counts as a draw.
pub(crate) const DRAW: f64 = 0.02;

/// Figure at a speed for each law; smaller is better unless `largest`. NaN if a law has no such figure.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Line {
    /// Name of the figure, with its unit.
    pub name: String,
    /// Speed (m/s), or the course.
    pub at: String,
    /// Number of decimals shown.
    pub decimals: usize,
    /// Largest insignificant difference.
    pub slight: f64,
    /// `true` if the largest is best.
    pub largest: bool,
    /// `true` if reported but not compared.
    pub reported: bool,
    /// Value for each law; the first is that of the report's design.
    pub values: Vec<f64>,
}

/// Outcomes of a row.
const WON: &str = "won";
const DRAWN: &str = "drawn";
const LOST: &str = "lost";

impl Line {
    /// Creates a compared figure without values; the smallest is best.
    pub fn new(name: impl Into<String>, decimals: usize, slight: f64) -> Self {
        let (name, at, values) = (name.into(), String::new(), vec![]);
        Self { name, at, decimals, slight, largest: false, reported: false, values }
    }

    /// Returns figures at a speed or on a course, with the values of each law in the order of the figures.
    pub fn filled(figures: &[Self], at: &str, laws: &[Vec<f64>]) -> Vec<Self> {
        let values = |i: usize| laws.iter().map(|law| law[i]).collect();
        let each = figures.iter().enumerate();
        each.map(|(i, figure)| Self { at: at.into(), values: values(i), ..figure.clone() }).collect()
    }

    /// Returns name, speed, values, and the outcome against each law but the first.
    pub fn row(&self) -> Vec<String> {
        let cells = self.values.iter().map(|v| match v {
            v if v.is_nan() => "-".into(),
            v if v.is_finite() => format!("{v:.*}", self.decimals),
            _ => "none".into(),
        });
        let outcomes = (1..self.values.len()).map(|i| self.outcome(i).to_owned());
        [self.name.clone(), self.at.clone()].into_iter().chain(cells).chain(outcomes).collect()
    }

    /// Returns the outcome of the first law against another; empty if the two are not compared.
    fn outcome(&self, other: usize) -> &'static str {
        let (ours, other) = (self.values[0], self.values[other]);
        let gain = if self.largest { ours - other } else { other - ours };
        let tolerance = self.slight.max(DRAW * ours.abs().max(other.abs()));
        match gain {
            _ if self.reported || ours.is_nan() || other.is_nan() => "",
            _ if other == ours || (tolerance.is_finite() && gain.abs() <= tolerance) => DRAWN,
            gain if gain < 0.0 => LOST,
            _ => WON,
        }
    }
}

/// Returns the numbers of rows that the design wins, draws and loses against another law, as text.
pub(crate) fn score(lines: &[Line], other: usize, against: &str) -> String {
    let count = |outcome: &str| lines.iter().filter(|line| line.outcome(other) == outcome).count();
    let [won, drawn, lost] = [WON, DRAWN, LOST].map(count);
    format!("Against {against} the design wins {won} rows, draws {drawn} and loses {lost}.")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn outcomes_of_rows() {
        for (ours, other, largest, expected) in [
            (10.0, 12.0, false, "won"),
            (12.0, 10.0, false, "lost"),
            (12.0, 10.0, true, "won"),
            (100.0, 98.5, false, "drawn"),
            (0.1, 0.5, false, "drawn"),
            (f64::INFINITY, 1.0, false, "lost"),
            (1.0, f64::INFINITY, false, "won"),
            (f64::INFINITY, f64::INFINITY, false, "drawn"),
            (1.0, f64::NAN, false, ""),
            (f64::NAN, 1.0, false, ""),
        ] {
            let line = Line { largest, values: vec![ours, other], ..Line::new("", 1, 0.5) };
            assert_eq!(line.outcome(1), expected, "{ours} {other}");
        }
    }
}
