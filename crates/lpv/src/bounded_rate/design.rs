//! The design of a controller for a parameter with a bounded rate.

use crate::analysis::bounded_gain::{Base, search};
use crate::analysis::gain_bound::GainBound;
use crate::bounded_rate::central::{Central, central, in_coordinates};
use crate::bounded_rate::inequalities::{Grid, Pair, Varying};
use crate::bounded_rate::intervals::{Claim, SlowBound, intervals};
use crate::bounded_rate::loop_lyapunov::{SAMPLES, tightened};
use crate::bounded_rate::scheduled::through;
use crate::error::{SynthesisError, SystemError};
use crate::matrix::{Mat, diagonal, pseudo_inverse, symmetric_part};
use crate::synthesis::Options;
use crate::synthesis::balance::Coordinates;
use crate::synthesis::least_gamma::{Conditioning, least_gamma_at};
use crate::system::{
    ClosedLoop, Controller, GeneralisedPlant, LoopError, MatrixPolynomial, Sizes, check_detectable,
    check_stabilisable, evenly_spread,
};

/// Options of the design.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SlowOptions {
    /// The bound nu on `|theta'|`, in units of theta per unit of time.
    pub rate: f64,
    /// The back-off: the controller is built at `(1 + back_off)` times the least gamma.
    pub back_off: f64,
    /// The relative accuracy of the least gamma.
    pub accuracy: f64,
    /// The number of parameter values, evenly spaced over [-1, 1], at which the inequalities are imposed.
    pub points: usize,
    /// The order of the Lyapunov matrix that depends on the parameter.
    pub order: usize,
}

impl SlowOptions {
    /// Returns the default options for a rate.
    pub fn at(rate: f64) -> Self {
        Self { rate, back_off: 0.1, accuracy: 1e-3, points: 7, order: 2 }
    }
}

/// A controller with its bounds.
#[derive(Debug, Clone, PartialEq)]
pub struct SlowDesign {
    /// The controller, an LFT in the parameter.
    pub controller: Controller,
    /// The least gamma of the inequalities at the values of the parameter.
    pub least: Least,
    /// The gamma at which the controller was built.
    pub gamma_design: f64,
    /// The gain of the closed loop at the bounded rate.
    pub bound: SlowBound,
    /// The gain of the closed loop for any rate of the parameter; `None` if none was found.
    pub fast: Option<GainBound>,
}

/// The least gamma at some values of the parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Least {
    /// The least gamma.
    pub gamma: f64,
    /// The matrix that varies.
    pub varying: Varying,
}

const STAGE: &str = "synthesis at a bounded rate";

/// The relative excess of the closed loop's gain, with an LFT, over that of the controllers to which it is fitted.
const LOSS: f64 = 0.03;

/// Orders of the polynomials fitted to the controllers, and relative tolerances of their singular values.
const ORDERS: [usize; 4] = [1, 2, 3, 4];
const TOLERANCES: [f64; 9] = [0.1, 0.03, 0.01, 3e-3, 1e-3, 3e-4, 1e-4, 1e-5, 1e-6];

/// The largest number of controllers for which a Lyapunov matrix of the loop is computed, which takes seconds for each.
const TRIES: usize = 4;

/// The additional order for a Lyapunov matrix that is a rational function.
const RATIONAL_ORDER: usize = 2;

/// Returns the coordinates of the least gamma for any rate of the parameter, or else diagonal ones.
fn conditioning_of(plant: &GeneralisedPlant) -> Conditioning {
    match least_gamma_at(plant, Options { accuracy: COORDINATES_ACCURACY, ..Options::default() }, None) {
        Ok((coordinates, found)) => Conditioning { coordinates, unit: found.gamma },
        Err(_) => Conditioning { coordinates: Coordinates::diagonal(plant), unit: 1.0 },
    }
}

fn grid(
    conditioning: &Conditioning,
    plant: &GeneralisedPlant,
    options: SlowOptions,
    varying: Varying,
) -> Result<Grid, SynthesisError> {
    let points = frozen(&conditioning.plant(plant), options.points)?;
    let rate = conditioning.coordinates.scaled_rate(options.rate);
    Ok(Grid { points, rate, varying, order: options.order })
}

/// The relative accuracy of the gamma whose coordinates are used.
const COORDINATES_ACCURACY: f64 = 0.02;

/// Returns the plant frozen at `count` values evenly spaced over [-1, 1].
fn frozen(plant: &GeneralisedPlant, count: usize) -> Result<Vec<(f64, GeneralisedPlant)>, SynthesisError> {
    let wrong = |e: SystemError| SynthesisError::numerical(STAGE, e.to_string());
    evenly_spread(count).map(|theta| Ok((theta, plant.frozen(&[theta]).map_err(wrong)?))).collect()
}

/// Returns the least gamma for a plant with one parameter with `|theta'| <= rate`, at values of the parameter.
///
/// # Errors
/// Returns [`SynthesisError::NotStabilisable`], [`SynthesisError::NotDetectable`]; [`SynthesisError::Numerical`] for a
/// number of parameters other than one; those of the solver.
pub fn least_gamma(plant: &GeneralisedPlant, options: SlowOptions) -> Result<Least, SynthesisError> {
    let candidates = candidates(plant, &conditioning_of(plant), options)?;
    // The list is in ascending order, and not empty.
    candidates.first().copied().ok_or_else(|| SynthesisError::numerical(STAGE, "no controller was attempted"))
}

/// Returns the least gamma for each choice of the varying matrices, ascending; at least one.
fn candidates(
    plant: &GeneralisedPlant,
    conditioning: &Conditioning,
    options: SlowOptions,
) -> Result<Vec<Least>, SynthesisError> {
    plant.check()?;
    check_stabilisable(plant)?;
    check_detectable(plant)?;
    if plant.blocks.len() != 1 {
        let diagnosis =
            format!("the plant has {} parameters, a bounded rate requires one", plant.blocks.len());
        return Err(SynthesisError::numerical(STAGE, diagnosis));
    }
    let (mut found, mut failure) = (vec![], None);
    for varying in [Varying::Both, Varying::X, Varying::Y] {
        match grid(conditioning, plant, options, varying)?.least(options.accuracy) {
            Ok(gamma) => found.push(Least { gamma: gamma * conditioning.unit, varying }),
            Err(e) => failure = Some(e),
        }
    }
    found.sort_by(|one, other| one.gamma.total_cmp(&other.gamma));
    match failure {
        Some(e) if found.is_empty() => Err(e),
        _ => Ok(found),
    }
}

/// Designs a controller for a plant with one parameter with `|theta'| <= rate`, and bounds the gain of the closed loop,
/// between all values of the parameter.
///
/// The varying matrices (X, Y or both) are chosen by the bound of the closed loop; a choice whose least gamma exceeds a
/// known bound is skipped.
///
/// # Errors
/// Errors of [`least_gamma`]; also [`SynthesisError::Numerical`] if no fitted LFT keeps the controllers' gamma.
pub fn synthesise(plant: &GeneralisedPlant, options: SlowOptions) -> Result<SlowDesign, SynthesisError> {
    let conditioning = conditioning_of(plant);
    let mut best: Option<SlowDesign> = None;
    let mut failure = None;
    for least in candidates(plant, &conditioning, options)? {
        if best.as_ref().is_some_and(|known| known.bound.gamma <= least.gamma) {
            break;
        }
        match build(plant, &conditioning.coordinates, least, options) {
            Ok(found) if best.as_ref().is_none_or(|known| found.bound.gamma < known.bound.gamma) => {
                best = Some(found);
            }
            Ok(_) => {}
            Err(e) => failure = failure.or(Some(e)),
        }
    }
    best.ok_or_else(|| {
        failure.unwrap_or_else(|| SynthesisError::numerical(STAGE, "no controller was attempted"))
    })
}

/// Builds the controller above a least gamma.
fn build(
    plant: &GeneralisedPlant,
    coordinates: &Coordinates,
    least: Least,
    options: SlowOptions,
) -> Result<SlowDesign, SynthesisError> {
    let gamma_design = (1.0 + options.back_off) * least.gamma;
    let conditioning = Conditioning { coordinates: coordinates.clone(), unit: gamma_design };
    let grid = grid(&conditioning, plant, options, least.varying)?;
    let pair = grid.centre(1.0)?;
    let family = family(&conditioning.plant(plant), &pair, least.varying)?;
    let (controller, bound) = simplest(plant, &conditioning, &family, options, least.varying)?;
    let closed = plant.close(&controller);
    let fast = any_rate(&closed, &bound);
    let bound = tightened(&closed, bound.rate, bound.gamma, fast.as_ref()).unwrap_or(bound);
    Ok(SlowDesign { controller, least, gamma_design, bound, fast })
}

/// Returns the controllers at many parameter values, in coordinates in which the Lyapunov matrix of their states is the
/// identity in the middle.
fn family(
    plant: &GeneralisedPlant,
    pair: &Pair,
    varying: Varying,
) -> Result<Vec<(f64, Central)>, SynthesisError> {
    let n = plant.sizes().x;
    let each = frozen(plant, SAMPLES)?.into_iter().map(|(theta, frozen)| {
        let found = central(&frozen, &pair.x.evaluate(theta), &pair.y.evaluate(theta), varying);
        found.map(|found| (theta, found)).ok_or_else(|| {
            let diagnosis =
                format!("no closed-form controller at theta = {theta}: X, Y, D12 or D21 is singular");
            SynthesisError::numerical(STAGE, diagnosis)
        })
    });
    let found: Vec<(f64, Central)> = each.collect::<Result<_, _>>()?;
    let middle = &found[SAMPLES / 2].1.lyapunov;
    let part = symmetric_part(&middle.view((n, n), (n, n)).into_owned());
    let singular = || SynthesisError::numerical(STAGE, "the Lyapunov matrix of the controller is singular");
    let root = part.cholesky().ok_or_else(singular)?.l().transpose();
    let inverse = root.clone().try_inverse().ok_or_else(singular)?;
    // In the coordinates T the Lyapunov matrix is T' P T, its inverse T^-1 Q T^-T.
    let (t, t_inverse) = match varying {
        Varying::X | Varying::Both => (inverse, root),
        Varying::Y => (root.transpose(), inverse.transpose()),
    };
    let change = if varying != Varying::Y { t.clone() } else { t_inverse.transpose() };
    Ok(found.into_iter().map(|(theta, c)| (theta, in_coordinates(&c, &t, &t_inverse, &change))).collect())
}

/// Returns the LFT with the fewest channels, fitted to a family of controllers, that keeps their gain up to [`LOSS`].
fn simplest(
    plant: &GeneralisedPlant,
    conditioning: &Conditioning,
    family: &[(f64, Central)],
    options: SlowOptions,
    varying: Varying,
) -> Result<(Controller, SlowBound), SynthesisError> {
    let s = plant.sizes();
    let samples: Vec<(f64, Mat)> = family.iter().map(|(theta, c)| (*theta, c.matrix.clone())).collect();
    let mut candidates: Vec<Controller> = vec![];
    for order in ORDERS {
        for tolerance in TOLERANCES {
            candidates.extend(through(
                &samples,
                Sizes { x: s.x, y: s.y, u: s.u, ..Sizes::default() },
                order,
                tolerance,
            ));
        }
    }
    candidates.sort_by_key(|k| k.blocks.iter().sum::<usize>());
    let gamma = conditioning.unit * (1.0 + LOSS);
    let inverse = varying == Varying::Y;
    // [X Z; Z Z] with Z = X - Y^-1 is not a polynomial if Y varies.
    let order = if varying == Varying::Both { options.order + RATIONAL_ORDER } else { options.order };
    let (rate, lyapunov) = (options.rate, lyapunov_matrix(conditioning, family, order, inverse)?);
    let controllers: Vec<Controller> = candidates.iter().map(|k| conditioning.coordinates.undo(k)).collect();
    for controller in &controllers {
        let closed = plant.close(controller);
        let none = LoopError::none(&closed);
        let lyapunov = &lyapunov;
        let claim = Claim { closed: &closed, error: &none, inverse, lyapunov, rate, gamma, lambda: 0.0 };
        if let Some(bound) = intervals(claim) {
            return Ok((controller.clone(), bound));
        }
    }
    by_loop_bounds(plant, &controllers, rate, gamma).ok_or_else(|| {
        SynthesisError::numerical(
            STAGE,
            "no LFT that interpolates the controllers preserves their gain; try a larger back-off",
        )
    })
}

/// Selects among controllers that keep a gamma at frozen values, tried from the fewest channels to the most: the first
/// whose loop keeps it by a Lyapunov matrix computed for that loop, or the one with the least bound.
fn by_loop_bounds(
    plant: &GeneralisedPlant,
    controllers: &[Controller],
    rate: f64,
    gamma: f64,
) -> Option<(Controller, SlowBound)> {
    let keeps = |k: &&Controller| {
        let loops = plant.close(k).sampled(SAMPLES).unwrap_or_default();
        !loops.is_empty() && loops.iter().all(|(_, s)| s.hinf_norm().value < gamma)
    };
    let mut kept: Vec<&Controller> = controllers.iter().filter(keeps).collect();
    kept.dedup_by_key(|k| k.blocks.iter().sum::<usize>());
    let mut best: Option<(Controller, SlowBound)> = None;
    for part in 0..kept.len().min(TRIES) {
        let k = kept[part * kept.len() / kept.len().min(TRIES)];
        let most = best.as_ref().map_or(FAST_GUESS * gamma, |(_, known)| known.gamma);
        if let Some(bound) = tightened(&plant.close(k), rate, most, None) {
            let done = bound.gamma < gamma;
            best = Some((k.clone(), bound));
            if done {
                break;
            }
        }
    }
    best
}

/// Fits a polynomial to the Lyapunov matrices of a family, or to their inverses, in the plant's coordinates.
fn lyapunov_matrix(
    conditioning: &Conditioning,
    family: &[(f64, Central)],
    order: usize,
    inverse: bool,
) -> Result<Vec<Mat>, SynthesisError> {
    let samples: Vec<(f64, Mat)> = family.iter().map(|(theta, c)| (*theta, c.lyapunov.clone())).collect();
    let fit = MatrixPolynomial::fit(&samples, order)
        .map_err(|e| SynthesisError::numerical(STAGE, e.to_string()))?;
    let undone = |m: &Mat| symmetric_part(&conditioning.coordinates.undo_lyapunov(m, inverse));
    Ok(fit.coefficients.iter().map(undone).collect())
}

/// Returns a bound for any rate of the parameter, searched from the proof at the bounded rate.
fn any_rate(closed: &ClosedLoop, slow: &SlowBound) -> Option<GainBound> {
    let r = closed.channels.len();
    let none = LoopError::none(closed);
    let middle = slow.lyapunov.first()?.clone();
    let x = if slow.inverse { symmetric_part(&middle.cholesky()?.inverse()) } else { middle };
    let mut bound = GainBound {
        gamma: FAST_GUESS * slow.gamma,
        s: channel_sizes(closed, &x),
        x,
        factor: None,
        t: Mat::zeros(r, r),
        lambda: 0.0,
        largest_eigenvalue: f64::NAN,
    };
    let mut best: Option<GainBound> = None;
    for tolerance in [0.3, 0.05, 0.01, 0.01] {
        let Ok((found, _)) = search(Base { closed, error: &none, bound: &bound }, tolerance) else { break };
        if found.largest_eigenvalue >= 0.0 {
            break;
        }
        bound = found.clone();
        best = Some(found);
    }
    best
}

/// The initial gain for any rate of the parameter, relative to that at the bounded rate.
const FAST_GUESS: f64 = 1.5;

/// Estimates S: the gains to and from the channels of the loop at theta = 0, in the metric of its Lyapunov matrix.
fn channel_sizes(closed: &ClosedLoop, x: &Mat) -> Mat {
    let (ct, bt) = (closed.ct(), closed.bt());
    let r = closed.channels.len();
    let inverse = pseudo_inverse(x, f64::EPSILON);
    let out = (&ct * &inverse * ct.transpose()).diagonal();
    let into = (bt.transpose() * x * &bt).diagonal();
    let size = |i: usize| {
        let (a, b): (f64, f64) = (into[i], out[i]);
        if a > 0.0 && b > 0.0 { (a / b).sqrt() } else { 1.0 }
    };
    diagonal((0..r).map(size))
}
