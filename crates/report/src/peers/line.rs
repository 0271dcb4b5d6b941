//! A row of a comparison: a figure of several control laws or designs, and which of them is better.

/// Figures with a smaller difference, relative to the larger, are a draw.
pub(crate) const DRAW: f64 = 0.02;

/// The names of the control laws compared and the rows, or, in words, why there is no comparison.
pub type Flights = Result<(Vec<&'static str>, Vec<Line>), String>;

/// A figure at a speed for each law; smaller is better unless `largest`. NaN where a law has no such figure.
#[derive(Debug, Clone, PartialEq)]
pub struct Line {
    /// The figure, with its unit.
    pub name: &'static str,
    /// The speed (m/s), or the course.
    pub at: String,
    /// Decimals that are shown.
    pub decimals: usize,
    /// The largest insignificant difference.
    pub slight: f64,
    /// Whether the largest is best.
    pub largest: bool,
    /// Reported but not compared.
    pub reported: bool,
    /// One for each law; the first is that of the report's design.
    pub values: Vec<f64>,
}

/// The outcomes of a row.
pub(crate) const WON: &str = "won";
pub(crate) const DRAWN: &str = "drawn";
pub(crate) const LOST: &str = "lost";

impl Line {
    /// A compared figure; the smallest is best.
    pub fn new(name: &'static str, at: &str, decimals: usize, slight: f64, values: Vec<f64>) -> Self {
        Self { name, at: at.into(), decimals, slight, largest: false, reported: false, values }
    }

    /// Whether it is a figure of the speed, which not every design tracks.
    pub fn is_of_speed(&self) -> bool {
        self.name.starts_with("speed step") || self.name.starts_with("largest speed error")
    }

    /// The values as text.
    pub fn cells(&self) -> impl Iterator<Item = String> {
        self.values.iter().map(|v| match v {
            v if v.is_nan() => "-".into(),
            v if v.is_finite() => format!("{v:.*}", self.decimals),
            _ => "none".into(),
        })
    }

    /// Name, speed, values, and the outcome against each law but the first.
    pub fn row(&self) -> Vec<String> {
        let outcomes = (1..self.values.len()).map(|i| self.outcome(i).to_owned());
        [self.name.to_owned(), self.at.clone()].into_iter().chain(self.cells()).chain(outcomes).collect()
    }

    /// The outcome of the first law against another; empty if the two are not compared.
    pub fn outcome(&self, other: usize) -> &'static str {
        self.against(self.values[0], self.values[other])
    }

    /// The places of the best figure and of those that are drawn with it.
    pub fn best(&self) -> Vec<usize> {
        let all = || 0..self.values.len();
        let worse = |i: &usize| all().any(|other| self.against(self.values[*i], self.values[other]) == LOST);
        all().filter(|i| self.against(self.values[*i], self.values[*i]) == DRAWN && !worse(i)).collect()
    }

    /// The outcome of one figure against another.
    fn against(&self, ours: f64, other: f64) -> &'static str {
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

/// How many rows the first law wins, draws and loses against another, in words.
pub(crate) fn score(lines: &[Line], other: usize, against: &str, ours: &str) -> String {
    let count = |outcome: &str| lines.iter().filter(|line| line.outcome(other) == outcome).count();
    let [won, drawn, lost] = [WON, DRAWN, LOST].map(count);
    format!("Against {against} {ours} wins {won} rows, draws {drawn} and loses {lost}.")
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
            let line = Line { largest, ..Line::new("", "", 1, 0.5, vec![ours, other]) };
            assert_eq!(line.outcome(1), expected, "{ours} {other}");
        }
    }

    #[test]
    fn the_best_and_what_is_drawn_with_it() {
        let best = |values: &[f64]| Line::new("", "", 1, 0.0, values.to_vec()).best();
        assert_eq!(best(&[3.0, 1.0, 2.0, 1.01]), [1, 3]);
        assert_eq!(best(&[f64::NAN, 2.0, f64::INFINITY]), [1]);
        assert_eq!(Line { largest: true, ..Line::new("", "", 1, 0.0, vec![3.0, 1.0]) }.best(), [0]);
        // Where drawn is not passed on: 1.015 is drawn with both, and the first is not beaten by it.
        assert_eq!(best(&[1.0, 1.015, 1.03]), [0, 1]);
        assert!(Line { reported: true, ..Line::new("", "", 1, 0.0, vec![3.0, 1.0]) }.best().is_empty());
    }
}
