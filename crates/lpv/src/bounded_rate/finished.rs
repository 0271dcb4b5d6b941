//! The gain of a finished loop at a bounded rate, by Lyapunov matrices of rising order.
//!
//! For each order the least gain at many values of theta is sought, with the inequality of F. Wu, X. H. Yang, A.
//! Packard, G. Becker, Int. J. Robust Nonlinear Control 6, 1996. At a gamma somewhat above it the same Lyapunov matrix
//! is shown to hold between the values by multipliers on intervals ([`mod@crate::bounded_rate::intervals`]). What is
//! returned holds on the whole range, and not at the values alone.

use crate::analysis::rate::rate_bounded_gain;
use crate::analysis::rate_program::RateOptions;
use crate::bounded_rate::intervals::{Claim, SlowBound, intervals};
use crate::error::{RateError, SynthesisError};
use crate::system::model_error::LoopError;
use crate::system::plant::ClosedLoop;

const STAGE: &str = "gain at a bounded rate";

/// Orders of the Lyapunov matrix, tried in turn.
const ORDERS: [usize; 4] = [2, 4, 6, 8];

/// A higher order is tried as long as the last one lowered the bound by this part of it.
const WORTH_MORE: f64 = 2e-3;

/// Unknowns of the Lyapunov matrix, at most: with as many the search takes some ten seconds. The lowest order is tried
/// whatever it takes, up to a number of states; with more unknowns it is affine in theta.
const MOST_UNKNOWNS: usize = 650;
const MOST_STATES: usize = 40;

/// Values of theta at which the inequality is checked, each how manieth it is imposed at first, and how far above the
/// least gain there the one shown on the whole range is, relative to it. The more values, the less is missed between
/// them.
const SAMPLES: [(usize, usize, &[f64]); 2] = [(81, 4, &[1e-3]), (321, 16, &[1e-3, 3e-3, 1e-2])];

/// How near to the least gain at the values the one sought is.
const ACCURACY: f64 = 5e-4;

/// A bound of the L2 gain of a loop of one parameter with `|theta'| <= rate`, in units of theta per unit of time.
///
/// The order of the Lyapunov matrix is raised from 2 to 8 as long as the bound falls by more than 0.2 % and the unknowns
/// are not too many.
///
/// # Errors
/// [`RateError::Unstable`] when the loop is not stable at a constant theta; [`RateError::Inequality`] when no bound is
/// found, with what the last order that was tried failed at.
pub fn finished(closed: &ClosedLoop, rate: f64) -> Result<SlowBound, RateError> {
    let mut best: Option<SlowBound> = None;
    let mut failure = None;
    for order in orders(closed.a().nrows()) {
        let before = best.as_ref().map(|known| known.gamma);
        match of_order(closed, rate, order) {
            Ok(found) if before.is_none_or(|known| found.gamma < known) => best = Some(found),
            Ok(_) => break,
            Err(unstable @ RateError::Unstable { .. }) => return Err(unstable),
            Err(e) => failure = Some(e),
        }
        let (Some(before), Some(now)) = (before, &best) else { continue };
        if now.gamma > (1.0 - WORTH_MORE) * before {
            break;
        }
    }
    let none = || numerical(format!("the loop has more than {MOST_STATES} states"));
    best.ok_or_else(|| failure.unwrap_or_else(none))
}

/// The orders that are tried for a loop of so many states.
fn orders(states: usize) -> Vec<usize> {
    let unknowns = |order: usize| (order + 1) * states * (states + 1) / 2;
    let few: Vec<usize> = ORDERS.into_iter().filter(|order| unknowns(*order) <= MOST_UNKNOWNS).collect();
    match few.is_empty() {
        true if states <= MOST_STATES => vec![1],
        _ => few,
    }
}

fn numerical(words: String) -> RateError {
    SynthesisError::numerical(STAGE, words).into()
}

/// The bound by a Lyapunov matrix of an order: at more values of theta and a larger gamma where it does not hold
/// between them.
fn of_order(closed: &ClosedLoop, rate: f64, order: usize) -> Result<SlowBound, RateError> {
    let error = &LoopError::none(closed);
    for (count, stride, raises) in SAMPLES {
        let samples = closed.sampled(count).map_err(|e| numerical(e.to_string()))?;
        let found = rate_bounded_gain(&samples, rate, RateOptions { order, stride, accuracy: ACCURACY })?;
        let lyapunov = &found.proof.lyapunov.coefficients;
        let claims = raises.iter().map(|raise| Claim {
            closed,
            error,
            inverse: false,
            lyapunov,
            rate,
            gamma: (1.0 + raise) * found.gamma,
            lambda: 0.0,
        });
        if let Some(bound) = claims.into_iter().find_map(intervals) {
            return Ok(bound);
        }
    }
    Err(numerical(format!(
        "a Lyapunov matrix of order {order} holds at values of theta, but not between them"
    )))
}
