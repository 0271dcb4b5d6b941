//! Controller design for a plant without parameters, by Riccati equations only.
//!
//! If a path has a zero on the imaginary axis or at infinity, the equations have no solution at any gain. The least
//! gain is then bracketed by those of two shifted plants, and the controller is that of the plant with a little noise
//! at its controls and a little weight on its measurements, in addition to [`Regularisation`]. Removing inputs and
//! outputs does not raise a loop's gain: the bound is that of the loop with the given plant.

use crate::analysis::gain_bound::GainBound;
use crate::error::SynthesisError;
use crate::matrix::Mat;
use crate::riccati::bound::{NORM_RESOLUTION, WideLoop};
use crate::riccati::equations::{WideController, WidePlant};
use crate::riccati::least::{Bracket, least_gain};
use crate::riccati::wide::{Quad, Wide, concatenated};
use crate::synthesis::design::{Design, FAR_ABOVE, Options};
use crate::synthesis::regularity::Regularisation;
use crate::system::{Controller, GeneralisedPlant, parameter_grid};

/// Returns the design for a plant without parameters, if the Riccati equations give one.
///
/// # Errors
/// Returns [`SynthesisError::AboveLimit`]; [`SynthesisError::Numerical`] if the limit lies within the bracket of the
/// least gain, or no controller near it can be computed. `None` if no bracket is found.
pub(crate) fn synthesise(
    plant: &GeneralisedPlant,
    options: Options,
) -> Option<(Bracket, Result<Design, SynthesisError>)> {
    let least = least_gain(plant)?;
    let outcome = match options.gamma_limit {
        Some(limit) if least.lower > limit => {
            let free = Options { gamma_limit: None, ..options };
            let found = design(plant, least, free);
            let dominant =
                found.and_then(|d| plant.close(&d.controller).frozen(&[]).ok()?.dominant_channel());
            Err(SynthesisError::AboveLimit { optimum: least.upper, lower: least.lower, limit, dominant })
        }
        Some(limit) if least.upper > limit => Err(SynthesisError::undecided(least.upper, least.lower, limit)),
        _ => design(plant, least, options).ok_or_else(|| {
            let Bracket { upper, lower } = least;
            let [from, to] = [lower, upper].map(|gamma| format!("{gamma:.4e}"));
            let least = if from == to { to } else { format!("between {from} and {to}") };
            let diagnosis = format!(
                "the least gamma is {least} (Riccati equations with 32 digits), but every controller near it is lost \
                 by rounding to 16 digits; use balanced coordinates for the states, or remove modes far slower or \
                 faster than the loop"
            );
            SynthesisError::numerical("controller by Riccati equations", diagnosis)
        }),
    };
    Some((least, outcome))
}

/// Returns a design within the back-off of the least gain, or not far above it, or the best; `None` if there is none.
fn design(plant: &GeneralisedPlant, least: Bracket, options: Options) -> Option<Design> {
    let most = (1.0 + options.back_off) * least.upper;
    let near_enough = (1.0 + FAR_ABOVE * options.back_off) * least.upper;
    let mut best: Option<Design> = None;
    for (tried, changed) in changes(plant, least.upper, options.back_off).enumerate() {
        for share in SHARES {
            crate::stop::check();
            let built_at = (1.0 + share * options.back_off) * least.upper;
            let Some((controller, certified)) = changed.controller(plant, built_at, most, options) else {
                continue;
            };
            let near = certified.gamma <= most;
            if best.as_ref().is_none_or(|best| certified.gamma < best.certified.gamma) {
                let (lower, regularisation) = (least.lower, changed.added.clone());
                let optimum = least.upper.min(certified.gamma);
                let found = Design::new(controller, optimum, built_at, certified);
                best = Some(Design { lower, regularisation, ..found });
            }
            if near {
                return best;
            }
        }
        if tried >= LEAST_CHANGES && best.as_ref().is_some_and(|best| best.certified.gamma <= near_enough) {
            break;
        }
    }
    best
}

/// Returns the bound of a plant without controls or measurements, as a design without a controller.
pub(crate) fn gain_alone(plant: &GeneralisedPlant, options: Options) -> Option<Design> {
    let size = plant.sizes();
    let controller = Controller::from_matrix(&Mat::zeros(size.u, size.y), 0, size.y, size.u, vec![]);
    let closed = WideLoop::new(plant, &WideController::new(&controller))?;
    let norm = closed.norm()?;
    let certified = closed.bound(norm, f64::INFINITY, options.back_off)?;
    let lower = (1.0 - NORM_RESOLUTION) * norm;
    Some(Design { lower, ..Design::new(controller, norm, norm, certified) })
}

/// A plant with additional inputs w and outputs z.
struct Changed {
    plant: WidePlant,
    added: Option<Regularisation>,
}

impl Changed {
    /// Returns the central controller at a gain, and the bound of the loop that it closes with the given plant.
    fn controller(
        &self,
        plant: &GeneralisedPlant,
        built_at: f64,
        most: f64,
        options: Options,
    ) -> Option<(Controller, GainBound)> {
        let limit = options.fastest_mode.unwrap_or(f64::INFINITY);
        let bounded = |k: &WideController| {
            let rounded = k.rounded()?;
            let closed = WideLoop::new(plant, &WideController::new(&rounded))?;
            let (guess, slack) = (closed.guess(), options.back_off.min(LARGEST_SLACK));
            let certified = closed.bound(guess, most, slack).or_else(|| {
                let norm = closed.norm().filter(|norm| *norm <= MOST_LOST * built_at)?;
                closed.bound(norm, f64::INFINITY, LARGEST_SLACK)
            })?;
            Some((rounded, certified))
        };
        let central = self.plant.central(&self.plant.solve(built_at)?)?;
        if central.rounded()?.fastest_mode(&parameter_grid(0)) > limit {
            return None;
        }
        let near = |found: &(Controller, GainBound)| found.1.gamma <= most;
        // Balanced coordinates of the loop, if rounding in the plant's coordinates spoils the controller.
        let rebalanced = || {
            let closed = WideLoop::new(plant, &central)?;
            bounded(&central.in_coordinates(&closed.balanced_coordinates(built_at, plant.sizes().x)?)?)
        };
        let found = bounded(&central);
        if found.as_ref().is_some_and(near) { found } else { rebalanced().or(found) }
    }
}

/// Returns the given plant, then with decreasing noise, weight or both that cost only a fraction of the back-off.
fn changes(plant: &GeneralisedPlant, gamma: f64, back_off: f64) -> impl Iterator<Item = Changed> {
    let affordable = (1.0 + NOISE_SHARE * back_off) * gamma;
    let given = WidePlant::new(plant);
    let regular = given.is_regular();
    let sizes = if regular { &SIZES[..SIZES_OF_REGULAR] } else { &SIZES[..] };
    let with_noise = sizes.iter().flat_map(move |&size| {
        let added = Some(Regularisation::new(plant, size)).filter(|added| !regular && !added.is_empty());
        let alone = WidePlant::new(&added.as_ref().map_or_else(|| plant.clone(), |added| added.apply(plant)));
        let weighted = |plant: &WidePlant| plant.dual().with_noise(size * gamma).dual();
        let noisy = alone.with_noise(size * gamma);
        let plants = [weighted(&noisy), weighted(&alone)].into_iter().chain(added.is_some().then_some(alone));
        let plants = std::iter::once(noisy).chain(plants);
        plants.map(move |plant| Changed { plant, added: added.clone() })
    });
    let affordable = with_noise.filter(move |changed| changed.plant.solve(affordable).is_some());
    std::iter::once(Changed { plant: given, added: None }).chain(affordable.take(MOST_CHANGES))
}

impl WidePlant {
    /// Returns the plant with one more disturbance per control, acting at the control, of a size relative to the
    /// control's weight.
    fn with_noise(&self, size: f64) -> Self {
        let (z, y, u) = (self.c1.nrows(), self.c2.nrows(), self.b2.ncols());
        let weight = |j: usize| self.d12.column(j).iter().map(|v| v.0 * v.0).sum::<f64>().sqrt();
        let noise =
            Wide::from_fn(self.a.nrows(), u, |i, j| self.b2[(i, j)] * Quad::from_f64(size / weight(j)));
        Self {
            b1: concatenated(&self.b1, &noise),
            d11: concatenated(&self.d11, &Wide::zeros(z, u)),
            d21: concatenated(&self.d21, &Wide::zeros(y, u)),
            ..self.clone()
        }
    }
}

/// The number of changed plants that are tried, in addition to the given one, before a bound above the back-off is
/// taken.
const LEAST_CHANGES: usize = 4;

/// The relative distance above the least gain at which a controller is built, as fractions of the back-off.
const SHARES: [f64; 3] = [1.0, 0.5, 0.2];

/// The factor between a loop's norm and the gain of its controller's design above which rounding spoilt the loop.
const MOST_LOST: f64 = 10.0;

/// The largest relative excess of a loop's bound over its norm.
const LARGEST_SLACK: f64 = 0.1;

/// The fraction of the back-off that noise and weight may cost.
const NOISE_SHARE: f64 = 0.4;

/// Noises and weights, relative to the controls' weights and the measurements' noise. If there are none, they are
/// relative to balanced coordinates of the plant, whose size is arbitrary.
const SIZES: [f64; 17] = [
    1e-1, 3e-2, 1e-2, 3e-3, 1e-3, 3e-4, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12, 1e-13, 1e-14,
];

/// The number of them used for plants with weights and noise.
const SIZES_OF_REGULAR: usize = 9;

/// The largest number of modified plants: if rounding spoils the controllers of all these, more do not help.
const MOST_CHANGES: usize = 9;
