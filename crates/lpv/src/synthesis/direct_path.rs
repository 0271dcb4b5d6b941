//! A direct path D22 from u to y: removed from the plant for the synthesis and restored around the controller.
//!
//! ```text
//! y = y~ + D22 u,   u = K~ y~ = K~ (y - D22 u) = K y
//! ```
//!
//! K~ is designed for the plant without D22, whose output is y~. The loop of K~ with that plant and the loop of K with
//! the given plant are the same, and so are their bounds. Source: M. G. Safonov, D. J. N. Limebeer, R. Y. Chiang,
//! "Simplifying the H-infinity theory via loop-shifting, matrix-pencil and descriptor concepts", Int. J. Control 50(6),
//! 1989, section 4.
//!
//! K exists if `I + Duy~ D22` is regular for every parameter value. If it is not, K~ is changed slightly: strict
//! inequalities permit a small change. If the parameters take it through a singular value, no small change helps: then
//! a controller is designed that measures y~ through lags and has no direct path.

use crate::analysis::bounded_gain::{bounded_gain, worst_eigenvalue};
use crate::analysis::gain_bound::GainBound;
use crate::error::{SynthesisError, SystemError};
use crate::matrix::{Mat, block, eigenvalues, largest, solve};
use crate::mu::structure::{Block, Structure};
use crate::mu::upper::upper_bound;
use crate::synthesis::{self, Design, Options};
use crate::system::Group::{T, U, W, X, Y};
use crate::system::{Controller, GeneralisedPlant, LoopError, Sizes, parameter_grid};
use nalgebra::Complex;

/// Returns the controller `u = K (y - D22 u)` from y to u; applied again with `-D22` this gives K back.
///
/// ```text
/// u = M (Cu xk + Duy y + Dut wk),   M = (I + Duy D22)^-1,   y - D22 u in place of y in the rows xk' and zk
/// ```
///
/// Shapes: D22 is y x u. `None` if `I + Duy D22` is singular, to rounding.
pub fn around(k: &Controller, d22: &Mat) -> Option<Controller> {
    let Sizes { x: n, y, .. } = k.parts.sizes();
    let looped = k.duy() * d22;
    let modes = eigenvalues(&looped);
    let nearest = modes.iter().map(|mode| (mode + 1.0).norm()).fold(1.0, f64::min);
    let size = modes.iter().map(|mode| mode.norm()).fold(1.0, f64::max);
    let regular = nearest > SINGULAR_RATIO * size;
    let of_u = k.parts.join(&[U], &[X, Y, T]);
    let u = regular.then(|| solve(&(Mat::identity(looped.nrows(), looped.nrows()) + &looped), &of_u))??;
    let fed_back = d22 * &u;
    let rows = |row| k.parts.join(&[row], &[X, Y, T]) - k.parts.block(row, Y) * &fed_back;
    let (state, channel) = (rows(X), rows(T));
    let matrix = block(&[&[&state], &[&u], &[&channel]]);
    Some(Controller::from_matrix(&matrix, n, y, looped.nrows(), k.blocks.clone()))
}

/// Designs a controller for a plant with a direct path from u to y, and bounds the gain of the closed loop:
/// [`synthesis::synthesise`] for `y = C2 x + D2t wt + D21 w + D22 u`.
///
/// `plant` is without D22 (y x u). The loop of D22 and the returned controller is the same as the loop without D22 and
/// with [`around`] of that controller and `-D22`; the bound is that of this loop.
///
/// # Errors
/// Errors of [`synthesis::synthesise`]; [`SynthesisError::System`] for a D22 of the wrong size;
/// [`SynthesisError::NotWellPosed`] if no controller was found whose loop with D22 is well posed.
pub fn synthesise(plant: &GeneralisedPlant, d22: &Mat, options: Options) -> Result<Design, SynthesisError> {
    if is_none(d22) {
        return synthesis::synthesise(plant, options);
    }
    let expected = (plant.sizes().y, plant.sizes().u);
    if d22.shape() != expected {
        return Err(SystemError::Shape { name: "D22", found: d22.shape(), expected }.into());
    }
    let limit = options.fastest_mode;
    let mut too_fast = None;
    // Same factors as without D22, where the limit on the controller's modes is enforced with the inequalities.
    for factor in [1.0, 2.0, 4.0] {
        let options = Options { back_off: factor * options.back_off, fastest_mode: None, ..options };
        let found =
            synthesis::synthesise(plant, options).and_then(|found| put_back(plant, d22, &found, options));
        let design = match (found, too_fast) {
            (Ok(design), _) => design,
            (Err(_), Some(ratio)) => return Err(SynthesisError::TooFast { ratio }),
            (Err(reason), None) => return Err(reason),
        };
        match excess(&design.controller, limit) {
            None => return Ok(design),
            Some(ratio) => too_fast = Some(too_fast.unwrap_or(ratio)),
        }
    }
    Err(SynthesisError::TooFast { ratio: too_fast.unwrap_or(f64::INFINITY) })
}

/// Removes states as [`crate::synthesis::reduce::reduce`] does, for a plant with a direct path from u to y.
pub fn reduce(plant: &GeneralisedPlant, d22: &Mat, design: &Design, fastest_mode: Option<f64>) -> Design {
    if is_none(d22) {
        return crate::synthesis::reduce::reduce(plant, design, fastest_mode);
    }
    let reduced = || {
        let inner = Design { controller: around(&design.controller, &-d22)?, ..design.clone() };
        let fewer = crate::synthesis::reduce::reduce(plant, &inner, None);
        let (controller, certified) = closed(plant, d22, &fewer.controller, &fewer.certified)?;
        excess(&controller, fastest_mode).is_none().then_some(Design { controller, certified, ..inner })
    };
    reduced().unwrap_or_else(|| design.clone())
}

fn is_none(d22: &Mat) -> bool {
    d22.iter().all(|entry| *entry == 0.0)
}

/// Returns the fastest mode as a multiple of the limit, if it exceeds it.
fn excess(k: &Controller, limit: Option<f64>) -> Option<f64> {
    let ratio = k.fastest_mode(&parameter_grid(k.blocks.len())) / limit?;
    (ratio > 1.0).then_some(ratio)
}

/// Converts a design for the plant without D22 to one for the plant with it: the first at negligible cost, or the best.
fn put_back(
    plant: &GeneralisedPlant,
    d22: &Mat,
    design: &Design,
    options: Options,
) -> Result<Design, SynthesisError> {
    let near = DIRECT_PATH_CHANGES.iter().filter_map(|nudge| {
        let k = with_scaled_paths(&design.controller, 1.0 - nudge);
        let (controller, certified) = closed(plant, d22, &k, &design.certified)?;
        Some(Design { controller, certified, ..design.clone() })
    });
    let rate = largest(0.0, eigenvalues(&plant.close(&design.controller).a()).iter().map(|mode| mode.norm()));
    let lagged = LAG_RATIOS.iter().filter_map(|lag| {
        let lagged = behind_lags(plant, rate / lag, options)?;
        let (controller, certified) = closed(plant, d22, &lagged.controller, &lagged.certified)?;
        Some(Design {
            gamma_optimum: design.gamma_optimum,
            lower: design.lower,
            multipliers: design.multipliers.clone(),
            controller,
            certified,
            ..lagged
        })
    });
    let good = |found: &Design| found.certified.gamma <= (1.0 + ACCEPTED_RISE) * design.certified.gamma;
    Design::first_or_best(near.chain(lagged), good).ok_or(SynthesisError::NotWellPosed)
}

/// Returns the controller with D22 around it, and the bound of its loop, proved for the controller with D22 removed
/// again, so that rounding is included.
fn closed(
    plant: &GeneralisedPlant,
    d22: &Mat,
    k: &Controller,
    shown: &GainBound,
) -> Option<(Controller, GainBound)> {
    let controller = around(k, d22).filter(is_well_posed)?;
    let inner = plant.close(&around(&controller, &-d22)?);
    let none = LoopError::none(&inner);
    let held = GainBound { largest_eigenvalue: worst_eigenvalue(&inner, &none, shown), ..shown.clone() };
    let bound = if held.largest_eigenvalue < 0.0 { held } else { bounded_gain(&inner, &none, shown).ok()? };
    Some((controller, bound))
}

/// Returns `true` if `I - Dtt Theta` of a controller is regular on the whole box, by mu in floating point.
fn is_well_posed(k: &Controller) -> bool {
    let blocks: Vec<Block> = k.blocks.iter().map(|r| Block::Real(*r)).collect();
    let Ok(structure) = Structure::new(blocks) else { return k.blocks.is_empty() };
    let dtt = k.dtt().map(|v| Complex::new(v, 0.0));
    upper_bound(&dtt, &structure).is_ok_and(|bound| bound.value < 1.0)
}

/// Returns the controller with its direct paths from y times a factor.
fn with_scaled_paths(k: &Controller, factor: f64) -> Controller {
    let mut out = k.clone();
    out.parts.block_mut(U, Y).scale_mut(factor);
    out.parts.block_mut(T, Y).scale_mut(factor);
    out
}

/// Designs a controller that measures y through lags of this rate (rad/s), which become part of it: their states come
/// first.
fn behind_lags(plant: &GeneralisedPlant, rate: f64, options: Options) -> Option<Design> {
    let s = plant.sizes();
    let unit = Mat::identity(s.y, s.y);
    let mut lagged = plant.changed(|parts| parts.resized(X, s.x + s.y));
    for column in [X, T, W] {
        let y = lagged.parts.block(Y, column) * rate;
        lagged.parts.block_mut(X, column).rows_mut(s.x, s.y).copy_from(&y);
    }
    lagged.parts.block_mut(X, X).view_mut((s.x, s.x), (s.y, s.y)).copy_from(&(&unit * -rate));
    lagged.parts.rows_mut(Y).fill(0.0);
    lagged.parts.block_mut(Y, X).columns_mut(s.x, s.y).copy_from(&unit);
    let design = synthesis::synthesise(&lagged, options).ok()?;
    let controller = behind(&design.controller, rate);
    Some(Design { controller, ..design })
}

/// Returns the controller with `yl' = rate (y - yl)` in place of y: `[A By Bt; Cu Duy Dut; Ct Dty Dtt]` with yl as the
/// first states.
fn behind(k: &Controller, rate: f64) -> Controller {
    let Sizes { x, t, u, y, .. } = k.parts.sizes();
    let (z, lag) = (Mat::zeros, Mat::identity(y, y) * rate);
    let matrix = block(&[
        &[&-&lag, &z(y, x), &lag, &z(y, t)],
        &[&k.by(), &k.a(), &z(x, y), &k.bt()],
        &[&k.duy(), &k.cu(), &z(u, y), &k.dut()],
        &[&k.dty(), &k.ct(), &z(t, y), &k.dtt()],
    ]);
    Controller::from_matrix(&matrix, y + x, y, u, k.blocks.clone())
}

/// The relative size, to the largest of `Duy D22` or 1, of an eigenvalue of `I + Duy D22` that is taken as zero: the
/// controller's gains grow with its inverse.
const SINGULAR_RATIO: f64 = 1e-6;

/// Relative changes of a controller's direct paths, tried until it is well posed with D22.
const DIRECT_PATH_CHANGES: [f64; 7] = [0.0, 1e-4, -1e-4, 1e-3, -1e-3, 1e-2, -1e-2];

/// The lags' time constants as multiples of that of the fastest mode of the loop without lags.
const LAG_RATIOS: [f64; 3] = [0.01, 0.1, 1.0];

/// The accepted relative increase of the bound, at which the search ends.
const ACCEPTED_RISE: f64 = 0.01;
