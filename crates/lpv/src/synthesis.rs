//! LPV synthesis: from a generalised plant to a scheduled controller and a bound of the loop's gain.
//!
//! The inequalities and their sources are in [`ScalingClass`]'s file; this one strings the steps together.

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
use crate::synthesis::balance::middle_speed;
use crate::synthesis::direct::{Least, directly};
use crate::synthesis::fast_modes::{Slowed, slowed};
use crate::synthesis::least_gamma::{at_best_speed, least_gamma_within, loop_speeds, sought};
use crate::synthesis::regularity::findings;
use crate::system::model_error::LoopError;
use crate::system::plant::GeneralisedPlant;

/// Designs a controller and bounds the gain of the loop that it closes.
///
/// Where the search is unsure of gamma, and some modes are far faster than the others, it is repeated for the plant
/// with these modes slowed; the bound is always of the loop with the plant itself. Where no controller can be
/// computed near the least gamma and something has no weight or no noise, it is repeated with a little of both
/// ([`crate::synthesis::regularise`]).
///
/// # Errors
/// Kept apart are: a design; [`SynthesisError::is_infeasible`] for a problem without solution;
/// [`SynthesisError::TooFast`] when only controllers beyond the limit were found; [`SynthesisError::Numerical`] when
/// nothing is known.
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
    let quick = Options { quick: true, ..options };
    match by_riccati::synthesise(plant, options) {
        Some((_, Ok(found))) => Ok(better_of(plant, found, options)),
        // A limit on the modes may be kept by another controller, or be said to be missed; a singular problem has
        // controllers that these equations do not give.
        Some((_, Err(SynthesisError::Numerical { .. })))
            if options.fastest_mode.is_some() || !findings(plant).is_empty() =>
        {
            by_inequalities(plant, options)
        }
        Some((least, Err(reason @ SynthesisError::Numerical { .. }))) => by_inequalities(plant, quick)
            .map(|found| Design { lower: least.lower, ..found })
            .map_err(|_| reason),
        Some((_, Err(reason))) => Err(reason),
        None => by_inequalities(plant, options),
    }
}

/// A design by Riccati equations, or one by inequalities where that is better: where the first is not within the
/// back-off.
fn better_of(plant: &GeneralisedPlant, found: Design, options: Options) -> Design {
    let is_known = found.lower >= (1.0 - OPEN_GAP) * found.gamma_optimum;
    if is_known && found.certified.gamma <= (1.0 + options.back_off) * found.gamma_optimum {
        return found;
    }
    let Ok(other) = by_inequalities(plant, Options { quick: is_known, ..options }) else { return found };
    let (gamma_optimum, lower) = (found.gamma_optimum.min(other.gamma_optimum), found.lower.max(other.lower));
    let better = if other.certified.gamma < found.certified.gamma { other } else { found };
    Design { gamma_optimum, lower, ..better }
}

/// Multipliers that may prove a lower bound of the least gamma, the most promising first: those of the search by
/// inequalities, with time in units of the loop of a design. None for many states, where they take longer than all
/// else.
pub fn multipliers(plant: &GeneralisedPlant, design: &Design) -> Vec<DualMultipliers> {
    if !design.multipliers.is_empty() || plant.sizes().x > MOST_STATES_FOR_MULTIPLIERS {
        return design.multipliers.clone();
    }
    let speed = middle_speed(&plant.close(&design.controller).a());
    let least = sought(plant, Options { quick: true, ..Options::default() }, Some(speed));
    least.map_or_else(|_| vec![], |(_, least)| least.multipliers)
}

/// See [`multipliers`].
const MOST_STATES_FOR_MULTIPLIERS: usize = 12;

/// Whether a gamma is shown to be the least within a part of [`LEAST_WITHIN`]: by a lower bound that is known, or as
/// there is no controller even for one constant value of the parameters.
///
/// Without parameters it must not change with the last digits of the plant's numbers. With parameters the least is that
/// of the synthesis inequalities, and no less than that of any controller for a constant value. All in floating point.
pub fn is_least(plant: &GeneralisedPlant, gamma: f64, lower: f64) -> bool {
    let level = (1.0 - LEAST_WITHIN) * gamma;
    let shown = lower >= level || (level > 0.0 && is_none_below(plant, level));
    shown && (!plant.blocks.is_empty() || is_determined(plant, gamma, LEAST_WITHIN))
}

/// How far a gamma that is called the least may be above it, relative to itself.
pub const LEAST_WITHIN: f64 = 1e-3;

/// The same by matrix inequalities alone, for a plant with parameters or without.
///
/// # Errors
/// As [`synthesise`].
pub fn by_inequalities(plant: &GeneralisedPlant, options: Options) -> Result<Design, SynthesisError> {
    let least = at_best_speed(plant, options);
    if options.quick {
        return directly(plant, &least, options);
    }
    let outcome = in_other_time(plant, as_given(plant, &least, options), options);
    let far =
        |design: &Design| design.gamma_design > (1.0 + FAR_ABOVE * options.back_off) * design.gamma_optimum;
    match &outcome {
        Ok(design) if !far(design) => return outcome,
        Ok(_) | Err(SynthesisError::Numerical { .. }) => {}
        Err(_) => return outcome,
    }
    let least = least.as_ref().ok().map(|(_, least)| least);
    match (regularise::design(plant, least, options), outcome) {
        (Some(added), Ok(given)) if added.certified.gamma >= given.certified.gamma => Ok(given),
        (Some(added), _) => Ok(added),
        (None, outcome) => outcome,
    }
}

/// The outcome, or a design with time in units of the loop where that is better: the coordinates in which the least
/// gamma is found may be too bad for a controller.
fn in_other_time(
    plant: &GeneralisedPlant,
    outcome: Result<Design, SynthesisError>,
    options: Options,
) -> Result<Design, SynthesisError> {
    let near = |d: &Design| d.certified.gamma <= (1.0 + FAR_ABOVE * options.back_off) * d.gamma_optimum;
    let may_gain = match &outcome {
        Ok(design) => !near(design),
        Err(error) => matches!(error, SynthesisError::Numerical { .. }),
    };
    if !may_gain || options.accuracy > ROUGH {
        return outcome;
    }
    let speeds = loop_speeds(plant).into_iter();
    let designs =
        speeds.filter_map(|speed| directly(plant, &sought(plant, options, Some(speed)), options).ok());
    designs.fold(outcome, |best, found| match best {
        Ok(best) if best.certified.gamma <= found.certified.gamma => Ok(best),
        Ok(best) => Ok(Design {
            gamma_optimum: best.gamma_optimum.min(found.gamma_optimum),
            lower: best.lower.max(found.lower),
            ..found
        }),
        Err(_) => Ok(found),
    })
}

/// A gamma sought no nearer than this is one of many.
const ROUGH: f64 = 1e-3;

/// The same without the repetitions: for one of many controllers, each a step on the way.
pub(crate) fn synthesise_once(plant: &GeneralisedPlant, options: Options) -> Result<Design, SynthesisError> {
    let least = least_gamma_within(plant, options);
    directly(plant, &least, options)
}

/// A controller that is built more than this many times the back-off asked for above the least gamma is also sought
/// with weights and noises added: the bound that results is often lower.
const FAR_ABOVE: f64 = 1.5;

/// The design for the plant as it is.
fn as_given(plant: &GeneralisedPlant, least: &Least, options: Options) -> Result<Design, SynthesisError> {
    let outcome = directly(plant, least, options);
    // The bound of a finished loop uses skew scalings: it says nothing of the least gamma without them.
    if options.scalings == ScalingClass::Symmetric || is_settled(&outcome, options) {
        return outcome;
    }
    let mut best = outcome;
    for slowed in slowed(plant) {
        let least = least_gamma_within(&slowed.plant, options);
        let found = directly(&slowed.plant, &least, options);
        let settled = is_settled(&found, options);
        let faster = |found| at_speed(plant, (&slowed, &least), found, &best, options);
        if let Some(design) = found.ok().and_then(faster) {
            best = Ok(design);
            if settled {
                break;
            }
        }
    }
    best
}

/// A gap between gamma and its lower bound, relative to gamma, that leaves the question open.
const OPEN_GAP: f64 = 0.01;

/// Whether there is nothing to be gained: the problem is infeasible, or gamma and the controller are as good as they
/// get.
fn is_settled(outcome: &Result<Design, SynthesisError>, options: Options) -> bool {
    match outcome {
        Ok(design) => {
            let (least, proved) = (design.gamma_optimum, design.certified.gamma);
            design.lower >= (1.0 - OPEN_GAP) * least && proved <= (1.0 + 2.0 * options.back_off) * least
        }
        Err(error) => !matches!(error, SynthesisError::Numerical { .. }),
    }
}

/// A design for a slowed plant, with the bound of the loop that its controller closes round the plant itself, where
/// that is better than what is known.
fn at_speed(
    plant: &GeneralisedPlant,
    (slowed, least): (&Slowed, &Least),
    found: Design,
    known: &Result<Design, SynthesisError>,
    options: Options,
) -> Option<Design> {
    let bound = |found: &Design| {
        let closed = plant.close(&found.controller);
        bounded_gain(&closed, &LoopError::none(&closed), &slowed.at_speed(&found.certified)).ok()
    };
    let certified = bound(&found)?;
    let better = known.as_ref().map_or(true, |known| certified.gamma < known.certified.gamma);
    if !better {
        return None;
    }
    // A loop closer to the least gamma says more of it.
    let nearer = Options { back_off: NEARER_BACK_OFF * options.back_off, ..options };
    let nearer = directly(&slowed.plant, least, nearer).ok().and_then(|found| bound(&found));
    let mut gamma_optimum = nearer.map_or(certified.gamma, |nearer| nearer.gamma.min(certified.gamma));
    let (mut lower, mut multipliers) = (0.0, vec![]);
    if let Ok(known) = known {
        gamma_optimum = gamma_optimum.min(known.gamma_optimum);
        (lower, multipliers) = (known.lower, known.multipliers.clone());
    }
    let within = options.gamma_limit.is_none_or(|limit| gamma_optimum <= limit);
    within.then_some(Design { gamma_optimum, lower, multipliers, certified, ..found })
}

/// How far from the least gamma a loop is closed only to learn that gamma, relative to the back-off.
const NEARER_BACK_OFF: f64 = 0.02;
