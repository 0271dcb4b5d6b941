//! The worst-case gain: the largest gain from w to z for perturbations up to a size.
//!
//! ```text
//! z = F(Delta) w,   F(Delta) = M22 + M21 Delta (I - M11 Delta)^-1 M12,   |Delta| <= size
//! ```
//!
//! Upper bound: the gain is below g, and the loop stable, for every such Delta if mu of
//! `[size M11, size M12; M21/g, M22/g]` with a full block from z to w is below 1 at every frequency. g is raised if
//! scalings do not prove that; earlier scalings remain valid, because they prove it for every larger g. Lower bound:
//! perturbations are improved by the first-order change of the largest singular value of F, and evaluated.
//!
//! A. Packard, J. C. Doyle, "The complex structured singular value", Automatica 29(1), 1993, section 4 (the main loop
//! theorem); A. Packard, G. Balas, R. Liu, J.-Y. Shin, "Results on worst-case performance assessment", American
//! Control Conference, 2000.

use super::CMat;
use super::coordinates::balanced;
use super::interval::{Covered, good_interval, middle};
pub use super::perturbable::Perturbable;
use super::structure::Structure;
use super::sweep::{LEAST_LEVEL, MOST_FAILURES, MOST_STEPS, SweepError, check_stable, response};
use super::upper::{DgScalings, UpperBound, UpperBoundOptions, upper_bound_with};
use super::wide::{Levels, Wide};
use super::worst_perturbation::{Perturbed, refined, worst_perturbation};
use crate::stop;
use crate::system::StateSpace;
use thiserror::Error;

/// Upper and lower bounds of the worst-case gain.
#[derive(Debug, Clone, PartialEq)]
pub struct WorstCaseGain {
    /// Upper bound of the gain at every frequency, for every perturbation of the size.
    pub upper: f64,
    /// The frequency at which the upper bound was determined, rad/s.
    pub frequency: f64,
    /// The number of intervals, each with its own scalings, that cover the frequencies from 0 to infinity.
    pub intervals: usize,
    /// The worst perturbation found.
    pub worst: Perturbed,
}

/// Failure to bound the worst-case gain.
#[derive(Debug, Clone, PartialEq, Error)]
#[allow(missing_docs, reason = "the message says what each field is")]
pub enum WorstCaseError {
    /// A loop that no scalings prove to stay stable; it need not become unstable.
    #[error(
        "stability for perturbations of size {size} is not shown: at {} the D-G scalings bound mu only by {:.6}, so \
         that no bound on the gain is known",
        rads(*frequency),
        1.0 / size
    )]
    NotRobustlyStable {
        size: f64,
        /// The frequency, rad/s.
        frequency: f64,
    },
    /// A size that is not positive and finite.
    #[error("the size of the perturbation is {found}; it must be above 0 and finite")]
    Size { found: f64 },
    /// A system without performance inputs or outputs.
    #[error("besides the {} inputs and {} outputs of the blocks the system has {} and {}; at least one more of each \
        is required", blocks.0, blocks.1, found.0, found.1)]
    NoPerformance { blocks: (usize, usize), found: (usize, usize) },
    /// A failed sweep.
    #[error(transparent)]
    Sweep(#[from] SweepError),
}

/// Formats a frequency (rad/s).
fn rads(frequency: f64) -> String {
    if frequency.is_infinite() { "infinite frequency".into() } else { format!("{frequency:.4e} rad/s") }
}

/// The relative increase of the gain over that proved at the worst frequency.
const GAIN_RAISE: f64 = 1e-4;

/// The relative tolerance of the gain at one frequency.
const GAIN_TOLERANCE: f64 = 2e-5;

/// Relative margin of the bound above the gain of the sweep, for rounding.
///
/// If the largest gain over frequency just touches the level, two eigenvalues meet on the axis, and rounding of 1e-16
/// moves them off it by its square root, times the condition number of the scalings.
const ROUNDING: f64 = 1e-6;

/// The ratio to the largest gain without perturbation above which a gain is taken as unbounded.
const UNBOUNDED_RATIO: f64 = 1e6;

impl Perturbable {
    fn check(&self) -> Result<(), WorstCaseError> {
        let (w, z) = self.performance();
        if w == 0 || z == 0 {
            let blocks = (self.structure.rows(), self.structure.cols());
            return Err(WorstCaseError::NoPerformance { blocks, found: (w, z) });
        }
        if !(self.size > 0.0 && self.size.is_finite()) {
            return Err(WorstCaseError::Size { found: self.size });
        }
        Ok(())
    }
}

/// Bounds the worst-case gain. Equations and sources: see the module.
///
/// # Errors
/// Returns [`WorstCaseError`].
pub fn worst_case_gain(loop_: &Perturbable) -> Result<WorstCaseGain, WorstCaseError> {
    loop_.check()?;
    let structure = loop_.with_performance().map_err(SweepError::from)?;
    check_stable(&loop_.system, &structure)?;
    let loop_ = &Perturbable { system: balanced(&loop_.system, &structure), ..loop_.clone() };
    let worst = worst_perturbation(loop_);
    let mut sweep = GainSweep::new(loop_, worst.gain, worst.frequency)?;
    for omega in sweep.first_frequencies(worst.frequency) {
        sweep.add(omega)?;
    }
    let mut failures = 0;
    for _ in 0..MOST_STEPS {
        stop::check();
        match sweep.covered.gap() {
            None => {
                let (upper, frequency) = (sweep.gain * (1.0 + ROUNDING), sweep.peak);
                let intervals = sweep.covered.count();
                let worst = refined(loop_, worst, frequency);
                return Ok(WorstCaseGain { upper, frequency, intervals, worst });
            }
            Some((from, to)) => {
                failures += usize::from(!sweep.add(middle(from, to))?);
                if failures > MOST_FAILURES {
                    return Err(SweepError::Stuck { from, to }.into());
                }
            }
        }
    }
    let (from, to) = sweep.covered.gap().unwrap_or((0.0, f64::INFINITY));
    Err(SweepError::Stuck { from, to }.into())
}

struct GainSweep<'a> {
    loop_: &'a Perturbable,
    structure: Structure,
    gain: f64,
    /// The system in units of the gain.
    system: StateSpace,
    peak: f64,
    covered: Covered,
    wide: Wide,
    /// The frequencies of earlier scalings, with starting points.
    starts: Vec<(f64, DgScalings)>,
}

impl<'a> GainSweep<'a> {
    fn new(loop_: &'a Perturbable, known: f64, peak: f64) -> Result<Self, WorstCaseError> {
        let structure = loop_.with_performance().map_err(SweepError::from)?;
        let gain = known.max(LEAST_LEVEL) * (1.0 + GAIN_RAISE);
        let system = loop_.scaled(gain);
        let (covered, wide) = (Covered::default(), Wide::new(&system));
        Ok(Self { loop_, structure, gain, system, peak, covered, wide, starts: vec![] })
    }

    /// Returns the first frequencies: the worst one first, so that the gain is about right from the start.
    fn first_frequencies(&self, worst: f64) -> Vec<f64> {
        let mut points: Vec<f64> = self.system.poles().iter().map(|p| p.norm()).collect();
        points.sort_by(f64::total_cmp);
        points.dedup_by(|a, b| (*a - *b).abs() <= 0.05 * b.abs());
        [worst].into_iter().chain(points).chain([0.0, f64::INFINITY]).collect()
    }

    /// Covers a frequency, at a larger gain if necessary; returns `true` if an interval was added.
    fn add(&mut self, omega: f64) -> Result<bool, WorstCaseError> {
        if self.covered.holds(omega) {
            return Ok(true);
        }
        let Some(m) = response(&self.system, omega) else { return Ok(false) };
        let nearest = self.starts.iter().min_by(|a, b| (a.0 - omega).abs().total_cmp(&(b.0 - omega).abs()));
        let from = nearest.map(|(_, start)| start.clone());
        if self.wide.is_first(omega) && self.widened(omega, from.as_ref())? {
            return Ok(true);
        }
        let mut bound = self.shown(&m, from.as_ref())?;
        if bound.value >= 1.0 {
            let start = self.raise(&m, omega, bound)?;
            let Some(m) = response(&self.system, omega) else { return Ok(false) };
            bound = self.shown(&m, Some(&start))?;
        }
        self.starts.push((omega, bound.start.clone()));
        match good_interval(&self.system, &bound.scalings, 1.0, omega) {
            Some(interval) => {
                if self.wide.is_next(omega, interval) && self.widened(omega, Some(&bound.start))? {
                    return Ok(true);
                }
                let is_added = self.covered.add(omega, interval);
                let (count, states) = (self.covered.count(), self.system.a.nrows());
                let raise = if is_added { interval.level_raise(omega, count, states) } else { GAIN_RAISE };
                if raise > 0.0 {
                    self.set(self.gain * (1.0 + raise));
                }
                Ok(is_added)
            }
            None => {
                // The scalings hold without a margin: a slightly higher gain has one.
                self.set(self.gain * (1.0 + GAIN_RAISE));
                Ok(true)
            }
        }
    }

    /// Covers a frequency by scalings for two frequencies around it; returns `true` if there are such.
    fn widened(&mut self, omega: f64, start: Option<&DgScalings>) -> Result<bool, SweepError> {
        let gap = self.covered.around(omega);
        let levels = Levels { level: 1.0, ceiling: 1.0 };
        let shown = self.wide.shown(&self.system, &self.structure, levels, gap, omega, start)?;
        let Some(shown) = shown else { return Ok(false) };
        self.starts.push((omega, shown.bound.start));
        Ok(self.covered.add(omega, shown.interval))
    }

    fn set(&mut self, gain: f64) {
        self.gain = gain;
        self.system = self.loop_.scaled(gain);
    }

    /// Returns scalings that prove mu to be below 1, or the least bound.
    fn shown(&self, m: &CMat, from: Option<&DgScalings>) -> Result<UpperBound, SweepError> {
        let options = UpperBoundOptions { level: 1.0, from, ..UpperBoundOptions::default() };
        Ok(upper_bound_with(m, &self.structure, options)?)
    }

    /// Raises the gain to the least that the scalings prove at a frequency, by false position in its logarithm; `least`
    /// is the bound at the current gain. Returns the scalings to start from there.
    ///
    /// The Illinois rule keeps both ends moving: M. Dowell, P. Jarratt, BIT 11, 1971.
    fn raise(&mut self, m: &CMat, omega: f64, least: UpperBound) -> Result<DgScalings, WorstCaseError> {
        let k = self.loop_.structure.cols();
        let mut start = least.start;
        let mut above = |factor: f64| -> Result<f64, SweepError> {
            let mut scaled = m.clone();
            let z = m.nrows() - k;
            scaled.rows_mut(k, z).unscale_mut(factor);
            let options = UpperBoundOptions { from: Some(&start), ..UpperBoundOptions::default() };
            let bound = upper_bound_with(&scaled, &self.structure, options)?;
            start = bound.start;
            Ok(bound.value.ln())
        };
        let (mut low, mut at_low) = (0.0, least.value.ln());
        let mut high = at_low.max(GAIN_TOLERANCE);
        let mut at_high = above(high.exp())?;
        while at_high >= 0.0 {
            (low, at_low) = (high, at_high);
            high = 2.0 * high + 0.1;
            if high > UNBOUNDED_RATIO.ln() {
                let (size, frequency) = (self.loop_.size, omega);
                return Err(WorstCaseError::NotRobustlyStable { size, frequency });
            }
            at_high = above(high.exp())?;
        }
        let mut last = 0;
        while high - low > GAIN_TOLERANCE {
            // Neither end itself, which would give no information.
            let next = low + at_low / (at_low - at_high) * (high - low);
            let next = next.clamp(low + 0.4 * GAIN_TOLERANCE, high - 0.4 * GAIN_TOLERANCE);
            let value = above(next.exp())?;
            if value >= 0.0 {
                (low, at_low) = (next, value);
                if last == 1 {
                    at_high *= 0.5
                }
                last = 1;
            } else {
                (high, at_high) = (next, value);
                if last == -1 {
                    at_low *= 0.5
                }
                last = -1;
            }
        }
        self.peak = omega;
        self.set(self.gain * high.exp() * (1.0 + GAIN_RAISE));
        Ok(start)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::matrix::{Mat, largest_complex_singular_value};
    use crate::mu::Block;
    use crate::mu::over_frequency::mu_over_frequency;
    use crate::mu::structure::random::blocks;
    use nalgebra::dmatrix;
    use proptest::prelude::*;

    /// Returns `x' = -x + 0.5 wd + w, zd = x, z = x`: with delta the gain is `1/(1 - 0.5 delta)` at frequency zero.
    fn first_order(size: f64) -> Perturbable {
        let system = StateSpace {
            a: dmatrix![-1.0],
            b: dmatrix![0.5, 1.0],
            c: dmatrix![1.0; 1.0],
            d: Mat::zeros(2, 2),
        };
        Perturbable { system, structure: Structure::new(vec![Block::Real(1)]).unwrap(), size }
    }

    #[test]
    fn the_gain_with_one_parameter_has_its_closed_form() {
        for size in [0.1, 1.0, 1.9] {
            let found = worst_case_gain(&first_order(size)).unwrap();
            let exact = 1.0 / (1.0 - 0.5 * size);
            assert!(found.upper >= exact && found.upper < exact * 1.001, "{} {exact}", found.upper);
            assert!((found.worst.gain - exact).abs() < 1e-9 * exact, "{} {exact}", found.worst.gain);
            assert!((found.worst.delta[(0, 0)].re - size).abs() < 1e-12);
        }
        assert!(matches!(worst_case_gain(&first_order(2.0)), Err(WorstCaseError::NotRobustlyStable { .. })));
        assert!(matches!(worst_case_gain(&first_order(0.0)), Err(WorstCaseError::Size { .. })));
    }

    /// Two channels of one scalar form no loop at infinite frequency, though the path between them has a large gain:
    /// full scalings of the repeated block prove that, and the gain is bounded.
    #[test]
    fn a_path_in_the_direct_term_forms_no_loop() {
        let system = StateSpace {
            a: dmatrix![-1.0],
            b: dmatrix![0.01, 0.02, 1.0],
            c: dmatrix![0.02; 0.01; 1.0],
            d: dmatrix![0.5, 3.0, 0.0; 0.0, 0.5, 0.0; 0.0, 0.0, 0.0],
        };
        let structure = Structure::new(vec![Block::Real(2)]).unwrap();
        let found = worst_case_gain(&Perturbable { system, structure, size: 1.0 }).unwrap();
        assert!(found.worst.gain <= found.upper && found.upper < 1.001 * found.worst.gain, "{found:?}");
    }

    fn systems() -> impl Strategy<Value = Perturbable> {
        (blocks(4), prop::collection::vec(-1.0..1.0f64, 200), 0.1..0.9f64).prop_map(
            |(structure, entries, part)| {
                let (inputs, outputs) = (structure.rows() + 2, structure.cols() + 1);
                let mut next = entries.into_iter().cycle();
                let mut fill = |r, c| Mat::from_fn(r, c, |_, _| next.next().unwrap_or(0.0));
                let a = fill(3, 3) - Mat::identity(3, 3) * 2.5;
                let system =
                    StateSpace { a, b: fill(3, inputs), c: fill(outputs, 3), d: fill(outputs, inputs) * 0.3 };
                let inner = system.parts(0..structure.cols(), 0..structure.rows());
                // The size is a fraction of one that is certainly tolerated.
                let size = part / mu_over_frequency(&inner, &structure).unwrap().upper.upper.max(1e-3);
                Perturbable { system, structure, size }
            },
        )
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(24))]

        /// The lower bound is below the upper one; its perturbation has the structure, the size and the reported gain.
        #[test]
        fn the_lower_bound_is_below_the_upper_one(loop_ in systems()) {
            let found = worst_case_gain(&loop_).unwrap();
            prop_assert!(found.worst.gain <= found.upper, "{} {}", found.worst.gain, found.upper);
            prop_assert!(loop_.structure.holds(&found.worst.delta) || found.worst.delta.norm() == 0.0);
            prop_assert!(largest_complex_singular_value(&found.worst.delta) <= loop_.size * (1.0 + 1e-9));
            let m = response(&loop_.system, found.worst.frequency).unwrap();
            let (k, w) = (loop_.structure.cols(), loop_.structure.rows());
            let part = |r: usize, c: usize, rows: usize, cols: usize| m.view((r, c), (rows, cols)).into_owned();
            let inner = CMat::identity(k, k) - part(0, 0, k, w) * &found.worst.delta;
            let solved = inner.lu().solve(&part(0, w, k, 2)).unwrap();
            let closed = part(k, w, 1, 2) + part(k, 0, 1, w) * &found.worst.delta * solved;
            let gain = largest_complex_singular_value(&closed);
            prop_assert!((gain - found.worst.gain).abs() < 1e-8 * gain, "{gain} {}", found.worst.gain);
        }

        /// The worst-case gain at the size 1/beta of robust performance is beta: mu with a full performance block.
        #[test]
        fn the_gain_at_the_size_of_robust_performance_is_its_inverse(loop_ in systems()) {
            let both = loop_.with_performance().unwrap();
            let beta = mu_over_frequency(&loop_.system, &both).unwrap().upper.upper;
            prop_assume!(beta > 1e-2);
            let found = worst_case_gain(&Perturbable { size: 0.999 / beta, ..loop_ }).unwrap();
            prop_assert!(found.upper <= beta * 1.01, "{} {beta}", found.upper);
        }
    }
}
