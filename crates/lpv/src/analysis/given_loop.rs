//! A bound on the gain of a loop with a given controller, without prior knowledge.

use crate::analysis::bounded_gain::{balanced_start, quickly};
use crate::analysis::gain_bound::GainBound;
use crate::matrix::Mat;
use crate::system::ClosedLoop;
use crate::system::Group::T;

/// Bounds the gain of a loop for every trajectory of its parameters, at any rate, without an initial bound.
///
/// The search starts in coordinates in which the Gramians at Theta = 0 are balanced. If it finds nothing for parameters
/// in the unit box, it is repeated for a smaller box, `Theta = a Theta~`, which is then enlarged step by step, each
/// from the bound of the last.
///
/// # Errors
/// Returns the largest a below 1 for which a bound was found; 0 if there is none for any, as for a loop that is
/// unstable at Theta = 0.
pub fn given_loop(closed: &ClosedLoop) -> Result<GainBound, f64> {
    let mut part = 1.0;
    let mut bound = loop {
        if let Some(bound) = from_nothing(&within(closed, part)) {
            break bound;
        }
        part *= 0.5;
        if part < LEAST_PART {
            return Err(0.0);
        }
    };
    let mut step = FIRST_STEP;
    while part < 1.0 {
        let next = f64::min(part + step, 1.0);
        let larger = within(closed, next);
        let raised = |factor: &f64| GainBound { gamma: factor * bound.gamma, ..bound.clone() };
        match RAISED.iter().find_map(|factor| quickly(&larger, &raised(factor))) {
            Some(found) => (bound, part, step) = (found, next, 1.5 * step),
            None => step *= 0.5,
        }
        if step < LEAST_STEP {
            return Err(part);
        }
    }
    Ok(bound)
}

/// The smallest box that is tried, and the first and the smallest step towards the unit box.
const LEAST_PART: f64 = 1.0 / 64.0;
const FIRST_STEP: f64 = 0.2;
const LEAST_STEP: f64 = 0.01;

/// Levels at which a search starts, relative to the bound for a smaller box.
const RAISED: [f64; 2] = [1.3, 3.0];

/// Returns the loop with parameters in a box of `part` of the unit box.
fn within(closed: &ClosedLoop, part: f64) -> ClosedLoop {
    let channels = closed.channels.len();
    let scale = Mat::from_diagonal_element(channels, channels, part);
    ClosedLoop { parts: closed.parts.transformed(&[], &[(T, &scale)]), channels: closed.channels.clone() }
}

/// Levels at which the search starts, relative to the frozen gain at Theta = 0.
const STARTS: [f64; 3] = [2.0, 10.0, 100.0];

fn from_nothing(closed: &ClosedLoop) -> Option<GainBound> {
    let middle = vec![0.0; closed.channels.iter().max().map_or(0, |last| last + 1)];
    let frozen = closed.frozen(&middle).ok().filter(|frozen| frozen.is_stable())?.hinf_norm().value;
    let r = closed.channels.len();
    STARTS.iter().find_map(|factor| {
        let start = GainBound {
            gamma: factor * frozen,
            x: Mat::zeros(0, 0),
            factor: None,
            s: Mat::identity(r, r),
            t: Mat::zeros(r, r),
            lambda: 0.0,
            largest_eigenvalue: f64::NAN,
        };
        quickly(closed, &balanced_start(closed, &start)?)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::system::{LOOP, Partitioned, Sizes};
    use nalgebra::dmatrix;

    /// Returns x' = (-1 + slope theta) x + w, z = x: stable for slope theta < 1, with the gain 1/(1 - slope theta).
    fn scalar(slope: f64) -> ClosedLoop {
        let sizes = Sizes { x: 1, t: 1, w: 1, z: 1, ..Sizes::default() };
        let matrix = dmatrix![-1.0, slope, 1.0; 1.0, 0.0, 0.0; 1.0, 0.0, 0.0];
        ClosedLoop { parts: Partitioned::of(matrix, LOOP, sizes), channels: vec![0] }
    }

    #[test]
    fn the_bound_of_a_scalar_is_its_largest_gain() {
        let found = given_loop(&scalar(0.5)).unwrap();
        assert!(found.largest_eigenvalue < 0.0 && (found.gamma / 2.0 - 1.0).abs() < 0.02, "{}", found.gamma);
    }

    #[test]
    fn the_largest_box_with_a_bound_is_found() {
        let part = given_loop(&scalar(2.0)).unwrap_err();
        assert!(part < 0.5 && part > 0.47, "{part}");
        let mut unstable = scalar(0.5);
        unstable.parts.block_mut(crate::system::Group::X, crate::system::Group::X)[0] = 1.0;
        assert_eq!(given_loop(&unstable), Err(0.0));
    }
}
