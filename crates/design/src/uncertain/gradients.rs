//! Matrix `[M C D]` at a trim and its derivatives by the uncertain parameters, scaled to their ranges.

use crate::error::UncertainError;
use crate::uncertain::model::{Block, Uncertain};
use squid_auv::{Descriptor, Linearisation, Parameter, Trim, Vehicle};
use squid_lpv::matrix::{Mat, block};
use squid_signals::States;

/// Size relative to the equations of motion below which values are rounding.
pub(crate) const ROUNDING: f64 = 1e-12;

/// Relative tolerance of affinity, in the equations of motion.
const AFFINE: f64 = 1e-10;

/// Matrix `[M C D]` at a trim and its derivatives by the normalised parameters; n x (2 n + m) each.
#[derive(Debug, Clone)]
pub struct Gradients {
    /// Value at delta = 0.
    pub nominal: Mat,
    /// Derivative with respect to each parameter.
    pub first: Vec<Mat>,
    /// Second derivatives with respect to two parameters i < j; missing pairs are zero.
    pub second: Vec<(usize, usize, Mat)>,
}

impl Gradients {
    /// Differentiates at the trim of a linear model, with its states, and checks that there are no further terms.
    ///
    /// # Errors
    /// [`UncertainError`]: a coefficient that does not enter affinely, a product of three, no valid vehicle at a
    /// corner.
    pub fn at(vehicle: &Vehicle, linear: &Linearisation, blocks: &[Block]) -> Result<Self, UncertainError> {
        let (trim, states) = (&linear.trim, linear.states);
        let nominal = Descriptor::at(vehicle, trim, states).stacked();
        let scaled_input = |m: &Mat, actuator: usize, factor: f64| {
            let mut only = Mat::zeros(m.nrows(), m.ncols());
            let column = 2 * m.nrows() + actuator;
            only.set_column(column, &(m.column(column) * factor));
            only
        };
        let first: Vec<Mat> = blocks
            .iter()
            .map(|b| match b.uncertain {
                Uncertain::Parameter(p) => {
                    Descriptor::derivative(vehicle, trim, states, p).stacked() * b.half_range
                }
                Uncertain::Gain(actuator) => scaled_input(&nominal, actuator, b.half_range),
            })
            .collect();
        let mut second = Vec::new();
        for (i, p) in blocks.iter().enumerate() {
            for (j, q) in blocks.iter().enumerate().skip(i + 1) {
                let both = match (p.uncertain, q.uncertain) {
                    (Uncertain::Parameter(a), Uncertain::Parameter(b)) => {
                        let by = [a, b];
                        Descriptor::second_derivative(vehicle, trim, states, by).stacked()
                            * (p.half_range * q.half_range)
                    }
                    (_, Uncertain::Gain(actuator)) => scaled_input(&first[i], actuator, q.half_range),
                    (Uncertain::Gain(_), _) => continue,
                };
                if both.amax() > ROUNDING * nominal.amax() * p.half_range.min(1.0) * q.half_range.min(1.0) {
                    second.push((i, j, both));
                }
            }
        }
        let gradients = Self { nominal, first, second };
        gradients.check(vehicle, trim, states, blocks)?;
        Ok(gradients)
    }

    /// Evaluates `[M C D]` at given deltas.
    pub fn evaluate(&self, delta: &[f64]) -> Mat {
        let linear = self.first.iter().zip(delta).fold(self.nominal.clone(), |sum, (m, d)| sum + m * *d);
        self.second.iter().fold(linear, |sum, (i, j, m)| sum + m * (delta[*i] * delta[*j]))
    }

    /// Returns the norm of `[C D]` in comparable units.
    pub(crate) fn size(&self, units: &Mat) -> f64 {
        let scaled = &self.nominal * units;
        let (mass, columns) = scaled.shape();
        scaled.columns(mass, columns - mass).norm()
    }

    fn check(
        &self,
        vehicle: &Vehicle,
        trim: &Trim,
        states: States,
        blocks: &[Block],
    ) -> Result<(), UncertainError> {
        let error_at = |delta: &[f64]| {
            let changed = perturbed(vehicle, blocks, delta);
            let truth = Descriptor::at(&changed, trim, states).stacked();
            (self.evaluate(delta) - &truth).amax() / truth.amax()
        };
        let coefficient =
            |b: &Block| matches!(b.uncertain, Uncertain::Parameter(_)) && !b.uncertain.is_of_trim();
        for (i, b) in blocks.iter().enumerate().filter(|(_, b)| coefficient(b)) {
            for end in [-1.0, 1.0] {
                let mut delta = vec![0.0; blocks.len()];
                delta[i] = end;
                let error = error_at(&delta);
                if error.is_nan() || error > AFFINE {
                    return Err(UncertainError::NotAffine { name: b.name.clone(), error });
                }
            }
        }
        for end in [-1.0, 1.0] {
            let delta: Vec<f64> = blocks.iter().map(|b| if coefficient(b) { end } else { 0.0 }).collect();
            let error = error_at(&delta);
            if error.is_nan() || error > AFFINE {
                return Err(UncertainError::ThreeMultiply { error });
            }
        }
        self.check_corners(vehicle, blocks)
    }

    /// Checks the corners of the box: the mass matrix is positive definite in the box if it is at the corners, because
    /// its least eigenvalue is concave in each coefficient.
    fn check_corners(&self, vehicle: &Vehicle, blocks: &[Block]) -> Result<(), UncertainError> {
        let inertial: Vec<usize> = (0..blocks.len())
            .filter(|i| self.first[*i].columns(0, self.nominal.nrows()).amax() > 0.0)
            .collect();
        for corner in 0..1_usize << inertial.len() {
            let mut delta = vec![0.0; blocks.len()];
            for (bit, i) in inertial.iter().enumerate() {
                delta[*i] = if corner >> bit & 1 == 1 { 1.0 } else { -1.0 };
            }
            let changed = perturbed(vehicle, blocks, &delta);
            changed.coefficients.check().map_err(|reason| UncertainError::Corner { reason })?;
        }
        Ok(())
    }
}

/// Returns the vehicle with its coefficients at `value + half_range delta`.
pub fn perturbed(vehicle: &Vehicle, blocks: &[Block], delta: &[f64]) -> Vehicle {
    blocks.iter().zip(delta).fold(vehicle.clone(), |changed, (b, d)| match b.uncertain {
        Uncertain::Parameter(p @ (Parameter::Coefficient(_) | Parameter::Effect { .. })) if *d != 0.0 => {
            p.with_value(&changed, b.value + b.half_range * d)
        }
        _ => changed,
    })
}

/// Returns units that make the columns of `[M C D]` comparable: inputs in units of their reach.
pub(crate) fn units(vehicle: &Vehicle, states: usize) -> Mat {
    let inputs = vehicle.actuators.iter().map(squid_auv::Actuator::reach);
    let all: Vec<f64> = std::iter::repeat_n(1.0, 2 * states).chain(inputs).collect();
    Mat::from_diagonal(&nalgebra::DVector::from_vec(all))
}

/// Removes directions of the trim's effect that are smaller than `detail` of `[C D]` at all of the trims; the model is
/// first order in the trim in any case.
pub fn coarsen(vehicle: &Vehicle, blocks: &[Block], detail: f64, samples: &mut [Gradients]) {
    let units = units(vehicle, samples.first().map_or(0, |g| g.nominal.nrows()));
    let inverse = units.map(|v| if v > 0.0 { 1.0 / v } else { 0.0 });
    let sizes: Vec<f64> = samples.iter().map(|g| g.size(&units)).collect();
    for index in (0..blocks.len()).filter(|i| blocks[*i].uncertain.is_of_trim()) {
        let mut rows = Mat::zeros(0, units.ncols());
        for (g, size) in samples.iter().zip(&sizes) {
            let inside = g.second.iter().filter(|(_, j, _)| *j == index).map(|(_, _, m)| m);
            for m in std::iter::once(&g.first[index]).chain(inside) {
                rows = block(&[&[&rows], &[&(m * &units / *size)]]);
            }
        }
        let decomposition = squid_lpv::matrix::svd(&rows);
        let rank = decomposition.s.iter().filter(|s| **s > detail).count();
        let directions = decomposition.v.columns(0, rank).into_owned();
        let projector = &units * &directions * directions.transpose() * &inverse;
        for (g, size) in samples.iter_mut().zip(&sizes) {
            g.first[index] = &g.first[index] * &projector;
            for (_, j, m) in &mut g.second {
                if *j == index {
                    *m = &*m * &projector;
                }
            }
            let large = |i: usize, j: usize, m: &Mat| {
                (m * &units).norm() > detail * size || (i != index && j != index)
            };
            g.second.retain(|(i, j, m)| large(*i, *j, m));
        }
    }
}
