//! Statistics of the rows of a campaign.

use crate::flight::{ERROR, Outcome, Row};
use crate::plan::Plan;
use serde::Serialize;

/// Quantile of the normal distribution at 97.5 %, for an interval of 95 %.
const NORMAL: f64 = 1.959_963_984_540_054;

/// Printed quantiles.
pub const QUANTILES: [f64; 3] = [0.5, 0.95, 0.99];

/// Share of the flights with an outcome.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Share {
    /// Name of the [`Outcome`].
    pub outcome: &'static str,
    /// Number of flights.
    pub flights: usize,
    /// Fraction of all flights.
    pub share: f64,
    /// 95 % confidence interval of the probability: E. B. Wilson, J. American Statistical Association 22(158), 1927.
    pub interval: [f64; 2],
}

/// Distribution of a figure over all flights in which it is known.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Spread {
    /// Name, as in [`Plan::figures`].
    pub figure: String,
    /// Unit.
    pub unit: &'static str,
    /// Values at the [`QUANTILES`].
    pub quantiles: [f64; QUANTILES.len()],
    /// Largest value.
    pub largest: f64,
    /// Flight with the largest value.
    pub flight: u64,
    /// Drawn numbers with their rank correlation to the figure, strongest first.
    pub pushed_by: Vec<(String, f64)>,
}

/// Returns the shares of the outcomes.
pub fn shares(rows: &[Row]) -> Vec<Share> {
    let of = |outcome: Outcome| {
        let flights = rows.iter().filter(|row| row.outcome == outcome).count();
        let share = flights as f64 / rows.len().max(1) as f64;
        Share { outcome: outcome.word(), flights, share, interval: wilson(flights, rows.len()) }
    };
    Outcome::ALL.into_iter().map(of).collect()
}

/// Returns Wilson's confidence interval.
fn wilson(found: usize, of: usize) -> [f64; 2] {
    if of == 0 {
        return [0.0, 1.0];
    }
    let (n, p, z2) = (of as f64, found as f64 / of as f64, NORMAL * NORMAL);
    let middle = p + z2 / (2.0 * n);
    let half = NORMAL * (p * (1.0 - p) / n + z2 / (4.0 * n * n)).sqrt();
    [-1.0, 1.0].map(|side| ((middle + side * half) / (1.0 + z2 / n)).clamp(0.0, 1.0))
}

/// Returns the distribution of each figure.
pub fn spreads(plan: &Plan<'_>, rows: &[Row]) -> Vec<Spread> {
    let names: Vec<String> = plan.drawn().into_iter().map(|(name, _)| name).collect();
    let of = |(index, (figure, unit)): (usize, (String, &'static str))| {
        let mut known: Vec<(f64, &Row)> =
            rows.iter().map(|row| (row.figures[index], row)).filter(|(value, _)| !value.is_nan()).collect();
        known.sort_by(|(a, _), (b, _)| a.total_cmp(b));
        let (largest, row) = *known.last()?;
        let at = |part: f64| known[((known.len() - 1) as f64 * part).round() as usize].0;
        let ranked = ranks(&known.iter().map(|(value, _)| *value).collect::<Vec<_>>());
        let correlated = |(k, name): (usize, &String)| {
            let drawn: Vec<f64> = known.iter().map(|(_, row)| row.drawn[k]).collect();
            (name.clone(), correlation(&ranked, &ranks(&drawn)))
        };
        let mut pushed_by: Vec<(String, f64)> = names.iter().enumerate().map(correlated).collect();
        pushed_by.sort_by(|(_, a), (_, b)| b.abs().total_cmp(&a.abs()));
        Some(Spread { figure, unit, quantiles: QUANTILES.map(at), largest, flight: row.flight, pushed_by })
    };
    plan.figures().into_iter().enumerate().filter_map(of).collect()
}

/// Returns the worst flights, at most `count`, worst first: lost, then surfaced, then others, each group by decreasing
/// RMS error of the signal controlled by the first axis. Flights without figures are omitted.
pub fn worst(rows: &[Row], count: usize) -> Vec<&Row> {
    const ORDER: [Outcome; 3] = [Outcome::Lost, Outcome::Surfaced, Outcome::Flown];
    let rank = |row: &Row| ORDER.iter().position(|outcome| *outcome == row.outcome);
    let mut known: Vec<&Row> = rows.iter().filter(|row| !row.figures[ERROR].is_nan()).collect();
    known.sort_by(|a, b| rank(a).cmp(&rank(b)).then_with(|| b.figures[ERROR].total_cmp(&a.figures[ERROR])));
    known.truncate(count);
    known
}

/// Returns the rank of each value; equal values share their mean rank.
fn ranks(values: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|a, b| values[*a].total_cmp(&values[*b]));
    let mut ranks = vec![0.0; values.len()];
    let mut below = 0;
    for same in order.chunk_by(|a, b| values[*a] == values[*b]) {
        same.iter().for_each(|index| ranks[*index] = below as f64 + 0.5 * (same.len() - 1) as f64);
        below += same.len();
    }
    ranks
}

/// Returns Pearson's correlation; 0 if one is constant.
fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let (ma, mb) = (mean(a), mean(b));
    let sum = |of: &dyn Fn(f64, f64) -> f64| a.iter().zip(b).map(|(x, y)| of(x - ma, y - mb)).sum::<f64>();
    let size = (sum(&|x, _| x * x) * sum(&|_, y| y * y)).sqrt();
    if size > 0.0 { sum(&|x, y| x * y) / size } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ten out of a hundred: 0.1148 +- 0.0596.
    #[test]
    fn wilson_interval_of_ten_in_a_hundred() {
        let [low, high] = wilson(10, 100);
        assert!((low - 0.0552).abs() < 1e-3 && (high - 0.1744).abs() < 1e-3, "{low} {high}");
        assert_eq!(wilson(0, 10)[0], 0.0);
    }

    #[test]
    fn worst_flights_come_first() {
        let row = |flight, outcome, error| {
            let mut figures = vec![0.0; ERROR + 1];
            figures[ERROR] = error;
            Row { flight, outcome, drawn: vec![], figures }
        };
        let rows = [
            row(0, Outcome::Flown, 0.1),
            row(1, Outcome::Flown, 0.3),
            row(2, Outcome::Lost, 0.2),
            row(3, Outcome::NoTrim, f64::NAN),
            row(4, Outcome::Flown, 0.2),
        ];
        let flights = |count| worst(&rows, count).iter().map(|row| row.flight).collect::<Vec<_>>();
        assert_eq!((flights(10), flights(2)), (vec![2, 1, 4, 0], vec![2, 1]));
    }

    #[test]
    fn ranks_and_correlation() {
        assert_eq!(ranks(&[3.0, 1.0, 3.0, 2.0]), [2.5, 0.0, 2.5, 1.0]);
        assert_eq!(correlation(&ranks(&[1.0, 2.0, 3.0]), &ranks(&[1.0, 8.0, 27.0])), 1.0);
        assert_eq!(correlation(&[1.0, 1.0], &[0.0, 2.0]), 0.0);
    }
}
