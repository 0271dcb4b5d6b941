//! Vehicle as an LPV model: polynomials in speed, fitted to its linearisations, as an LFT.

pub mod authority;
pub mod frequency;
pub mod reach;
pub mod trim_slope;

use crate::augment::LinearModel;
use crate::axis::{Linearisation, VehicleModel};
use crate::error::ModelError;
use crate::fit::trim_slope::{trim_slope, trim_slopes};
use crate::inputs::design_file::{DesignFile, WorkingSea};
use crate::linearise::{split, stacked};
use squid_lpv::lft::Lft;
use squid_lpv::matrix::{Mat, largest_singular_value};
use squid_lpv::polynomial::{FitResidual, MatrixPolynomial};

/// Singular values below this fraction of the largest are rounding.
const ROUNDING: f64 = 1e-12;

/// Linearisations and the polynomials fitted to them.
#[derive(Debug, Clone)]
pub struct Model {
    /// Scheduling parameter and linearisation at each speed of the grid.
    pub grid: Vec<(f64, Linearisation)>,
    /// `[A B]` as a polynomial in rho, of the order of the design.
    pub fit: MatrixPolynomial,
    /// Residuals on the grid of the fits of order 1, 2, ..., up to one above the design's.
    pub residuals: Vec<Residual>,
    /// LFT of `[A B]`.
    pub lft: Lft,
    /// Largest difference between the LFT and the polynomial over the range, as a singular value.
    pub lft_error: f64,
    /// LFT of the slope of the trim, `[x0'; u0']` per m/s of forward speed, (n + m) x 1; see [`trim_slope()`].
    pub trim_slope: Lft,
    /// LFT of the waves of the design's `[sea]`, (n + 2) x 3; see [`WorkingSea::acting`].
    pub waves: Option<Lft>,
}

/// Residual of a fit of one order.
#[derive(Debug, Clone)]
pub struct Residual {
    /// Order of the fit.
    pub order: usize,
    /// Residual of A alone.
    pub a: FitResidual,
    /// Residual of `[A B]`.
    pub ab: FitResidual,
    /// Rms residual of A relative to its rms variation over the range, rather than to A itself.
    pub relative_to_variation: f64,
}

impl Model {
    /// Linearises over the grid of the design and fits `[A B](rho) = sum_k M_k rho^k` by least squares.
    ///
    /// rho = (V - centre)/half_range of the range of speed; `[A B]` has one row per state and one column per state and
    /// actuator.
    ///
    /// # Errors
    /// [`ModelError::Trim`] if the vehicle has no trim, or its trims jump; [`ModelError::System`].
    pub fn new(vehicle: &dyn VehicleModel, design: &DesignFile) -> Result<Self, ModelError> {
        let slopes = trim_slopes(vehicle, design)?;
        let grid: Vec<(f64, Linearisation)> = design
            .spread(design.speeds)
            .into_iter()
            .map(|v| Ok((design.rho(v), vehicle.linearise(v)?)))
            .collect::<Result<_, ModelError>>()?;
        let samples = samples(&grid);
        let highest = (design.order + 1).min(samples.len() - 1);
        let residuals = (1..=highest)
            .map(|order| Residual::of(&samples, order))
            .collect::<Result<Vec<_>, ModelError>>()?;
        let fit = MatrixPolynomial::fit(&samples, design.order)?;
        let lft = Lft::from_polynomial(&fit, design.drop);
        let lft_error = lft_error(&lft, &fit)?;
        let trim_slope = trim_slope(vehicle.actuators(), design, &grid, &slopes)?;
        let waves = design.sea.as_ref().map(|sea| waves(sea, &grid)).transpose()?;
        Ok(Self { grid, fit, residuals, lft, lft_error, trim_slope, waves })
    }

    /// Returns the LFT of a polynomial of another order; singular values below the fraction `drop` of the largest are
    /// dropped.
    ///
    /// # Errors
    /// [`ModelError::System`].
    pub fn of_order(&self, order: usize, drop: f64) -> Result<Lft, ModelError> {
        Ok(Lft::from_polynomial(&MatrixPolynomial::fit(&samples(&self.grid), order)?, drop))
    }

    /// Returns the model used for the design.
    pub fn linear(&self) -> LinearModel {
        LinearModel { ab: self.lft.clone(), trim_slope: self.trim_slope.clone(), waves: self.waves.clone() }
    }

    /// Returns the coefficients `A_k` and `B_k` of the fit.
    pub fn coefficients(&self) -> (Vec<Mat>, Vec<Mat>) {
        self.fit.coefficients.iter().map(split).unzip()
    }
}

/// Matrices `[A B]` over the grid.
fn samples(grid: &[(f64, Linearisation)]) -> Vec<(f64, Mat)> {
    grid.iter().map(|(rho, l)| (*rho, stacked(&l.a, &l.b))).collect()
}

impl Residual {
    fn of(samples: &[(f64, Mat)], order: usize) -> Result<Self, ModelError> {
        let only_a: Vec<(f64, Mat)> = samples.iter().map(|(rho, m)| (*rho, split(m).0)).collect();
        let a = MatrixPolynomial::fit(&only_a, order)?.residual(&only_a);
        let ab = MatrixPolynomial::fit(samples, order)?.residual(samples);
        let constant = MatrixPolynomial::fit(&only_a, 0)?.residual(&only_a);
        let relative_to_variation =
            if constant.relative_rms > 0.0 { a.relative_rms / constant.relative_rms } else { 0.0 };
        Ok(Self { order, a, ab, relative_to_variation })
    }
}

/// Wave model as a first-order polynomial: the filter is affine in the speed, and so is G except for the incidence.
fn waves(sea: &WorkingSea, grid: &[(f64, Linearisation)]) -> Result<Lft, ModelError> {
    let samples: Vec<(f64, Mat)> = grid.iter().filter_map(|(rho, l)| Some((*rho, sea.acting(l)?))).collect();
    Ok(Lft::from_polynomial(&MatrixPolynomial::fit(&samples, 1)?, ROUNDING))
}

/// Largest error over 201 parameter values from -1 to 1.
fn lft_error(lft: &Lft, fit: &MatrixPolynomial) -> Result<f64, ModelError> {
    let mut worst = 0.0;
    for i in 0..=200 {
        let rho = f64::from(i) / 100.0 - 1.0;
        worst = f64::max(worst, largest_singular_value(&(lft.evaluate(&[rho])? - fit.evaluate(rho))));
    }
    Ok(worst)
}
