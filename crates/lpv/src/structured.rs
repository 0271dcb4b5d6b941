//! Tuning of a controller of fixed structure.
//!
//! - [`minimax()`]: the gains of a [`Structure`] minimise the largest H-infinity norm of the loop over frozen
//!   parameters. Every local peak over frequency is a smooth piece of that function, which is minimised from several
//!   starts by sequential quadratic programming.
//! - [`tune()`]: the gains then minimise the bound of the loop for every trajectory of the parameters, along the slope
//!   given by the multipliers of its inequality. The result is a design with the matrices that prove its bound.
//!
//! Sources: P. Apkarian, D. Noll, "Nonsmooth H-infinity synthesis", IEEE Trans. Automatic Control 51(1), 2006 (norm);
//! the inequality is that of [`crate::analysis::bounded_gain()`].

#[cfg(test)]
mod cases;
mod frozen;
mod minimax;
mod proved;
mod quadratic_program;
mod structure;

pub use structure::Structure;

use crate::analysis::bounded_gain::bounded_gain;
use crate::analysis::{GainBound, given_loop};
use crate::error::SynthesisError;
use crate::riccati::bound::WideLoop;
use crate::riccati::equations::WideController;
use crate::structured::frozen::{Frozen, LargestAbscissa, LargestNorm};
use crate::structured::minimax::{Effort, Function, minimise};
use crate::structured::proved::{EFFORT, ProvedGain};
use crate::structured::structure::Loop;
use crate::synthesis::Design;
use crate::system::parameter_grid::{coarse_grid, evenly_spread};
use crate::system::{GeneralisedPlant, LoopError};
use rayon::prelude::*;

/// Gains of a structure and the largest H-infinity norm of their loop over frozen parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct Tuned {
    /// Gains, one for each direction of the structure.
    pub gains: Vec<f64>,
    /// The largest H-infinity norm over the frozen parameters.
    pub frozen_gain: f64,
}

/// A number of starts on which more seldom improve by 1 %.
pub const STARTS: usize = 16;

/// Returns the gains of smallest frozen H-infinity norm found from `start` and `starts - 1` points around it, the same
/// at each call.
///
/// ```text
/// minimise over g  max over theta of |F(P, K(g)) at theta|_inf,  F the loop of the plant and K(g) = K0 + sum g_i K_i
/// ```
///
/// An unstable start is first stabilised by minimising the largest real part of the modes over the frozen parameters.
/// Shapes: one gain for each direction. Source: see the module.
///
/// # Errors
/// Returns [`SynthesisError::System`] if structure and plant do not fit; [`SynthesisError::Numerical`] if no start
/// reaches a stable loop.
pub fn minimax(
    plant: &GeneralisedPlant,
    structure: &Structure,
    start: &[f64],
    starts: usize,
) -> Result<Tuned, SynthesisError> {
    found(plant, structure, start, starts).map(|all| all[0].clone())
}

/// Returns the results of the starts, the best first: at least one.
fn found(
    plant: &GeneralisedPlant,
    structure: &Structure,
    start: &[f64],
    starts: usize,
) -> Result<Vec<Tuned>, SynthesisError> {
    structure.check(plant)?;
    let (of, thetas) = (Loop::new(plant, structure), frozen_parameters(plant));
    let search = Search::new(&of, &thetas, start);
    let points: Vec<Vec<f64>> = (0..starts).map(|k| search.spread(start, k)).collect();
    let mut all: Vec<Tuned> = points.into_par_iter().filter_map(|point| search.first_steps(&point)).collect();
    all.sort_by(|a, b| a.frozen_gain.total_cmp(&b.frozen_gain));
    all.truncate((starts / 2).max(LEAST_FINISHED));
    let mut all: Vec<Tuned> = all.into_par_iter().map(|first_steps| search.finished(first_steps)).collect();
    let least = all.iter().map(|tuned| tuned.frozen_gain).fold(f64::INFINITY, f64::min);
    let order = |tuned: &Tuned| {
        let near = tuned.frozen_gain <= (1.0 + AS_GOOD) * least;
        if near { (least, search.size(&tuned.gains)) } else { (tuned.frozen_gain, 0.0) }
    };
    all.sort_by(|a, b| order(a).partial_cmp(&order(b)).unwrap_or(std::cmp::Ordering::Equal));
    if all.is_empty() {
        return Err(SynthesisError::numerical(STAGE, format!("{starts} starts {NONE_STABLE}")));
    }
    Ok(all)
}

/// A tuned structure as a design.
#[derive(Debug, Clone, PartialEq)]
pub struct TunedDesign {
    /// Gains, one for each direction of the structure.
    pub gains: Vec<f64>,
    /// The largest H-infinity norm of the loop over the frozen parameters.
    pub frozen_gain: f64,
    /// The controller with the bound of its loop for every trajectory of the parameters. Its least gamma is that bound,
    /// or the norm of a loop without parameters, and it has no lower bound: the search is local.
    pub design: Design,
}

/// Returns the gains of smallest proved bound found: [`minimax()`], and then, for a plant with parameters,
///
/// ```text
/// minimise over g  gamma(g),  the least gamma of the analysis inequality of the loop with K(g) in X, S and T
/// ```
///
/// by quasi-Newton steps in a trust region, with tangents of steps that failed as cutting planes. The bound is local,
/// and above the frozen norm. Shapes: one gain for each direction.
///
/// # Errors
/// Errors of [`minimax()`]; [`SynthesisError`] if no start reaches a loop with a bound for every trajectory.
pub fn tune(
    plant: &GeneralisedPlant,
    structure: &Structure,
    start: &[f64],
    starts: usize,
) -> Result<TunedDesign, SynthesisError> {
    let all = found(plant, structure, start, starts)?;
    let mut last = None;
    let mut best: Option<TunedDesign> = None;
    for tuned in all.into_iter().take(MOST_PROVED) {
        match bound(plant, structure, &tuned.gains) {
            Ok(bound) => best = Some(improved(plant, structure, tuned, bound)),
            Err(error) => last = Some(error),
        }
        if best.is_some() {
            break;
        }
    }
    // Gains of a smaller frozen norm may be farther from a small bound than those of the start.
    let known = best.as_ref().map_or(f64::INFINITY, |best| best.design.certified.gamma);
    if let Some(near) = provable(plant, structure, start, known)
        && near.design.certified.gamma < known
    {
        best = Some(near);
    }
    best.ok_or_else(|| last.unwrap_or_else(|| SynthesisError::numerical(STAGE, NONE_STABLE)))
}

/// Returns the design of smallest bound from the start itself, if its frozen norm is below a known bound.
fn provable(
    plant: &GeneralisedPlant,
    structure: &Structure,
    start: &[f64],
    known: f64,
) -> Option<TunedDesign> {
    let (of, thetas) = (Loop::new(plant, structure), frozen_parameters(plant));
    let frozen = LargestNorm(Frozen { of: &of, thetas: &thetas });
    let (frozen_gain, _) = frozen.value(start).filter(|(norm, _)| *norm < known)?;
    let bound = bound(plant, structure, start).ok()?;
    Some(improved(plant, structure, Tuned { gains: start.to_vec(), frozen_gain }, bound))
}

/// The number of starts for whose results a bound is computed.
const MOST_PROVED: usize = 4;

/// Returns the bound of the loop with some gains.
///
/// # Errors
/// Returns [`SynthesisError`] if none is found.
pub fn bound(
    plant: &GeneralisedPlant,
    structure: &Structure,
    gains: &[f64],
) -> Result<GainBound, SynthesisError> {
    structure.check(plant)?;
    let controller = structure.controller(gains);
    let closed = plant.close(&controller);
    let exact = || {
        let wide = WideLoop::new(plant, &WideController::new(&controller))?;
        wide.bound(wide.guess(), f64::INFINITY, SLACK)
    };
    if closed.channels.is_empty()
        && let Some(bound) = exact()
    {
        return Ok(bound);
    }
    given_loop(&closed).map_err(|part| SynthesisError::numerical(STAGE, format!("{NOT_BOUNDED} {part:.2}")))
}

const NOT_BOUNDED: &str = "the gains are stable at frozen parameters, but no bound was found for every trajectory; \
    the largest fraction of the parameter box with a bound is";

/// The relative slack of a bound above the norm without parameters.
const SLACK: f64 = 0.01;

/// Returns a design with a smaller bound than that of the given gains, or that of these gains.
fn improved(plant: &GeneralisedPlant, structure: &Structure, tuned: Tuned, bound: GainBound) -> TunedDesign {
    let Tuned { mut gains, mut frozen_gain } = tuned;
    let mut certified = bound;
    let (of, thetas) = (Loop::new(plant, structure), frozen_parameters(plant));
    let frozen = || Frozen { of: &of, thetas: &thetas };
    if !of.at(&gains).channels.is_empty() {
        let function = ProvedGain::new(frozen(), certified.clone());
        let better = minimise(&function, &gains, EFFORT).and_then(|(better, _)| {
            let closed = of.at(&better);
            Some((better, bounded_gain(&closed, &LoopError::none(&closed), &function.best()).ok()?))
        });
        if let Some((better, bound)) = better.filter(|(_, bound)| bound.gamma < certified.gamma) {
            (gains, certified) = (better, bound);
            frozen_gain = LargestNorm(frozen()).value(&gains).map_or(f64::INFINITY, |(norm, _)| norm);
        }
    }
    let scheduled = !of.at(&gains).channels.is_empty();
    let gamma = if scheduled { certified.gamma } else { frozen_gain };
    let design = Design::new(structure.controller(&gains), gamma, gamma, certified);
    TunedDesign { gains, frozen_gain, design }
}

/// The relative difference of results below which the smallest gains are taken: an infimum may be at infinity.
const AS_GOOD: f64 = 1e-3;

const STAGE: &str = "controller of fixed structure";

const NONE_STABLE: &str = "gave no gains for which the loop is stable at every frozen parameter; such gains may \
    exist: give initial gains closer to a stable loop";

/// Returns the frozen parameters of the objective.
fn frozen_parameters(plant: &GeneralisedPlant) -> Vec<Vec<f64>> {
    match plant.blocks.len() {
        1 => evenly_spread(FROZEN).map(|theta| vec![theta]).collect(),
        several => coarse_grid(several),
    }
}

/// The number of values of a single parameter.
const FROZEN: usize = 9;

struct Search<'a> {
    norm: LargestNorm<'a>,
    abscissa: LargestAbscissa<'a>,
    /// The significant changes of the gains at the start.
    units: Vec<f64>,
}

impl<'a> Search<'a> {
    fn new(of: &'a Loop, thetas: &'a [Vec<f64>], start: &[f64]) -> Self {
        let frozen = || Frozen { of, thetas };
        let (norm, abscissa) = (LargestNorm(frozen()), LargestAbscissa::new(frozen(), start));
        let units = units_at(&norm, start).unwrap_or_else(|| abscissa.units.clone());
        Self { norm, abscissa, units }
    }

    /// Returns the start of a given number: 0 the given one, others spread around it by multiples of the units.
    ///
    /// Source of the sequence: R. D. Richtmyer, Los Alamos report LA-1342, 1951.
    fn spread(&self, start: &[f64], number: usize) -> Vec<f64> {
        let reach = REACHES[number % REACHES.len()];
        let roots = primes().map(f64::sqrt);
        let at = |root: f64| 2.0 * (number as f64 * root).fract() - 1.0;
        let moved = start.iter().zip(&self.units).zip(roots);
        moved.map(|((g, unit), root)| if number == 0 { *g } else { g + reach * unit * at(root) }).collect()
    }

    /// Returns the size of gains in the units.
    fn size(&self, gains: &[f64]) -> f64 {
        gains.iter().zip(&self.units).map(|(g, unit)| (g / unit).powi(2)).sum()
    }

    /// Runs a few steps from a start, which is stabilised first.
    fn first_steps(&self, start: &[f64]) -> Option<Tuned> {
        let stable = match self.norm.value(start) {
            Some(_) => start.to_vec(),
            None => minimise(&self.abscissa, start, FULL)?.0,
        };
        let (gains, frozen_gain) = minimise(&self.norm, &stable, Effort { steps: FIRST_STEPS, ..FULL })?;
        Some(Tuned { gains, frozen_gain })
    }

    fn finished(&self, first_steps: Tuned) -> Tuned {
        let found = minimise(&self.norm, &first_steps.gains, FULL);
        found.map_or(first_steps, |(gains, frozen_gain)| Tuned { gains, frozen_gain })
    }
}

/// The effort of a complete minimisation from one start.
const FULL: Effort = Effort { steps: 300, least: 1e-9, slow: 1e-4, slow_steps: 15, resets: 2, radius: 1.0 };

/// The steps after which the better half of the starts is continued, and the least number that is.
const FIRST_STEPS: usize = 40;
const LEAST_FINISHED: usize = 3;

/// The distances of the starts from the first, in its units.
const REACHES: [f64; 4] = [1.0, 0.3, 3.0, 0.1];

fn units_at(function: &impl Function, start: &[f64]) -> Option<Vec<f64>> {
    let (value, at) = function.value(start)?;
    let pieces = function.pieces(&at)?;
    Some(function.units(value, &pieces).as_slice().to_vec())
}

/// Returns the prime numbers.
fn primes() -> impl Iterator<Item = f64> {
    let is_prime = |n: &u32| (2..*n).take_while(|d| d * d <= *n).all(|d| !n.is_multiple_of(d));
    (2..).filter(is_prime).map(f64::from)
}
