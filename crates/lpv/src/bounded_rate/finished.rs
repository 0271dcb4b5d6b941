//! The gain of a closed loop at a bounded rate, by Lyapunov matrices of increasing order.
//!
//! The least gain at many values of theta is computed for each order from the inequality of F. Wu, X. H. Yang, A.
//! Packard, G. Becker, Int. J. Robust Nonlinear Control 6, 1996. At a gamma somewhat above it the same Lyapunov matrix,
//! or one with a larger margin, is then verified between the values by multipliers on intervals
//! ([`mod@crate::bounded_rate::intervals`]). The result holds on the whole range, not only at the values.

use crate::analysis::rate::{RateBound, rate_bounded_gain, with_raised_gamma};
use crate::analysis::rate_program::RateOptions;
use crate::bounded_rate::intervals::{Claim, SlowBound, intervals};
use crate::error::{RateError, SynthesisError};
use crate::system::{ClosedLoop, LoopError, StateSpace};

const STAGE: &str = "gain at a bounded rate";

/// Orders of the Lyapunov matrix, in the order tried.
const ORDERS: [usize; 5] = [1, 2, 4, 6, 8];

/// The relative decrease of the bound that a higher order must allow to be tried. The search stops only from order
/// [`TELLING`] on: from 1 to 2 the bound may decrease little, and from 2 to 4 much.
const WORTH_MORE: f64 = 2e-3;
const TELLING: usize = 4;

/// The largest number of unknowns of the Lyapunov matrix for orders above 1, so that a search takes seconds; and the
/// largest number of states for order 1.
const MOST_UNKNOWNS: usize = 330;
const MOST_STATES: usize = 30;

/// The number of values of theta at which the inequality is checked, and the stride of those at which it is first
/// imposed.
const SAMPLES: usize = 321;
const STRIDE: usize = 32;

/// The relative accuracy of the least gain at the values.
const ACCURACY: f64 = 5e-4;

/// Relative increases of the gain proved on the whole range over the least at the values, in the order tried.
const RAISES: [f64; 4] = [1e-3, 3e-3, 1e-2, 3e-2];

/// Returns a bound of the L2 gain of a loop with one parameter with `|theta'| <= rate` (theta per unit of time).
///
/// The order of the Lyapunov matrix is raised from 1 to 8 as long as the bound decreases by more than 0.2 % and the
/// number of unknowns allows it.
///
/// # Errors
/// Returns [`RateError::Unstable`] if the loop is not stable at a constant theta; [`RateError::Inequality`] if no bound
/// is found, with the failure of the last order.
pub fn finished(closed: &ClosedLoop, rate: f64) -> Result<SlowBound, RateError> {
    let samples = closed.sampled(SAMPLES).map_err(|e| numerical(e.to_string()))?;
    let mut best: Option<SlowBound> = None;
    let mut failure = numerical(format!("the loop has more than {MOST_STATES} states"));
    for order in orders(closed.a().nrows()) {
        let search = Search { closed, samples: &samples, order };
        let most = best.as_ref().map_or(f64::INFINITY, |known| (1.0 - WORTH_MORE) * known.gamma);
        match rate_bounded_gain(&samples, rate, search.options()) {
            Ok(least) if least.gamma >= most && order < TELLING => {}
            Ok(least) if least.gamma >= most => break,
            Ok(least) => match search.between(&least, most) {
                Some(found) => best = Some(found),
                None => {
                    failure = numerical(format!("order {order} holds only at the {SAMPLES} samples of theta"))
                }
            },
            Err(unstable @ RateError::Unstable { .. }) => return Err(unstable),
            Err(e) => failure = e,
        }
    }
    best.ok_or(failure)
}

fn numerical(diagnosis: String) -> RateError {
    SynthesisError::numerical(STAGE, diagnosis).into()
}

/// Returns the orders tried for a loop with `states` states.
fn orders(states: usize) -> impl Iterator<Item = usize> {
    let unknowns = move |order: usize| (order + 1) * states * (states + 1) / 2;
    let few = move |order: &usize| match *order {
        1 => states <= MOST_STATES,
        higher => unknowns(higher) <= MOST_UNKNOWNS,
    };
    ORDERS.into_iter().filter(few)
}

/// A loop, its samples, and the order of the Lyapunov matrix.
#[derive(Clone, Copy)]
struct Search<'a> {
    closed: &'a ClosedLoop,
    samples: &'a [(f64, StateSpace)],
    order: usize,
}

impl Search<'_> {
    fn options(self) -> RateOptions {
        RateOptions { order: self.order, stride: STRIDE, accuracy: ACCURACY }
    }

    /// Returns a bound below `most` that also holds between the samples, close to the least at the samples.
    fn between(self, least: &RateBound, most: f64) -> Option<SlowBound> {
        let raises = RAISES.iter().filter(|raise| (1.0 + **raise) * least.gamma < most);
        raises.into_iter().find_map(|raise| {
            let raised = RateBound { gamma: (1.0 + raise) * least.gamma, ..least.clone() };
            self.on_intervals(&raised).or_else(|| {
                let clear = with_raised_gamma(self.samples, self.options(), least, *raise).ok()?;
                self.on_intervals(&clear)
            })
        })
    }

    fn on_intervals(self, bound: &RateBound) -> Option<SlowBound> {
        intervals(Claim {
            closed: self.closed,
            error: &LoopError::none(self.closed),
            inverse: false,
            lyapunov: &bound.proof.lyapunov.coefficients,
            rate: bound.rate,
            gamma: bound.gamma,
            lambda: 0.0,
        })
    }
}
