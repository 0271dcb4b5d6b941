//! Controllers for singular problems: a small weight on what no output weighs, a small noise on what no disturbance
//! enters.
//!
//! Without them the least gamma is an infimum that gains without limit approach, and the arithmetic may fail on the
//! way (see [`crate::synthesis::regularity`]). With them the plant has one more output for each such direction of the
//! controls, and one more disturbance for each such combination of measurements:
//!
//! ```text
//! z+ = e v' u~,   y~ + e c w+
//! ```
//!
//! A loop with outputs and disturbances left out has no larger gain, and the matrices that bound the gain with them,
//! rows and columns left out, bound it without: the bound of the plant as given comes with that of the plant so
//! changed, and is then tightened. Source of the idea: K. Zhou, J. C. Doyle, K. Glover, "Robust and Optimal
//! Control", 1996, section 17.1.

use crate::analysis::bounded_gain::{Base, bounded_gain, clearest};
use crate::analysis::gain_bound::GainBound;
use crate::synthesis::design::{Design, Options};
use crate::synthesis::direct::directly;
use crate::synthesis::inequalities::LmiSolution;
use crate::synthesis::least_gamma::least_gamma;
pub use crate::synthesis::regularity::Regularisation;
use crate::system::model_error::LoopError;
use crate::system::plant::GeneralisedPlant;

/// A design for a plant of which the least gamma may be known, but no controller: that of the plant with weights and
/// noises added.
///
/// How small the arithmetic lets these be is tried out. The first bound near the least gamma is taken, or
/// the best of all; of a least gamma that is zero but for rounding the first, for none is near it.
pub(crate) fn design(
    plant: &GeneralisedPlant,
    least: Option<&LmiSolution>,
    options: Options,
) -> Option<Design> {
    let mut best: Option<Design> = None;
    for (size, share) in SIZES_AND_SHARES {
        let sought = Options { back_off: share * options.back_off, gamma_limit: None, ..options };
        let Some(found) = attempt(plant, size, sought) else { continue };
        if best.as_ref().is_none_or(|best| found.certified.gamma < best.certified.gamma) {
            best = Some(found);
        }
        let (Some(least), Some(best)) = (least, &best) else { continue };
        let bound = best.certified.gamma;
        if bound <= (1.0 + NEAR_SHARE * options.back_off) * least.gamma || is_nothing(least.gamma, bound) {
            break;
        }
    }
    let best = best?;
    let bound = best.certified.gamma;
    Some(Design {
        gamma_optimum: least.map_or(bound, |least| least.gamma.min(bound)),
        lower: least.map_or(0.0, |least| least.lower),
        multipliers: least.map_or_else(Vec::new, |least| least.multipliers.clone()),
        ..best
    })
}

/// Whether a least gamma is zero but for rounding: there is then none that is attained, and no controller is
/// near it.
pub fn is_nothing(least: f64, bound: f64) -> bool {
    least < ZERO_GAMMA_RATIO * bound
}

/// The controller of the plant with weights and noises of a size, and a clear bound of the loop that it closes round
/// the plant as given.
fn attempt(plant: &GeneralisedPlant, size: f64, options: Options) -> Option<Design> {
    let added = Regularisation::new(plant, size);
    if added.is_empty() {
        return None;
    }
    let changed = added.apply(plant);
    let design = directly(&changed, &least_gamma(&changed, options.scalings), options).ok()?;
    let closed = plant.close(&design.controller);
    let error = LoopError::none(&closed);
    let known = bounded_gain(&closed, &error, &design.certified).ok();
    if let Some(certified) = known.clone().filter(|bound| bound.largest_eigenvalue < -ROUNDING_EIGENVALUE) {
        return Some(Design { certified, regularisation: Some(added), ..design });
    }
    // What holds by so little may be rounding, and may not hold for the same reason.
    let base = known.clone().unwrap_or(design.certified.clone());
    let room = GainBound { gamma: GAMMA_RAISE * base.gamma, ..base };
    let clearer = clearest(Base { closed: &closed, error: &error, bound: &room }).ok();
    let eigenvalue = known.as_ref().map_or(0.0, |known| known.largest_eigenvalue);
    let certified = clearer.filter(|design| design.largest_eigenvalue < eigenvalue).or(known)?;
    Some(Design { certified, regularisation: Some(added), ..design })
}

/// Sizes of weights and noises, relative to what else reaches z and enters y, each with the part of the back-off
/// asked for that the design keeps from the least gamma of the plant with them: they keep X Y off I, too. The first
/// costs a few per cent of most gammas, and leaves gains that double precision can hold.
const SIZES_AND_SHARES: [(f64, f64); 12] = [
    (1e-3, 0.2),
    (3e-3, 0.1),
    (1e-3, 0.5),
    (3e-4, 0.2),
    (1e-4, 0.2),
    (1e-2, 0.1),
    (3e-5, 0.2),
    (3e-2, 0.1),
    (1e-5, 0.2),
    (1e-1, 0.2),
    (1e-6, 0.2),
    (1e-1, 1.0),
];

/// A bound is near the least gamma within this part of the back-off that was asked for.
const NEAR_SHARE: f64 = 0.5;

/// A least gamma below this fraction of a bound counts as zero.
const ZERO_GAMMA_RATIO: f64 = 1e-6;

/// An eigenvalue of the inequalities, scaled to a unit diagonal, nearer to zero than this may be rounding.
const ROUNDING_EIGENVALUE: f64 = 1e-11;

/// How far the bound is raised, as a factor, in order to hold more clearly.
const GAMMA_RAISE: f64 = 1.01;
