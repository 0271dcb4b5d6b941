//! Controllers for singular problems: a small weight on each unweighted control, a small noise on each noiseless
//! measurement.
//!
//! The least gamma is otherwise an infimum that is approached with unbounded gains, and the arithmetic may fail (see
//! [`crate::synthesis::regularity`]). The modified plant has one more output per such direction of the controls, and
//! one more disturbance per such combination of measurements:
//!
//! ```text
//! z+ = e v' u~,   y~ + e c w+
//! ```
//!
//! Removing outputs and disturbances does not raise a loop's gain, and the matrices that bound the gain with them, with
//! rows and columns removed, bound it without: the bound of the modified plant gives one of the given plant, which is
//! then tightened. Source of the idea: K. Zhou, J. C. Doyle, K. Glover, "Robust and Optimal Control", 1996, section
//! 17.1.

use crate::analysis::bounded_gain::{Base, bounded_gain, largest_margin};
use crate::analysis::gain_bound::GainBound;
use crate::synthesis::design::{Design, Options, repetitions};
use crate::synthesis::direct::directly;
use crate::synthesis::inequalities::LmiSolution;
use crate::synthesis::least_gamma::least_gamma;
pub use crate::synthesis::regularity::Regularisation;
use crate::system::{GeneralisedPlant, LoopError};

/// Returns a design for the plant with weights and noises added, if the least gamma of the given plant may be known but
/// no controller.
///
/// Several sizes are tried, fewer for a large plant. The first bound near the least gamma is taken, or else the best;
/// if the least gamma is zero to rounding, the first, since none is near it.
pub(crate) fn design(
    plant: &GeneralisedPlant,
    least: Option<&LmiSolution>,
    options: Options,
) -> Option<Design> {
    let found = SIZES_AND_SHARES.into_iter().take(repetitions(plant)).filter_map(|(size, share)| {
        attempt(plant, size, Options { back_off: share * options.back_off, gamma_limit: None, ..options })
    });
    let best = Design::first_or_best(found, |best| {
        let bound = best.certified.gamma;
        let near =
            |least: f64| bound <= (1.0 + NEAR_SHARE * options.back_off) * least || is_zero(least, bound);
        least.is_some_and(|least| near(least.gamma))
    })?;
    let bound = best.certified.gamma;
    Some(Design {
        gamma_optimum: least.map_or(bound, |least| least.gamma.min(bound)),
        lower: least.map_or(0.0, |least| least.lower),
        multipliers: least.map_or_else(Vec::new, |least| least.multipliers.clone()),
        ..best
    })
}

/// Returns `true` if a least gamma is zero to rounding: it is then not attained, and no controller is near it.
pub fn is_zero(least: f64, bound: f64) -> bool {
    least < ZERO_GAMMA_RATIO * bound
}

/// Returns the controller of the plant with weights and noises of a size, and a bound, valid with a margin, of the loop
/// that it closes with the given plant.
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
    // A bound with so small a margin may be rounding.
    let base = known.clone().unwrap_or(design.certified.clone());
    let raised = GainBound { gamma: GAMMA_RAISE * base.gamma, ..base };
    let clearer = largest_margin(Base { closed: &closed, error: &error, bound: &raised }).ok();
    let eigenvalue = known.as_ref().map_or(0.0, |known| known.largest_eigenvalue);
    let certified = clearer.filter(|design| design.largest_eigenvalue < eigenvalue).or(known)?;
    Some(Design { certified, regularisation: Some(added), ..design })
}

/// Sizes of weights and noises, relative to the other terms in z and y, each with the fraction of the back-off used for
/// the modified plant: the weights also keep X Y away from I. The first costs a few per cent of most gammas, with gains
/// that double precision can represent.
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

/// The distance from the least gamma, as a fraction of the back-off, at which the search ends.
const NEAR_SHARE: f64 = 0.5;

/// The fraction of a bound below which a least gamma is taken as zero.
const ZERO_GAMMA_RATIO: f64 = 1e-6;

/// The magnitude below which an eigenvalue of the inequalities, scaled to a unit diagonal, may be rounding.
const ROUNDING_EIGENVALUE: f64 = 1e-11;

/// The factor by which the bound is raised to gain margin.
const GAMMA_RAISE: f64 = 1.01;
