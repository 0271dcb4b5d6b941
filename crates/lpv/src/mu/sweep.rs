//! A bound on mu that holds at every frequency from 0 to infinity, not on a grid.
//!
//! Scalings found at one frequency, or for two, are good on an interval; frequencies are added where none is, until the
//! intervals cover the axis. Where no scalings reach the level sought the level is raised, by no more than it takes:
//! so it ends close above the largest of the bounds at single frequencies. Where that would take too many intervals,
//! because the bound is nearly the same over a wide range of frequencies, the level is raised faster and faster: a
//! sweep ends after a limited number of steps, with a bound that is guaranteed, or says where it has none.

use super::components::of_system;
use super::coordinates::{balanced, in_own_units};
pub use super::interval::response;
use super::interval::{Covered, Interval, good_interval, middle};
use super::structure::{Structure, StructureError};
use super::upper::DgScalings;
use super::upper::balance::Balance;
use super::upper::{BOUND_TOLERANCE, UpperBound, UpperBoundOptions, upper_bound_with};
use super::wide::{Shown, Wide};
use super::{CMat, lower};
use crate::matrix::{largest_complex_singular_value, spectral_abscissa};
use crate::stop;
use crate::system::state_space::StateSpace;
use nalgebra::Complex;
use thiserror::Error;

/// Where scalings show the bound.
#[derive(Debug, Clone, PartialEq)]
pub struct Piece {
    /// The frequency at which they were found, rad/s.
    pub frequency: f64,
    /// The bound that they show there alone.
    pub value: f64,
    /// Where they show the bound of the sweep.
    pub interval: Interval,
}

/// A bound for all frequencies.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct FrequencyBound {
    /// mu is below this at every frequency from 0 to infinity.
    pub upper: f64,
    /// The frequency with the largest bound of its own, rad/s.
    pub frequency: f64,
    /// Pieces whose intervals cover the axis, ascending; of a system whose channels fall into components, those of
    /// each.
    pub pieces: Vec<Piece>,
}

/// A sweep that came to no end.
#[derive(Debug, Clone, PartialEq, Error)]
#[allow(missing_docs, reason = "the message says what each field is")]
pub enum SweepError {
    /// The unperturbed loop is stable.
    #[error("the loop is unstable without any perturbation: a mode has real part {re:.3e}")]
    Unstable { re: f64 },
    /// M fits the structure.
    #[error(transparent)]
    Structure(#[from] StructureError),
    /// Intervals do not close.
    #[error("the bound could not be shown {} rad/s", range(*from, *to))]
    Stuck { from: f64, to: f64 },
}

/// A range, as one number where the digits shown are the same.
fn range(from: f64, to: f64) -> String {
    let [first, last] = [from, to].map(|v| format!("{v:.6e}"));
    if first == last { format!("near {first}") } else { format!("between {first} and {last}") }
}

/// By how much the level is above the largest bound at a single frequency.
const LEVEL_RAISE: f64 = 5e-5;

/// So many unknowns of scalings are easy. With more of them less is aimed at: that raise, and how close the bounds at
/// single frequencies are to the least ones, grow with the power 1.5.
const EASY_UNKNOWNS: f64 = 200.0;

/// An interval this much slower than every mode and this short, both relatively, raises the level by so much.
const SHORT_INTERVAL_RAISE: f64 = 2e-3;

/// By how much the level may be above the largest bound at a single frequency for the sake of scalings for two, where
/// there are so many intervals already.
const WIDE_RAISE: f64 = 5e-4;
const WIDE_COUNT: usize = 160;

/// A level below this is none: its square and the inverse of that are numbers with room to spare.
pub(super) const LEAST_LEVEL: f64 = 1e-60;

/// With more intervals than these each short one raises the level, by twice as much after so many further ones: many
/// where one is quickly found, as its cost grows with the states at least to the second power.
const EASY_COUNT: usize = 300;
const EASY_COST: usize = 100_000;
const HURRY_COUNT: usize = 100;

/// More steps than this are not made, nor so many that lead to no interval at all.
pub(super) const MOST_STEPS: usize = 4000;
pub(super) const MOST_FRUITLESS: usize = 20;

/// Bounds mu of `M(j omega)` over all frequencies. The bound need not go below one from below that is `known`; where
/// that was found is looked at, too.
///
/// # Errors
/// [`SweepError`].
pub fn bound_over_frequency(
    system: &StateSpace,
    structure: &Structure,
    known: Option<&lower::LowerBound>,
) -> Result<FrequencyBound, SweepError> {
    check_stable(system, structure)?;
    let mut all = FrequencyBound::default();
    for part in of_system(system, structure) {
        let own = balanced(&part.system(system), &part.structure);
        all.add(swept(&own, &part.structure, known)?);
    }
    Ok(all)
}

/// The bound of one component in balanced coordinates.
pub(super) fn swept(
    system: &StateSpace,
    structure: &Structure,
    known: Option<&lower::LowerBound>,
) -> Result<FrequencyBound, SweepError> {
    let mut sweep = Sweep::new(system, structure, known);
    sweep.start(known.and_then(|lower| lower.frequency))?;
    for _ in 0..MOST_STEPS {
        stop::check();
        let Some((from, to)) = sweep.covered.gap() else { return Ok(sweep.finish()) };
        sweep.add(middle(from, to))?;
        if sweep.fruitless > MOST_FRUITLESS {
            return Err(SweepError::Stuck { from, to });
        }
    }
    let (from, to) = sweep.covered.gap().unwrap_or((0.0, f64::INFINITY));
    Err(SweepError::Stuck { from, to })
}

/// That a loop is stable without perturbation, and fits the structure.
///
/// # Errors
/// [`SweepError::Unstable`]; [`SweepError::Structure`].
pub(super) fn check_stable(system: &StateSpace, structure: &Structure) -> Result<(), SweepError> {
    structure.check(&system.d.map(Complex::from))?;
    let re = spectral_abscissa(&in_own_units(system, structure).a);
    if !system.a.is_empty() && (re.is_nan() || re >= 0.0) {
        return Err(SweepError::Unstable { re });
    }
    Ok(())
}

impl Interval {
    /// By how much a short interval raises a level that `count` intervals show already, relatively, of a system with so
    /// many states.
    pub(super) fn hurry(&self, omega: f64, count: usize, states: usize) -> f64 {
        let beyond = count.saturating_sub(EASY_COUNT + EASY_COST / (states * states).max(1));
        let raise = SHORT_INTERVAL_RAISE * 2f64.powi((beyond / HURRY_COUNT) as i32);
        if beyond > 0 && self.is_short(omega) { raise } else { 0.0 }
    }
}

struct Sweep<'a> {
    system: &'a StateSpace,
    structure: &'a Structure,
    /// How much less is aimed at.
    coarse: f64,
    level: f64,
    peak: (f64, f64),
    pieces: Vec<Piece>,
    /// Where scalings were found.
    starts: Vec<(f64, DgScalings)>,
    covered: Covered,
    /// How many scalings showed the level on no interval.
    fruitless: usize,
    wide: Wide,
}

impl<'a> Sweep<'a> {
    fn new(system: &'a StateSpace, structure: &'a Structure, known: Option<&lower::LowerBound>) -> Self {
        let floor = known.map_or(0.0, |lower| lower.value);
        let coarse = (structure.unknowns() as f64 / EASY_UNKNOWNS).powf(1.5).max(1.0);
        Self {
            system,
            structure,
            coarse,
            level: floor * (1.0 + coarse * LEVEL_RAISE),
            peak: (known.and_then(|lower| lower.frequency).unwrap_or(0.0), floor),
            pieces: vec![],
            starts: vec![],
            covered: Covered::default(),
            fruitless: 0,
            wide: Wide::new(system),
        }
    }

    /// Looks at zero, infinity, the modes and where the peak is thought to be, so that the level is about right from
    /// the beginning.
    fn start(&mut self, peak: Option<f64>) -> Result<(), SweepError> {
        let mut points: Vec<f64> =
            self.system.poles().iter().map(|p| p.norm()).chain([0.0, f64::INFINITY]).collect();
        points.sort_by(f64::total_cmp);
        points.dedup_by(|a, b| (*a - *b).abs() <= 0.05 * b.abs());
        let mut largest = 0.0f64;
        for &omega in &points {
            let Some(m) = response(self.system, omega) else { continue };
            let m = Balance::new(&[m], self.structure).matrices;
            largest = m.iter().map(largest_complex_singular_value).fold(largest, f64::max);
        }
        // Real blocks may have a mu of zero almost everywhere.
        self.level = self.level.max(1e-6 * largest).max(LEAST_LEVEL);
        // The peak first: then few of the others ask for a higher level.
        for omega in peak.into_iter().chain(points) {
            self.add(omega)?;
        }
        Ok(())
    }

    fn note(&mut self, omega: f64, value: f64) {
        if value > self.peak.1 {
            self.peak = (omega, value);
        }
        self.level = self.level.max(value * (1.0 + self.coarse * LEVEL_RAISE));
    }

    fn add(&mut self, omega: f64) -> Result<(), SweepError> {
        if self.covered.holds(omega) {
            return Ok(());
        }
        let Some(m) = response(self.system, omega) else { return Ok(()) };
        let nearest = self.starts.iter().min_by(|a, b| (a.0 - omega).abs().total_cmp(&(b.0 - omega).abs()));
        let start = nearest.map(|(_, scalings)| scalings.clone());
        // Next to a short interval there are others: not even tried.
        if self.wide.is_first(omega) && self.widened(omega, start.as_ref())? {
            return Ok(());
        }
        let mut bound = self.bound(&m, start.as_ref())?;
        if bound.value >= self.level {
            // Nothing shows this level, so what was found is the least.
            self.note(omega, bound.value);
            bound = self.bound(&m, Some(&bound.start))?;
        }
        let Some(interval) = good_interval(self.system, &bound.scalings, self.level, omega) else {
            // The scalings hold with no clearance at all: a level that is a little higher has some.
            self.level *= 1.0 + self.coarse * LEVEL_RAISE;
            return Ok(());
        };
        if self.wide.is_next(omega, interval) && self.widened(omega, Some(&bound.start))? {
            return Ok(());
        }
        let is_one = self.covered.add(omega, interval);
        self.fruitless += usize::from(!is_one);
        if interval.is_short(omega) && (omega < self.wide.slow || !is_one) {
            // Slower than every mode nothing changes but the phase, which leaves zero: real blocks are easier to
            // bound at zero itself than next to it.
            self.level *= 1.0 + SHORT_INTERVAL_RAISE;
        } else {
            self.level *= 1.0 + interval.hurry(omega, self.covered.count(), self.system.a.nrows());
        }
        self.push(omega, interval, bound);
        Ok(())
    }

    fn bound(&self, m: &CMat, from: Option<&DgScalings>) -> Result<UpperBound, StructureError> {
        let asked = UpperBoundOptions { level: self.level, tight: self.coarse * BOUND_TOLERANCE, from };
        upper_bound_with(m, self.structure, asked)
    }

    /// Covers a frequency by scalings for two frequencies about it; whether there are such.
    fn widened(&mut self, omega: f64, start: Option<&DgScalings>) -> Result<bool, SweepError> {
        let ceiling = if self.covered.count() < WIDE_COUNT { 0.0 } else { self.peak.1 * (1.0 + WIDE_RAISE) };
        let levels = (self.level, ceiling);
        let gap = self.covered.around(omega);
        let shown = self.wide.shown((self.system, self.structure), levels, gap, omega, start)?;
        let Some(Shown { level, interval, bound }) = shown else { return Ok(false) };
        let is_one = self.covered.add(omega, interval);
        if is_one {
            self.level = level;
            self.push(omega, interval, bound);
        }
        Ok(is_one)
    }

    fn push(&mut self, frequency: f64, interval: Interval, UpperBound { value, scalings, .. }: UpperBound) {
        self.pieces.push(Piece { frequency, value, interval });
        self.starts.push((frequency, scalings));
    }

    fn finish(mut self) -> FrequencyBound {
        self.pieces.sort_by(|a, b| a.interval.from.total_cmp(&b.interval.from));
        FrequencyBound { upper: self.level, frequency: self.peak.0, pieces: self.pieces }
    }
}

impl FrequencyBound {
    /// Takes the bound of another component in.
    pub(super) fn add(&mut self, mut other: Self) {
        if other.upper > self.upper {
            (self.upper, self.frequency) = (other.upper, other.frequency);
        }
        self.pieces.append(&mut other.pieces);
    }

    /// Frequencies (rad/s), those with the largest bounds of their own first.
    pub(super) fn peaks(&self) -> Vec<f64> {
        let mut best: Vec<(f64, f64)> = self.pieces.iter().map(|p| (p.value, p.frequency)).collect();
        best.push((f64::INFINITY, self.frequency));
        best.sort_by(|a, b| b.0.total_cmp(&a.0));
        best.into_iter().map(|(_, omega)| omega).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mu::structure::Block;
    use nalgebra::dmatrix;

    /// A mode that hardly decays and has no part in the response: near its frequency no scalings are known to hold, and
    /// the sweep says so, instead of trying for ever.
    #[test]
    fn a_mode_beside_the_axis_is_named() {
        let (re, im) = (1e-13, 1.0);
        let system = StateSpace {
            a: dmatrix![-1.0, 0.0, 0.0; 0.0, -re, im; 0.0, -im, -re],
            b: dmatrix![1.0; 1.0; 0.0],
            c: dmatrix![0.5, 0.0, 0.0],
            d: dmatrix![0.0],
        };
        let structure = Structure::new(vec![Block::Real(1)]).unwrap();
        match bound_over_frequency(&system, &structure, None) {
            Ok(bound) => assert!(bound.upper >= 0.5, "{}", bound.upper),
            Err(SweepError::Stuck { from, to }) => assert!(from <= im && im <= to, "{from} {to}"),
            Err(other) => panic!("{other}"),
        }
    }
}
