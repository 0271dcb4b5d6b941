//! The smallest destabilising perturbation of a system, searched at the peaks of the upper bound and from there along
//! the frequency.

use super::interval::response;
use super::lower::{LowerBound, improved, lower_bound_below};
use super::structure::{Structure, StructureError};
use super::upper::upper_bound;
use crate::stop;
use crate::system::StateSpace;

/// The number of frequencies at which a perturbation is searched, and their least ratio.
const FREQUENCIES: usize = 4;
const APART: f64 = 1.05;

/// The relative gap to the upper bound at which the search ends.
const CLOSED: f64 = 1e-4;

/// The first ratio by which the frequency is moved, its growth after a success, and the largest number of moves.
const FIRST_STRIDE: f64 = 1.1;
const STRETCH: f64 = 1.5;
const MOST_MOVES: usize = 40;

/// Returns a perturbation that gives a larger bound than the known one, or that one. `peaks` are frequencies (rad/s),
/// the most promising first; `upper` is a bound for all frequencies.
///
/// # Errors
/// Returns [`StructureError`] if the system does not fit the structure.
pub(super) fn lower_at_peaks(
    system: &StateSpace,
    structure: &Structure,
    peaks: &[f64],
    upper: f64,
    known: Option<LowerBound>,
) -> Result<Option<LowerBound>, StructureError> {
    let mut best = known;
    let enough = upper * (1.0 - CLOSED);
    let is_enough = |best: &Option<LowerBound>| best.as_ref().is_some_and(|best| best.value >= enough);
    let mut tried: Vec<f64> = vec![];
    for &omega in peaks {
        let is_new = tried.iter().all(|known| omega > APART * known || *known > APART * omega);
        if tried.len() == FREQUENCIES || is_enough(&best) {
            break;
        }
        let Some(m) = response(system, omega).filter(|_| is_new) else { continue };
        tried.push(omega);
        let bound = upper_bound(&m, structure)?;
        let Some(found) = lower_bound_below(&m, structure, Some(&bound))? else { continue };
        let found = along_frequency(system, structure, LowerBound { frequency: Some(omega), ..found });
        if best.as_ref().is_none_or(|known| found.value > known.value) {
            best = Some(found);
        }
    }
    Ok(best)
}

/// Follows a perturbation along the frequency to its least size.
fn along_frequency(system: &StateSpace, structure: &Structure, known: LowerBound) -> LowerBound {
    let mut best = known;
    let mut stride = FIRST_STRIDE;
    for _ in 0..MOST_MOVES {
        stop::check();
        let Some(here) = best.frequency.filter(|omega| *omega > 0.0 && omega.is_finite()) else { break };
        let better = [here * stride, here / stride].into_iter().find_map(|omega| {
            let found = improved(&response(system, omega)?, structure, &best)?;
            (found.value > best.value).then_some(LowerBound { frequency: Some(omega), ..found })
        });
        match better {
            Some(found) => {
                best = found;
                stride = 1.0 + STRETCH * (stride - 1.0);
            }
            None => stride = 1.0 + 0.3 * (stride - 1.0),
        }
        if stride < 1.0 + f64::EPSILON.sqrt() {
            break;
        }
    }
    best
}
