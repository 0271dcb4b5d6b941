//! The bound of a loop for every trajectory of the parameters as a function of the gains, with its slope.
//!
//! At the least gamma of the analysis inequality F < 0 in X, S and T, with its multiplier Z, the derivative over a gain
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
use crate::structured::frozen::{Frozen, LargestNorm};
use crate::structured::minimax::{Effort, Function, Piece, Pieces, units_of};
use crate::system::Group::{T, W, X, Z};
use crate::system::{ClosedLoop, LOOP, LoopError, Partitioned};
use nalgebra::DVector;
use std::cell::RefCell;

/// The least bound of a loop for every trajectory of the parameters.
pub(crate) struct ProvedGain<'a> {
    norm: LargestNorm<'a>,
    /// The best bound so far, from which the next search starts.
    nearest: RefCell<GainBound>,
}

/// A bound at some gains and its slope.
pub(crate) struct Proved {
    gains: DVector<f64>,
    pub(crate) bound: GainBound,
    slope: DVector<f64>,
}

impl<'a> ProvedGain<'a> {
    pub(crate) fn new(frozen: Frozen<'a>, start: GainBound) -> Self {
        Self { norm: LargestNorm(frozen), nearest: RefCell::new(start) }
    }

    /// The best bound found.
    pub(crate) fn best(self) -> GainBound {
        self.nearest.into_inner()
    }
}

/// The relative distance of the bound from the least.
const TOLERANCE: f64 = 1e-4;

/// The raises of gamma at which the matrices of a loop are tried for another one.
const RAISES: [f64; 4] = [1.01, 1.1, 1.5, 3.0];

impl Function for ProvedGain<'_> {
    type At = Proved;

    fn value(&self, gains: &[f64]) -> Option<(f64, Proved)> {
        let known = self.nearest.borrow().clone();
        // No bound is below a frozen gain.
        let (frozen, _) = self.norm.value(gains)?;
        if frozen >= known.gamma {
            return None;
        }
        let of = self.norm.0.of;
        let closed = of.at(gains);
        let (bound, slope) = RAISES.iter().find_map(|raise| {
            let near = GainBound { gamma: raise * known.gamma, ..known.clone() };
            least(&closed, &of.directions, &near)
        })?;
        if bound.gamma < known.gamma {
            *self.nearest.borrow_mut() = bound.clone();
        }
        Some((bound.gamma, Proved { gains: DVector::from_column_slice(gains), bound, slope }))
    }

    fn pieces(&self, at: &Proved) -> Option<Pieces> {
        let piece = Piece { value: at.bound.gamma, slope: at.slope.clone(), place: (0, 0.0) };
        Some(Pieces { objective: vec![piece], limits: vec![] })
    }

    /// The tangent there is a cutting plane here.
    fn seen_from(&self, at: &Proved, other: &Proved) -> Vec<Piece> {
        let tangent = other.bound.gamma + other.slope.dot(&(&at.gains - &other.gains));
        vec![Piece { value: tangent.min(at.bound.gamma), slope: other.slope.clone(), place: (1, 0.0) }]
    }

    fn size(&self, value: f64) -> f64 {
        value
    }

    fn units(&self, value: f64, pieces: &Pieces) -> DVector<f64> {
        units_of(pieces, value)
    }

    fn suffices(&self, _: f64) -> bool {
        false
    }

    fn effort(&self) -> Effort {
        Effort { steps: 40, slow: 2e-3, slow_steps: 5, resets: 0, radius: 0.1 }
    }
}

/// The least gamma of a loop and its slope over the gains, sought from a bound of a similar loop.
fn least(
    closed: &ClosedLoop,
    directions: &[Partitioned],
    near: &GainBound,
) -> Option<(GainBound, DVector<f64>)> {
    let error = LoopError::none(closed);
    let base = Base { closed, error: &error, bound: near };
    let mut posed = Posed::new(base, false).ok()?;
    posed.program.positive("X", posed.unknowns.x.clone());
    posed.program.positive("S", posed.unknowns.s.clone());
    posed.program.negative("bounded real", posed.inequality.clone());
    posed.program.minimise_trace(&posed.unknowns.gamma, 1.0);
    if solver::margin(&posed.program, &posed.start) <= 0.0 {
        return None;
    }
    let search = SolverOptions {
        start: Some(&posed.start),
        settles: true,
        quick: true,
        ..SolverOptions::within(TOLERANCE)
    };
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
    (bound.largest_eigenvalue < 0.0).then_some((bound, slope))
}

const STAGE: &str = "analysis of the loop of a fixed structure";

/// The weights of the entries of the loop's matrix in `<Z, dF>`, normalised.
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
