//! Lyapunov equations, and the geometric mean of the gramians.
//!
//! J. D. Roberts, "Linear model reduction and solution of the algebraic Riccati equation by use of the sign function",
//! Int. J. Control 32(4), 1980 (a report of 1971); the balanced pair of gramians: B. C. Moore, IEEE Trans. Automatic
//! Control 26(1), 1981.

use crate::matrix::{Mat, diagonal, largest_eigenvalue, solve, symmetric_function, symmetric_part};
use crate::system::StateSpace;

/// The smallest eigenvalue that a gramian may have, relative to the largest; smaller ones are raised.
const EIGENVALUE_FLOOR: f64 = 1e-6;

/// Returns a matrix X midway between the largest and the smallest storage function of a mean system, and an estimate of
/// its gain: `Q/g < X < g P^-1` holds for the storage functions of a system with gramians P, Q and gain g, so
/// `X = P^-1 # Q`, the geometric mean, which is the identity in balanced coordinates, lies in the middle.
///
/// P and Q are the means of the gramians of all systems, which must be stable. `None` if a step fails.
pub(crate) fn middle_of_gramians(systems: &[&StateSpace]) -> Option<(Mat, f64)> {
    let n = systems.first()?.a.nrows();
    let (mut p, mut q) = (Mat::zeros(n, n), Mat::zeros(n, n));
    for s in systems {
        p += lyapunov(&s.a.transpose(), &(&s.b * s.b.transpose()))?;
        q += lyapunov(&s.a, &(s.c.transpose() * &s.c))?;
    }
    let (p, q) = [p, q].map(|sum| filled(&(sum / systems.len() as f64), EIGENVALUE_FLOOR)).into();
    // P = L L':  P^-1 # Q = L'^-1 (L' Q L)^1/2 L^-1, whose root holds the Hankel singular values.
    let l = p.cholesky()?.l();
    let hankel = symmetric_function(&(l.transpose() * q * &l), |v| v.max(0.0).sqrt());
    let inverse = l.try_inverse()?;
    let x = symmetric_part(&(inverse.transpose() * &hankel * inverse));
    let gain = largest_eigenvalue(&hankel);
    (gain > 0.0 && x.iter().all(|v| v.is_finite())).then_some((x, gain))
}

/// Relative regularisations of a gramian; the first that makes it positive definite is used, because rounding makes
/// gramians indefinite in badly conditioned coordinates.
const FLOORS: [f64; 4] = [EIGENVALUE_FLOOR, 1e-4, 1e-2, 1.0];

/// Tolerance of the sign iteration for the factors of gramians: only their size matters.
const NEAR: f64 = 1e-3;

/// Returns the factors p and q of the gramians: `p p'` of reachability and `q q'` of observability, regularised in
/// directions that are not reached; `None` if a step fails.
pub(crate) fn gramian_factors(s: &StateSpace) -> Option<(Mat, Mat)> {
    let p = lyapunov_to(&s.a.transpose(), &(&s.b * s.b.transpose()), NEAR)?;
    let q = lyapunov_to(&s.a, &(s.c.transpose() * &s.c), NEAR)?;
    let factor =
        |gramian: &Mat| FLOORS.iter().find_map(|floor| filled(gramian, *floor).cholesky()).map(|f| f.l());
    Some((factor(&p)?, factor(&q)?))
}

/// Returns a gramian regularised in the directions that are not reached; the identity for zero.
fn filled(gramian: &Mat, least: f64) -> Mat {
    let n = gramian.nrows();
    let variances: Vec<f64> = gramian.diagonal().iter().map(|d| d.max(0.0)).collect();
    let most = variances.iter().copied().fold(0.0, f64::max);
    if most <= 0.0 {
        return Mat::identity(n, n);
    }
    // The floor is in proportion to each state's size, so that the states' units matter little.
    let floor = |d: f64| least * d.max(least * most);
    gramian + diagonal(variances.into_iter().map(floor))
}

/// Returns X of `A'X + XA + Q = 0` for a stable A, by the matrix sign iteration; `None` if it does not converge.
pub(crate) fn lyapunov(a: &Mat, q: &Mat) -> Option<Mat> {
    lyapunov_to(a, q, 1e-7)
}

/// Returns the solution of [`lyapunov`] to about the square of `near`: badly conditioned coordinates may allow no more.
fn lyapunov_to(a: &Mat, q: &Mat, near: f64) -> Option<Mat> {
    let n = a.nrows();
    let (mut a, mut q, one) = (a.clone(), q.clone(), Mat::identity(n, n));
    for _ in 0..100 {
        // The sign of a stable matrix is -I, and one more step from here doubles the digits.
        let close = (&a + &one).norm() < near * n as f64;
        // `try_inverse` takes determinants of small matrices and loses most digits of badly scaled ones.
        let inverse = solve(&a, &one)?;
        let c = (a.norm() / inverse.norm()).sqrt();
        q = (&q / c + inverse.transpose() * &q * &inverse * c) * 0.5;
        a = (&a / c + inverse * c) * 0.5;
        if close {
            return Some(symmetric_part(&q) * 0.5);
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::dmatrix;

    #[test]
    fn solves_the_lyapunov_equation_of_slow_and_fast_modes() {
        let a = dmatrix![-1e-3, 2.0, 0.0; 0.0, -1.0, 5.0; 0.0, -5.0, -200.0];
        let q = dmatrix![1.0, 0.5, 0.0; 0.5, 2.0, 0.1; 0.0, 0.1, 3.0];
        let x = lyapunov(&a, &q).unwrap();
        let left = a.transpose() * &x + &x * &a + q;
        assert!(left.amax() < 1e-10 * x.amax(), "{left}");
    }

    #[test]
    fn an_unstable_matrix_has_no_gramian() {
        assert!(lyapunov(&dmatrix![1.0], &dmatrix![1.0]).is_none());
    }

    #[test]
    fn the_middle_of_a_balanced_system_is_the_identity() {
        // g/(s + 1) with equal gramians g/2.
        let s = StateSpace { a: dmatrix![-1.0], b: dmatrix![2.0], c: dmatrix![2.0], d: dmatrix![0.0] };
        let (x, gain) = middle_of_gramians(&[&s]).unwrap();
        assert!((x[(0, 0)] - 1.0).abs() < 1e-5 && (gain - 2.0).abs() < 1e-5);
    }
}
