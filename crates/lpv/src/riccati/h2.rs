//! The controller that minimises the H2 norm of the loop, for a plant without parameters.
//!
//! K. Zhou, J. C. Doyle, K. Glover, "Robust and Optimal Control", 1996, theorem 14.7, without the rotations that make
//! `D12'D12 = I` and `D21 D21' = I`:
//!
//! ```text
//! R = D12'D12,   A'X + X A + C1'C1 - (X B2 + C1'D12) R^-1 (B2'X + D12'C1) = 0,   F = -R^-1 (B2'X + D12'C1)
//! xk' = (A + B2 F + L C2) xk - L y,   u = F xk,   Y and L by the transposed plant
//! ```
//!
//! It exists if every mode that is not stable is controllable from u and observable from y, D11 is zero, D12 has full
//! column rank and D21 full row rank, and neither the path from u to z nor that from w to y has a zero on the imaginary
//! axis.

use crate::error::SynthesisError;
use crate::matrix::Mat;
use crate::riccati::bound::WideLoop;
use crate::riccati::equations::{WideController, WidePlant, stabilising};
use crate::riccati::wide::{Wide, four, solve};
use crate::synthesis::direct_path::around;
use crate::system::modes::{check_detectable, check_stabilisable};
use crate::system::{Controller, GeneralisedPlant};

/// An H2-optimal controller.
#[derive(Debug, Clone, PartialEq)]
pub struct H2Design {
    /// The controller `u = K y`.
    pub controller: Controller,
    /// H2 norm of the loop from w to z, in floating point: the root of the power of z for white noise w of unit
    /// intensity.
    pub norm: f64,
}

/// Designs the H2-optimal controller for a plant without parameters and with the direct path D22 (y x u).
///
/// # Errors
/// Returns [`SynthesisError::NotStabilisable`], [`SynthesisError::NotDetectable`]; [`SynthesisError::H2DirectPath`] for
/// a nonzero D11; [`SynthesisError::Singular`] without a weight on each control or noise on each measurement;
/// [`SynthesisError::Numerical`] for a zero on the imaginary axis, or if the numerics fail.
pub fn synthesise(plant: &GeneralisedPlant, d22: &Mat) -> Result<H2Design, SynthesisError> {
    plant.check()?;
    check_stabilisable(plant)?;
    check_detectable(plant)?;
    if plant.d11().amax() > 0.0 {
        return Err(SynthesisError::H2DirectPath { largest: plant.d11().amax() });
    }
    let wide = WidePlant::new(plant);
    if !wide.is_regular() {
        return Err(SynthesisError::Singular);
    }
    let failed = |diagnosis: &str| SynthesisError::numerical("H2 synthesis", diagnosis);
    let (one, two) = (wide.state_feedback(), wide.dual().state_feedback());
    let (Some(f), Some(l)) = (one, two.map(|l| l.transpose())) else {
        return Err(failed(
            "a Riccati equation has no stabilising solution: the path from u to z or that from w to y has a zero on \
             the imaginary axis",
        ));
    };
    let a = &wide.a + &wide.b2 * &f + &l * &wide.c2;
    let (u, y) = (wide.b2.ncols(), wide.c2.nrows());
    let rounded = WideController { a, b: -l, c: f, d: Wide::zeros(u, y) }
        .rounded()
        .ok_or_else(|| failed("the controller is not finite"))?;
    let looped = WideLoop::new(plant, &WideController::new(&rounded));
    let norm = looped
        .and_then(|looped| looped.h2_norm())
        .ok_or_else(|| failed("the controller is lost by rounding to 16 digits"))?;
    let controller = around(&rounded, d22).ok_or_else(|| failed("the loop with D22 is not well posed"))?;
    Ok(H2Design { controller, norm })
}

impl WidePlant {
    /// Returns F of the state feedback `u = F x` that minimises the H2 norm.
    fn state_feedback(&self) -> Option<Wide> {
        let Self { a, b2, c1, d12, .. } = self;
        let r = d12.transpose() * d12;
        let of_state = solve(&r, &(d12.transpose() * c1))?;
        let of_costate = solve(&r, &b2.transpose())?;
        let left = a - b2 * &of_state;
        let lower = c1.transpose() * (d12 * &of_state - c1);
        let x = stabilising(&four(&left, &-(b2 * &of_costate), &lower, &-left.transpose()))?;
        Some(-(of_costate * x + of_state))
    }
}
