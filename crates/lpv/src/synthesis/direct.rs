//! One pass of the design: least gamma, back-off, controller, bound of the closed loop.

use crate::analysis::bounded_gain::bounded_gain;
use crate::analysis::gain_bound::GainBound;
use crate::error::SynthesisError;
use crate::riccati::least::is_none_below;
use crate::synthesis::back_off::centre;
use crate::synthesis::balance::Coordinates;
use crate::synthesis::design::{Design, Options, repetitions};
use crate::synthesis::inequalities::{LmiSolution, ScalingClass};
use crate::synthesis::least_gamma::{equalised, smallest};
use crate::synthesis::quadratic::{Stabilisation, stabilisation};
use crate::synthesis::reconstruct::reconstruct;
use crate::system::{GeneralisedPlant, LoopError};

/// The outcome of [`least_gamma`](crate::synthesis::least_gamma()).
pub(crate) type Least = Result<(Coordinates, LmiSolution), SynthesisError>;

/// Makes one pass of the design, above the least gamma of the plant.
pub(crate) fn directly(
    plant: &GeneralisedPlant,
    least: &Least,
    options: Options,
) -> Result<Design, SynthesisError> {
    let (coordinates, optimum) = match least {
        Ok(found) => found,
        Err(error) => return explained(plant, Err(error.clone()), options),
    };
    let pass = Pass { plant, coordinates, optimum, options };
    if let Some(limit) = options.gamma_limit.filter(|limit| optimum.gamma > *limit) {
        return Err(pass.above_limit(limit));
    }
    let outcome = pass.build();
    explained(plant, outcome.map(|design| consistent(design, options.scalings)), options)
}

/// Limits the least gamma with skew scalings to the bound of the closed loop, which is proved with them.
fn consistent(design: Design, scalings: ScalingClass) -> Design {
    if scalings == ScalingClass::Symmetric {
        return design;
    }
    Design { gamma_optimum: design.gamma_optimum.min(design.certified.gamma), ..design }
}

/// Explains a failure by quadratic stabilisability: if no gamma exists, the solver only sees gamma grow.
fn explained(
    plant: &GeneralisedPlant,
    outcome: Result<Design, SynthesisError>,
    options: Options,
) -> Result<Design, SynthesisError> {
    match outcome {
        Err(error @ (SynthesisError::Numerical { .. } | SynthesisError::Infeasible { .. }))
            if !options.quick =>
        {
            Err(match (stabilisation(plant, options.scalings), error) {
                (Stabilisation::Impossible(reason), _) => reason,
                (possible, SynthesisError::Infeasible { stage }) => {
                    let diagnosis = match possible {
                        Stabilisation::Possible => NO_GAMMA,
                        _ => NO_GAMMA_AND_NO_DECISION,
                    };
                    SynthesisError::numerical(stage, diagnosis)
                }
                (_, error) => error,
            })
        }
        other => other,
    }
}

const NO_GAMMA: &str =
    "the solver finds no gamma although the plant can be stabilised; check units and weights";

const NO_GAMMA_AND_NO_DECISION: &str = "the solver finds no gamma and cannot decide whether the plant can be \
    stabilised for every parameter trajectory; narrow the parameter range, or check units and weights";

/// The coordinates in which a controller is built.
#[derive(Clone, Copy, PartialEq)]
enum Basis {
    /// Coordinates in which the smallest X and Y are equal.
    Equalised,
    /// Coordinates in which the least gamma was found, for a plant so stiff that rounding spoils the others.
    AsFound,
}

/// The plant, the least gamma found, and the options.
struct Pass<'a> {
    plant: &'a GeneralisedPlant,
    coordinates: &'a Coordinates,
    optimum: &'a LmiSolution,
    options: Options,
}

impl Pass<'_> {
    /// Builds the controller slightly above the least gamma, or farther away if none can be built so close.
    fn build(&self) -> Result<Design, SynthesisError> {
        let options = self.options;
        let mut first_failure = None;
        let factors: &[f64] = if options.quick { &[1.0] } else { &[1.0, 2.0, 4.0] };
        for factor in factors.iter().take(repetitions(self.plant)) {
            for basis in [Basis::Equalised, Basis::AsFound] {
                let gamma = self.optimum.gamma * (1.0 + factor * options.back_off);
                match self.build_at(gamma, basis) {
                    Err(error @ (SynthesisError::Numerical { .. } | SynthesisError::TooFast { .. })) => {
                        first_failure.get_or_insert(error);
                    }
                    settled => return settled,
                }
            }
        }
        Err(first_failure.unwrap_or_else(|| SynthesisError::numerical("back-off", "no gamma was tried")))
    }

    fn build_at(&self, gamma_design: f64, basis: Basis) -> Result<Design, SynthesisError> {
        let Self { plant, coordinates, optimum, options } = *self;
        let unit = plant.in_units_of(gamma_design);
        let small = smallest(&coordinates.apply(&unit), 1.0, optimum, options)?;
        let equal = (basis == Basis::Equalised).then(|| equalised(coordinates, &small, &unit)).flatten();
        let (coordinates, small) = match equal {
            Some(equal) => (equal.clone(), equal.carry(coordinates, &small)),
            None => (coordinates.clone(), small),
        };
        let balanced = coordinates.apply(&unit);
        let centred = centre(&balanced, 1.0, &small, options)?;
        let fastest = options.fastest_mode.map(|limit| coordinates.scaled_rate(limit));
        let (in_balance, shown) = reconstruct(&balanced, &centred, fastest)?;
        let shown = GainBound { gamma: gamma_design, ..shown };
        let controller = coordinates.undo(&in_balance);
        let closed = plant.close(&controller);
        let certified = bounded_gain(&closed, &LoopError::none(&closed), &coordinates.undo_bound(&shown))?;
        let (lower, multipliers) = (optimum.lower, optimum.multipliers.clone());
        Ok(Design { lower, multipliers, ..Design::new(controller, optimum.gamma, gamma_design, certified) })
    }

    /// Returns the error for a missed limit, with the dominant channel of the best controller's loop.
    fn above_limit(&self, limit: f64) -> SynthesisError {
        let Self { plant, optimum, .. } = *self;
        if optimum.lower <= limit && !is_none_below(plant, limit) {
            return SynthesisError::undecided(optimum.gamma, optimum.lower, limit);
        }
        let dominant = self.build().ok().and_then(|design| {
            let theta = vec![0.0; plant.blocks.len()];
            plant.close(&design.controller).frozen(&theta).ok()?.dominant_channel()
        });
        SynthesisError::AboveLimit { optimum: optimum.gamma, lower: optimum.lower, limit, dominant }
    }
}
