//! Smaller controllers, and the criteria for them: frozen gains, Gramians in the loop, a bound.

use crate::analysis::bounded_gain::{balanced_start, bounded_gain};
use crate::analysis::gain_bound::GainBound;
use crate::matrix::{Mat, block, solve};
use crate::riccati::bound::WideLoop;
use crate::riccati::equations::WideController;
use crate::system::controller::Controller;
use crate::system::lyapunov::lyapunov;
use crate::system::model_error::LoopError;
use crate::system::parameter_grid::{evenly_spread, parameter_grid};
use crate::system::partition::Group::{T, X};
use crate::system::plant::GeneralisedPlant;
use rayon::prelude::*;

/// The frozen parameters over which Gramians are summed and gains are compared.
const FROZEN: usize = 9;

/// The largest excess of a bound without parameters over the norm, relative.
const SLACK: f64 = 0.02;

/// The removed parts of a controller.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Part {
    States,
    Channels,
}

/// The requirements on a smaller controller.
#[derive(Debug, Clone, Copy)]
pub(super) struct Limits {
    /// The bound on the loop's gain.
    pub(super) gamma: f64,
    /// The fastest mode on the grid of [`parameter_grid()`], rad/s.
    pub(super) fastest_mode: Option<f64>,
}

/// Returns a bound of the loop, if it is at most `most`, searched from the matrices of a similar loop.
pub(super) fn bounded(
    plant: &GeneralisedPlant,
    k: &Controller,
    start: &GainBound,
    most: f64,
) -> Option<GainBound> {
    let found = without_parameters(plant, k, most).or_else(|| {
        let closed = plant.close(k);
        let start = GainBound { gamma: most, ..start.clone() };
        let from = |start: &GainBound| bounded_gain(&closed, &LoopError::none(&closed), start).ok();
        from(&start).or_else(|| from(&balanced_start(&closed, &start)?))
    })?;
    (found.gamma <= most).then_some(found)
}

/// Returns the frozen parameters: the same value for each.
fn frozen_parameters(plant: &GeneralisedPlant) -> Vec<Vec<f64>> {
    match plant.blocks.len() {
        1 => evenly_spread(FROZEN).map(|theta| vec![theta]).collect(),
        several => parameter_grid(several),
    }
}

/// Returns the largest gain of the loop frozen at parameters; `None` if it is unstable or ill posed at one.
pub(super) fn frozen_gain(plant: &GeneralisedPlant, k: &Controller) -> Option<f64> {
    let closed = plant.close(k);
    let gain = |theta: Vec<f64>| {
        let frozen = closed.frozen(&theta).ok().filter(|frozen| frozen.is_stable())?;
        Some(frozen.hinf_norm().value).filter(|gain| gain.is_finite())
    };
    frozen_parameters(plant).into_par_iter().map(gain).try_reduce(|| 0.0, |most, gain| Some(most.max(gain)))
}

/// Returns reachability and observability of the controller's states, or of its channels, in the loop, summed over
/// frozen parameters. A channel is controlled by zk and observed through a signal added to wk.
pub(super) fn gramians(plant: &GeneralisedPlant, k: &Controller, part: Part) -> Option<[Mat; 2]> {
    let closed = plant.close(k);
    let (all, own) = match part {
        Part::States => (closed.a().nrows(), k.a().nrows()),
        Part::Channels => (closed.dtt().nrows(), k.dtt().nrows()),
    };
    let mut sums = [Mat::zeros(own, own), Mat::zeros(own, own)];
    for theta in frozen_parameters(plant) {
        let frozen = closed.frozen(&theta).ok()?;
        let reach = lyapunov(&frozen.a.transpose(), &(&frozen.b * frozen.b.transpose()))?;
        let see = lyapunov(&frozen.a, &(frozen.c.transpose() * &frozen.c))?;
        let pair = if part == Part::Channels {
            let delta = Mat::from_diagonal_element(all, all, 1.0);
            let values: Vec<f64> = closed.channels.iter().map(|parameter| theta[*parameter]).collect();
            let scale = Mat::from_diagonal(&values.into());
            let outputs =
                solve(&(&delta - closed.dtt() * &scale), &block(&[&[&closed.ct(), &closed.dt1()]]))?;
            let inner = solve(&(&delta - &scale * closed.dtt()), &delta)?;
            let n = closed.a().nrows();
            let (ct, dt1) = (outputs.columns(0, n), outputs.columns(n, outputs.ncols() - n));
            let (bt, d1t) = (closed.bt() * &inner, closed.d1t() * &inner);
            [
                ct * reach * ct.transpose() + dt1 * dt1.transpose(),
                bt.transpose() * see * &bt + d1t.transpose() * &d1t,
            ]
        } else {
            [reach, see]
        };
        for (sum, gramian) in sums.iter_mut().zip(pair) {
            *sum += gramian.view((all - own, all - own), (own, own));
        }
    }
    Some(sums.map(filled))
}

/// Returns the bound of the loop of a plant without parameters by a Riccati equation, if it is at most `most`.
pub(super) fn without_parameters(
    plant: &GeneralisedPlant,
    controller: &Controller,
    most: f64,
) -> Option<GainBound> {
    if !plant.blocks.is_empty() {
        return None;
    }
    let closed = WideLoop::new(plant, &WideController::new(controller))?;
    closed.bound(closed.guess(), most, SLACK)
}

/// Returns a gramian regularised at rounding level, so that it has a Cholesky factor.
fn filled(gramian: Mat) -> Mat {
    let n = gramian.nrows();
    let size = 1e-12 * gramian.trace().max(f64::MIN_POSITIVE);
    gramian + Mat::identity(n, n) * size
}

/// Returns the controller of one parameter with the channels after the first `kept` left out.
pub(super) fn with_channels(k: &Controller, kept: usize) -> Option<Controller> {
    Some(Controller { parts: k.parts.resized(T, kept), blocks: vec![kept] })
}

/// Returns the controller with the states after the first `kept` left out.
pub(super) fn truncated(k: &Controller, kept: usize) -> Option<Controller> {
    Some(Controller { parts: k.parts.resized(X, kept), blocks: k.blocks.clone() })
}

/// Returns the controller with the states after the first `kept` residualised.
pub(super) fn residualised(k: &Controller, kept: usize) -> Option<Controller> {
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
