//! Axis of a chart: range, ticks, and tick labels.

use crate::page::tidy;

/// Scale of an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scale {
    /// Linear.
    Linear,
    /// Logarithmic.
    Logarithmic,
}

/// Axis of a chart.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    /// Quantity and unit.
    pub label: String,
    /// Scale.
    pub scale: Scale,
    /// Displayed range; that of the curves by default.
    pub range: Option<(f64, f64)>,
    /// Smallest length of the default range, in axis coordinates.
    pub least: f64,
    /// `true` if a unit has the same length on the page as one of the other axis.
    pub is_equal: bool,
}

impl Axis {
    /// Creates a linear axis with the range of the curves.
    pub fn linear(label: impl Into<String>) -> Self {
        Self { label: label.into(), scale: Scale::Linear, range: None, least: 0.0, is_equal: false }
    }

    /// Creates a logarithmic axis with the range of the curves.
    pub fn logarithmic(label: impl Into<String>) -> Self {
        Self { label: label.into(), scale: Scale::Logarithmic, range: None, least: 0.0, is_equal: false }
    }

    /// Returns this axis with a given range.
    #[must_use]
    pub fn over(mut self, from: f64, to: f64) -> Self {
        self.range = Some((from, to));
        self
    }

    /// Returns this axis with units of the same length on the page as those of the other axis.
    #[must_use]
    pub fn equal(mut self) -> Self {
        self.is_equal = true;
        self
    }

    /// Returns this axis with a smallest length of its default range.
    #[must_use]
    pub fn at_least(mut self, least: f64) -> Self {
        self.least = least;
        self
    }

    /// Converts a value to axis coordinates: itself or its decimal logarithm; `None` if that is not finite.
    pub fn place(&self, v: f64) -> Option<f64> {
        let placed = match self.scale {
            Scale::Linear => v,
            Scale::Logarithmic => v.log10(),
        };
        placed.is_finite().then_some(placed)
    }

    /// Returns the range in axis coordinates, given or from the coordinates of all values, with padding if `padded`.
    pub fn extent(&self, coordinates: impl Iterator<Item = f64>, padded: bool) -> (f64, f64) {
        if let Some((from, to)) = self.range
            && let (Some(from), Some(to)) = (self.place(from), self.place(to))
        {
            return (from, to);
        }
        let (low, high) = extent(coordinates);
        if low > high {
            return (0.0, 1.0);
        }
        if high - low < self.least {
            let middle = 0.5 * (low + high);
            return (middle - 0.5 * self.least, middle + 0.5 * self.least);
        }
        let flat = high - low <= 1e-9 * high.abs().max(low.abs());
        let padding = if flat { (0.1 * high.abs()).max(1e-6) } else { 0.06 * (high - low) };
        if padded || flat { (low - padding, high + padding) } else { (low, high) }
    }

    /// Returns about `count` ticks within a range of axis coordinates, with their labels.
    pub fn labels(&self, (from, to): (f64, f64), count: usize) -> Vec<(f64, String)> {
        let ticks = match self.scale {
            Scale::Linear => linear_ticks(from, to, count),
            Scale::Logarithmic => logarithmic_ticks(from, to, count),
        };
        ticks.into_iter().map(|tick| (tick, self.word(tick, (from, to), count))).collect()
    }

    /// Returns the label of a tick in axis coordinates.
    fn word(&self, tick: f64, (from, to): (f64, f64), count: usize) -> String {
        match self.scale {
            Scale::Linear => {
                let digits = (-step(to - from, count).log10().floor()).clamp(0.0, 9.0) as usize;
                tidy(tick, digits)
            }
            Scale::Logarithmic => {
                let value = 10f64.powf(tick);
                if tick.abs() > LONGEST && (tick - tick.round()).abs() < 1e-9 {
                    return power_of_ten(tick.round() as i32);
                }
                tidy(value, (1.0 - tick.floor()).clamp(0.0, 9.0) as usize)
            }
        }
    }
}

/// Returns the minimum and maximum of values; infinity and its negative if there are none.
pub fn extent(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)))
}

/// Largest magnitude of the exponent of a power of ten that is written without exponent.
const LONGEST: f64 = 3.5;

/// Returns a power of ten with a superscript exponent.
fn power_of_ten(exponent: i32) -> String {
    let raised = |c: char| match c.to_digit(10) {
        Some(digit) => ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'][digit as usize],
        None => '⁻',
    };
    format!("10{}", exponent.to_string().chars().map(raised).collect::<String>())
}

/// Returns the step, 1, 2 or 5 times a power of ten, that divides a range into about `count` steps.
fn step(range: f64, count: usize) -> f64 {
    let raw = (range / count.max(1) as f64).max(f64::MIN_POSITIVE);
    let power = 10f64.powf(raw.log10().floor());
    match raw / power {
        lead if lead < 1.5 => power,
        lead if lead < 3.5 => 2.0 * power,
        lead if lead < 7.5 => 5.0 * power,
        _ => 10.0 * power,
    }
}

fn linear_ticks(from: f64, to: f64, count: usize) -> Vec<f64> {
    let step = step(to - from, count);
    let (first, last) = ((from / step - 1e-9).ceil() as i64, (to / step + 1e-9).floor() as i64);
    (first..=last).map(|k| k as f64 * step).collect()
}

/// Returns decades if there are at least three, otherwise 1, 2 and 5 in each.
fn logarithmic_ticks(from: f64, to: f64, count: usize) -> Vec<f64> {
    let decades = (from.floor() as i64)..=(to.ceil() as i64);
    let within = |t: &f64| (from - 1e-9..=to + 1e-9).contains(t);
    let powers: Vec<f64> = decades.clone().map(|k| k as f64).filter(within).collect();
    if powers.len() >= 3 {
        let every = powers.len().div_ceil(count.max(1));
        return powers.into_iter().step_by(every).collect();
    }
    let fine = decades.flat_map(|k| [1.0f64, 2.0, 5.0].map(|lead| k as f64 + lead.log10()));
    let fine: Vec<f64> = fine.filter(within).collect();
    if fine.len() >= 2 {
        return fine;
    }
    linear_ticks(10f64.powf(from), 10f64.powf(to), count).into_iter().map(f64::log10).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_numbers_within_range() {
        assert_eq!(linear_ticks(-0.3, 10.2, 5), vec![0.0, 2.0, 4.0, 6.0, 8.0, 10.0]);
        assert_eq!(linear_ticks(0.5, 3.0, 5), vec![0.5, 1.0, 1.5, 2.0, 2.5, 3.0]);
        assert_eq!(logarithmic_ticks(-2.0, 1.0, 5), vec![-2.0, -1.0, 0.0, 1.0]);
        assert_eq!(logarithmic_ticks(-0.1, 0.8, 5).len(), 3, "1, 2 and 5");
    }

    #[test]
    fn labels_have_sufficient_digits() {
        let axis = Axis::linear("");
        assert_eq!(axis.word(0.5, (0.0, 3.0), 5), "0.5");
        assert_eq!(axis.word(-0.0, (-1.0, 1.0), 5), "0");
        assert_eq!(axis.word(200.0, (0.0, 1000.0), 5), "200");
        let axis = Axis::logarithmic("");
        assert_eq!(axis.word(-2.0, (-2.0, 1.0), 5), "0.01");
        assert_eq!(axis.word(2.0, (-2.0, 2.0), 5), "100");
        assert_eq!(axis.word(-16.0, (-20.0, 2.0), 5), "10⁻¹⁶");
        assert_eq!(axis.word(5f64.log10(), (0.0, 1.0), 5), "5");
    }

    #[test]
    fn extent_of_constant_and_of_no_values() {
        let (low, high) = Axis::linear("").extent([2.0, 2.0].into_iter(), false);
        assert!(low < 2.0 && high > 2.0);
        assert_eq!(Axis::linear("").at_least(4.0).extent([2.0, 2.5].into_iter(), true), (0.25, 4.25));
        assert_eq!(Axis::linear("").extent(std::iter::empty(), true), (0.0, 1.0));
        assert_eq!(Axis::logarithmic("").place(0.0), None);
    }
}
