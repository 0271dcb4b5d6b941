//! One descent of a search: minimises a cost subject to the margin of every requirement.
//!
//! ```text
//! min over y   cost(x + D y)
//! subject to   margin_k(x + D y) >= REQUIRED_MARGIN for every key of [require] with a limit
//! ```
//!
//! Source of COBYLA: M. J. D. Powell, A direct search optimization method that models the objective and constraint
//! functions by linear interpolation, 1994.

use crate::attempt::margin;
use crate::candidate::{Attempt, Candidate, FAILED_COST, REQUIRED_MARGIN, merit};
use crate::direction::Direction;
use cobyla::{Func, RhoBeg, StopTols, minimize};
use squid_design::inputs::design_file::{DesignFile, REQUIREMENTS};
use squid_design::verdict::Verdict;
use std::cell::{Cell, RefCell};

/// Largest magnitude of a coordinate of a candidate.
const FARTHEST: f64 = 3.0;

/// Returns the keys of `[require]` that have a limit.
pub(crate) fn required(design: &DesignFile) -> Vec<&'static str> {
    REQUIREMENTS.iter().map(|r| r.key).filter(|key| design.require.limit(key).is_some()).collect()
}

/// Returns the smallest margin of each key in a verdict; -1 where it is unknown.
pub(crate) fn margins(keys: &[&'static str], verdict: &Verdict) -> Vec<f64> {
    let least = |key: &&'static str| {
        let rows = verdict.rows.iter().filter(|row| row.key == *key);
        let margins = rows.map(|row| margin(row, 1.0)).map(|v| if v.is_nan() { -1.0 } else { v });
        margins.fold(f64::INFINITY, f64::min).clamp(-FAILED_COST, 1.0)
    };
    keys.iter().map(least).collect()
}

/// Descends from a candidate along directions, with at most `designs` attempts and a first step `first`. Returns the
/// best candidate, and adds all attempts to `found`.
pub(crate) fn descend(
    start: &Candidate,
    directions: &[Direction],
    first: f64,
    designs: usize,
    attempt: &dyn Fn(&[f64]) -> Attempt,
    found: &mut Vec<Attempt>,
) -> Candidate {
    let keys = start.margins.len();
    let best = RefCell::new(start.clone());
    let last = RefCell::new((vec![0.0; directions.len()], start.clone()));
    let (found, left) = (RefCell::new(found), Cell::new(designs));
    let evaluate = |y: &[f64]| -> Candidate {
        if last.borrow().0 == y {
            return last.borrow().1.clone();
        }
        let mut x = start.x.clone();
        for (direction, step) in directions.iter().zip(y) {
            direction.0.iter().for_each(|i| x[*i] = (x[*i] + step).clamp(-FARTHEST, FARTHEST));
        }
        if left.get() == 0 {
            return Candidate::failed(&x, keys);
        }
        left.set(left.get() - 1);
        let attempted = attempt(&x);
        let tried = attempted.tried.clone();
        found.borrow_mut().push(attempted);
        if merit(&tried) < merit(&best.borrow()) {
            *best.borrow_mut() = tried.clone();
        }
        *last.borrow_mut() = (y.to_vec(), tried.clone());
        tried
    };
    let objective = |y: &[f64], (): &mut ()| evaluate(y).cost;
    let limits: Vec<_> = (0..keys)
        .map(|k| {
            let evaluate = &evaluate;
            move |y: &[f64], (): &mut ()| evaluate(y).margins[k] - REQUIRED_MARGIN
        })
        .collect();
    let constraints: Vec<&dyn Func<()>> = limits.iter().map(|limit| limit as &dyn Func<()>).collect();
    let here = vec![0.0; directions.len()];
    let bounds = vec![(-FARTHEST, FARTHEST); here.len()];
    let close = StopTols { xtol_abs: vec![0.3 * first; here.len()], ..StopTols::default() };
    if designs > 0 {
        // The start is already evaluated and costs no attempt.
        let most = designs + 1;
        let _ = minimize(objective, &here, &bounds, &constraints, (), most, RhoBeg::All(first), Some(close));
    }
    best.into_inner()
}
