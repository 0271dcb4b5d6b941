//! `[M C D]` as it depends on the uncertain parameters, and the LFT of `[A B] = M^-1 [C D]` that follows.

use crate::error::Error;
use crate::uncertain::{Block, Uncertain, UncertainError};
use crate::uncertain_reduce::range;
use auv::{Descriptor, Parameter, Trim, Vehicle};
use lpv::lft::Lft;
use lpv::matrix::{Mat, block};
use lpv::polynomial::MatrixPolynomial;

/// Columns of M in `[M C D]`, and those of M and C.
const MASS: usize = 4;
const INPUTS: usize = 8;

/// What is smaller than this beside the equations of motion is rounding.
const ROUNDING: f64 = 1e-12;

/// What is smaller than this beside `[C D]` is left out of what the trim does: fewer channels for an error that is measured
/// with the rest, and small beside what is uncertain.
pub const DETAIL: f64 = 1e-3;

/// The same over the range of speed, and how well the polynomials in rho must meet the uncertain parts.
pub const DETAIL_OVER_RANGE: f64 = 3e-3;

/// What a coefficient may be off being affine, relative to the equations of motion.
const AFFINE: f64 = 1e-10;

/// `[M C D]` at a trim and its derivatives by the normalised parameters; 4 x (8 + m) each.
#[derive(Debug, Clone)]
pub struct Gradients {
    /// At delta = 0.
    pub nominal: Mat,
    /// By each parameter.
    pub first: Vec<Mat>,
    /// By two parameters i < j; pairs that are not here do not multiply.
    pub second: Vec<(usize, usize, Mat)>,
}

impl Gradients {
    /// Differentiates at a trim, and checks that this is all there is.
    ///
    /// # Errors
    /// [`UncertainError`]: a coefficient that does not enter affinely, three that multiply, no vehicle at a corner.
    pub fn at(vehicle: &Vehicle, trim: &Trim, blocks: &[Block]) -> Result<Self, UncertainError> {
        let nominal = Descriptor::at(vehicle, trim).stacked();
        let scaled_input = |m: &Mat, actuator: usize, factor: f64| {
            let mut only = Mat::zeros(m.nrows(), m.ncols());
            only.set_column(INPUTS + actuator, &(m.column(INPUTS + actuator) * factor));
            only
        };
        let first: Vec<Mat> = blocks
            .iter()
            .map(|b| match b.uncertain {
                Uncertain::Parameter(p) => Descriptor::derivative(vehicle, trim, p).stacked() * b.half_range,
                Uncertain::Gain(actuator) => scaled_input(&nominal, actuator, b.half_range),
            })
            .collect();
        let mut second = Vec::new();
        for (i, p) in blocks.iter().enumerate() {
            for (j, q) in blocks.iter().enumerate().skip(i + 1) {
                let both = match (p.uncertain, q.uncertain) {
                    (Uncertain::Parameter(a), Uncertain::Parameter(b)) => {
                        let by = [a, b];
                        Descriptor::second_derivative(vehicle, trim, by).stacked()
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
        let found = Self { nominal, first, second };
        found.check(vehicle, trim, blocks)?;
        Ok(found)
    }

    /// `[M C D]` at a delta for each parameter.
    pub fn evaluate(&self, delta: &[f64]) -> Mat {
        let linear = self.first.iter().zip(delta).fold(self.nominal.clone(), |sum, (m, d)| sum + m * *d);
        self.second.iter().fold(linear, |sum, (i, j, m)| sum + m * (delta[*i] * delta[*j]))
    }

    /// The size of `[C D]` in comparable units.
    fn size(&self, units: &Mat) -> f64 {
        let scaled = &self.nominal * units;
        scaled.columns(MASS, scaled.ncols() - MASS).norm()
    }

    fn check(&self, vehicle: &Vehicle, trim: &Trim, blocks: &[Block]) -> Result<(), UncertainError> {
        let off = |delta: &[f64]| {
            let changed = perturbed(vehicle, blocks, delta);
            let truth = Descriptor::at(&changed, trim).stacked();
            (self.evaluate(delta) - &truth).amax() / truth.amax()
        };
        let coefficient =
            |b: &Block| matches!(b.uncertain, Uncertain::Parameter(_)) && !b.uncertain.is_of_trim();
        for (i, b) in blocks.iter().enumerate().filter(|(_, b)| coefficient(b)) {
            for end in [-1.0, 1.0] {
                let mut delta = vec![0.0; blocks.len()];
                delta[i] = end;
                let off = off(&delta);
                if off.is_nan() || off > AFFINE {
                    return Err(UncertainError::NotAffine { name: b.name.clone(), off });
                }
            }
        }
        for end in [-1.0, 1.0] {
            let delta: Vec<f64> = blocks.iter().map(|b| if coefficient(b) { end } else { 0.0 }).collect();
            let off = off(&delta);
            if off.is_nan() || off > AFFINE {
                return Err(UncertainError::ThreeMultiply { off });
            }
        }
        self.check_corners(vehicle, blocks)
    }

    /// The mass matrix is positive definite in the box if it is at its corners: its least eigenvalue is concave in each
    /// coefficient.
    fn check_corners(&self, vehicle: &Vehicle, blocks: &[Block]) -> Result<(), UncertainError> {
        let heavy: Vec<usize> =
            (0..blocks.len()).filter(|i| self.first[*i].columns(0, MASS).amax() > 0.0).collect();
        for corner in 0..1_usize << heavy.len() {
            let mut delta = vec![0.0; blocks.len()];
            for (bit, i) in heavy.iter().enumerate() {
                delta[*i] = if corner >> bit & 1 == 1 { 1.0 } else { -1.0 };
            }
            let changed = perturbed(vehicle, blocks, &delta);
            changed.coefficients.check().map_err(|reason| UncertainError::Corner { reason })?;
        }
        Ok(())
    }
}

/// The vehicle with its coefficients at `value + half_range delta`.
pub fn perturbed(vehicle: &Vehicle, blocks: &[Block], delta: &[f64]) -> Vehicle {
    blocks.iter().zip(delta).fold(vehicle.clone(), |changed, (b, d)| match b.uncertain {
        Uncertain::Parameter(p @ (Parameter::Coefficient(_) | Parameter::Effect { .. })) if *d != 0.0 => {
            p.with_value(&changed, b.value + b.half_range * d)
        }
        _ => changed,
    })
}

/// The parts of `[M C D]` as constants or as LFTs in rho, the parameter 0; parameter i of `first` is parameter 1 + i of the LFT.
#[derive(Debug, Clone)]
pub struct Pencil {
    /// `[A B]` at delta = 0.
    nominal: Lft,
    /// M at delta = 0.
    mass: Mat,
    first: Vec<Lft>,
    second: Vec<(usize, usize, Lft)>,
}

impl Pencil {
    /// At one speed, where the nominal `[A B]` is `nominal`.
    pub fn frozen(gradients: &Gradients, nominal: &Mat) -> Self {
        let constant = |m: &Mat| Lft::constant(m.clone());
        Self {
            nominal: constant(nominal),
            mass: gradients.nominal.columns(0, MASS).into_owned(),
            first: gradients.first.iter().map(constant).collect(),
            second: gradients.second.iter().map(|(i, j, m)| (*i, *j, constant(m))).collect(),
        }
    }

    /// Over the range of rho, each part a polynomial fitted to the samples; `nominal` is the LFT of `[A B]` in rho.
    ///
    /// # Errors
    /// [`Error::Fit`].
    pub fn scheduled(
        vehicle: &Vehicle,
        samples: &[(f64, Gradients)],
        nominal: &Lft,
        order: usize,
    ) -> Result<Self, Error> {
        let Some((_, any)) = samples.first() else { return Err(lpv::error::FitError::NoSamples.into()) };
        let units = units(vehicle);
        let fit = |of: &dyn Fn(&Gradients) -> Mat| {
            let values: Vec<(f64, Mat, f64)> =
                samples.iter().map(|(rho, g)| (*rho, of(g), DETAIL_OVER_RANGE * g.size(&units))).collect();
            fitted(&values, &units, order)
        };
        let first =
            (0..any.first.len()).map(|i| fit(&|g| g.first[i].clone())).collect::<Result<_, Error>>()?;
        let mut pairs: Vec<(usize, usize)> =
            samples.iter().flat_map(|(_, g)| g.second.iter().map(|(i, j, _)| (*i, *j))).collect();
        pairs.sort_unstable();
        pairs.dedup();
        let of_pair = |g: &Gradients, (i, j): (usize, usize)| {
            let found = g.second.iter().find(|(p, q, _)| (*p, *q) == (i, j));
            found.map_or_else(|| Mat::zeros(g.nominal.nrows(), g.nominal.ncols()), |(_, _, m)| m.clone())
        };
        let second = pairs
            .into_iter()
            .map(|(i, j)| Ok((i, j, fit(&|g| of_pair(g, (i, j)))?)))
            .collect::<Result<_, Error>>()?;
        let mass = any.nominal.columns(0, MASS).into_owned();
        Ok(Self { nominal: nominal.clone(), mass, first, second })
    }

    /// The LFT of `[A B]`, not yet minimal.
    ///
    /// With `M x' = M N [x; u] + L w` and `z = D w + R_c [x; u] - R_m x'`, where N is the nominal `[A B]`,
    ///
    /// ```text
    /// x' = N [x; u] + M^-1 L w,   z = (D - R_m M^-1 L) w + (R_c - R_m N) [x; u]
    /// ```
    pub fn lft(&self) -> Lft {
        let parts: Vec<Lft> = (0..self.first.len()).filter_map(|i| self.term(i)).collect();
        let Some(sum) = parts.into_iter().reduce(|sum, part| sum.add(&part)) else {
            return self.nominal.clone();
        };
        let columns = sum.right.ncols();
        let r_m = sum.right.columns(0, MASS).into_owned();
        let r_c = sum.right.columns(MASS, columns - MASS).into_owned();
        // M is positive definite: `Gradients::at` checked it.
        let bd = lpv::matrix::solve(&self.mass, &sum.left).unwrap_or_else(|| sum.left.clone() * f64::NAN);
        let n = &self.nominal;
        let zero = Mat::zeros(n.size(), sum.size());
        Lft {
            constant: n.constant.clone(),
            left: block(&[&[&n.left, &bd]]),
            inner: block(&[&[&n.inner, &zero], &[&-(&r_m * &n.left), &(&sum.inner - &r_m * &bd)]]),
            right: block(&[&[&n.right], &[&(r_c - &r_m * &n.constant)]]),
            channels: n.channels.iter().chain(&sum.channels).copied().collect(),
        }
    }

    /// `delta_i (E_i + sum_j delta_j E_ij)`, j > i, with as few channels of delta_i as the range of the bracket has directions.
    fn term(&self, i: usize) -> Option<Lft> {
        let pairs = self.second.iter().filter(|(p, _, _)| *p == i);
        let bracket = pairs.fold(self.first[i].clone(), |sum, (_, j, both)| {
            let rows = range(&block(&[&[&both.constant], &[&both.right]]).transpose());
            let (into, out) = (Lft::constant(rows.clone()), Lft::constant(rows.transpose()));
            sum.add(&both.multiply(&into).multiply(&repeated(1 + j, rows.ncols())).multiply(&out))
        });
        let basis = range(&block(&[&[&bracket.constant, &bracket.left]]));
        if basis.ncols() == 0 {
            return None;
        }
        let inside = Lft::constant(basis.transpose()).multiply(&bracket);
        Some(Lft::constant(basis.clone()).multiply(&repeated(1 + i, basis.ncols())).multiply(&inside))
    }
}

/// `theta_parameter I`.
fn repeated(parameter: usize, count: usize) -> Lft {
    let identity = Mat::identity(count, count);
    Lft {
        constant: Mat::zeros(count, count),
        left: identity.clone(),
        inner: Mat::zeros(count, count),
        right: identity,
        channels: vec![parameter; count],
    }
}

/// The LFT of the polynomial of least order, up to `order`, that meets samples `(rho, m, allowed)` to what is allowed of each.
fn fitted(samples: &[(f64, Mat, f64)], units: &Mat, order: usize) -> Result<Lft, Error> {
    let values: Vec<(f64, Mat)> = samples.iter().map(|(rho, m, _)| (*rho, m.clone())).collect();
    let largest = values.iter().map(|(_, m)| m.amax()).fold(0.0, f64::max);
    let mut fit = MatrixPolynomial::fit(&values, 0)?;
    for order in 1..=order {
        let meets =
            |(rho, m, allowed): &(f64, Mat, f64)| ((fit.evaluate(*rho) - m) * units).norm() <= *allowed;
        if samples.iter().all(meets) {
            break;
        }
        fit = MatrixPolynomial::fit(&values, order)?;
    }
    for coefficient in &mut fit.coefficients {
        coefficient.apply(|v| {
            if v.abs() < ROUNDING * largest {
                *v = 0.0;
            }
        });
    }
    Ok(Lft::from_polynomial(&fit, ROUNDING))
}

/// Columns of `[M C D]` in units in which they compare: inputs in units of their reach.
fn units(vehicle: &Vehicle) -> Mat {
    let inputs = vehicle.actuators.iter().map(auv::Actuator::reach);
    let all: Vec<f64> = std::iter::repeat_n(1.0, INPUTS).chain(inputs).collect();
    Mat::from_diagonal(&nalgebra::DVector::from_vec(all))
}

/// Leaves out of what the trim does the directions that are smaller than `detail` of `[C D]`, at all of the trims; the motion is
/// of first order in the trim anyway.
pub fn coarsen(vehicle: &Vehicle, blocks: &[Block], detail: f64, samples: &mut [Gradients]) {
    let units = units(vehicle);
    let inverse = units.map(|v| if v > 0.0 { 1.0 / v } else { 0.0 });
    let sizes: Vec<f64> = samples.iter().map(|g| g.size(&units)).collect();
    for place in (0..blocks.len()).filter(|i| blocks[*i].uncertain.is_of_trim()) {
        let mut rows = Mat::zeros(0, units.ncols());
        for (g, size) in samples.iter().zip(&sizes) {
            let inside = g.second.iter().filter(|(_, j, _)| *j == place).map(|(_, _, m)| m);
            for m in std::iter::once(&g.first[place]).chain(inside) {
                rows = block(&[&[&rows], &[&(m * &units / *size)]]);
            }
        }
        let found = lpv::matrix::svd(&rows);
        let kept = found.s.iter().filter(|s| **s > detail).count();
        let directions = found.v.columns(0, kept).into_owned();
        let projector = &units * &directions * directions.transpose() * &inverse;
        for (g, size) in samples.iter_mut().zip(&sizes) {
            g.first[place] = &g.first[place] * &projector;
            for (_, j, m) in &mut g.second {
                if *j == place {
                    *m = &*m * &projector;
                }
            }
            let large = |i: usize, j: usize, m: &Mat| {
                (m * &units).norm() > detail * size || (i != place && j != place)
            };
            g.second.retain(|(i, j, m)| large(*i, *j, m));
        }
    }
}
