//! Tuning of a controller of fixed structure.
//!
//! The gains of a [`Structure`] first minimise the largest H-infinity norm of the loop over frozen parameters, from
//! several starts: every local peak over frequency is a smooth piece of that function, which is minimised by sequential
//! quadratic programming. Source: P. Apkarian, D. Noll, "Nonsmooth H-infinity synthesis", IEEE Trans. Automatic
//! Control 51(1), 2006.

mod frozen;
mod minimax;
mod proved;
mod quadratic_program;
mod structure;

pub use structure::Structure;

use crate::error::SynthesisError;
use crate::structured::frozen::{Frozen, LargestAbscissa, LargestNorm};
use crate::structured::minimax::{Function, minimise};
use crate::structured::structure::Loop;
use crate::system::GeneralisedPlant;
use crate::system::parameter_grid::{coarse_grid, evenly_spread};
use rayon::prelude::*;

/// Gains of a structure and the largest H-infinity norm of their loop over frozen parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct Tuned {
    /// One for each direction of the structure.
    pub gains: Vec<f64>,
    /// The largest H-infinity norm over the frozen parameters.
    pub frozen_gain: f64,
}

/// A number of starts that finds what more seldom improve by 1 %.
pub const STARTS: usize = 16;

/// The gains of smallest frozen H-infinity norm found from `start` and `starts - 1` points around it, the same at each
/// call.
///
/// ```text
/// minimise over g  max over theta of |F(P, K(g)) at theta|_inf,  F the loop of the plant and K(g) = K0 + sum g_i K_i
/// ```
///
/// An unstable start is first stabilised by minimising the largest real part of the modes over the frozen parameters.
/// Shapes: one gain for each direction. For the source see the top of this file.
///
/// # Errors
/// [`SynthesisError::Shape`] if structure and plant do not fit; [`SynthesisError::Numerical`] if no start reaches a
/// stable loop.
pub fn minimax(
    plant: &GeneralisedPlant,
    structure: &Structure,
    start: &[f64],
    starts: usize,
) -> Result<Tuned, SynthesisError> {
    structure.check(plant)?;
    let (of, thetas) = (Loop::new(plant, structure), frozen_parameters(plant));
    let search = Search::new(&of, &thetas, start);
    let points: Vec<Vec<f64>> = (0..starts).map(|k| search.spread(start, k)).collect();
    let found: Vec<Tuned> = points.into_par_iter().filter_map(|point| search.run(&point)).collect();
    let least = found.iter().map(|tuned| tuned.frozen_gain).fold(f64::INFINITY, f64::min);
    let near = found.into_iter().filter(|tuned| tuned.frozen_gain <= (1.0 + AS_GOOD) * least);
    let best = near.min_by(|a, b| search.size(&a.gains).total_cmp(&search.size(&b.gains)));
    best.ok_or_else(|| SynthesisError::numerical(STAGE, format!("{starts} starts {NONE_STABLE}")))
}

/// Of gains whose results differ by less, relative to them, the smallest are taken: an infimum may be at infinity.
const AS_GOOD: f64 = 1e-3;

const STAGE: &str = "controller of fixed structure";

const NONE_STABLE: &str = "found no gains for which the loop is stable at every frozen parameter; there may be some: \
    give gains to start from that are closer to such a loop";

/// The frozen parameters of the objective.
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
    /// The changes of the gains that matter at the start.
    units: Vec<f64>,
}

impl<'a> Search<'a> {
    fn new(of: &'a Loop, thetas: &'a [Vec<f64>], start: &[f64]) -> Self {
        let frozen = || Frozen { of, thetas };
        let (norm, abscissa) = (LargestNorm(frozen()), LargestAbscissa::new(frozen(), start));
        let units = units_at(&norm, start).unwrap_or_else(|| abscissa.units.clone());
        Self { norm, abscissa, units }
    }

    /// The start with a number: 0 the given one, others spread around it by multiples of the units.
    ///
    /// Source of the sequence: R. D. Richtmyer, Los Alamos report LA-1342, 1951.
    fn spread(&self, start: &[f64], number: usize) -> Vec<f64> {
        let reach = REACHES[number % REACHES.len()];
        let roots = primes().map(f64::sqrt);
        let at = |root: f64| 2.0 * (number as f64 * root).fract() - 1.0;
        let moved = start.iter().zip(&self.units).zip(roots);
        moved.map(|((g, unit), root)| if number == 0 { *g } else { g + reach * unit * at(root) }).collect()
    }

    /// The size of gains in the units.
    fn size(&self, gains: &[f64]) -> f64 {
        gains.iter().zip(&self.units).map(|(g, unit)| (g / unit).powi(2)).sum()
    }

    fn run(&self, start: &[f64]) -> Option<Tuned> {
        let stable = match self.norm.value(start) {
            Some(_) => start.to_vec(),
            None => minimise(&self.abscissa, start)?.0,
        };
        let (gains, frozen_gain) = minimise(&self.norm, &stable)?;
        Some(Tuned { gains, frozen_gain })
    }
}

/// The distances of the starts from the first, in its units.
const REACHES: [f64; 4] = [1.0, 0.3, 3.0, 0.1];

fn units_at(function: &impl Function, start: &[f64]) -> Option<Vec<f64>> {
    let (value, at) = function.value(start)?;
    let pieces = function.pieces(&at)?;
    Some(function.units(value, &pieces).as_slice().to_vec())
}

/// The prime numbers.
fn primes() -> impl Iterator<Item = f64> {
    let is_prime = |n: &u32| (2..*n).take_while(|d| d * d <= *n).all(|d| n % d != 0);
    (2..).filter(is_prime).map(f64::from)
}
