//! The section `bounded_rate` of the certificate: the bound for a parameter that moves at a bounded rate, for the plant
//! and for the ball of models around it.

use crate::error::ProofError;
use certificate::{BoundedRate, Slow, SlowResidual};
use lpv::bounded_rate::{Claim, SlowBound, covering, intervals};
use lpv::error::SynthesisError;
use lpv::matrix::to_rows;
use lpv::model_error::LoopError;
use lpv::plant::ClosedLoop;

/// By how much the gamma of the fit is raised for the ball, and how the multiplier of Delta is varied around the one
/// for a speed that moves however fast: tried in turn.
const RAISES: [f64; 6] = [1.005, 1.01, 1.02, 1.03, 1.05, 1.1];
const FACTORS: [f64; 7] = [1.0, 0.5, 2.0, 0.25, 4.0, 0.1, 10.0];

/// The section for a bound of a loop, with a bound that covers the model error: by the same Lyapunov matrix, or by
/// one of its own.
///
/// # Errors
/// [`ProofError::Synthesis`] when no bound covers the model error.
pub fn bounded_rate(
    closed: &ClosedLoop,
    error: &LoopError,
    slow: &SlowBound,
    lambda: f64,
) -> Result<BoundedRate, ProofError> {
    // That of the transposed loop is the reciprocal.
    let own = if slow.inverse { 1.0 / lambda } else { lambda };
    let tries = RAISES.iter().flat_map(|raise| FACTORS.iter().map(move |factor| (raise, factor)));
    let claims = tries.map(|(raise, factor)| Claim {
        closed,
        error,
        inverse: slow.inverse,
        lyapunov: &slow.lyapunov,
        rate: slow.rate,
        gamma: raise * slow.gamma,
        lambda: factor * own,
    });
    let covered = claims
        .into_iter()
        .find_map(intervals)
        .or_else(|| covering(closed, error, slow.rate, slow.gamma, lambda))
        .ok_or_else(|| SynthesisError::Numerical {
            stage: "model error at a bounded rate",
            diagnosis:
                "no Lyapunov matrix found shows a gain for the models in the ball around the fit; raise \
                        'synthesis.back_off', or 'model.order' for a smaller ball"
                    .into(),
        })?;
    let residual = Some(SlowResidual { lambda: covered.lambda, slow: section(&covered) });
    Ok(BoundedRate { residual, ..of_plant_alone(slow) })
}

/// The section for a bound of a loop, without model error.
pub fn of_plant_alone(slow: &SlowBound) -> BoundedRate {
    BoundedRate { rate: slow.rate, slow: section(slow), residual: None }
}

fn section(bound: &SlowBound) -> Slow {
    Slow {
        gamma: bound.gamma,
        inverse: bound.inverse,
        x: bound.lyapunov.iter().map(to_rows).collect(),
        breakpoints: bound.breakpoints.clone(),
        n: bound.multipliers.iter().map(to_rows).collect(),
    }
}
