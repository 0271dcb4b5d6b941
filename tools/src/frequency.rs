//! How far the fits are from the true linearisations as frequency responses (the paper's Fig. 4).

use crate::model::{Model, STATES, stacked};
use lpv::matrix::{Mat, complex_singular_values};
use lpv::polynomial::MatrixPolynomial;
use lpv::state_space::StateSpace;
use nalgebra::{Complex, DMatrix};

/// Frequencies, rad/s, evenly spread on a logarithmic axis.
pub fn axis() -> Vec<f64> {
    (0..=60).map(|i| 10f64.powf(-2.0 + f64::from(i) / 20.0)).collect()
}

/// From the actuators to forward speed and pitch.
pub fn system(ab: &Mat) -> StateSpace {
    let inputs = ab.ncols() - STATES;
    let mut c = Mat::zeros(2, STATES);
    c[(0, 0)] = 1.0;
    c[(1, 3)] = 1.0;
    StateSpace {
        a: ab.columns(0, STATES).into_owned(),
        b: ab.columns(STATES, inputs).into_owned(),
        c,
        d: Mat::zeros(2, inputs),
    }
}

/// For each order of the model's residuals, the largest `|G_fit - G| / |G|` over the grid of speeds and the
/// frequencies, in the largest singular value.
pub fn errors(model: &Model) -> Vec<(usize, f64)> {
    let samples: Vec<(f64, Mat)> = model.grid.iter().map(|(rho, l)| (*rho, stacked(l))).collect();
    let fits = model
        .residuals
        .iter()
        .filter_map(|r| Some((r.order, MatrixPolynomial::fit(&samples, r.order).ok()?)));
    fits.map(|(order, fit)| (order, largest_error(&samples, &fit))).collect()
}

/// The largest singular value.
fn largest(g: &DMatrix<Complex<f64>>) -> f64 {
    complex_singular_values(g).first().copied().unwrap_or(0.0)
}

fn largest_error(samples: &[(f64, Mat)], fit: &MatrixPolynomial) -> f64 {
    let mut worst = 0.0;
    for (rho, truth) in samples {
        let (exact, fitted) = (system(truth), system(&fit.evaluate(*rho)));
        for omega in axis() {
            let s = Complex::new(0.0, omega);
            let (Some(g), Some(h)) = (exact.response(s), fitted.response(s)) else { continue };
            worst = f64::max(worst, largest(&(&h - &g)) / largest(&g));
        }
    }
    worst
}
