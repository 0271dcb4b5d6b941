//! Minimisation of the maximum of smooth functions, by sequential quadratic programming.
//!
//! Each step minimises the largest of the pieces, linearised, with one quadratic term for all, within a trust region.
//! The quadratic term approximates the Hessian of the Lagrangian by damped BFGS updates. Sources: E. Polak, Y. Wardi,
//! Automatica 18(3), 1982 (local peaks over frequency as pieces); M. J. D. Powell, in: Numerical Analysis, Dundee 1977,
//! Lecture Notes in Mathematics 630, 1978 (the damped update).

use crate::matrix::Mat;
use crate::stop;
use crate::structured::quadratic_program::{Line, minimax_step};
use nalgebra::DVector;

/// A smooth piece of the function, or of a limit: its value, its slope and its origin.
pub(crate) struct Piece {
    pub(crate) value: f64,
    pub(crate) slope: DVector<f64>,
    /// The index of the system, and the coordinate in it; near coordinates belong to one piece.
    pub(crate) place: (usize, f64),
}

/// The pieces at a point.
pub(crate) struct Pieces {
    /// Pieces that may be the largest nearby.
    pub(crate) objective: Vec<Piece>,
    /// Pieces that must stay negative.
    pub(crate) limits: Vec<Piece>,
}

/// A function that is the maximum of smooth ones.
pub(crate) trait Function {
    /// The data of an evaluation that the pieces need.
    type At;
    /// Returns the value; `None` if it is not defined.
    fn value(&self, gains: &[f64]) -> Option<(f64, Self::At)>;
    /// Returns the pieces at a point with a value.
    fn pieces(&self, at: &Self::At) -> Option<Pieces>;
    /// Returns the pieces at a point that were found to be large at another.
    fn seen_from(&self, at: &Self::At, other: &Self::At) -> Vec<Piece>;
    /// Returns the size of a significant change of the value.
    fn size(&self, value: f64) -> f64 {
        value
    }
    /// Returns the significant change of each gain.
    fn units(&self, value: f64, pieces: &Pieces) -> DVector<f64> {
        units_of(pieces, value)
    }
    /// Returns `true` if a value is small enough to end the search.
    fn suffices(&self, _: f64) -> bool {
        false
    }
}

/// Limits of the search.
#[derive(Clone, Copy)]
pub(crate) struct Effort {
    /// The largest number of steps.
    pub(crate) steps: usize,
    /// The relative predicted decrease at which the search ends.
    pub(crate) least: f64,
    /// The relative decrease over a number of steps below which the search ends.
    pub(crate) slow: f64,
    pub(crate) slow_steps: usize,
    /// The number of times that the quadratic term is reset when steps have become too small.
    pub(crate) resets: usize,
    /// The first trust region, in units of the gains.
    pub(crate) radius: f64,
}

/// The trust region, in units of the gains, below which the search ends.
const SMALLEST_RADIUS: f64 = 1e-9;

/// The ratio of the actual to the predicted decrease from which a step is taken, and that from which the region grows.
const ENOUGH: f64 = 0.05;
const GOOD: f64 = 0.6;

/// The fraction of the distance of a limit from zero that one step may use.
const PART_OF_LIMIT: f64 = 0.9;

/// Returns the point that the search from `start` reaches, and its value; `None` if there is no value at the start.
pub(crate) fn minimise<F: Function>(function: &F, start: &[f64], effort: Effort) -> Option<(Vec<f64>, f64)> {
    let (value, at) = function.value(start)?;
    let pieces = function.pieces(&at)?;
    let units = function.units(value, &pieces);
    let hessian = Mat::identity(start.len(), start.len()) * function.size(value);
    let gains = DVector::from_column_slice(start);
    let mut state = State { function, gains, value, at, pieces, units, hessian, radius: effort.radius };
    let (mut resets, mut values) = (0, vec![value]);
    for _ in 0..effort.steps {
        stop::check();
        if values.last().is_some_and(|last| state.value < *last) {
            values.push(state.value);
        }
        let before = values.len().checked_sub(effort.slow_steps).map_or(f64::INFINITY, |k| values[k]);
        if function.suffices(state.value) || before - state.value < effort.slow * function.size(state.value) {
            break;
        }
        if !state.advance(effort.least).unwrap_or(false) {
            if resets == effort.resets {
                break;
            }
            resets += 1;
            state.reset();
        }
    }
    Some((state.gains.as_slice().to_vec(), state.value))
}

struct State<'a, F: Function> {
    function: &'a F,
    gains: DVector<f64>,
    value: f64,
    at: F::At,
    pieces: Pieces,
    /// The units of the gains for the quadratic term and the radius.
    units: DVector<f64>,
    hessian: Mat,
    radius: f64,
}

impl<F: Function> State<'_, F> {
    /// Makes one step, taken or not; `true` if another one may make progress. `None` if the pieces cannot be computed.
    fn advance(&mut self, least: f64) -> Option<bool> {
        let line = |piece: &Piece, part: f64| Line {
            value: part * piece.value,
            slope: piece.slope.component_mul(&self.units),
        };
        let objective: Vec<Line> = self.pieces.objective.iter().map(|piece| line(piece, 1.0)).collect();
        let limits: Vec<Line> = self.pieces.limits.iter().map(|piece| line(piece, PART_OF_LIMIT)).collect();
        let Some(found) = minimax_step(&objective, &limits, &self.hessian, self.radius) else {
            return Some(false);
        };
        let lines = objective.iter().map(|l| l.value + l.slope.dot(&found.step));
        let predicted = self.value - lines.fold(f64::NEG_INFINITY, f64::max);
        if predicted < least * self.function.size(self.value) {
            return Some(false);
        }
        let next: DVector<f64> = &self.gains + found.step.component_mul(&self.units);
        let Some((value, there)) = self.function.value(next.as_slice()) else {
            return Some(self.shrink(&found.step));
        };
        let fell = self.value - value;
        if fell < ENOUGH * predicted {
            let seen = self.function.seen_from(&self.at, &there);
            self.pieces.objective.extend(seen);
            return Some(self.shrink(&found.step));
        }
        let pieces = self.function.pieces(&there)?;
        if fell > GOOD * predicted && found.step.amax() > 0.9 * self.radius {
            self.radius *= 2.0;
        }
        let change = change_of_slope(&self.pieces, &pieces, &found.multipliers).component_mul(&self.units);
        update(&mut self.hessian, &found.step, &change);
        (self.gains, self.value, self.at, self.pieces) = (next, value, there, pieces);
        Some(true)
    }

    fn shrink(&mut self, step: &DVector<f64>) -> bool {
        self.radius = 0.4 * self.radius.min(step.amax());
        self.radius > SMALLEST_RADIUS
    }

    /// Sets new units and resets the quadratic term.
    fn reset(&mut self) {
        let size = self.function.size(self.value);
        self.units = self.function.units(self.value, &self.pieces);
        self.hessian = Mat::identity(self.gains.len(), self.gains.len()) * size;
        self.radius = RADIUS_AFTER_RESET;
    }
}

/// The radius of the trust region after a reset of the quadratic term.
const RADIUS_AFTER_RESET: f64 = 0.1;

/// Returns the change of each gain that changes the function by `size` according to the steepest piece.
fn units_of(pieces: &Pieces, size: f64) -> DVector<f64> {
    let largest = |i: usize| pieces.objective.iter().map(|piece| piece.slope[i].abs()).fold(0.0, f64::max);
    let n = pieces.objective.first().map_or(0, |piece| piece.slope.len());
    let slopes = DVector::from_fn(n, |i, _| largest(i));
    let steepest = slopes.max();
    if steepest == 0.0 {
        return DVector::from_element(n, 1.0);
    }
    slopes.map(|slope| size / slope.max(LEAST_SLOPE * steepest))
}

/// The least slope that sets the unit of a gain, relative to the largest.
const LEAST_SLOPE: f64 = 1e-3;

/// Returns the change of the Lagrangian's slope from one point to the next, each piece compared with the nearest there.
fn change_of_slope(from: &Pieces, to: &Pieces, multipliers: &[f64]) -> DVector<f64> {
    let n = from.objective.first().map_or(0, |piece| piece.slope.len());
    let mut change = DVector::zeros(n);
    for (piece, multiplier) in from.objective.iter().zip(multipliers).filter(|(_, m)| **m > 1e-8) {
        let distance = |other: &&Piece| (other.place.1 - piece.place.1).abs();
        let same = to.objective.iter().filter(|other| other.place.0 == piece.place.0);
        if let Some(other) = same.min_by(|a, b| distance(a).total_cmp(&distance(b))) {
            change += (&other.slope - &piece.slope) * *multiplier;
        }
    }
    change
}

/// Applies the damped BFGS update to H for a step s and the change y of the slope.
fn update(hessian: &mut Mat, step: &DVector<f64>, change: &DVector<f64>) {
    let product = &*hessian * step;
    let (curvature, seen) = (step.dot(&product), step.dot(change));
    if curvature <= 0.0 || !seen.is_finite() {
        return;
    }
    let share = if seen >= 0.2 * curvature { 1.0 } else { 0.8 * curvature / (curvature - seen) };
    let change = change * share + &product * (1.0 - share);
    let seen = step.dot(&change);
    *hessian += &change * change.transpose() / seen - &product * product.transpose() / curvature;
    *hessian = crate::matrix::symmetric_part(hessian);
}
