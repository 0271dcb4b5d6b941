//! Whether any controller stabilises the plant for every course of the parameters, whatever the gain.
//!
//! Without w and z the synthesis inequalities are homogeneous, so that the unknowns may be bounded by the identity. The clearance
//! t that they then allow is positive exactly when a gamma exists; t is bounded from both sides, so the solver can tell
//! where without the bound it only sees gamma grow.
//!
//! B. R. Barmish, "Necessary and sufficient conditions for quadratic stabilizability of an uncertain system", J. Optimization Theory
//! and Applications 46(4), 1985, for the notion.

use crate::balance::Coordinates;
use crate::bounded_real::{Multipliers, bounded_real_compact};
use crate::error::SynthesisError;
use crate::inequalities::Scalings;
use crate::lmi::{Affine, Program};
use crate::matrix::{Mat, block, kernel};
use crate::model_error::LoopError;
use crate::plant::{ClosedLoop, GeneralisedPlant, channels};
use crate::solver::{self, Search};

/// A clearance below this counts as none: the solver's accuracy.
const NONE: f64 = 1e-7;

const STAGE: &str = "stabilisation for every parameter";

/// Says which side makes the problem infeasible, if one does and the solver could tell.
pub(crate) fn infeasible_side(plant: &GeneralisedPlant, scalings: Scalings) -> Option<SynthesisError> {
    let balanced = Coordinates::diagonal(plant).apply(plant);
    if clearance(&balanced.dual(), scalings).is_some_and(|t| t < NONE) {
        return Some(SynthesisError::NotQuadraticallyStabilisable);
    }
    if clearance(&balanced, scalings).is_some_and(|t| t < NONE) {
        return Some(SynthesisError::NotQuadraticallyDetectable);
    }
    None
}

/// The largest t with `N' L(X, S, T) N <= -t I`, `t I <= X <= I`, `t I <= S <= I`; `None` when the solver does not reach an optimum.
fn clearance(plant: &GeneralisedPlant, scalings: Scalings) -> Option<f64> {
    let (n, r) = (plant.sizes().x, plant.sizes().t);
    let mut program = Program::new();
    let theta = channels(&plant.blocks);
    let zero = Affine::zeros(1, 1);
    let m = Multipliers {
        gamma: zero.clone(),
        x: program.symmetric(n),
        s: program.symmetric_commuting(&theta),
        t: match scalings {
            Scalings::Symmetric => Affine::zeros(r, r),
            Scalings::SymmetricAndSkew => program.skew_commuting(&theta),
        },
        lambda: zero,
    };
    let t = program.scalar();
    let bare = without_performance(plant);
    let whole = bounded_real_compact(&bare, &LoopError::none(&bare), &m);
    let projected = whole.congruence(&kernel(&block(&[&[&plant.c2, &plant.d2t]])));
    let size = projected.shape().0;
    program.negative("stability", projected + t.times_identity(size));
    for (e, size) in [(&m.x, n), (&m.s, r)] {
        program.positive("floor", e.clone() - t.times_identity(size));
        program.positive("upper bound", Affine::constant(Mat::identity(size, size)) - e.clone());
    }
    program.minimise_trace(&t, -1.0);
    let solution = solver::solve(&program, STAGE, Search { tolerance: 0.1 * NONE, start: None }).ok()?;
    (solution.gap <= NONE).then(|| t.value(&program, &solution.x)[(0, 0)])
}

fn without_performance(plant: &GeneralisedPlant) -> ClosedLoop {
    let (n, r) = (plant.sizes().x, plant.sizes().t);
    ClosedLoop {
        b1: Mat::zeros(n, 0),
        dt1: Mat::zeros(r, 0),
        c1: Mat::zeros(0, n),
        d1t: Mat::zeros(0, r),
        d11: Mat::zeros(0, 0),
        ..plant.open()
    }
}
