//! A bound on mu that holds at every frequency from 0 to infinity, not only on a grid.
//!
//! Scalings found at one or two frequencies hold on an interval; frequencies are added until the intervals cover the
//! axis. If no scalings achieve the level, it is raised, by no more than necessary: it ends close above the largest of
//! the bounds at single frequencies. If that would take too many intervals, because the bound is nearly constant over a
//! wide range of frequencies, the level is raised in growing steps: a sweep ends after a limited number of steps, with
//! a guaranteed bound or an error that states the uncovered frequencies.

use super::components::of_system;
use super::coordinates::{balanced, block_scaled};
pub use super::interval::response;
use super::interval::{Covered, Interval, good_interval, middle};
use super::structure::{Structure, StructureError};
use super::upper::DgScalings;
use super::upper::balance::Balance;
use super::upper::{BOUND_TOLERANCE, UpperBound, UpperBoundOptions, upper_bound_with};
use super::wide::{Levels, Shown, Wide};
use super::{CMat, lower};
use crate::matrix::{largest_complex_singular_value, spectral_abscissa};
use crate::stop;
use crate::system::StateSpace;
use nalgebra::Complex;
use thiserror::Error;

/// Scalings, and the interval on which they prove the bound.
#[derive(Debug, Clone, PartialEq)]
pub struct Piece {
    /// The frequency at which they were found, rad/s.
    pub frequency: f64,
    /// The bound that they prove at that frequency.
    pub value: f64,
    /// The interval on which they prove the bound of the sweep.
    pub interval: Interval,
}

/// A bound for all frequencies.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct FrequencyBound {
    /// Upper bound of mu at every frequency from 0 to infinity.
    pub upper: f64,
    /// The frequency of the largest bound at a single frequency, rad/s.
    pub frequency: f64,
    /// Pieces whose intervals cover the axis, ascending; for a system with several components, those of each.
    pub pieces: Vec<Piece>,
}

/// A sweep that failed.
#[derive(Debug, Clone, PartialEq, Error)]
#[allow(missing_docs, reason = "the message says what each field is")]
pub enum SweepError {
    /// A loop that is unstable without perturbation.
    #[error("the loop is unstable without any perturbation: a mode has real part {re:.3e}")]
    Unstable { re: f64 },
    /// A system that does not fit the structure.
    #[error(transparent)]
    Structure(#[from] StructureError),
    /// A part of the frequency axis that the intervals do not cover.
    #[error("the bound could not be verified {} rad/s", range(*from, *to))]
    Stuck { from: f64, to: f64 },
}

/// Formats a range, as one number if its digits agree.
fn range(from: f64, to: f64) -> String {
    let [first, last] = [from, to].map(|v| format!("{v:.6e}"));
    if first == last { format!("near {first}") } else { format!("between {first} and {last}") }
}

/// The least relative increase of the level over the largest bound at a single frequency, and the corresponding
/// tolerance.
pub const CLOSEST: f64 = 5e-5;

/// The number of unknowns of scalings up to which full accuracy is used. Above it, that increase and the tolerance of
/// the bounds at single frequencies grow with the power 1.5.
const EASY_UNKNOWNS: f64 = 200.0;

/// The relative increase of the level for an interval that is short and slower than every mode.
const SHORT_INTERVAL_RAISE: f64 = 2e-3;

/// The allowed increase of the level over the largest bound at a single frequency for scalings of two frequencies, and
/// the number of intervals from which it is allowed.
const WIDE_RAISE: f64 = 5e-4;
const WIDE_COUNT: usize = 160;

/// The least level: its square and the inverse of that are far from under- and overflow.
pub(super) const LEAST_LEVEL: f64 = 1e-60;

/// The number of intervals above which each short one raises the level, doubled after each further `RAISE_COUNT`: more
/// are allowed for small systems, as the cost grows at least with the second power of the number of states.
const EASY_COUNT: usize = 300;
const EASY_COST: usize = 100_000;
const RAISE_COUNT: usize = 100;

/// The largest number of steps, and of those without a new interval.
pub(super) const MOST_STEPS: usize = 4000;
pub(super) const MOST_FAILURES: usize = 20;

/// Bounds mu of `M(j omega)` over all frequencies, within a relative `tolerance` of the largest bound at a single
/// frequency, or a little more where intervals are short; [`CLOSEST`] is the least tolerance.
///
/// # Errors
/// Returns [`SweepError`] if the loop is unstable, the structure does not fit or the axis is not covered.
pub fn bound_over_frequency(
    system: &StateSpace,
    structure: &Structure,
    tolerance: f64,
) -> Result<FrequencyBound, SweepError> {
    check_stable(system, structure)?;
    let mut all = FrequencyBound::default();
    for part in of_system(system, structure) {
        let balanced = balanced(&part.system(system), &part.structure);
        all.add(swept(&balanced, &part.structure, None, tolerance)?);
    }
    Ok(all)
}

/// Returns the bound of one component in balanced coordinates. It need not be below the `known` lower bound, whose
/// frequency is also tried.
pub(super) fn swept(
    system: &StateSpace,
    structure: &Structure,
    known: Option<&lower::LowerBound>,
    tolerance: f64,
) -> Result<FrequencyBound, SweepError> {
    let mut sweep = Sweep::new(system, structure, known, tolerance);
    sweep.start(known.and_then(|lower| lower.frequency))?;
    for _ in 0..MOST_STEPS {
        stop::check();
        let Some((from, to)) = sweep.covered.gap() else { return Ok(sweep.finish()) };
        sweep.add(middle(from, to))?;
        if sweep.failures > MOST_FAILURES {
            return Err(SweepError::Stuck { from, to });
        }
    }
    let (from, to) = sweep.covered.gap().unwrap_or((0.0, f64::INFINITY));
    Err(SweepError::Stuck { from, to })
}

/// Checks that a loop is stable without perturbation and fits the structure.
///
/// # Errors
/// Returns [`SweepError::Unstable`] or [`SweepError::Structure`].
pub(super) fn check_stable(system: &StateSpace, structure: &Structure) -> Result<(), SweepError> {
    structure.check(&system.d.map(Complex::from))?;
    let re = spectral_abscissa(&block_scaled(system, structure).a);
    if !system.a.is_empty() && (re.is_nan() || re >= 0.0) {
        return Err(SweepError::Unstable { re });
    }
    Ok(())
}

impl Interval {
    /// Returns the relative increase of the level for a short interval if there are `count` intervals already, for a
    /// system with `states` states.
    pub(super) fn level_raise(&self, omega: f64, count: usize, states: usize) -> f64 {
        let beyond = count.saturating_sub(EASY_COUNT + EASY_COST / (states * states).max(1));
        let raise = SHORT_INTERVAL_RAISE * 2f64.powi((beyond / RAISE_COUNT) as i32);
        if beyond > 0 && self.is_short(omega) { raise } else { 0.0 }
    }
}

struct Sweep<'a> {
    system: &'a StateSpace,
    structure: &'a Structure,
    /// The factor of the tolerances.
    coarse: f64,
    level: f64,
    peak: (f64, f64),
    pieces: Vec<Piece>,
    /// The frequencies of scalings found, with the scalings.
    starts: Vec<(f64, DgScalings)>,
    covered: Covered,
    /// The number of scalings that were valid on no interval.
    failures: usize,
    wide: Wide,
}

impl<'a> Sweep<'a> {
    fn new(
        system: &'a StateSpace,
        structure: &'a Structure,
        known: Option<&lower::LowerBound>,
        tolerance: f64,
    ) -> Self {
        let floor = known.map_or(0.0, |lower| lower.value);
        let coarse =
            (structure.unknowns() as f64 / EASY_UNKNOWNS).powf(1.5).max(tolerance / CLOSEST).max(1.0);
        Self {
            system,
            structure,
            coarse,
            level: floor * (1.0 + coarse * CLOSEST),
            peak: (known.and_then(|lower| lower.frequency).unwrap_or(0.0), floor),
            pieces: vec![],
            starts: vec![],
            covered: Covered::default(),
            failures: 0,
            wide: Wide::new(system),
        }
    }

    /// Tries zero, infinity, the modes and the expected peak, so that the level is about right from the start.
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
        // The peak comes first: few of the others then raise the level.
        for omega in peak.into_iter().chain(points) {
            self.add(omega)?;
        }
        Ok(())
    }

    fn note(&mut self, omega: f64, value: f64) {
        if value > self.peak.1 {
            self.peak = (omega, value);
        }
        self.level = self.level.max(value * (1.0 + self.coarse * CLOSEST));
    }

    fn add(&mut self, omega: f64) -> Result<(), SweepError> {
        if self.covered.holds(omega) {
            return Ok(());
        }
        let Some(m) = response(self.system, omega) else { return Ok(()) };
        let nearest = self.starts.iter().min_by(|a, b| (a.0 - omega).abs().total_cmp(&(b.0 - omega).abs()));
        let start = nearest.map(|(_, scalings)| scalings.clone());
        // Scalings for one frequency are not tried near a short interval.
        if self.wide.is_first(omega) && self.widened(omega, start.as_ref())? {
            return Ok(());
        }
        let mut bound = self.bound(&m, start.as_ref())?;
        if bound.value >= self.level {
            // No scalings prove this level, so the bound found is the least.
            self.note(omega, bound.value);
            bound = self.bound(&m, Some(&bound.start))?;
        }
        let Some(interval) = good_interval(self.system, &bound.scalings, self.level, omega) else {
            // The scalings hold without a margin: a slightly higher level has one.
            self.level *= 1.0 + self.coarse * CLOSEST;
            return Ok(());
        };
        if self.wide.is_next(omega, interval) && self.widened(omega, Some(&bound.start))? {
            return Ok(());
        }
        let is_added = self.covered.add(omega, interval);
        self.failures += usize::from(!is_added);
        if interval.is_short(omega) && (omega < self.wide.slow || !is_added) {
            // Only the phase changes below every mode, from zero: real blocks have a lower bound at zero than near it.
            self.level *= 1.0 + SHORT_INTERVAL_RAISE;
        } else {
            self.level *= 1.0 + interval.level_raise(omega, self.covered.count(), self.system.a.nrows());
        }
        self.push(omega, interval, bound);
        Ok(())
    }

    fn bound(&self, m: &CMat, from: Option<&DgScalings>) -> Result<UpperBound, StructureError> {
        let options = UpperBoundOptions { level: self.level, tight: self.coarse * BOUND_TOLERANCE, from };
        upper_bound_with(m, self.structure, options)
    }

    /// Covers a frequency by scalings for two frequencies around it; returns `true` if there are such.
    fn widened(&mut self, omega: f64, start: Option<&DgScalings>) -> Result<bool, SweepError> {
        let ceiling = if self.covered.count() < WIDE_COUNT { 0.0 } else { self.peak.1 * (1.0 + WIDE_RAISE) };
        let levels = Levels { level: self.level, ceiling };
        let gap = self.covered.around(omega);
        let shown = self.wide.shown(self.system, self.structure, levels, gap, omega, start)?;
        let Some(Shown { level, interval, bound }) = shown else { return Ok(false) };
        let is_added = self.covered.add(omega, interval);
        if is_added {
            self.level = level;
            self.push(omega, interval, bound);
        }
        Ok(is_added)
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
    /// Merges the bound of another component.
    pub(super) fn add(&mut self, mut other: Self) {
        if other.upper > self.upper {
            (self.upper, self.frequency) = (other.upper, other.frequency);
        }
        self.pieces.append(&mut other.pieces);
    }

    /// Returns the frequencies (rad/s), those with the largest bounds first.
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

    /// A bound within a larger tolerance, of a mass and a spring both uncertain, is a bound, at most that much larger.
    #[test]
    fn a_bound_is_within_the_tolerance() {
        let system = StateSpace {
            a: dmatrix![0.0, 1.0; -1.0, -0.4],
            b: dmatrix![0.0, 0.0; 0.3, 0.2],
            c: dmatrix![-1.0, 0.0; -1.0, -0.4],
            d: dmatrix![0.0, 0.0; 0.3, 0.2],
        };
        let structure = Structure::new(vec![Block::Real(1), Block::Real(1)]).unwrap();
        let bound = |tolerance| bound_over_frequency(&system, &structure, tolerance).unwrap();
        let close = bound(CLOSEST);
        for tolerance in [1e-3, 1e-2, 1e-1] {
            let ratio = bound(tolerance).upper / close.upper;
            assert!(ratio >= 1.0 - 2.0 * CLOSEST && ratio <= 1.0 + 2.0 * tolerance, "{tolerance} {ratio}");
        }
    }

    /// No scalings are known to hold near the frequency of a barely damped mode without effect on the response; the
    /// sweep reports that and ends.
    #[test]
    fn a_mode_near_the_axis_is_reported() {
        let (re, im) = (1e-13, 1.0);
        let system = StateSpace {
            a: dmatrix![-1.0, 0.0, 0.0; 0.0, -re, im; 0.0, -im, -re],
            b: dmatrix![1.0; 1.0; 0.0],
            c: dmatrix![0.5, 0.0, 0.0],
            d: dmatrix![0.0],
        };
        let structure = Structure::new(vec![Block::Real(1)]).unwrap();
        match bound_over_frequency(&system, &structure, CLOSEST) {
            Ok(bound) => assert!(bound.upper >= 0.5, "{}", bound.upper),
            Err(SweepError::Stuck { from, to }) => assert!(from <= im && im <= to, "{from} {to}"),
            Err(other) => panic!("{other}"),
        }
    }
}
