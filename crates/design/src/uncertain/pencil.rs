//! Matrix `[M C D]` as an LFT in the uncertain parameters and rho, and the resulting LFT of `[A B] = M^-1 [C D]`.

use crate::error::Error;
use crate::uncertain::gradients::{Gradients, ROUNDING, units};
use crate::uncertain::reduce::range_basis;
use squid_auv::Vehicle;
use squid_lpv::lft::Lft;
use squid_lpv::matrix::{Mat, block};
use squid_lpv::polynomial::MatrixPolynomial;

/// Size, relative to `[C D]`, below which effects of the trim are left out. This saves channels; the error, which is
/// measured with the rest, is small compared with the uncertainty.
pub const DETAIL: f64 = 1e-3;

/// Parts of `[M C D]` as constants or as LFTs in rho, which is parameter 0; parameter i of `first` is parameter 1 + i
/// of the LFT.
#[derive(Debug, Clone)]
pub struct Pencil {
    /// Matrix `[A B]` at delta = 0.
    nominal: Lft,
    /// Mass matrix M at delta = 0.
    mass: Mat,
    first: Vec<Lft>,
    second: Vec<(usize, usize, Lft)>,
}

impl Pencil {
    /// Builds the pencil at one speed, with the nominal `[A B]` `nominal`.
    pub fn frozen(gradients: &Gradients, nominal: &Mat) -> Self {
        let constant = |m: &Mat| Lft::constant(m.clone());
        Self {
            nominal: constant(nominal),
            mass: mass_of(gradients),
            first: gradients.first.iter().map(constant).collect(),
            second: gradients.second.iter().map(|(i, j, m)| (*i, *j, constant(m))).collect(),
        }
    }

    /// Builds the pencil over the range of rho. Each part is a polynomial of at most `order`, fitted to the samples
    /// within `detail` of `[C D]`; `nominal` is the LFT of `[A B]` in rho.
    ///
    /// # Errors
    /// [`ModelError::System`](crate::error::ModelError::System).
    pub fn scheduled(
        vehicle: &Vehicle,
        samples: &[(f64, Gradients)],
        nominal: &Lft,
        order: usize,
        detail: f64,
    ) -> Result<Self, Error> {
        let Some((_, any)) = samples.first() else {
            return Err(squid_lpv::error::SystemError::NoSamples.into());
        };
        let units = units(vehicle, any.nominal.nrows());
        let fit = |of: &dyn Fn(&Gradients) -> Mat| {
            let values: Vec<(f64, Mat, f64)> =
                samples.iter().map(|(rho, g)| (*rho, of(g), detail * g.size(&units))).collect();
            fitted(&values, &units, order)
        };
        let first =
            (0..any.first.len()).map(|i| fit(&|g| g.first[i].clone())).collect::<Result<_, Error>>()?;
        let mut pairs: Vec<(usize, usize)> =
            samples.iter().flat_map(|(_, g)| g.second.iter().map(|(i, j, _)| (*i, *j))).collect();
        pairs.sort_unstable();
        pairs.dedup();
        let of_pair = |g: &Gradients, (i, j): (usize, usize)| {
            let pair = g.second.iter().find(|(p, q, _)| (*p, *q) == (i, j));
            pair.map_or_else(|| Mat::zeros(g.nominal.nrows(), g.nominal.ncols()), |(_, _, m)| m.clone())
        };
        let second = pairs
            .into_iter()
            .map(|(i, j)| Ok((i, j, fit(&|g| of_pair(g, (i, j)))?)))
            .collect::<Result<_, Error>>()?;
        let mass = mass_of(any);
        Ok(Self { nominal: nominal.clone(), mass, first, second })
    }

    /// Returns the LFT of `[A B]`, not yet minimal.
    ///
    /// The LFT follows from `M x' = M N [x; u] + L w` and `z = D w + R_c [x; u] - R_m x'`, where N is the nominal `[A
    /// B]`:
    ///
    /// ```text
    /// x' = N [x; u] + M^-1 L w,   z = (D - R_m M^-1 L) w + (R_c - R_m N) [x; u]
    /// ```
    pub fn lft(&self) -> Lft {
        let parts: Vec<Lft> = (0..self.first.len()).filter_map(|i| self.term(i)).collect();
        let Some(sum) = parts.into_iter().reduce(|sum, part| sum.add(&part)) else {
            return self.nominal.clone();
        };
        let (mass, columns) = (self.mass.ncols(), sum.right.ncols());
        let r_m = sum.right.columns(0, mass).into_owned();
        let r_c = sum.right.columns(mass, columns - mass).into_owned();
        // M is positive definite, as checked by `Gradients::at`.
        let bd =
            squid_lpv::matrix::solve(&self.mass, &sum.left).unwrap_or_else(|| sum.left.clone() * f64::NAN);
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

    /// Term `delta_i (E_i + sum_j delta_j E_ij)`, j > i, with as many channels of delta_i as the rank of the bracket.
    fn term(&self, i: usize) -> Option<Lft> {
        let pairs = self.second.iter().filter(|(p, _, _)| *p == i);
        let bracket = pairs.fold(self.first[i].clone(), |sum, (_, j, both)| {
            let rows = range_basis(&block(&[&[&both.constant], &[&both.right]]).transpose(), 0.0);
            let (into, out) = (Lft::constant(rows.clone()), Lft::constant(rows.transpose()));
            sum.add(&both.multiply(&into).multiply(&repeated(1 + j, rows.ncols())).multiply(&out))
        });
        let basis = range_basis(&block(&[&[&bracket.constant, &bracket.left]]), 0.0);
        if basis.ncols() == 0 {
            return None;
        }
        let inside = Lft::constant(basis.transpose()).multiply(&bracket);
        Some(Lft::constant(basis.clone()).multiply(&repeated(1 + i, basis.ncols())).multiply(&inside))
    }
}

/// Mass matrix M, the first columns of `[M C D]`.
fn mass_of(gradients: &Gradients) -> Mat {
    gradients.nominal.columns(0, gradients.nominal.nrows()).into_owned()
}

/// Block `theta_parameter I`.
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

/// LFT of the polynomial of least order, up to `order`, that fits samples `(rho, m, allowed)` within the allowed error
/// of each.
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
