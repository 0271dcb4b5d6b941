//! Quadratic stabilisability: existence of a controller for every trajectory of the parameters, at any gain.
//!
//! Without w and z the synthesis inequalities are homogeneous, so the unknowns may be bounded by the identity; the
//! largest margin t is then positive exactly if a gamma exists. The value of t depends on the coordinates, and for a
//! stiff plant it is as small as rounding in most. A point that satisfies the inequalities strictly is therefore
//! conclusive; infeasibility is concluded only after several successful changes to the coordinates in which the best X
//! and S are the identity, which raise t towards 1 if it can be raised.
//!
//! Source of the notion: B. R. Barmish, "Necessary and sufficient conditions for quadratic stabilizability of an
//! uncertain system", J. Optimization Theory and Applications 46(4), 1985.

use crate::analysis::bounded_real::{Multipliers, bounded_real_compact};
use crate::error::SynthesisError;
use crate::lmi::{Affine, Program, SolverOptions, solver};
use crate::matrix::{Mat, kernel, scaled_largest_eigenvalue, symmetric_function};
use crate::synthesis::balance::Coordinates;
use crate::synthesis::inequalities::ScalingClass;
use crate::system::Group::{T, W, X, Y, Z};
use crate::system::{ClosedLoop, GeneralisedPlant, LoopError, channels};

/// The margin below which it is taken as zero, if it is no larger in other coordinates.
const NO_MARGIN: f64 = 1e-7;

/// The largest number of changes of coordinates.
const MOST_COORDINATES: usize = 10;

/// The number of coordinates without a margin from which infeasibility is concluded.
const DENIALS_NEEDED: usize = 5;

/// The initial floor of the eigenvalues of X or S in a change of coordinates, relative to the largest.
const EIGENVALUE_FLOOR: f64 = 1e-4;

const STAGE: &str = "stabilisation for every parameter";

/// The result: whether a controller stabilises the plant for every trajectory of the parameters.
pub(crate) enum Stabilisation {
    /// No controller does; the error names control or measurement.
    Impossible(SynthesisError),
    /// A controller does: both inequalities hold strictly at a point found.
    Possible,
    /// The solver could not decide.
    Unknown,
}

/// Decides for both inequalities, the control first. Without parameters the modes decide, which were checked before.
pub(crate) fn stabilisation(plant: &GeneralisedPlant, scalings: ScalingClass) -> Stabilisation {
    if plant.blocks.is_empty() {
        return Stabilisation::Possible;
    }
    let balanced = Coordinates::diagonal(plant).apply(plant);
    let control = is_possible(balanced.dual(), scalings);
    if control == Some(false) {
        return Stabilisation::Impossible(SynthesisError::NotQuadraticallyStabilisable);
    }
    match (control, is_possible(balanced, scalings)) {
        (_, Some(false)) => Stabilisation::Impossible(SynthesisError::NotQuadraticallyDetectable),
        (Some(true), Some(true)) => Stabilisation::Possible,
        _ => Stabilisation::Unknown,
    }
}

/// Returns `true` if a margin exists; `None` if the solver could not decide.
fn is_possible(plant: GeneralisedPlant, scalings: ScalingClass) -> Option<bool> {
    let (mut here, mut best) = (plant.clone(), None);
    let (mut next, mut floor, mut denied) = (plant, EIGENVALUE_FLOOR, 0);
    for _ in 0..MOST_COORDINATES {
        match largest_margin(&next, scalings) {
            Some(found) if found.holds => return Some(true),
            Some(found) if found.margin > NO_MARGIN => return None,
            Some(found) => {
                denied += 1;
                (here, best) = (next, Some(found));
            }
            // These coordinates are too badly conditioned: the next are closer to the last well-conditioned ones.
            None => floor *= 10.0,
        }
        let LargestMargin { x, s, .. } = best.as_ref()?;
        let ((state, state_inverse), (channel, channel_inverse)) = (root(x, floor), root(s, floor));
        next = here
            .changed(|parts| parts.in_coordinates((&state, &state_inverse), (&channel, &channel_inverse)));
    }
    (denied >= DENIALS_NEEDED).then_some(false)
}

/// The point of the largest margin.
struct LargestMargin {
    margin: f64,
    x: Mat,
    s: Mat,
    /// `true` if the inequalities hold strictly at the point.
    holds: bool,
}

/// Returns the largest t with `N' L(X, S, T) N <= -t I`, `t I <= X <= I`, `t I <= S <= I`; `None` if the solver does
/// not reach an optimum.
fn largest_margin(plant: &GeneralisedPlant, scalings: ScalingClass) -> Option<LargestMargin> {
    let (n, r) = (plant.sizes().x, plant.sizes().t);
    let mut program = Program::default();
    let theta = channels(&plant.blocks);
    let zero = Affine::zeros(1, 1);
    let m = Multipliers {
        gamma: zero.clone(),
        x: program.symmetric(n),
        s: program.symmetric_commuting(&theta),
        t: match scalings {
            ScalingClass::Symmetric => Affine::zeros(r, r),
            ScalingClass::SymmetricAndSkew => program.skew_commuting(&theta),
        },
        lambda: zero,
    };
    let t = program.scalar();
    let ClosedLoop { parts, channels } = plant.open();
    let bare = ClosedLoop { parts: parts.resized(W, 0).resized(Z, 0), channels };
    let full = bounded_real_compact(&bare, &LoopError::none(&bare), &m);
    let projected = full.congruence(&kernel(&plant.parts.join(&[Y], &[X, T])));
    let size = projected.shape().0;
    program.negative("stability", projected.clone() + t.times_identity(size));
    for (e, size) in [(&m.x, n), (&m.s, r)] {
        program.positive("floor", e.clone() - t.times_identity(size));
        program.positive("upper bound", Affine::constant(Mat::identity(size, size)) - e.clone());
    }
    program.minimise_trace(&t, -1.0);
    let search = SolverOptions { patient: true, ..SolverOptions::within(0.1 * NO_MARGIN) };
    let solution = solver::solve(&program, STAGE, search).ok()?;
    let value = |e: &Affine| e.value(&program, &solution.x);
    let (x, s) = (value(&m.x), value(&m.s));
    let inequalities = [value(&projected), -&x, -&s];
    let holds = inequalities.iter().all(|m| scaled_largest_eigenvalue(m) < -ROUNDING_EIGENVALUE);
    let margin = value(&t)[(0, 0)];
    (holds || solution.gap <= NO_MARGIN).then_some(LargestMargin { margin, x, s, holds })
}

/// The eigenvalue of an inequality scaled to a unit diagonal above which it holds strictly.
const ROUNDING_EIGENVALUE: f64 = 1e-12;

/// Returns `M^-1/2` and its inverse, with small eigenvalues raised.
fn root(m: &Mat, floor: f64) -> (Mat, Mat) {
    if m.is_empty() {
        return (m.clone(), m.clone());
    }
    let floor = floor * crate::matrix::largest_eigenvalue(m).max(f64::MIN_POSITIVE);
    (symmetric_function(m, |v| 1.0 / v.max(floor).sqrt()), symmetric_function(m, |v| v.max(floor).sqrt()))
}
