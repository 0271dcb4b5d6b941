//! The gain of a closed loop at a bounded rate, by Lyapunov matrices computed for that loop.

use crate::analysis::gain_bound::GainBound;
use crate::analysis::rate::rate_bounded_gain;
use crate::analysis::rate_program::RateOptions;
use crate::bounded_rate::intervals::{Claim, SlowBound, intervals};
use crate::matrix::Mat;
use crate::system::Group::{T, W, X, Z};
use crate::system::{ClosedLoop, LoopError};

/// The number of parameter values at which loops are frozen.
pub(crate) const SAMPLES: usize = 21;

/// Returns the least gain of a loop at values of the parameter, with its Lyapunov matrix. `None` if none was found, and
/// for loops with more than [`MOST_STATES`] states.
fn loop_bound(closed: &ClosedLoop, rate: f64) -> Option<(f64, Vec<Mat>)> {
    let order = match closed.a().nrows() {
        0..=FEW_STATES => 2,
        states if states <= MOST_STATES => 1,
        _ => return None,
    };
    let options = RateOptions { order, accuracy: TIGHTENED, ..RateOptions::default() };
    let found = rate_bounded_gain(&closed.sampled(SAMPLES).ok()?, rate, options).ok()?;
    Some((found.gamma, found.proof.lyapunov.coefficients))
}

/// Returns a bound of a loop below `most`: by a Lyapunov matrix computed for the loop, since that of the synthesis has
/// other objectives, or by that for any rate of the parameter.
pub(crate) fn tightened(
    closed: &ClosedLoop,
    rate: f64,
    most: f64,
    fast: Option<&GainBound>,
) -> Option<SlowBound> {
    let varying = loop_bound(closed, rate).map(|(gamma, lyapunov)| ((1.0 + TIGHTENED) * gamma, lyapunov));
    let constant = fast.map(|bound| (bound.gamma, vec![bound.x.clone()]));
    let mut tries: Vec<(f64, Vec<Mat>)> = varying.into_iter().chain(constant).collect();
    tries.sort_by(|one, other| one.0.total_cmp(&other.0));
    let error = &LoopError::none(closed);
    tries.iter().filter(|(gamma, _)| *gamma < most).find_map(|(gamma, lyapunov)| {
        intervals(Claim { closed, error, inverse: false, lyapunov, rate, gamma: *gamma, lambda: 0.0 })
    })
}

/// Limits for the search for a loop's Lyapunov matrix, which takes a second at 12 states and a minute at 30: with more
/// states it is affine in the parameter, and with still more it is left out.
const FEW_STATES: usize = 20;
const MOST_STATES: usize = 40;

/// The relative accuracy of the least gain, and the relative increase of the claimed gain over it, so that the
/// inequality holds with a margin.
const TIGHTENED: f64 = 0.01;

/// Returns a bound of a loop with model error, somewhat above a gamma that it has without; `lambda` is an estimate of
/// the error's multiplier. `None` if none was found.
///
/// The error is made part of w and z: let g be the gain of the loop from `[w; sqrt(lambda/gamma) w_D]` to
/// `[z; sqrt(lambda gamma) z_D]`. If g is at most gamma, g bounds the loop with model error, with `lambda g/gamma`.
pub fn covering(
    closed: &ClosedLoop,
    error: &LoopError,
    rate: f64,
    gamma: f64,
    lambda: f64,
) -> Option<SlowBound> {
    let tries =
        RAISES.iter().flat_map(|raise| FACTORS.iter().map(move |factor| (raise * gamma, factor * lambda)));
    tries.into_iter().find_map(|(gamma, lambda)| {
        let (gain, lyapunov) = loop_bound(&with_error(closed, error, gamma, lambda), rate)?;
        let lyapunov = &lyapunov;
        let reached = (1.0 + TIGHTENED) * gain;
        let lambda = lambda * reached / gamma;
        let claim = Claim { closed, error, inverse: false, lyapunov, rate, gamma: reached, lambda };
        if reached <= gamma { intervals(claim) } else { None }
    })
}

/// Trial factors of gamma and lambda.
const RAISES: [f64; 3] = [1.1, 1.3, 2.0];
const FACTORS: [f64; 3] = [1.0, 0.2, 5.0];

fn with_error(closed: &ClosedLoop, error: &LoopError, gamma: f64, lambda: f64) -> ClosedLoop {
    let s = closed.parts.sizes();
    let (f, d) = (error.fx.nrows(), error.e.ncols());
    let (out, into) = ((lambda * gamma).sqrt(), (gamma / lambda).sqrt());
    let mut parts = closed.parts.resized(Z, s.z + f).resized(W, s.w + d);
    parts.block_mut(Z, X).rows_mut(s.z, f).copy_from(&(&error.fx * out));
    parts.block_mut(Z, T).rows_mut(s.z, f).copy_from(&(&error.ft * out));
    parts.block_mut(Z, W).view_mut((s.z, 0), (f, s.w)).copy_from(&(&error.fw * out));
    parts.block_mut(X, W).columns_mut(s.w, d).copy_from(&(&error.e * into));
    ClosedLoop { parts, channels: closed.channels.clone() }
}
