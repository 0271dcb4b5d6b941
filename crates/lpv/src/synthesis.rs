//! LPV synthesis: a scheduled controller for a generalised plant, and a bound on the closed loop's gain.
//!
//! This file combines the steps; the inequalities and their sources are in the file of [`ScalingClass`].

mod back_off;
pub(crate) mod balance;
mod by_riccati;
mod design;
mod direct;
pub mod direct_path;
pub(crate) mod dual;
mod fast_modes;
pub(crate) mod inequalities;
pub(crate) mod least_gamma;
mod quadratic;
pub mod reconstruct;
pub mod reduce;
pub mod regularise;
pub mod regularity;

pub use design::{Design, Options};
pub use inequalities::{DualMultipliers, LmiSolution, ScalingClass};
pub use least_gamma::least_gamma;

use crate::analysis::bounded_gain::bounded_gain;
use crate::error::SynthesisError;
use crate::riccati::least::{is_determined, is_none_below};
use crate::synthesis::balance::median_time_scale;
use crate::synthesis::design::{FAR_ABOVE, repetitions};
use crate::synthesis::direct::{Least, directly};
use crate::synthesis::fast_modes::{Slowed, slowed};
use crate::synthesis::least_gamma::{at_best_time_scale, least_gamma_at, loop_time_scales};
use crate::synthesis::regularity::irregularities;
use crate::system::{GeneralisedPlant, LoopError};

/// Designs a controller and bounds the gain of the closed loop.
///
/// If gamma is uncertain and some modes are far faster than the others, the search is repeated for the plant with these
/// modes slowed; the bound is always that of the loop with the given plant. If no controller can be computed near the
/// least gamma and some signal has no weight or no noise, the search is repeated with small ones added
/// ([`crate::synthesis::regularise`]).
///
/// # Errors
/// Returns an error with [`SynthesisError::is_infeasible`] for a problem without solution; [`SynthesisError::TooFast`]
/// if only controllers beyond the limit were found; [`SynthesisError::Numerical`] if the numerics fail without a
/// decision.
pub fn synthesise(plant: &GeneralisedPlant, options: Options) -> Result<Design, SynthesisError> {
    plant.check()?;
    crate::system::modes::check_stabilisable(plant)?;
    crate::system::modes::check_detectable(plant)?;
    if !plant.blocks.iter().all(|repetitions| *repetitions == 0) || options.quick {
        return by_inequalities(plant, options);
    }
    let size = plant.sizes();
    if size.u == 0 || size.y == 0 {
        let alone = by_riccati::gain_alone(plant, options);
        return alone.map_or_else(|| by_inequalities(plant, options), Ok);
    }
    match by_riccati::synthesise(plant, options) {
        Some((_, Ok(found))) => Ok(better_of(plant, found, options)),
        Some((least, Err(reason @ SynthesisError::Numerical { .. }))) => {
            // Another controller may meet the limit on the modes; a singular problem has controllers that these
            // equations do not give.
            let may_gain = options.fastest_mode.is_some() || !irregularities(plant).is_empty();
            match by_inequalities(plant, Options { quick: !may_gain, ..options }) {
                Ok(found) => Ok(Design { lower: found.lower.max(least.lower), ..found }),
                Err(other) => Err(if may_gain { other } else { reason }),
            }
        }
        Some((_, Err(reason))) => Err(reason),
        None => by_inequalities(plant, options),
    }
}

/// Returns a design by Riccati equations, or, if its gain far exceeds the back-off, one by inequalities if that is
/// better.
fn better_of(plant: &GeneralisedPlant, found: Design, options: Options) -> Design {
    let is_known = found.lower >= (1.0 - OPEN_GAP) * found.gamma_optimum;
    if is_known && found.certified.gamma <= (1.0 + FAR_ABOVE * options.back_off) * found.gamma_optimum {
        return found;
    }
    let Ok(other) = by_inequalities(plant, Options { quick: is_known, ..options }) else { return found };
    let (gamma_optimum, lower) = (found.gamma_optimum.min(other.gamma_optimum), found.lower.max(other.lower));
    let better = if other.certified.gamma < found.certified.gamma { other } else { found };
    Design { gamma_optimum, lower, ..better }
}

/// Returns multipliers that may prove a lower bound of the least gamma, the most promising first: those of the search
/// by inequalities, with time in units of the closed loop. None for many states, as they would dominate the time.
pub fn multipliers(plant: &GeneralisedPlant, design: &Design) -> Vec<DualMultipliers> {
    if !design.multipliers.is_empty() || plant.sizes().x > MOST_STATES_FOR_MULTIPLIERS {
        return design.multipliers.clone();
    }
    let time_scale = median_time_scale(&plant.close(&design.controller).a());
    let least = least_gamma_at(plant, Options { quick: true, ..Options::default() }, Some(time_scale));
    least.map_or_else(|_| vec![], |(_, least)| least.multipliers)
}

/// The largest number of states for which [`multipliers`] searches.
const MOST_STATES_FOR_MULTIPLIERS: usize = 12;

/// Returns `true` if a gamma is shown to be the least within [`LEAST_WITHIN`]: by a known lower bound, or because no
/// controller achieves less even for one constant parameter value.
///
/// It must not change with the last digits of the plant's numbers if there are no parameters. With parameters the least
/// is that of the synthesis inequalities, and at least that of any controller for a constant value. In floating point.
pub fn is_least(plant: &GeneralisedPlant, gamma: f64, lower: f64) -> bool {
    let level = (1.0 - LEAST_WITHIN) * gamma;
    let shown = lower >= level || (level > 0.0 && is_none_below(plant, level));
    shown && (!plant.blocks.is_empty() || is_determined(plant, gamma, LEAST_WITHIN))
}

/// The relative tolerance within which a gamma is called the least.
pub const LEAST_WITHIN: f64 = 1e-3;

/// Designs as [`synthesise`] by matrix inequalities only, for a plant with or without parameters: attempts until one is
/// near enough to the least gamma; the best is taken.
///
/// # Errors
/// Errors of [`synthesise`].
pub fn by_inequalities(plant: &GeneralisedPlant, options: Options) -> Result<Design, SynthesisError> {
    let least = at_best_time_scale(plant, options);
    let mut best = directly(plant, &least, options);
    if options.quick {
        return best;
    }
    // The bound of a closed loop uses skew scalings: it implies nothing for the least gamma without them.
    if options.scalings != ScalingClass::Symmetric {
        best = with_slowed_modes(plant, best, options);
    }
    let far = 1.0 + FAR_ABOVE * options.back_off;
    let is_far = |design: &Design| design.certified.gamma > far * design.gamma_optimum;
    // The coordinates in which the least gamma was found may be too badly conditioned for a controller.
    if options.accuracy <= ROUGH && may_gain(&best, is_far) {
        for time_scale in loop_time_scales(plant).into_iter().take(repetitions(plant)) {
            let least = least_gamma_at(plant, options, Some(time_scale));
            best = better(best, directly(plant, &least, options).ok());
        }
    }
    if may_gain(&best, |design| design.gamma_design > far * design.gamma_optimum) {
        let least = least.as_ref().ok().map(|(_, least)| least);
        best = better(best, regularise::design(plant, least, options));
    }
    best
}

/// Returns `true` if another attempt may be better: a design is inadequate, or the numerics failed.
fn may_gain(outcome: &Result<Design, SynthesisError>, is_poor: impl Fn(&Design) -> bool) -> bool {
    match outcome {
        Ok(design) => is_poor(design),
        Err(error) => matches!(error, SynthesisError::Numerical { .. }),
    }
}

/// Returns the design of the lower bound, with the least gamma known from both; if equal the first.
fn better(best: Result<Design, SynthesisError>, found: Option<Design>) -> Result<Design, SynthesisError> {
    match (best, found) {
        (Ok(best), Some(found)) if found.certified.gamma < best.certified.gamma => Ok(Design {
            gamma_optimum: best.gamma_optimum.min(found.gamma_optimum),
            lower: best.lower.max(found.lower),
            multipliers: if found.multipliers.is_empty() { best.multipliers } else { found.multipliers },
            ..found
        }),
        (Err(_), Some(found)) => Ok(found),
        (best, _) => best,
    }
}

/// A required accuracy larger than this marks one of many trial designs, for which no attempt is repeated.
const ROUGH: f64 = 1e-3;

/// Designs as [`by_inequalities`] without repetitions, for one of many intermediate controllers.
pub(crate) fn synthesise_once(plant: &GeneralisedPlant, options: Options) -> Result<Design, SynthesisError> {
    directly(plant, &least_gamma_at(plant, options, None), options)
}

/// Returns the best design, also of plants with their fast modes slowed, unless it cannot be improved.
fn with_slowed_modes(
    plant: &GeneralisedPlant,
    mut best: Result<Design, SynthesisError>,
    options: Options,
) -> Result<Design, SynthesisError> {
    let is_open = |design: &Design| {
        let (least, proved) = (design.gamma_optimum, design.certified.gamma);
        design.lower < (1.0 - OPEN_GAP) * least || proved > (1.0 + 2.0 * options.back_off) * least
    };
    if !may_gain(&best, is_open) {
        return best;
    }
    for slowed in slowed(plant).into_iter().take(repetitions(plant)) {
        let least = least_gamma_at(&slowed.plant, options, None);
        let found = directly(&slowed.plant, &least, options);
        let is_settled = !may_gain(&found, is_open);
        let found =
            found.ok().and_then(|found| for_given_plant(plant, (&slowed, &least), found, &best, options));
        if found.is_some() {
            best = better(best, found);
            if is_settled {
                break;
            }
        }
    }
    best
}

/// The relative gap between gamma and its lower bound above which the least gamma is uncertain.
const OPEN_GAP: f64 = 0.01;

/// Returns a design for a slowed plant, with the bound of the loop that its controller closes with the given plant, if
/// that is better than the known design.
fn for_given_plant(
    plant: &GeneralisedPlant,
    (slowed, least): (&Slowed, &Least),
    found: Design,
    known: &Result<Design, SynthesisError>,
    options: Options,
) -> Option<Design> {
    let bound = |found: &Design| {
        let closed = plant.close(&found.controller);
        bounded_gain(&closed, &LoopError::none(&closed), &slowed.restored(&found.certified)).ok()
    };
    let certified = bound(&found)?;
    if known.as_ref().is_ok_and(|known| certified.gamma >= known.certified.gamma) {
        return None;
    }
    // A loop closer to the least gamma gives a better estimate of it.
    let nearer = Options { back_off: NEARER_BACK_OFF * options.back_off, ..options };
    let nearer = directly(&slowed.plant, least, nearer).ok().and_then(|found| bound(&found));
    let gamma_optimum = nearer.map_or(certified.gamma, |nearer| nearer.gamma.min(certified.gamma));
    let within = known.is_ok() || options.gamma_limit.is_none_or(|limit| gamma_optimum <= limit);
    within.then_some(Design { gamma_optimum, lower: 0.0, multipliers: vec![], certified, ..found })
}

/// The relative back-off of a loop closed only to estimate the least gamma, as a factor of the back-off.
const NEARER_BACK_OFF: f64 = 0.02;
