//! Reconstruction of the controller's matrices from a solution of the synthesis inequalities.
//!
//! The multiplier of the closed loop has a closed form: with `W = S + T` and `U = Sigma + Gamma`,
//!
//! ```text
//! W_e = [ W          W - U^-1 ]      (W_e^-1)_11 = U,   W_e + W_e' > 0
//!       [ W + U^-T   W + U^-T ]
//! ```
//!
//! is a multiplier for `blkdiag(Theta, Theta)` (plant's copy, controller's copy) with the primal part W and the dual
//! part U; the Lyapunov matrix is `X_c = [X Z; Z Z]`, `Z = X - Y^-1`. With these and gamma fixed the bounded-real
//! inequality is affine in the controller, `Psi + U K V + (U K V)' < 0`, and has a solution in closed form: R. E.
//! Skelton, T. Iwasaki, K. Grigoriadis, A Unified Algebraic Approach to Linear Control Design, 1998, theorem 2.3.12.

use crate::analysis::bounded_real::bounded_real_value;
use crate::analysis::gain_bound::GainBound;
use crate::error::SynthesisError;
use crate::matrix::{
    Mat, block, diagonal_blocks, kernel, largest_eigenvalue, pseudo_inverse, rank_factors,
    scaled_largest_eigenvalue, skew_part, spectral_abscissa, symmetric_function, symmetric_part,
};
use crate::synthesis::inequalities::LmiSolution;
use crate::system::{
    CONTROLLER, Controller, GeneralisedPlant, LoopError, Partitioned, Sizes, coarse_grid, parameter_grid,
};

const STAGE: &str = "reconstruction";

/// Returns the controller for a solution `found` of the synthesis inequalities of `plant`, with the resulting bound of
/// the closed loop's gain.
///
/// The closed form gives a family of controllers; of those that satisfy the inequality the one whose fastest mode is
/// slowest is taken: it is the easiest to sample.
///
/// A `limit` on the fastest mode is in the plant's unit of time. It is checked only on the grid of
/// [`parameter_grid()`].
///
/// # Errors
/// Returns [`SynthesisError::TooFast`] if the controller exceeds the limit; [`SynthesisError::Numerical`] if X - Y^-1
/// or the multiplier is singular, or no controller of the family satisfies the inequality.
pub fn reconstruct(
    plant: &GeneralisedPlant,
    found: &LmiSolution,
    limit: Option<f64>,
) -> Result<(Controller, GainBound), SynthesisError> {
    let size = plant.sizes();
    let shown = bound(found)?;
    let affine = AffineLoop::new(plant, &shown)?;
    let mut best: Option<(f64, Controller)> = None;
    let Some(family) = affine.family() else {
        return Err(SynthesisError::numerical(
            STAGE,
            "the dual inequality fails after the completion of the Lyapunov matrix",
        ));
    };
    let thetas = coarse_grid(plant.blocks.len());
    for step in 0..24 {
        let weight = family.least_weight() * (1.0 + 10f64.powf(-2.0 + 0.25 * step as f64));
        let Some(m) = family.solution(weight) else {
            continue;
        };
        if scaled_largest_eigenvalue(&affine.inequality(&m)) >= 0.0 {
            continue;
        }
        let k = Controller::from_matrix(&m, size.x, size.y, size.u, plant.blocks.clone());
        let fastest = k.fastest_mode(&thetas);
        if spectral_abscissa(&plant.close(&k).a()) < 0.0
            && best.as_ref().is_none_or(|(least, _)| fastest < SLOWER_RATIO * least)
        {
            best = Some((fastest, k));
        }
    }
    if let (Some((_, k)), Some(limit)) = (&best, limit) {
        let fastest = k.fastest_mode(&parameter_grid(k.blocks.len()));
        if fastest > limit {
            return Err(SynthesisError::TooFast { ratio: fastest / limit });
        }
    }
    best.map(|(_, k)| (k, shown)).ok_or_else(|| {
        SynthesisError::numerical(
            STAGE,
            "no controller of the family satisfies the bounded-real inequality; try a larger back-off",
        )
    })
}

/// The ratio of two fastest modes below which one is taken as slower, so that rounding does not decide.
const SLOWER_RATIO: f64 = 0.999;

/// Returns the bound given by the completed Lyapunov matrix and multiplier.
fn bound(found: &LmiSolution) -> Result<GainBound, SynthesisError> {
    let (x, multiplier) = (lyapunov_matrix(found)?, multiplier(found)?);
    let (s, t) = (symmetric_part(&multiplier), skew_part(&multiplier));
    Ok(GainBound { gamma: found.gamma, x, factor: None, s, t, lambda: 0.0, largest_eigenvalue: f64::NAN })
}

/// Returns `X_c = [X Z; Z Z]`, `Z = X - Y^-1`.
fn lyapunov_matrix(found: &LmiSolution) -> Result<Mat, SynthesisError> {
    let y_inverse = inverse(&found.y, "Y")?;
    let z = symmetric_part(&(&found.x - y_inverse));
    Ok(block(&[&[&found.x, &z], &[&z, &z]]))
}

/// Returns `W_e`, with the symmetric part S_e and the skew part T_e.
fn multiplier(found: &LmiSolution) -> Result<Mat, SynthesisError> {
    let w = &found.primal_scaling;
    let u_inverse = inverse(&found.dual_scaling, "Sigma + Gamma")?;
    let lower = w + u_inverse.transpose();
    Ok(block(&[&[w, &(w - &u_inverse)], &[&lower, &lower]]))
}

fn inverse(m: &Mat, name: &str) -> Result<Mat, SynthesisError> {
    m.clone().try_inverse().ok_or_else(|| SynthesisError::numerical(STAGE, format!("{name} is singular")))
}

/// The bounded-real inequality of the closed loop as `Psi + U K V + (U K V)'`, in coordinates in which the Lyapunov
/// matrix and the scaling are the identity.
struct AffineLoop {
    psi: Mat,
    left: Mat,
    right: Mat,
    /// Factors of U and V: `U = left left_inner`, `V = right_inner right`.
    left_inner: Mat,
    right_inner: Mat,
}

impl AffineLoop {
    fn new(plant: &GeneralisedPlant, bound: &GainBound) -> Result<Self, SynthesisError> {
        let size = plant.sizes();
        let parts = Partitioned::zeros(CONTROLLER, Sizes { w: 0, z: 0, ..size });
        let open = plant.close(&Controller { parts, blocks: plant.blocks.clone() });
        let GainBound { x: lyapunov, s, t, gamma, .. } = bound;
        let psi = bounded_real_value(&open, &LoopError::none(&open), bound);
        let (z, eye) = (Mat::zeros, Mat::identity);
        let (n, r, m, p) = (size.x, size.t, size.u, size.y);
        // The map from the controller's outputs [xk', u, zk] to [x'; xk'], to [zt; zk] and to z.
        let into_x = block(&[&[&z(n, n), &plant.b2(), &z(n, r)], &[&eye(n, n), &z(n, m), &z(n, r)]]);
        let into_t = block(&[&[&z(r, n), &plant.dt2(), &z(r, r)], &[&z(r, n), &z(r, m), &eye(r, r)]]);
        let into_z = block(&[&[&z(size.z, n), &plant.d12(), &z(size.z, r)]]);
        let left = block(&[
            &[&(lyapunov * &into_x)],
            &[&(t * &into_t)],
            &[&z(size.w, n + m + r)],
            &[&(s * &into_t)],
            &[&into_z],
        ]);
        // The map from [x, xk, wt, wk, w] to the controller's inputs [xk; y; wk].
        let rest = |rows: usize| z(rows, 2 * r + size.z);
        let right = block(&[
            &[&z(n, n), &eye(n, n), &z(n, r), &z(n, r), &z(n, size.w), &rest(n)],
            &[&plant.c2(), &z(p, n), &plant.d2t(), &z(p, r), &plant.d21(), &rest(p)],
            &[&z(r, n), &z(r, n), &z(r, r), &eye(r, r), &z(r, size.w), &rest(r)],
        ]);
        let unit = normalising_congruence(lyapunov, s, *gamma, size.w, size.z)?;
        let psi = unit.transpose() * psi * &unit;
        let (left, left_inner) = orthonormal_columns(&(unit.transpose() * left));
        let (right_t, right_inner_t) = orthonormal_columns(&(right * unit).transpose());
        Ok(Self { psi, left, right: right_t.transpose(), left_inner, right_inner: right_inner_t.transpose() })
    }

    /// Returns the family of solutions; `None` if there are none because `Psi_22` is not negative definite.
    fn family(&self) -> Option<ControllerFamily> {
        let complement = kernel(&self.left.transpose());
        let part = |a: &Mat, b: &Mat| a.transpose() * &self.psi * b;
        let inner = symmetric_part(&-part(&complement, &complement)).cholesky()?;
        let cross = part(&complement, &self.left);
        let lower = (&self.right * &complement).transpose();
        let (of_cross, of_lower) = (inner.solve(&cross), inner.solve(&lower));
        Some(ControllerFamily {
            q: symmetric_part(&(part(&self.left, &self.left) + cross.transpose() * of_cross)),
            v: (&self.right * &self.left).transpose() + cross.transpose() * &of_lower,
            rest: lower.transpose() * of_lower,
            left_inverse: pseudo_inverse(&self.left_inner, 1e-12),
            right_inverse: pseudo_inverse(&self.right_inner, 1e-12),
        })
    }

    fn inequality(&self, k: &Mat) -> Mat {
        let term = &self.left * &self.left_inner * k * &self.right_inner * &self.right;
        &self.psi + &term + term.transpose()
    }
}

/// The closed form `K = -w U' Phi V' (V Phi V')^-1` with `Phi = (w U U' - Psi)^-1`, in the basis of U and its
/// complement, so that a large weight w does not swamp other terms:
///
/// ```text
/// Q = Psi_11 - Psi_12 Psi_22^-1 Psi_21,   v = V_1' - Psi_12 Psi_22^-1 V_2',   rest = -V_2 Psi_22^-1 V_2'
/// U' Phi V' = (w I - Q)^-1 v,   V Phi V' = rest + v' (w I - Q)^-1 v
/// ```
struct ControllerFamily {
    q: Mat,
    v: Mat,
    rest: Mat,
    left_inverse: Mat,
    right_inverse: Mat,
}

impl ControllerFamily {
    /// Returns the weight above which there is a solution: the largest eigenvalue of Q.
    fn least_weight(&self) -> f64 {
        largest_eigenvalue(&self.q).max(1e-6)
    }

    /// Returns the controller matrix of the family member `weight`; `None` if the weight is too small.
    fn solution(&self, weight: f64) -> Option<Mat> {
        let n = self.q.nrows();
        // w (w I - Q)^-1 v
        let solved = (Mat::identity(n, n) - &self.q / weight).cholesky()?.solve(&self.v);
        let middle = symmetric_part(&(&self.rest + self.v.transpose() * &solved / weight)).cholesky()?;
        let k = &self.left_inverse * -middle.solve(&solved.transpose()).transpose() * &self.right_inverse;
        k.iter().all(|v| v.is_finite()).then_some(k)
    }
}

/// Returns `blkdiag(X^-1/2, S^-1/2, gamma^-1/2 I, S^-1/2, gamma^-1/2 I)`.
fn normalising_congruence(x: &Mat, s: &Mat, gamma: f64, w: usize, z: usize) -> Result<Mat, SynthesisError> {
    for (m, name) in [(x, "X_c"), (s, "S_e")] {
        let least = crate::matrix::least_eigenvalue(m);
        if least <= 0.0 {
            return Err(SynthesisError::numerical(
                STAGE,
                format!("{name} is not positive definite (least eigenvalue {least:.1e})"),
            ));
        }
    }
    let root = |m: &Mat| if m.is_empty() { m.clone() } else { symmetric_function(m, |v| 1.0 / v.sqrt()) };
    let (root_x, root_s) = (root(x), root(s));
    let flat = |n: usize| Mat::identity(n, n) / gamma.sqrt();
    Ok(diagonal_blocks(&[&root_x, &root_s, &flat(w), &root_s, &flat(z)]))
}

/// Returns `M = Q R` with orthonormal columns in Q, as many as the rank of M.
fn orthonormal_columns(m: &Mat) -> (Mat, Mat) {
    let scale = crate::matrix::largest_singular_value(m);
    let (mut q, mut r) = rank_factors(m, 1e-12 * scale);
    for k in 0..q.ncols() {
        let norm = q.column(k).norm();
        q.column_mut(k).scale_mut(1.0 / norm);
        r.row_mut(k).scale_mut(norm);
    }
    (q, r)
}
