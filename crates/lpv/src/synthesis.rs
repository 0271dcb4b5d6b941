//! LPV synthesis: from a generalised plant to a scheduled controller and a bound of the loop's gain.
//!
//! The inequalities and their sources are in [`Scalings`]'s file; this one strings the steps together.

use crate::analysis::{GainBound, bounded_gain};
use crate::back_off::centre;
use crate::balance::Coordinates;
use crate::controller::Controller;
use crate::error::SynthesisError;
use crate::fast_modes::{Slowed, slowed};
pub use crate::inequalities::{DualMultipliers, Existence, Scalings};
pub use crate::least_gamma::least_gamma;
use crate::least_gamma::{equalised, smallest};
use crate::model_error::LoopError;
use crate::plant::GeneralisedPlant;
use crate::quadratic::{Stabilisation, stabilisation};
use crate::reconstruct::reconstruct;
use crate::regularise::{self, Regularisation};
use crate::solver::numerical;

/// How a controller is sought.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// The scalings.
    pub scalings: Scalings,
    /// The controller is built at `(1 + back_off)` times the least gamma, where X Y keeps off I. Where no controller
    /// can be built so close to it, the back-off is doubled, twice at most.
    pub back_off: f64,
    /// A least gamma above this counts as infeasible.
    pub gamma_limit: Option<f64>,
    /// No mode of the frozen controller may be faster than this, rad/s.
    pub fastest_mode: Option<f64>,
}

impl Default for Options {
    fn default() -> Self {
        Self { scalings: Scalings::SymmetricAndSkew, back_off: 0.1, gamma_limit: None, fastest_mode: None }
    }
}

/// A controller with what is known of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Design {
    /// The controller, in the plant's coordinates.
    pub controller: Controller,
    /// The least gamma that the synthesis inequalities allow.
    pub gamma_optimum: f64,
    /// An estimate of how low the least gamma may be, from multipliers in floating point; 0 when nothing is known. It is no bound.
    pub lower_estimate: f64,
    /// Multipliers that may prove a lower bound of the least gamma, the most promising first.
    pub multipliers: Vec<DualMultipliers>,
    /// The gamma at which the controller was built.
    pub gamma_design: f64,
    /// The gain bound of the closed loop, with the matrices that show it.
    pub certified: GainBound,
    /// What was added to the plant for the design of the controller, where none could be built without; gamma_design is then of the
    /// plant with it, and all else of the plant as given.
    pub regularisation: Option<Regularisation>,
}

/// Designs a controller and bounds the gain of the loop that it closes.
///
/// Where the search is unsure of gamma, and some modes are far faster than the others, it is repeated for the plant with these modes slowed; the bound is
/// always of the loop with the plant itself. Where no controller can be computed and something has no weight or no noise, it is repeated with
/// a little of both ([`crate::regularise`]).
///
/// # Errors
/// Kept apart are: a design; [`SynthesisError::is_infeasible`] for a problem without solution; [`SynthesisError::TooFast`] when only
/// controllers beyond the limit were found; [`SynthesisError::Numerical`] when nothing is known.
pub fn synthesise(plant: &GeneralisedPlant, options: Options) -> Result<Design, SynthesisError> {
    plant.check()?;
    crate::modes::check_stabilisable(plant)?;
    crate::modes::check_detectable(plant)?;
    match as_given(plant, options) {
        Err(reason @ SynthesisError::Numerical { .. }) => {
            let least = least_gamma(plant, options.scalings).ok();
            let least = least.map(|(_, found)| found);
            regularise::design(plant, least.as_ref(), options).ok_or(reason)
        }
        outcome => outcome,
    }
}

/// The design for the plant as it is.
fn as_given(plant: &GeneralisedPlant, options: Options) -> Result<Design, SynthesisError> {
    let outcome = directly(plant, options);
    // The bound of a finished loop uses skew scalings: it tells nothing of the least gamma without them.
    if options.scalings == Scalings::Symmetric || is_settled(&outcome, options) {
        return outcome;
    }
    let mut best = outcome;
    for slowed in slowed(plant) {
        let found = directly(&slowed.plant, options);
        let settled = is_settled(&found, options);
        if let Some(design) = found.ok().and_then(|found| at_speed(plant, &slowed, found, &best, options)) {
            best = Ok(design);
            if settled {
                break;
            }
        }
    }
    best
}

/// A gap between gamma and its lower bound, relative to gamma, that leaves the question open.
const DOUBTFUL: f64 = 0.01;

/// Whether there is nothing to be gained: the problem is infeasible, or gamma and the controller are as good as they get.
fn is_settled(outcome: &Result<Design, SynthesisError>, options: Options) -> bool {
    match outcome {
        Ok(design) => {
            let (least, proved) = (design.gamma_optimum, design.certified.gamma);
            design.lower_estimate >= (1.0 - DOUBTFUL) * least
                && proved <= (1.0 + 2.0 * options.back_off) * least
        }
        Err(error) => !matches!(error, SynthesisError::Numerical { .. }),
    }
}

/// A design for a slowed plant, with the bound of the loop that its controller closes round the plant itself, where that is better than what is known.
fn at_speed(
    plant: &GeneralisedPlant,
    slowed: &Slowed,
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
    // A loop closer to the least gamma tells more of it.
    let nearer = Options { back_off: CLOSE * options.back_off, ..options };
    let nearer = directly(&slowed.plant, nearer).ok().and_then(|found| bound(&found));
    let mut gamma_optimum = nearer.map_or(certified.gamma, |nearer| nearer.gamma.min(certified.gamma));
    let (mut lower_estimate, mut multipliers) = (0.0, vec![]);
    if let Ok(known) = known {
        gamma_optimum = gamma_optimum.min(known.gamma_optimum);
        (lower_estimate, multipliers) = (known.lower_estimate, known.multipliers.clone());
    }
    let within = options.gamma_limit.is_none_or(|limit| gamma_optimum <= limit);
    within.then_some(Design { gamma_optimum, lower_estimate, multipliers, certified, ..found })
}

/// How far from the least gamma a loop is closed only to tell it, relative to the back-off.
const CLOSE: f64 = 0.02;

/// The design in one go.
pub(crate) fn directly(plant: &GeneralisedPlant, options: Options) -> Result<Design, SynthesisError> {
    let (coordinates, optimum) = match least_gamma(plant, options.scalings) {
        Ok(found) => found,
        Err(error) => return explained(plant, Err(error), options),
    };
    if let Some(limit) = options.gamma_limit.filter(|limit| optimum.gamma > *limit) {
        return Err(above_limit(plant, &coordinates, &optimum, limit, options));
    }
    let outcome = build(plant, &coordinates, &optimum, options);
    explained(plant, outcome.map(|design| consistent(design, options.scalings)), options)
}

/// The bound of a loop, shown with skew scalings, shows that the least gamma with them is no larger.
fn consistent(design: Design, scalings: Scalings) -> Design {
    if scalings == Scalings::Symmetric {
        return design;
    }
    Design { gamma_optimum: design.gamma_optimum.min(design.certified.gamma), ..design }
}

/// A failure may be that no gamma exists at all: then the solver only saw gamma grow.
fn explained(
    plant: &GeneralisedPlant,
    outcome: Result<Design, SynthesisError>,
    options: Options,
) -> Result<Design, SynthesisError> {
    match outcome {
        Err(SynthesisError::Numerical { .. } | SynthesisError::Infeasible { .. }) => {
            match (stabilisation(plant, options.scalings), outcome) {
                (Stabilisation::Impossible(reason), _) => Err(reason),
                (Stabilisation::Possible, Err(SynthesisError::Infeasible { stage })) => Err(numerical(
                    stage,
                    "the solver finds no gamma, but the plant can be stabilised; check units and weights".into(),
                )),
                (Stabilisation::Unknown, Err(SynthesisError::Infeasible { stage })) => Err(numerical(
                    stage,
                    "the solver finds no gamma, and could not tell whether the plant can be stabilised for every course of the \
                     parameters; narrow their range, or check units and weights"
                        .into(),
                )),
                (_, outcome) => outcome,
            }
        }
        other => other,
    }
}

/// Builds the controller a little above the least gamma, or farther where none can be built so close.
fn build(
    plant: &GeneralisedPlant,
    coordinates: &Coordinates,
    optimum: &Existence,
    options: Options,
) -> Result<Design, SynthesisError> {
    let mut first_failure = None;
    for factor in [1.0, 2.0, 4.0] {
        for basis in [Basis::Equalised, Basis::AsFound] {
            let gamma = optimum.gamma * (1.0 + factor * options.back_off);
            match build_at(gamma, basis, plant, coordinates, optimum, options) {
                Err(error @ (SynthesisError::Numerical { .. } | SynthesisError::TooFast { .. })) => {
                    first_failure.get_or_insert(error);
                }
                settled => return settled,
            }
        }
    }
    Err(first_failure.unwrap_or_else(|| numerical("back-off", "no gamma was tried".into())))
}

/// The coordinates in which a controller is built.
#[derive(Clone, Copy, PartialEq)]
enum Basis {
    /// Those in which the smallest X and Y are equal.
    Equalised,
    /// Those in which the least gamma was found, for a plant so stiff that rounding spoils the others.
    AsFound,
}

fn build_at(
    gamma_design: f64,
    basis: Basis,
    plant: &GeneralisedPlant,
    coordinates: &Coordinates,
    optimum: &Existence,
    options: Options,
) -> Result<Design, SynthesisError> {
    let unit = plant.in_units_of(gamma_design);
    let small = smallest(&coordinates.apply(&unit), 1.0, optimum, options.scalings)?;
    let equal = (basis == Basis::Equalised).then(|| equalised(coordinates, &small, &unit)).flatten();
    let (coordinates, small) = match equal {
        Some(equal) => (equal.clone(), equal.carry(coordinates, &small)),
        None => (coordinates.clone(), small),
    };
    let balanced = coordinates.apply(&unit);
    let centred = centre(&balanced, 1.0, &small, options.scalings)?;
    let fastest = options.fastest_mode.map(|limit| coordinates.scaled_rate(limit));
    let (in_balance, shown) = reconstruct(&balanced, &centred, fastest)?;
    let shown = GainBound { gamma: gamma_design, ..shown };
    let controller = coordinates.undo(&in_balance);
    let closed = plant.close(&controller);
    let certified = bounded_gain(&closed, &LoopError::none(&closed), &coordinates.undo_bound(&shown))?;
    Ok(Design {
        controller,
        gamma_optimum: optimum.gamma,
        lower_estimate: optimum.lower_estimate(),
        multipliers: optimum.multipliers.clone(),
        gamma_design,
        certified,
        regularisation: None,
    })
}

/// Says by how much the limit is missed, and which channel dominates in the loop of the best controller.
fn above_limit(
    plant: &GeneralisedPlant,
    coordinates: &Coordinates,
    optimum: &Existence,
    limit: f64,
    options: Options,
) -> SynthesisError {
    if optimum.gamma * (1.0 - optimum.gap) <= limit {
        let (gamma, limit) = (optimum.gamma, limit);
        return SynthesisError::Numerical {
            stage: "limit of gamma",
            diagnosis: format!(
                "the least gamma found is {gamma:.6e}, above the limit {limit:.6e}, but the search is only sure of it to {:.1e} of itself",
                optimum.gap
            ),
        };
    }
    let dominant = build(plant, coordinates, optimum, options).ok().and_then(|design| {
        let theta = vec![0.0; plant.blocks.len()];
        plant.close(&design.controller).frozen(&theta).ok()?.dominant_channel()
    });
    SynthesisError::AboveLimit { optimum: optimum.gamma, limit, dominant }
}
