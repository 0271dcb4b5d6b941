//! The smallest destabilising perturbation of a system, sought where the upper bound is largest and from there along
//! the frequency.

use super::interval::response;
use super::lower::{LowerBound, improved, lower_bound_below};
use super::structure::{Structure, StructureError};
use super::upper::upper_bound;
use crate::stop;
use crate::system::state_space::StateSpace;

/// At how many frequencies a perturbation is sought, and how far they are apart, as a ratio.
const FREQUENCIES: usize = 4;
const APART: f64 = 1.05;

/// A lower bound this close to the upper one, relatively, is good enough.
const CLOSED: f64 = 1e-4;

/// How far the frequency is moved at first, as a ratio, by how much farther after a success, and how often.
const FIRST_STRIDE: f64 = 1.1;
const STRETCH: f64 = 1.5;
const MOST_MOVES: usize = 40;

/// A perturbation that shows more than the one that is known, or that one. `peaks` are frequencies (rad/s), the most
/// promising first; `upper` is a bound for all frequencies.
///
/// # Errors
/// [`StructureError`] when the system does not fit the structure.
pub(super) fn lower_at_peaks(
    system: &StateSpace,
    structure: &Structure,
    (peaks, upper): (&[f64], f64),
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

/// A perturbation that is followed along the frequency to where it is smallest.
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
