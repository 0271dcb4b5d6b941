//! The controller at one value of the parameter, in closed form.
//!
//! In the variables of C. Scherer, P. Gahinet, M. Chilali, "Multiobjective output-feedback control via LMI
//! optimization", IEEE Trans. Automatic Control 42(7), 1997, the inequality of the closed loop is
//!
//! ```text
//! [ He(AY + B2 Ck) - Y'     Ak' + A + B2 Dk C2   B1 + B2 Dk D21    (C1 Y + D12 Ck)'      ]
//! [          *              He(XA + Bk C2) + X'  X B1 + Bk D21     (C1 + D12 Dk C2)'     ]  < 0
//! [          *                       *           -gamma I          (D11 + D12 Dk D21)'   ]
//! [          *                       *              *              -gamma I              ]
//! ```
//!
//! Bk and Ck complete the squares of the two diagonal blocks for any X' and Y', and Ak makes the off-diagonal block
//! zero: P. Gahinet, "Explicit controller formulas for LMI-based H-infinity synthesis", Automatica 32(7), 1996. If one
//! of X and Y is constant, the controller is therefore the same for every rate of the parameter, and depends smoothly
//! on it. If both vary, a term `Y^-1 Y'` of Ak, proportional to the rate, is left out.

use crate::bounded_rate::inequalities::Varying;
use crate::matrix::{Mat, block, diagonal_blocks, largest_singular_value, pseudo_inverse, symmetric_part};
use crate::system::GeneralisedPlant;

/// A controller `[A B; C D]` and the Lyapunov matrix of the loop (plant's states, then controller's), or its inverse if
/// Y varies.
pub(crate) struct Central {
    pub(crate) matrix: Mat,
    pub(crate) lyapunov: Mat,
}

/// Returns the controller for the plant frozen at a value, at gamma = 1. `None` if a matrix that must be regular is
/// singular: noise on every measurement and a weight on every control make them regular.
///
/// With a constant Y the Lyapunov matrix is `[X Z; Z Z]`, `Z = X - Y^-1`; with a constant X its inverse is `[Y W; W
/// W]`, `W = Y - X^-1`. Either is a polynomial in the parameter if the varying one of X and Y is.
pub(crate) fn central(p: &GeneralisedPlant, x: &Mat, y: &Mat, varying: Varying) -> Option<Central> {
    let (a, b1, b2, c1, c2) = (p.a(), p.b1(), p.b2(), p.c1(), p.c2());
    let (d11, d12, d21) = (p.d11(), p.d12(), p.d21());
    let s = p.sizes();
    let direct = -pseudo_inverse(&d12, RANK_TOLERANCE) * &d11 * pseudo_inverse(&d21, RANK_TOLERANCE);
    let d = &d11 + &d12 * &direct * &d21;
    if largest_singular_value(&d) >= 1.0 {
        return None;
    }
    let gain = block(&[&[&Mat::identity(s.w, s.w), &-d.transpose()], &[&-&d, &Mat::identity(s.z, s.z)]]);
    let inner = gain.cholesky()?.inverse();
    let closed_a = &a + &b2 * &direct * &c2;
    let closed_c = &c1 + &d12 * &direct * &c2;
    let closed_b = &b1 + &b2 * &direct * &d21;

    let seen = block(&[&[&d21, &Mat::zeros(s.y, s.z)]]);
    let open = block(&[&[&(x * &b1), &closed_c.transpose()]]);
    let weight = (&seen * &inner * seen.transpose()).cholesky()?;
    let gain_y = -weight.solve(&(&c2 + &seen * &inner * open.transpose())).transpose();
    let observer = &open + &gain_y * &seen;

    let driven = block(&[&[&Mat::zeros(s.u, s.w), &d12.transpose()]]);
    let open = block(&[&[&closed_b, &(&c1 * y).transpose()]]);
    let weight = (&driven * &inner * driven.transpose()).cholesky()?;
    let gain_u = -weight.solve(&(b2.transpose() + &driven * &inner * open.transpose()));
    let feedback = open + gain_u.transpose() * &driven;

    let hat = -(closed_a.transpose() + &observer * &inner * feedback.transpose());
    let (y_inverse, x_inverse) = (y.clone().cholesky()?.inverse(), x.clone().cholesky()?.inverse());
    // N M' = I - XY; M is constant if Y is, and N if X is, each with its inverse.
    let (n_inverse, m, m_inverse, n, lyapunov) = match varying {
        Varying::X | Varying::Both => {
            let z = symmetric_part(&(x - &y_inverse));
            let full = block(&[&[x, &z], &[&z, &z]]);
            (z.clone().cholesky()?.inverse(), -y, -y_inverse, z, full)
        }
        Varying::Y => {
            let w = symmetric_part(&(y - &x_inverse));
            let w_inverse = symmetric_part(&w.clone().cholesky()?.inverse());
            let full = block(&[&[y, &w], &[&w, &w]]);
            (-x_inverse, w.clone(), w_inverse, -x, full)
        }
    };
    let c = (&gain_u - &direct * &c2 * y) * &m_inverse;
    let b = &n_inverse * (&gain_y - x * &b2 * &direct);
    let a = &n_inverse * (hat - &n * &b * &c2 * y - x * &b2 * &c * &m - x * &closed_a * y) * &m_inverse;
    let matrix = block(&[&[&a, &b], &[&c, &direct]]);
    matrix.iter().all(|v| v.is_finite()).then_some(Central { matrix, lyapunov })
}

/// The relative size of singular values of D12 and D21 that are taken as zero.
const RANK_TOLERANCE: f64 = 1e-10;

/// Returns the controller with the states `xk = T xk~`; `change` is T for a Lyapunov matrix, and T^-T for its inverse.
/// All are n x n.
pub(crate) fn in_coordinates(of: &Central, t: &Mat, t_inverse: &Mat, change: &Mat) -> Central {
    let n = t.nrows();
    let (rows, columns) = (of.matrix.nrows() - n, of.matrix.ncols() - n);
    let left = diagonal_blocks(&[t_inverse, &Mat::identity(rows, rows)]);
    let right = diagonal_blocks(&[t, &Mat::identity(columns, columns)]);
    let states = of.lyapunov.nrows() - n;
    let state = diagonal_blocks(&[&Mat::identity(states, states), change]);
    Central {
        matrix: left * &of.matrix * right,
        lyapunov: symmetric_part(&(state.transpose() * &of.lyapunov * &state)),
    }
}
