//! Claim `rate` of a certificate: bound for a parameter with a bounded rate, for the plant and for the ball of models
//! around it.

use crate::error::ProofError;
use squid_certificate::{Claim, Rate};
use squid_lpv::bounded_rate::{Claim as Attempt, SlowBound, covering, intervals};
use squid_lpv::error::SynthesisError;
use squid_lpv::matrix::to_rows;
use squid_lpv::model_error::LoopError;
use squid_lpv::plant::ClosedLoop;

/// Factors, tried in turn, on the gamma of the fit for the ball, and on the multiplier of Delta found for arbitrarily
/// fast changes of speed.
const RAISES: [f64; 6] = [1.005, 1.01, 1.02, 1.03, 1.05, 1.1];
const FACTORS: [f64; 7] = [1.0, 0.5, 2.0, 0.25, 4.0, 0.1, 10.0];

/// Returns the claim that covers the model error, from a bound of the loop without it, with the same Lyapunov matrix or
/// another.
///
/// # Errors
/// [`ProofError::Synthesis`] if no bound covers the model error.
pub fn with_error(
    closed: &ClosedLoop,
    error: &LoopError,
    slow: &SlowBound,
    lambda: f64,
) -> Result<Claim, ProofError> {
    // The multiplier of the transposed loop is the reciprocal.
    let start = if slow.inverse { 1.0 / lambda } else { lambda };
    let tries = RAISES.iter().flat_map(|raise| FACTORS.iter().map(move |factor| (raise, factor)));
    let claims = tries.map(|(raise, factor)| Attempt {
        closed,
        error,
        inverse: slow.inverse,
        lyapunov: &slow.lyapunov,
        rate: slow.rate,
        gamma: raise * slow.gamma,
        lambda: factor * start,
    });
    let covered = claims
        .into_iter()
        .find_map(intervals)
        .or_else(|| covering(closed, error, slow.rate, slow.gamma, lambda))
        .ok_or_else(|| SynthesisError::Numerical {
            stage: "model error at a bounded rate",
            diagnosis:
                "no Lyapunov matrix was found that bounds the gain for the models in the ball around the fit; raise \
                        'synthesis.back_off', or 'model.order' for a smaller ball"
                    .into(),
        })?;
    Ok(rate(&covered, Some(covered.lambda)))
}

/// Returns the claim of a bound; with `lambda`, for the model error.
pub fn rate(bound: &SlowBound, lambda: Option<f64>) -> Claim {
    Claim::Rate(Rate {
        rate: bound.rate,
        gamma: bound.gamma,
        lambda,
        inverse: bound.inverse,
        x: bound.lyapunov.iter().map(to_rows).collect(),
        breakpoints: bound.breakpoints.clone(),
        n: bound.multipliers.iter().map(to_rows).collect(),
    })
}
