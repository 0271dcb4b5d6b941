//! Removal of controller states of little effect, with a new proof of the bound.
//!
//! If eigenvalues of X Y are close to 1, the controller has modes that nearly cancel. The controller's constant part,
//! with y and wk as inputs and u and zk as outputs, is balanced and its smallest states are removed, one more at a
//! time, as long as the loop keeps the allowed gain bound. Source of the balancing: B. C. Moore, IEEE Trans. Automatic
//! Control 26(1), 1981; the states are replaced by their steady values (residualised): K. V. Fernando, H. Nicholson,
//! IEEE Trans. Automatic Control 27(2), 1982.

use crate::analysis::bounded_gain::{balanced_start, bounded_gain};
use crate::analysis::gain_bound::GainBound;
use crate::matrix::{Mat, block, solve, spectral_abscissa, svd};
use crate::riccati::bound::WideLoop;
use crate::riccati::equations::WideController;
use crate::synthesis::balance::equalise;
use crate::synthesis::design::Design;
use crate::synthesis::fast_modes::projector;
use crate::system::Group::{T, U, X, Y};
use crate::system::{Controller, GeneralisedPlant, LoopError, lyapunov, parameter_grid};

/// The allowed relative rise of the bound over that of the full controller.
const ALLOWED_RISE: f64 = 0.02;

/// The design with as many controller states removed as keep the certified bound within 2 %; the design itself if none
/// can be removed, or if its controller is unstable at Theta = 0.
///
/// With a `fastest_mode` (rad/s) only controllers that satisfy it on the grid of [`parameter_grid()`] are taken:
/// residualising states may make the others faster.
pub fn reduce(plant: &GeneralisedPlant, design: &Design, fastest_mode: Option<f64>) -> Design {
    let thetas = parameter_grid(plant.blocks.len());
    let slow_enough = |k: &Controller| fastest_mode.is_none_or(|limit| k.fastest_mode(&thetas) <= limit);
    let Some((balanced, transform)) = balance(&design.controller) else { return design.clone() };
    let mut best = design.clone();
    for states in (0..design.controller.a().nrows()).rev() {
        let Some(controller) = residualised(&balanced, states) else { break };
        let most = design.certified.gamma * (1.0 + ALLOWED_RISE);
        let certified = without_parameters(plant, &controller, most).or_else(|| {
            let closed = plant.close(&controller);
            let shown = restricted(&design.certified, plant.a().nrows(), &transform, states);
            bounded_gain(&closed, &LoopError::none(&closed), &shown).ok()
        });
        let Some(certified) = certified.filter(|bound| bound.gamma <= most) else { break };
        if slow_enough(&controller) {
            best = Design { controller, certified, ..best };
        }
    }
    best
}

/// The bound of the loop of a plant without parameters by a Riccati equation, if it is at most `most`.
fn without_parameters(plant: &GeneralisedPlant, controller: &Controller, most: f64) -> Option<GainBound> {
    if !plant.blocks.is_empty() {
        return None;
    }
    let closed = WideLoop::new(plant, &WideController::new(controller))?;
    closed.bound(closed.guess(), most, ALLOWED_RISE)
}

/// The design with controller modes residualised so that none on the grid of [`parameter_grid()`] is faster than
/// `limit` (rad/s), with a new bound. `None` if no such controller is found, or no bound within `1 + rise` times the
/// design's.
///
/// Modes are residualised that decay faster, at Theta = 0, than a fraction of the limit: elsewhere they may be faster.
/// In coordinates in which A is `diag(A_slow, A_fast)`, `0 = A_fast x_fast + B_fast [y; wk]` eliminates x_fast.
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

/// The rate beyond which modes at Theta = 0 are removed, relative to the limit, tried in turn.
const PARTS_OF_LIMIT: [f64; 3] = [1.0, 0.6, 0.3];

/// The controller with the modes faster than `rate` residualised; `None` if there are none.
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

/// The controller in balanced coordinates `x = T x~`, most important states first, and T. `None` if it is unstable.
fn balance(k: &Controller) -> Option<(Controller, Mat)> {
    if spectral_abscissa(&k.a()) >= 0.0 {
        return None;
    }
    let inputs = k.parts.join(&[X], &[Y, T]);
    let outputs = k.parts.join(&[U, T], &[X]);
    let reach = filled(lyapunov(&k.a().transpose(), &(&inputs * inputs.transpose()))?);
    let see = filled(lyapunov(&k.a(), &(outputs.transpose() * &outputs))?);
    let (transform, inverse) = equalise(&see, &reach)?;
    let parts = k.parts.transformed(&[(X, &inverse)], &[(X, &transform)]);
    let out = Controller { parts, blocks: k.blocks.clone() };
    out.matrix().iter().all(|v| v.is_finite()).then_some((out, transform))
}

/// A gramian regularised at rounding level, so that it has a Cholesky factor.
fn filled(gramian: Mat) -> Mat {
    let n = gramian.nrows();
    let size = 1e-12 * gramian.trace().max(f64::MIN_POSITIVE);
    gramian + Mat::identity(n, n) * size
}

/// The controller with the states after the first `kept` residualised.
fn residualised(k: &Controller, kept: usize) -> Option<Controller> {
    let sizes = k.parts.sizes();
    let n = sizes.x;
    let gone = n - kept;
    let full = k.matrix();
    let a22 = full.view((kept, kept), (gone, gone)).into_owned();
    let other: Vec<usize> = (0..kept).chain(n..full.ncols()).collect();
    let rest = full.rows(kept, gone).select_columns(&other);
    // 0 = A22 x2 + rest, so x2 = -A22^-1 rest.
    let steady = -solve(&a22, &rest)?;
    let rows: Vec<usize> = (0..kept).chain(n..full.nrows()).collect();
    let from_gone: Vec<usize> = (kept..n).collect();
    let pick = |rows: &[usize], columns: &[usize]| full.select_rows(rows).select_columns(columns);
    let reduced = pick(&rows, &other) + pick(&rows, &from_gone) * steady;
    Some(Controller::from_matrix(&reduced, kept, sizes.y, sizes.u, k.blocks.clone()))
}

/// The bound's matrices on the remaining states: a start for the search, not a bound.
fn restricted(bound: &GainBound, plant_states: usize, transform: &Mat, kept: usize) -> GainBound {
    let lift = crate::matrix::diagonal_blocks(&[&Mat::identity(plant_states, plant_states), transform]);
    let x = lift.transpose() * &bound.x * &lift;
    let kept = x.view((0, 0), (plant_states + kept, plant_states + kept)).into_owned();
    GainBound { x: kept, factor: None, ..bound.clone() }
}
