//! Controllers with a small structured singular value, by D-K iteration.
//!
//! ```text
//! K: least gain of [Dz 0; 0 I] P [Dw^-1 0; 0 I] with K       for given scalings D(s)
//! D: least largest singular value of Dz M Dw^-1 at each frequency, M the loop of P and K;
//!    then d(s) = k prod (s + z_i)/(s + p_i) fitted to each scaling
//! ```
//!
//! Neither step raises the bound of mu except by the error of the fit; the result is a local optimum. Real blocks are
//! taken as complex ones in the iteration, and as real ones in the returned bound. Source: J. C. Doyle, "Structured
//! uncertainty in control system design", IEEE Conference on Decision and Control, 1985; G. J. Balas et al.,
//! "mu-Analysis and Synthesis Toolbox", 1993.

use super::over_frequency::mu_over_frequency;
use super::structure::{Block, Structure};
use super::sweep::SweepError;
use super::upper::upper_bound;
use crate::error::SynthesisError;
use crate::matrix::{Mat, solve};
use crate::synthesis::{Options, direct_path};
use crate::system::Group::{T, U, W, Y, Z};
use crate::system::{Controller, GeneralisedPlant, Sizes, StateSpace};
use nalgebra::{Complex, DVector};
use thiserror::Error;

/// Options of the iteration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MuOptions {
    /// The largest number of controllers.
    pub iterations: usize,
    /// The largest order of a fitted scaling.
    pub order: usize,
    /// The relative distance above the least gain at which each controller is built.
    pub back_off: f64,
}

impl Default for MuOptions {
    fn default() -> Self {
        Self { iterations: 6, order: 4, back_off: 0.005 }
    }
}

/// The best controller of the iteration.
#[derive(Debug, Clone, PartialEq)]
pub struct MuDesign {
    /// The controller `u = K y`.
    pub controller: Controller,
    /// The loop from w to z.
    pub closed: StateSpace,
    /// Upper bound of mu of the loop at every frequency, in floating point.
    pub mu: f64,
    /// The same bound for the controller of each iteration.
    pub history: Vec<f64>,
}

/// An iteration without a result.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum MuSynthesisError {
    /// Failure to find a first controller.
    #[error(transparent)]
    Synthesis(#[from] SynthesisError),
    /// A structure that does not fit, or a mu that cannot be bounded.
    #[error(transparent)]
    Mu(#[from] SweepError),
}

/// Designs a controller by D-K iteration for a plant without parameters and with the direct path D22 (y x u).
///
/// `structure` has the blocks of `w = Delta z`; a requirement on the gain is one more full block.
///
/// # Errors
/// Returns [`MuSynthesisError`] if there is no first controller.
pub fn musyn(
    plant: &GeneralisedPlant,
    d22: &Mat,
    structure: &Structure,
    options: MuOptions,
) -> Result<MuDesign, MuSynthesisError> {
    let synthesis_options = Options { back_off: options.back_off, ..Options::default() };
    let mut scalings = vec![Scaling::one(); scaled_signals(structure).len()];
    let mut best: Option<MuDesign> = None;
    let mut history = vec![];
    for _ in 0..options.iterations {
        let design = direct_path::synthesise(&scaled(plant, structure, &scalings), d22, synthesis_options);
        let next = design.map_err(MuSynthesisError::from).and_then(|design| {
            let looped = direct_path::around(&design.controller, &-d22);
            let closed = looped.and_then(|k| plant.close(&k).frozen(&[]).ok());
            let closed =
                closed.ok_or_else(|| SynthesisError::numerical(STAGE, "the loop is not well posed"))?;
            let mu = mu_over_frequency(&closed, structure)?.upper.upper;
            Ok(MuDesign { controller: design.controller, closed, mu, history: vec![] })
        });
        // A failure after the first controller ends the iteration with the best one.
        let found = match (next, &best) {
            (Ok(found), _) => found,
            (Err(error), None) => return Err(error),
            (Err(_), Some(_)) => break,
        };
        history.push(found.mu);
        scalings = fitted(&found.closed, structure, options.order);
        let improved = best.as_ref().is_none_or(|best| found.mu < (1.0 - LEAST_IMPROVEMENT) * best.mu);
        if best.as_ref().is_none_or(|best| found.mu < best.mu) {
            best = Some(found);
        }
        if !improved {
            break;
        }
    }
    let best = best.ok_or_else(|| SynthesisError::numerical(STAGE, "no iteration was requested"))?;
    Ok(MuDesign { history, ..best })
}

const STAGE: &str = "D-K iteration";

/// The relative decrease of mu below which the iteration ends.
const LEAST_IMPROVEMENT: f64 = 1e-3;

/// Returns rows (of w) and columns (of z) of each scaling: one for each entry of a repeated scalar, one for a full
/// block.
fn scaled_signals(structure: &Structure) -> Vec<(usize, usize)> {
    let of = |block: &Block| match *block {
        Block::Real(r) | Block::Complex(r) => vec![(1, 1); r],
        Block::Full { rows, cols } => vec![(rows, cols)],
    };
    structure.blocks().iter().flat_map(of).collect()
}

/// A scaling `k prod (s + z_i)/(s + p_i)` with positive k, z_i and p_i: stable, with a stable inverse.
#[derive(Debug, Clone, PartialEq)]
struct Scaling {
    gain: f64,
    zeros: Vec<f64>,
    poles: Vec<f64>,
}

impl Scaling {
    fn one() -> Self {
        Self { gain: 1.0, zeros: vec![], poles: vec![] }
    }

    fn inverse(&self) -> Self {
        Self { gain: 1.0 / self.gain, zeros: self.poles.clone(), poles: self.zeros.clone() }
    }

    /// Returns a realisation: the factors `1 + (z - p)/(s + p)` in series.
    fn realised(&self) -> StateSpace {
        let n = self.poles.len();
        // The input of factor i is the sum of the input and of the outputs of all earlier factors.
        let a = Mat::from_fn(n, n, |i, j| match i.cmp(&j) {
            std::cmp::Ordering::Equal => -self.poles[i],
            std::cmp::Ordering::Greater => self.zeros[j] - self.poles[j],
            std::cmp::Ordering::Less => 0.0,
        });
        let c = Mat::from_fn(1, n, |_, j| self.gain * (self.zeros[j] - self.poles[j]));
        StateSpace { a, b: Mat::from_element(n, 1, 1.0), c, d: Mat::from_element(1, 1, self.gain) }
    }

    /// Returns the logarithm of its magnitude at a frequency, by the logarithms of gain, zeros and poles, and its
    /// derivatives.
    fn log_magnitude(parameters: &DVector<f64>, omega: f64) -> (f64, DVector<f64>) {
        let order = (parameters.len() - 1) / 2;
        let mut value = parameters[0];
        let mut slope = DVector::zeros(parameters.len());
        slope[0] = 1.0;
        for i in 1..=2 * order {
            let sign = if i <= order { 1.0 } else { -1.0 };
            let square = (2.0 * parameters[i]).exp();
            value += sign * 0.5 * (omega * omega + square).ln();
            slope[i] = sign * square / (omega * omega + square);
        }
        (value, slope)
    }
}

/// Returns P with its scalings.
fn scaled(plant: &GeneralisedPlant, structure: &Structure, scalings: &[Scaling]) -> GeneralisedPlant {
    let copies = |of: fn(&(usize, usize)) -> usize, inverse: bool| {
        let signals = scaled_signals(structure);
        let each = signals.iter().zip(scalings).flat_map(|(signal, scaling)| {
            let scaling = if inverse { scaling.inverse() } else { scaling.clone() };
            vec![scaling.realised(); of(signal)]
        });
        StateSpace::side_by_side(&each.collect::<Vec<_>>())
    };
    let (out, into) = (copies(|signal| signal.1, false), copies(|signal| signal.0, true));
    let s = plant.sizes();
    let system = plant.parts.state_space(&[T, Z, Y], &[T, W, U]);
    let unit = |n: usize| StateSpace::constant(Mat::identity(n, n));
    let out = StateSpace::side_by_side(&[out, unit(s.y)]);
    let into = StateSpace::side_by_side(&[into, unit(s.u)]);
    let scaled = out.after(&system.after(&into));
    let sizes = Sizes { x: scaled.a.nrows(), ..s };
    // The plant has no direct path from u to y.
    GeneralisedPlant::of_system(&scaled, sizes, vec![]).0
}

/// Fits scalings to those of the loop on a grid of frequencies, relative to the last one.
fn fitted(closed: &StateSpace, structure: &Structure, order: usize) -> Vec<Scaling> {
    let signals = scaled_signals(structure);
    let full = signals.iter().map(|&(rows, cols)| Block::Full { rows, cols }).collect();
    let complex = Structure::of(full);
    let rates: Vec<f64> = closed.poles().iter().map(|pole| pole.norm()).filter(|rate| *rate > 0.0).collect();
    let (slowest, fastest) = rates.iter().fold((f64::INFINITY, 0.0_f64), |(a, b), r| (a.min(*r), b.max(*r)));
    let (from, to) = ((0.1 * slowest).ln(), (10.0 * fastest).ln());
    let mut found: Vec<(f64, f64, Vec<f64>)> = vec![];
    for i in 0..POINTS {
        let omega = (from + (to - from) * i as f64 / (POINTS - 1) as f64).exp();
        let Some(response) = closed.response(Complex::new(0.0, omega)) else { continue };
        let Ok(bound) = upper_bound(&response, &complex) else { continue };
        let mut at = 0;
        let logs = signals.iter().map(|(rows, _)| {
            let log = 0.5 * bound.scalings.dw[(at, at)].re.ln();
            at += rows;
            log
        });
        found.push((omega, bound.value, logs.collect()));
    }
    let largest = found.iter().map(|point| point.1).fold(0.0, f64::max);
    (0..signals.len())
        .map(|k| {
            let points: Vec<Point> = found
                .iter()
                .map(|(omega, mu, logs)| Point {
                    omega: *omega,
                    log: logs[k] - logs[signals.len() - 1],
                    weight: (mu / largest).powi(WEIGHT_POWER),
                })
                .collect();
            (0..=order)
                .map(|order| fit(&points, order))
                .find(|(_, error)| *error < FIT_ERROR)
                .unwrap_or_else(|| fit(&points, order))
                .0
        })
        .collect()
}

/// A frequency (rad/s), the logarithm of a scaling there, and its weight in the fit.
struct Point {
    omega: f64,
    log: f64,
    weight: f64,
}

/// The number of frequencies at which scalings are computed.
const POINTS: usize = 80;

/// The power of mu, relative to its peak, by which a frequency is weighted in the fit.
const WEIGHT_POWER: i32 = 2;

/// The weighted rms error of the logarithm of a scaling below which no higher order is tried.
const FIT_ERROR: f64 = 5e-3;

/// Fits the scaling of an order with the least weighted squared error of the logarithm, by Levenberg's method; returns
/// it and its rms error.
fn fit(points: &[Point], order: usize) -> (Scaling, f64) {
    let total: f64 = points.iter().map(|p| p.weight).sum();
    let error = |parameters: &DVector<f64>| {
        let squares =
            points.iter().map(|p| p.weight * (Scaling::log_magnitude(parameters, p.omega).0 - p.log).powi(2));
        (squares.sum::<f64>() / total).sqrt()
    };
    let mut parameters = DVector::zeros(1 + 2 * order);
    if points.len() < 2 {
        return (Scaling::one(), 0.0);
    }
    // Conditioning a zero and a pole about the middle of each part of the curve; all parts rise and fall by equal
    // amounts.
    let steps: Vec<f64> = points.windows(2).map(|pair| pair[1].log - pair[0].log).collect();
    let total_variation: f64 = steps.iter().map(|step| step.abs()).sum();
    for i in 0..order {
        let target = (i as f64 + 0.5) / order as f64 * total_variation;
        let mut passed = 0.0;
        let at = steps.iter().position(|step| {
            passed += step.abs();
            passed >= target
        });
        let at = at.unwrap_or_default();
        let (omega, step) = (points[at].omega.ln(), steps[at]);
        parameters[1 + i] = omega - 0.5 * step.signum();
        parameters[1 + order + i] = omega + 0.5 * step.signum();
    }
    let mut damping = 1e-2;
    let mut least = error(&parameters);
    for _ in 0..FIT_STEPS {
        let n = parameters.len();
        let (mut normal, mut right) = (Mat::zeros(n, n), Mat::zeros(n, 1));
        for p in points {
            let (value, slope) = Scaling::log_magnitude(&parameters, p.omega);
            normal += &slope * slope.transpose() * p.weight;
            right += slope * (p.weight * (p.log - value));
        }
        let damped = &normal + Mat::identity(n, n) * (damping * normal.trace() / n as f64);
        let Some(step) = solve(&damped, &right) else { break };
        let next = &parameters + step.column(0);
        let found = error(&next);
        if found < least {
            (parameters, least, damping) = (next, found, 0.3 * damping);
        } else {
            damping *= 4.0;
        }
    }
    let value = |i: usize| parameters[i].exp();
    let scaling = Scaling {
        gain: value(0),
        zeros: (1..=order).map(value).collect(),
        poles: (order + 1..=2 * order).map(value).collect(),
    };
    (scaling, least)
}

/// The number of steps of a fit.
const FIT_STEPS: usize = 100;
