//! Plain H-infinity synthesis by Riccati equations: a second opinion on the least gamma, and coordinates for the
//! inequalities.
//!
//! For a plant without parameters whose measurements are all noisy, the vectors of the primal inequality are `x` and
//! `w = H x + D eta`, where D spans the kernel of D21 and `H = -D21^+ C2`. With w and z in units in which gamma is 1
//! the inequality reads
//!
//! ```text
//! X L + L'X + X G X + Q < 0,   R = I - Dk'Dk,   G = Bk R^-1 Bk'
//! L = Ak + Bk R^-1 Dk'Ck,   Q = Ck'Ck - H'H + Ck'Dk R^-1 Dk'Ck
//! Ak = A + B1 H,   Bk = B1 D,   Ck = C1 + D11 H,   Dk = D11 D
//! ```
//!
//! and every solution is below the one of the equation for which `L + G X` is antistable. A controller exists when
//! those of the plant and of its dual satisfy `[X I; I Y] > 0`: J. C. Doyle, K. Glover, P. P. Khargonekar, B. A.
//! Francis, IEEE Trans. Automatic Control 34(8), 1989, in the terms of P. Gahinet, P. Apkarian, Int. J. Robust and
//! Nonlinear Control 4, 1994. Nothing here is proved: what is found is put into the inequalities.

use crate::matrix::{
    Mat, block, growing_basis, kernel, largest_eigenvalue, least_eigenvalue, pseudo_inverse, solve,
    symmetric_part,
};
use crate::synthesis::balance::osborne;
use crate::system::plant::GeneralisedPlant;

/// The inverses of the largest X and Y at a gain of 1; `None` where there is no controller with that gain, or D21 or
/// D12 lacks rank.
pub(crate) fn largest_inverses(plant: &GeneralisedPlant) -> Option<(Mat, Mat)> {
    let (p, q) = (largest_inverse(plant)?, largest_inverse(&plant.dual())?);
    // X Y > I for X = P^-1, Y = Q^-1.
    let root = crate::matrix::symmetric_function(&p, |v| v.max(0.0).sqrt());
    (largest_eigenvalue(&(&root * &q * &root)) < 1.0).then_some((p, q))
}

/// A value of this, relative to the largest, is rounding.
const ROUNDING_RATIO: f64 = 1e-9;

fn largest_inverse(p: &GeneralisedPlant) -> Option<Mat> {
    let n = p.a().nrows();
    let d21 = crate::matrix::svd(&p.d21()).s;
    let (most, least) = (d21.first().copied().unwrap_or(0.0), d21.last().copied().unwrap_or(0.0));
    let full_rank = p.d21().nrows() <= p.d21().ncols() && least > ROUNDING_RATIO * most;
    if !full_rank && p.d21().nrows() > 0 {
        return None;
    }
    let (h, d) = (-pseudo_inverse(&p.d21(), ROUNDING_RATIO) * &p.c2(), kernel(&p.d21()));
    let (a, b) = (&p.a() + &p.b1() * &h, &p.b1() * &d);
    let (c, dk) = (&p.c1() + &p.d11() * &h, &p.d11() * &d);
    let r = Mat::identity(d.ncols(), d.ncols()) - dk.transpose() * &dk;
    if least_eigenvalue(&r) <= 0.0 {
        return None;
    }
    let feedback = solve(&r, &(dk.transpose() * &c))?;
    let l = a + &b * &feedback;
    let g = &b * solve(&r, &b.transpose())?;
    let q = c.transpose() * &c - h.transpose() * &h + c.transpose() * &dk * &feedback;
    let mut hamiltonian = block(&[&[&l, &g], &[&-q, &-l.transpose()]]);
    let units = balance(&mut hamiltonian);
    let basis = growing_basis(&hamiltonian)?;
    let (upper, lower) = (basis.rows(0, n).into_owned(), basis.rows(n, n).into_owned());
    // X = U2 U1^-1
    let inverse = symmetric_part(&solve(&lower.transpose(), &upper.transpose())?);
    let (least, most) = (least_eigenvalue(&inverse), largest_eigenvalue(&inverse));
    (least >= -ROUNDING_RATIO * most).then(|| &units * inverse * &units)
}

/// Brings rows and columns of `[L G; -Q -L']`, 2n x 2n, to one size by units of the states alone, so that slow modes do
/// not drown beside the gains; returns these units, n x n, diagonal. Source: E. E. Osborne, J. ACM 7(4), 1960.
fn balance(hamiltonian: &mut Mat) -> Mat {
    let n = hamiltonian.nrows() / 2;
    let mut units = Mat::identity(n, n);
    for _ in 0..BALANCING_SWEEPS {
        for i in 0..n {
            // The unit is in G and Q twice: a full step where they prevail, half of one where L does.
            let unit = osborne(hamiltonian, i).sqrt();
            units[(i, i)] *= unit;
            for (k, factor) in [(i, unit), (n + i, 1.0 / unit)] {
                hamiltonian.row_mut(k).scale_mut(1.0 / factor);
                hamiltonian.column_mut(k).scale_mut(factor);
            }
        }
    }
    units
}

/// How often each state's unit is changed.
const BALANCING_SWEEPS: usize = 20;
