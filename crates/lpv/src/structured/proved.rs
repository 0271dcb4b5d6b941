//! The bound of a loop for every trajectory of the parameters as a function of the gains, with its slope.
//!
//! The derivative over a gain at the least gamma of the analysis inequality F < 0 in X, S and T, with its multiplier Z,
//! is that of the Lagrangian:
//!
//! ```text
//! d gamma/d g_i = <Z, dF/d g_i>,  tr(Z) = 1 over the rows of w and z
//! F = He(E_x' X [A Bt B1 0] + E_t' T [Ct Dtt Dt1 0] + E_z' [C1 D1t D11 0]) + [Ct Dtt Dt1 0]' S [Ct Dtt Dt1 0]
//!     - diag(0, S, gamma I, gamma I)
//! <Z, dF> = 2 <[X E_x; T' E_t + S [Ct Dtt Dt1 0]; E_z] Z, d[A Bt B1 0; Ct Dtt Dt1 0; C1 D1t D11 0]>
//! ```
//!
//! E_x, E_t, E_z: the rows of x, wt, z of the identity. Source of the inequality: [`crate::analysis::bounded_gain()`];
//! of the derivative: J. F. Bonnans, A. Shapiro, Perturbation Analysis of Optimization Problems, 2000, section 4.3.

use crate::analysis::bounded_gain::{Base, Posed, whitening};
use crate::analysis::gain_bound::GainBound;
use crate::lmi::{SolverOptions, solver};
use crate::matrix::{Mat, block};
use crate::structured::frozen::{Frozen, FrozenLoop, LargestNorm};
use crate::structured::minimax::{Effort, Function, Piece, Pieces};
use crate::system::Group::{T, W, X};
use crate::system::{ClosedLoop, LoopError, Partitioned};
use nalgebra::DVector;
use std::cell::RefCell;
use std::collections::VecDeque;

/// The least bound of a loop for every trajectory of the parameters.
pub(crate) struct ProvedGain<'a> {
    norm: LargestNorm<'a>,
    known: RefCell<Known>,
}

/// The data of the points tried.
struct Known {
    /// A bound of the best loop so far, from which the next search starts, and the least one.
    nearest: GainBound,
    least: f64,
    /// The tangents at the last points.
    tangents: VecDeque<Tangent>,
}

/// A value and its slope at some gains.
#[derive(Clone)]
struct Tangent {
    gains: DVector<f64>,
    value: f64,
    slope: DVector<f64>,
}

/// A point with its tangent, and its frozen loops.
pub(crate) struct Proved {
    tangent: Tangent,
    frozen: Vec<FrozenLoop>,
}

impl<'a> ProvedGain<'a> {
    pub(crate) fn new(frozen: Frozen<'a>, start: GainBound) -> Self {
        let known = Known { least: f64::INFINITY, nearest: start, tangents: VecDeque::new() };
        Self { norm: LargestNorm(frozen), known: RefCell::new(known) }
    }

    /// Returns a bound of the best loop.
    pub(crate) fn best(self) -> GainBound {
        self.known.into_inner().nearest
    }

    /// Returns the largest frozen norm and its slope, a lower bound of gamma.
    fn of_frozen(&self, value: f64, at: &Vec<FrozenLoop>) -> Option<(f64, DVector<f64>)> {
        let pieces = self.norm.pieces(at)?.objective;
        let largest = pieces.into_iter().max_by(|a, b| a.value.total_cmp(&b.value))?;
        Some((value, largest.slope))
    }
}

/// The number of tangents that are kept.
const TANGENTS: usize = 40;

/// The relative distance of the bound from the least.
const TOLERANCE: f64 = 1e-5;

impl Function for ProvedGain<'_> {
    type At = Proved;

    fn value(&self, gains: &[f64]) -> Option<(f64, Proved)> {
        let (frozen, at) = self.norm.value(gains)?;
        let known = &mut *self.known.borrow_mut();
        // No bound is below a frozen gain.
        let (value, slope) = if frozen >= known.least {
            self.of_frozen(frozen, &at)?
        } else {
            let of = self.norm.0.of;
            let closed = of.at(gains);
            let inner = interior(&closed, &known.nearest)?;
            let (gamma, slope) = least(&closed, &of.directions, &inner)?;
            if gamma < known.least {
                (known.least, known.nearest) = (gamma, inner);
            }
            (gamma, slope)
        };
        let tangent = Tangent { gains: DVector::from_column_slice(gains), value, slope };
        known.tangents.push_back(tangent.clone());
        if known.tangents.len() > TANGENTS {
            known.tangents.pop_front();
        }
        Some((value, Proved { tangent, frozen: at }))
    }

    /// Returns the tangents at the points tried, and the frozen norms, which are below the bound.
    fn pieces(&self, at: &Proved) -> Option<Pieces> {
        let mut pieces = self.norm.pieces(&at.frozen)?;
        let own =
            Piece { value: at.tangent.value, slope: at.tangent.slope.clone(), place: (usize::MAX, 0.0) };
        pieces.objective.push(own);
        let known = self.known.borrow();
        let others = known.tangents.iter().filter(|other| other.gains != at.tangent.gains);
        pieces.objective.extend(others.map(|other| seen(&at.tangent, other)));
        Some(pieces)
    }

    fn seen_from(&self, at: &Proved, other: &Proved) -> Vec<Piece> {
        vec![seen(&at.tangent, &other.tangent)]
    }
}

/// The effort of the minimisation of the bound.
pub(crate) const EFFORT: Effort =
    Effort { steps: 200, least: 3e-5, slow: 1e-3, slow_steps: 10, resets: 1, radius: 0.1 };

/// Returns a tangent at another point, at most the value here: a cutting plane.
fn seen(at: &Tangent, other: &Tangent) -> Piece {
    let value = other.value + other.slope.dot(&(&at.gains - &other.gains));
    Piece { value: value.min(at.value), slope: other.slope.clone(), place: (usize::MAX - 1, value) }
}

/// Returns a bound in the interior of the inequalities, from which that of a similar loop can be found, starting at
/// `near`.
fn interior(closed: &ClosedLoop, near: &GainBound) -> Option<GainBound> {
    let error = LoopError::none(closed);
    let raised = |raise: &f64| GainBound { gamma: raise * near.gamma, ..near.clone() };
    let search = SolverOptions { quick: true, ..SolverOptions::within(INTERIOR) };
    let from = |bound: &GainBound, must: bool| {
        let base = Base { closed, error: &error, bound };
        let posed = posed(base)?;
        let search = if solver::margin(&posed.program, &posed.start) > 0.0 {
            SolverOptions { start: Some(&posed.start), ..search }
        } else if must {
            SolverOptions { near: Some((&posed.start, LARGEST_RISE)), ..search }
        } else {
            return None;
        };
        let found = solver::solve(&posed.program, STAGE, search).ok()?;
        Some(posed.bound(base, &found.x)).filter(|bound| bound.largest_eigenvalue < 0.0)
    };
    RAISES.iter().map(raised).find_map(|bound| from(&bound, false)).or_else(|| from(near, true))
}

fn posed(base: Base) -> Option<Posed> {
    let mut posed = Posed::new(base, false).ok()?;
    posed.program.positive("X", posed.unknowns.x.clone());
    posed.program.positive("S", posed.unknowns.s.clone());
    posed.program.negative("bounded real", posed.inequality.clone());
    posed.program.minimise_trace(&posed.unknowns.gamma, 1.0);
    Some(posed)
}

/// The relative distance from the least of a bound in the interior.
const INTERIOR: f64 = 0.3;

/// Increases of gamma at which the matrices of a loop are tried for another one.
const RAISES: [f64; 3] = [1.01, 1.1, 1.5];

/// The largest bound accepted, relative to the known one.
const LARGEST_RISE: f64 = 2.0;

/// Returns the least gamma of a loop and its slope over the gains, searched from one of its bounds.
fn least(closed: &ClosedLoop, directions: &[Partitioned], near: &GainBound) -> Option<(f64, DVector<f64>)> {
    let error = LoopError::none(closed);
    let base = Base { closed, error: &error, bound: near };
    let posed = posed(base)?;
    let search = SolverOptions { start: Some(&posed.start), quick: true, ..SolverOptions::within(TOLERANCE) };
    let found = solver::solve(&posed.program, STAGE, search).ok()?;
    let bound = posed.bound(base, &found.x);
    let multiplier = found.multipliers.last()?.last()?;
    let value = |e: &crate::lmi::Affine| e.value(&posed.program, &found.x);
    let [x, s, t] = [&posed.unknowns.x, &posed.unknowns.s, &posed.unknowns.t].map(value);
    let weights = weights(&posed.scaled, [&x, &s, &t], multiplier);
    let (state, state_inverse) = whitening(&near.x, "X").ok()?;
    let (channel, channel_inverse) = whitening(&near.s, "S").ok()?;
    let slope = |direction: &Partitioned| {
        let scaled = direction
            .in_coordinates((&state, &state_inverse), (&channel, &channel_inverse))
            .in_units_of(near.gamma);
        near.gamma * weights.dot(scaled.matrix())
    };
    let slope = DVector::from_iterator(directions.len(), directions.iter().map(slope));
    (found.margin > 0.0).then_some((bound.gamma, slope))
}

const STAGE: &str = "analysis of the loop of a fixed structure";

/// Returns the weights of the entries of the loop's matrix in `<Z, dF>`, normalised.
fn weights(closed: &ClosedLoop, [x, s, t]: [&Mat; 3], multiplier: &Mat) -> Mat {
    let sizes = closed.parts.sizes();
    let channel = closed.parts.join(&[T], &[X, T, W]);
    let (inputs, total) = (sizes.x + sizes.t + sizes.w, multiplier.nrows());
    let rows = |first: usize, size: usize| multiplier.rows(first, size);
    let of_x = x * rows(0, sizes.x);
    let of_t = t.transpose() * rows(sizes.x, sizes.t) + s * channel * rows(0, inputs);
    let of_z = rows(inputs, sizes.z).into_owned();
    let trace: f64 = (sizes.x + sizes.t..total).map(|i| multiplier[(i, i)]).sum();
    let all = block(&[&[&of_x], &[&of_t], &[&of_z]]);
    all.columns(0, inputs) * (2.0 / trace)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::given_loop;
    use crate::structured::cases::{differences, scheduled};
    use crate::structured::structure::Loop;

    #[test]
    fn the_slope_agrees_with_finite_differences() {
        let (plant, structure) = scheduled();
        let of = Loop::new(&plant, &structure);
        let at = |gains: &[f64]| {
            let closed = of.at(gains);
            let near = given_loop(&closed).unwrap();
            least(&closed, &of.directions, &interior(&closed, &near).unwrap()).unwrap()
        };
        let gains = [0.2, -0.3, 0.1];
        let (gamma, slope) = at(&gains);
        let expected = differences(|gains| at(gains).0, &gains);
        assert!((&slope - &expected).norm() < 1e-3 * expected.norm(), "{} {slope} {expected}", gamma);
    }
}
