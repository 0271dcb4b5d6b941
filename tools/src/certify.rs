//! The certificate: the gain bound of the finished loop in a form that exact arithmetic re-checks.
//!
//! Two claims go into one file: the bound for the fitted model, and the bound that also holds when the model is off by
//! as much as the fit misses the true linearisations anywhere in the range of speed.

use crate::error::Error;
use crate::inputs::Inputs;
use crate::model::{Model, STATES, linearise_at, speeds, stacked};
use certificate::{Certificate, Residual, Theorem};
use lpv::analysis::{GainBound, bounded_gain};
use lpv::controller::Controller;
use lpv::matrix::{Mat, block, largest_singular_value, solve, to_rows};
use lpv::model_error::ModelError;
use lpv::plant::GeneralisedPlant;
use lpv::synthesis::Design;
use scheduled::LftMatrices;

/// Speeds at which the fit's residual is taken.
pub const SAMPLES: usize = 1001;

/// What was proved, and the text that proves it.
#[derive(Debug, Clone)]
pub struct Proof {
    /// The certificate.
    pub certificate: Certificate,
    /// What it proves.
    pub theorem: Theorem,
    /// The size of the model error that is covered, in the coordinates of [`ModelError`].
    pub model_error: f64,
}

/// Certifies a design, and proves the certificate in exact arithmetic.
///
/// # Errors
/// [`Error::Unproved`] with the first thing that failed; [`Error::Synthesis`] when no bound covers the model error.
pub fn certify(
    inputs: &Inputs,
    model: &Model,
    plant: &GeneralisedPlant,
    design: &Design,
) -> Result<Proof, Error> {
    let (error, size) = model_error(inputs, model, plant, &design.certified)?;
    let closed = plant.close(&design.controller);
    let covered = bounded_gain(&closed, &error.close(plant, &design.controller), &design.certified)?;
    let mut certificate = nominal(plant, &design.controller, &design.certified);
    certificate.residual = Some(residual(&error, &covered));
    let theorem = certificate.prove()?;
    Ok(Proof { certificate, theorem, model_error: size })
}

/// The certificate of a bound without model error.
pub fn nominal(plant: &GeneralisedPlant, k: &Controller, bound: &GainBound) -> Certificate {
    Certificate {
        blocks: plant.blocks.clone(),
        controller_blocks: k.blocks.clone(),
        plant: plant_rows(plant),
        controller: controller_rows(k),
        gamma: bound.gamma,
        x: to_rows(&bound.x),
        s: to_rows(&bound.s),
        t: to_rows(&bound.t),
        residual: None,
    }
}

/// A plant as the certificate holds it.
pub fn plant_rows(p: &GeneralisedPlant) -> certificate::Plant {
    certificate::Plant {
        a: to_rows(&p.a),
        bt: to_rows(&p.bt),
        b1: to_rows(&p.b1),
        b2: to_rows(&p.b2),
        ct: to_rows(&p.ct),
        c1: to_rows(&p.c1),
        c2: to_rows(&p.c2),
        dtt: to_rows(&p.dtt),
        dt1: to_rows(&p.dt1),
        dt2: to_rows(&p.dt2),
        d1t: to_rows(&p.d1t),
        d11: to_rows(&p.d11),
        d12: to_rows(&p.d12),
        d2t: to_rows(&p.d2t),
        d21: to_rows(&p.d21),
    }
}

/// A controller as the certificate holds it.
pub fn controller_rows(k: &Controller) -> certificate::Controller {
    certificate::Controller {
        a: to_rows(&k.a),
        by: to_rows(&k.by),
        bt: to_rows(&k.bt),
        cu: to_rows(&k.cu),
        duy: to_rows(&k.duy),
        dut: to_rows(&k.dut),
        ct: to_rows(&k.ct),
        dty: to_rows(&k.dty),
        dtt: to_rows(&k.dtt),
    }
}

/// A certificate's controller with its blocks, as files hold a controller.
pub fn rows_with_blocks(certificate: &Certificate) -> LftMatrices {
    let certificate::Controller { a, by, bt, cu, duy, dut, ct, dty, dtt } = certificate.controller.clone();
    LftMatrices { blocks: certificate.controller_blocks.clone(), a, by, bt, cu, duy, dut, ct, dty, dtt }
}

/// The frozen controller's matrices as the certificate holds them.
pub fn frozen_rows(lft: &LftMatrices) -> certificate::Controller {
    let LftMatrices { blocks: _, a, by, bt, cu, duy, dut, ct, dty, dtt } = lft.clone();
    certificate::Controller { a, by, bt, cu, duy, dut, ct, dty, dtt }
}

fn residual(error: &ModelError, bound: &GainBound) -> Residual {
    Residual {
        e: to_rows(&error.e),
        f: to_rows(&error.f),
        fu: to_rows(&error.fu),
        lambda: bound.lambda,
        gamma: bound.gamma,
        x: to_rows(&bound.x),
        s: to_rows(&bound.s),
        t: to_rows(&bound.t),
    }
}

/// The smallest ball `E Delta [F Fu]`, `|Delta| <= 1`, that holds `[A B2] - [A B2](rho)` at every speed, in coordinates in which
/// the Lyapunov matrix of the bound is the identity on the model's states and each input is in units of its scale.
///
/// With `T` those coordinates and `R(V) = T^-1 [dA T, dB S_u]`, `E = sqrt(e) T` and `[F Fu] = sqrt(e) [T^-1 0; 0 I]` where
/// `e = max |R(V)|`. The maximum is taken over [`SAMPLES`] speeds and raised by a bound of what may lie between two of them:
/// see [`between_samples`]. The LFT that was designed on is subtracted, not the polynomial, so that what was dropped there is
/// covered, too.
fn model_error(
    inputs: &Inputs,
    model: &Model,
    plant: &GeneralisedPlant,
    bound: &GainBound,
) -> Result<(ModelError, f64), Error> {
    let own = bound.x.view((0, 0), (STATES, STATES)).into_owned();
    let Some(factor) = own.cholesky() else {
        return Err(not_definite());
    };
    // X = L L', so T = L^-T.
    let t_inverse = factor.l().transpose();
    let Some(t) = solve(&t_inverse, &Mat::identity(STATES, STATES)) else {
        return Err(not_definite());
    };
    let scales: Vec<f64> = inputs.vehicle.actuators.iter().map(auv::Actuator::reach).collect();
    let (centre, half_range) = inputs.design.scheduling();
    let mut residuals = Vec::with_capacity(SAMPLES);
    for v in speeds(inputs, SAMPLES) {
        let truth = stacked(&linearise_at(inputs, v)?);
        let difference = truth - model.lft.evaluate(&[(v - centre) / half_range])?;
        let state = &t_inverse * difference.columns(0, STATES) * &t;
        let mut input = &t_inverse * difference.columns(STATES, scales.len());
        for (j, scale) in scales.iter().enumerate() {
            input.column_mut(j).scale_mut(*scale);
        }
        residuals.push(block(&[&[&state, &input]]));
    }
    let largest = residuals.iter().map(largest_singular_value).fold(0.0, f64::max);
    let size = largest + between_samples(&residuals);
    let (n, m) = (plant.a.nrows(), scales.len());
    let root = size.sqrt();
    let mut e = Mat::zeros(n, STATES);
    e.view_mut((0, 0), (STATES, STATES)).copy_from(&(&t * root));
    let mut f = Mat::zeros(STATES + m, n);
    f.view_mut((0, 0), (STATES, STATES)).copy_from(&(&t_inverse * root));
    let mut fu = Mat::zeros(STATES + m, m);
    for j in 0..m {
        fu[(STATES + j, j)] = root;
    }
    Ok((ModelError { e, f, fu }, size))
}

fn not_definite() -> Error {
    let diagnosis = "the Lyapunov matrix is not positive definite".into();
    lpv::error::SynthesisError::Numerical { stage: "model error", diagnosis }.into()
}

/// A bound of how far the residual may rise above its samples: 17/8 of the largest second difference D.
///
/// Let `R = S + J (V - v)_+` on an interval of length h between two speeds, with S smooth, `C = h^2 max |S''|`, and a kink of slope J at the
/// fraction s of the interval, because A has kinks where w|w| changes sign. The norm is convex, so that on the chord it is largest at an
/// end, and R leaves the chord by at most
///
/// ```text
/// C/8 + s (1 - s) h |J|
/// ```
///
/// (for S: linear interpolation, for instance K. Atkinson, An Introduction to Numerical Analysis, 1989, eq. 3.1.10). The second difference
/// at the interval's first speed holds `(1 - s) h J`, the one at its last speed `s h J`, and S adds C at most to either. In the
/// first and the last interval of the range only one of the two exists, but each gives `s (1 - s) h |J| <= D + C`; together at most
/// `9/8 C + D`. That is 17/8 D where `C <= D`, that is, where the second differences of a thousand speeds show somewhere how much S
/// bends, and where no two kinks share an interval or lie in neighbouring ones.
fn between_samples(residuals: &[Mat]) -> f64 {
    let second = residuals.windows(3).map(|w| largest_singular_value(&(&w[0] - &w[1] * 2.0 + &w[2])));
    17.0 / 8.0 * second.fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    const H: f64 = 0.1;
    const INTERVALS: i32 = 8;

    /// How far a curve rises above its samples, and the reserve for it.
    fn rise_and_reserve(curve: impl Fn(f64) -> f64) -> (f64, f64) {
        let samples: Vec<Mat> =
            (0..=INTERVALS).map(|i| Mat::from_element(1, 1, curve(H * f64::from(i)))).collect();
        let sampled = samples.iter().map(largest_singular_value).fold(0.0, f64::max);
        let highest =
            (0..=1000 * INTERVALS).map(|i| curve(H * f64::from(i) / 1000.0).abs()).fold(0.0, f64::max);
        (highest - sampled, between_samples(&samples))
    }

    /// A kink anywhere in any interval, the first and the last among them, upon a parabola that bends with it or against it.
    #[test]
    fn the_reserve_covers_kinks_and_curves() {
        let mut hidden = 0;
        for interval in 0..INTERVALS {
            for fraction in [0.02, 0.1, 0.3, 0.5, 0.8, 0.98] {
                for bend in [-0.2, 0.0, 0.2] {
                    let kink = H * (f64::from(interval) + fraction);
                    let curve = |x: f64| 1.0 - (x - kink).abs() + bend * (x - kink).powi(2);
                    let (rise, reserve) = rise_and_reserve(curve);
                    assert!(rise <= reserve, "kink at {kink}, bend {bend}: {rise} above {reserve}");
                    hidden += i32::from(rise > 0.5 / (17.0 / 8.0) * reserve);
                }
            }
        }
        assert!(hidden > 0, "some of these would need more than half of the second difference");
        let (rise, reserve) = rise_and_reserve(|x| 1.0 - (x - 0.35).powi(2));
        assert!(0.0 < rise && rise <= reserve);
    }
}
