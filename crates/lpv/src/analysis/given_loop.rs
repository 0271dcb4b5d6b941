//! A bound on the gain of a loop with a given controller, of which nothing is known.

use crate::analysis::bounded_gain::{balanced_start, bounded_gain};
use crate::analysis::gain_bound::GainBound;
use crate::error::SynthesisError;
use crate::matrix::Mat;
use crate::synthesis::{Options, synthesise};
use crate::system::{ClosedLoop, GeneralisedPlant, LoopError, PLANT, Partitioned, Sizes};

/// Bounds the gain of a loop for every trajectory of its parameters, at any rate, without a bound to start from.
///
/// The search of [`bounded_gain`] begins in coordinates in which the Gramians at Theta = 0 are balanced. If it finds
/// nothing, the loop is posed as a synthesis without controls, which balances more and is slower.
///
/// # Errors
/// [`SynthesisError::is_infeasible`] if no constant Lyapunov matrix bounds the gain; [`SynthesisError::Numerical`] if
/// the search fails.
pub fn given_loop(closed: &ClosedLoop) -> Result<GainBound, SynthesisError> {
    directly(closed).map_or_else(|| as_synthesis(closed), Ok)
}

/// Levels at which the search begins, relative to the frozen gain at Theta = 0.
const STARTS: [f64; 3] = [2.0, 10.0, 100.0];

fn directly(closed: &ClosedLoop) -> Option<GainBound> {
    let middle = vec![0.0; closed.channels.iter().max().map_or(0, |last| last + 1)];
    let frozen = closed.frozen(&middle).ok().filter(|frozen| frozen.is_stable())?.hinf_norm().value;
    let r = closed.channels.len();
    STARTS.iter().find_map(|factor| {
        let start = GainBound {
            gamma: factor * frozen,
            x: Mat::identity(closed.a().nrows(), closed.a().nrows()),
            factor: None,
            s: Mat::identity(r, r),
            t: Mat::zeros(r, r),
            lambda: 0.0,
            largest_eigenvalue: f64::NAN,
        };
        bounded_gain(closed, &LoopError::none(closed), &balanced_start(closed, &start)?).ok()
    })
}

/// The least gamma of a plant without controls is the gain of the loop.
fn as_synthesis(closed: &ClosedLoop) -> Result<GainBound, SynthesisError> {
    let mut order: Vec<usize> = (0..closed.channels.len()).collect();
    order.sort_by_key(|i| closed.channels[*i]);
    let r = order.len();
    let sorted = Mat::from_fn(r, r, |i, j| if order[i] == j { 1.0 } else { 0.0 });
    let blocks: Vec<usize> = (0..closed.channels.iter().max().map_or(0, |last| last + 1))
        .map(|parameter| closed.channels.iter().filter(|c| **c == parameter).count())
        .collect();
    let n = closed.a().nrows();
    let parts = closed
        .in_coordinates((&Mat::identity(n, n), &Mat::identity(n, n)), (&sorted.transpose(), &sorted))
        .parts;
    let sizes = Sizes { u: 0, y: 0, ..parts.sizes() };
    let plant = GeneralisedPlant { parts: Partitioned::of(parts.matrix().clone(), PLANT, sizes), blocks };
    let found =
        synthesise(&plant, Options { back_off: BACK_OFF, quick: true, ..Options::default() })?.certified;
    // The synthesis adds an unconnected controller; the blocks of the loop come first.
    let corner = |m: &Mat, size: usize| m.view((0, 0), (size, size)).into_owned();
    let back = |m: &Mat| sorted.transpose() * corner(m, r) * &sorted;
    Ok(GainBound { x: corner(&found.x, n), factor: None, s: back(&found.s), t: back(&found.t), ..found })
}

/// The back-off from the least gamma: small, since there is no controller to build.
const BACK_OFF: f64 = 1e-3;
