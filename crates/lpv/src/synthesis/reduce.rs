//! Removal of controller states and channels with little effect on the loop, with a new proof of the bound.
//!
//! The controller's states are balanced in the closed loop: reachability from w and observability in z, the blocks of
//! the loop's Gramians that belong to the controller, summed over frozen parameters. The smallest states are truncated
//! or replaced by their steady values, whichever gives the smaller frozen gain; channels of Theta likewise. Sources of
//! balancing and residualising: B. C. Moore, IEEE Trans. Automatic Control 26(1), 1981; K. V. Fernando, H.
//! Nicholson, IEEE Trans. Automatic Control 27(2), 1982; of the Gramians in the closed loop: P. Wortelboer,
//! Frequency-weighted balanced reduction of closed-loop mechanical servo-systems, thesis, Delft, 1994.

mod descent;
mod smaller;

use crate::analysis::bounded_gain::{balanced_start, bounded_gain};
use crate::analysis::gain_bound::GainBound;
use crate::matrix::{Mat, block, solve, svd};
use crate::synthesis::design::Design;
use crate::synthesis::fast_modes::projector;
use crate::synthesis::reduce::descent::Descent;
use crate::synthesis::reduce::smaller::{Limits, Part, residualised, without_parameters};
use crate::system::controller::Controller;
use crate::system::model_error::LoopError;
use crate::system::parameter_grid::parameter_grid;
use crate::system::partition::Group::X;
use crate::system::plant::GeneralisedPlant;

/// The allowed relative increase of the bound over that of the full controller.
const ALLOWED_RISE: f64 = 0.02;

/// Returns the design with as many controller states and channels removed as keep the certified bound within 2 %; the
/// design itself if none can be removed.
///
/// With a `fastest_mode` (rad/s) only controllers that satisfy it on the grid of [`parameter_grid()`] are taken:
/// residualising states may make the others faster.
pub fn reduce(plant: &GeneralisedPlant, design: &Design, fastest_mode: Option<f64>) -> Design {
    let smallest = Reductions::of(plant, design, ALLOWED_RISE, fastest_mode).next();
    smallest.unwrap_or_else(|| design.clone())
}

/// Designs with fewer controller states and channels, the smallest first, all with certified bounds within `1 + rise`
/// times the design's. Each is computed on demand.
///
/// The smallest is found by bisection over the sizes: if no bound is found for one, none is expected below it.
#[derive(Debug)]
pub struct Reductions<'a> {
    /// The descent of each part, and the index of the next size of the last one.
    descents: Vec<(Descent<'a>, usize)>,
}

impl<'a> Reductions<'a> {
    /// Finds the smallest reduction; with a `fastest_mode` (rad/s) as in [`reduce`].
    pub fn of(plant: &'a GeneralisedPlant, design: &Design, rise: f64, fastest_mode: Option<f64>) -> Self {
        let limits = Limits { gamma: design.certified.gamma * (1.0 + rise), fastest_mode };
        let mut from = design.clone();
        let mut descents = vec![];
        // Fewer channels leave fewer unknowns to the proofs of the following parts.
        for part in [Part::Channels, Part::States, Part::Channels] {
            let descent = Descent::of(plant, &from, part, limits);
            if let Some((mut descent, smallest)) = descent.and_then(Descent::smallest) {
                from = descent.at(smallest).unwrap_or(from);
                descents.push((descent, smallest));
            }
        }
        Self { descents }
    }
}

impl Iterator for Reductions<'_> {
    type Item = Design;

    fn next(&mut self) -> Option<Design> {
        while let Some((descent, next)) = self.descents.last_mut() {
            while *next < descent.sizes() {
                *next += 1;
                if let Some(found) = descent.at(*next - 1) {
                    return Some(found);
                }
            }
            self.descents.pop();
        }
        None
    }
}

/// Returns the design with controller modes residualised so that none on the grid of [`parameter_grid()`] is faster
/// than `limit` (rad/s), with a new bound. `None` if no such controller is found, or no bound within `1 + rise` times
/// the design's.
///
/// Modes that decay faster than a fraction of the limit at Theta = 0 are residualised: elsewhere they may be faster. In
/// coordinates in which A is `diag(A_slow, A_fast)`, `0 = A_fast x_fast + B_fast [y; wk]` eliminates x_fast.
pub fn without_fast_modes(
    plant: &GeneralisedPlant,
    design: &Design,
    limit: f64,
    rise: f64,
) -> Option<Design> {
    let thetas = parameter_grid(plant.blocks.len());
    let slower = PARTS_OF_LIMIT.iter().filter_map(|part| at_rest(&design.controller, part * limit));
    let controller = slower.into_iter().find(|k| k.fastest_mode(&thetas) <= limit)?;
    let closed = plant.close(&controller);
    let most = design.certified.gamma * (1.0 + rise);
    let mut starts =
        STARTS.into_iter().map(|start| start * design.certified.gamma).filter(|start| *start <= most);
    let certified = without_parameters(plant, &controller, most).or_else(|| {
        starts.find_map(|gamma| {
            let start = balanced_start(&closed, &GainBound { gamma, ..design.certified.clone() })?;
            bounded_gain(&closed, &LoopError::none(&closed), &start).ok()
        })
    })?;
    (certified.gamma <= most).then(|| Design { controller, certified, ..design.clone() })
}

/// Starting values of the search for a bound, relative to the design's and at most the allowed one: a search that
/// starts below the least gamma may find nothing.
const STARTS: [f64; 2] = [1.0, 2.0];

/// The rates above which modes at Theta = 0 are removed, relative to the limit, in the order tried.
const PARTS_OF_LIMIT: [f64; 3] = [1.0, 0.6, 0.3];

/// Returns the controller with the modes faster than `rate` residualised; `None` if there are none.
fn at_rest(k: &Controller, rate: f64) -> Option<Controller> {
    let n = k.a().nrows();
    let fast = projector(&k.a(), rate)?;
    let gone = fast.trace().round() as usize;
    if gone == 0 {
        return None;
    }
    let span = |projector: Mat, rank: usize| svd(&projector).u.columns(0, rank).into_owned();
    let slow = Mat::identity(n, n) - &fast;
    let transform = block(&[&[&span(slow, n - gone), &span(fast, gone)]]);
    let inverse = solve(&transform, &Mat::identity(n, n))?;
    let parts = k.parts.transformed(&[(X, &inverse)], &[(X, &transform)]);
    residualised(&Controller { parts, blocks: k.blocks.clone() }, n - gone)
}
