//! An axis of a chart: its range, its ticks, and the words at the ticks.

use crate::page::words::tidy;

/// How values lie along an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scale {
    /// Evenly.
    Linear,
    /// By their logarithm.
    Logarithmic,
}

/// One axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    /// Quantity and unit.
    pub label: String,
    /// How values lie along it.
    pub scale: Scale,
    /// The range to show; what the curves need if none is given.
    pub range: Option<(f64, f64)>,
    /// The least that is shown where no range is given, in axis coordinates.
    pub least: f64,
}

impl Axis {
    /// A linear axis as long as the curves need.
    pub fn linear(label: impl Into<String>) -> Self {
        Self { label: label.into(), scale: Scale::Linear, range: None, least: 0.0 }
    }

    /// A logarithmic axis as long as the curves need.
    pub fn logarithmic(label: impl Into<String>) -> Self {
        Self { label: label.into(), scale: Scale::Logarithmic, range: None, least: 0.0 }
    }

    /// The same over a given range.
    #[must_use]
    pub fn over(mut self, from: f64, to: f64) -> Self {
        self.range = Some((from, to));
        self
    }

    /// The same, at least so long where no range is given.
    #[must_use]
    pub fn at_least(mut self, least: f64) -> Self {
        self.least = least;
        self
    }

    /// A value in axis coordinates: itself or its decimal logarithm; `None` where it has no place on the axis.
    pub fn place(&self, v: f64) -> Option<f64> {
        let placed = match self.scale {
            Scale::Linear => v,
            Scale::Logarithmic => v.log10(),
        };
        placed.is_finite().then_some(placed)
    }

    /// The range in axis coordinates, from the one given or from the places of all values, with some room when `roomy`.
    pub fn extent(&self, places: impl Iterator<Item = f64>, roomy: bool) -> (f64, f64) {
        if let Some((from, to)) = self.range
            && let (Some(from), Some(to)) = (self.place(from), self.place(to))
        {
            return (from, to);
        }
        let (low, high) = extent(places);
        if low > high {
            return (0.0, 1.0);
        }
        if high - low < self.least {
            let middle = 0.5 * (low + high);
            return (middle - 0.5 * self.least, middle + 0.5 * self.least);
        }
        let flat = high - low <= 1e-9 * high.abs().max(low.abs());
        let room = if flat { (0.1 * high.abs()).max(1e-6) } else { 0.06 * (high - low) };
        if roomy || flat { (low - room, high + room) } else { (low, high) }
    }

    /// The ticks within a range of axis coordinates, about `wanted` of them, with their words.
    pub fn words(&self, (from, to): (f64, f64), wanted: usize) -> Vec<(f64, String)> {
        let ticks = match self.scale {
            Scale::Linear => linear_ticks(from, to, wanted),
            Scale::Logarithmic => logarithmic_ticks(from, to, wanted),
        };
        ticks.into_iter().map(|tick| (tick, self.word(tick, (from, to), wanted))).collect()
    }

    /// The words at a tick, which is in axis coordinates.
    fn word(&self, tick: f64, (from, to): (f64, f64), wanted: usize) -> String {
        match self.scale {
            Scale::Linear => {
                let digits = (-step(to - from, wanted).log10().floor()).clamp(0.0, 9.0) as usize;
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

/// The least and the largest of some values; the other way round where there is none.
pub fn extent(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)))
}

/// Powers of ten beyond this one, up or down, are written with their exponent.
const LONGEST: f64 = 3.5;

/// A power of ten with its exponent raised.
fn power_of_ten(exponent: i32) -> String {
    let raised = |c: char| match c.to_digit(10) {
        Some(digit) => ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'][digit as usize],
        None => '⁻',
    };
    format!("10{}", exponent.to_string().chars().map(raised).collect::<String>())
}

/// 1, 2 or 5 times a power of ten, so that a range has about `wanted` steps.
fn step(range: f64, wanted: usize) -> f64 {
    let raw = (range / wanted.max(1) as f64).max(f64::MIN_POSITIVE);
    let power = 10f64.powf(raw.log10().floor());
    match raw / power {
        lead if lead < 1.5 => power,
        lead if lead < 3.5 => 2.0 * power,
        lead if lead < 7.5 => 5.0 * power,
        _ => 10.0 * power,
    }
}

fn linear_ticks(from: f64, to: f64, wanted: usize) -> Vec<f64> {
    let step = step(to - from, wanted);
    let (first, last) = ((from / step - 1e-9).ceil() as i64, (to / step + 1e-9).floor() as i64);
    (first..=last).map(|k| k as f64 * step).collect()
}

/// Decades where there are some, else 1, 2 and 5 of each.
fn logarithmic_ticks(from: f64, to: f64, wanted: usize) -> Vec<f64> {
    let decades = (from.floor() as i64)..=(to.ceil() as i64);
    let within = |t: &f64| (from - 1e-9..=to + 1e-9).contains(t);
    let whole: Vec<f64> = decades.clone().map(|k| k as f64).filter(within).collect();
    if whole.len() >= 3 {
        let every = whole.len().div_ceil(wanted.max(1));
        return whole.into_iter().step_by(every).collect();
    }
    let fine = decades.flat_map(|k| [1.0f64, 2.0, 5.0].map(|lead| k as f64 + lead.log10()));
    let fine: Vec<f64> = fine.filter(within).collect();
    if fine.len() >= 2 {
        return fine;
    }
    linear_ticks(10f64.powf(from), 10f64.powf(to), wanted).into_iter().map(f64::log10).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_numbers_inside_the_range() {
        assert_eq!(linear_ticks(-0.3, 10.2, 5), vec![0.0, 2.0, 4.0, 6.0, 8.0, 10.0]);
        assert_eq!(linear_ticks(0.5, 3.0, 5), vec![0.5, 1.0, 1.5, 2.0, 2.5, 3.0]);
        assert_eq!(logarithmic_ticks(-2.0, 1.0, 5), vec![-2.0, -1.0, 0.0, 1.0]);
        assert_eq!(logarithmic_ticks(-0.1, 0.8, 5).len(), 3, "1, 2 and 5");
    }

    #[test]
    fn words_have_the_digits_that_they_need() {
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
    fn a_constant_has_room_and_no_value_has_an_axis() {
        let (low, high) = Axis::linear("").extent([2.0, 2.0].into_iter(), false);
        assert!(low < 2.0 && high > 2.0);
        assert_eq!(Axis::linear("").at_least(4.0).extent([2.0, 2.5].into_iter(), true), (0.25, 4.25));
        assert_eq!(Axis::linear("").extent(std::iter::empty(), true), (0.0, 1.0));
        assert_eq!(Axis::logarithmic("").place(0.0), None);
    }
}
