//! The storage matrix X of an inequality that holds at every frequency.

use crate::matrix::{Mat, block, growing_basis, scaled_largest_eigenvalue, solve, symmetric_part};
use crate::system::lyapunov;

/// Margins by which the inequality is tightened, in the order tried.
const MARGINS: [f64; 7] = [1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-8, 1e-10];

/// The number of Newton steps for X as long as rounding prevents a proof of the inequality.
const REFINEMENTS: usize = 3;

/// Returns X with `[A'X + XA, XB; B'X, 0] + M < 0`, and the largest eigenvalue there, scaled; `None` if none was found.
///
/// A is n x n, B n x m, M symmetric, (n + m) x (n + m).
pub(super) fn storage(dynamics: &Mat, form: &Mat) -> Option<(Mat, f64)> {
    MARGINS.into_iter().find_map(|clear| {
        let riccati = Riccati::new(dynamics, form, clear);
        let mut x = riccati.stabilising()?;
        for step in 0..=REFINEMENTS {
            if step > 0 {
                x = riccati.refined(&x)?;
            }
            let largest = scaled_largest_eigenvalue(&inequality(dynamics, form, &x));
            if largest < 0.0 {
                return Some((x, largest));
            }
        }
        None
    })
}

/// Returns `[A'X + XA, XB; B'X, 0] + M`.
fn inequality(dynamics: &Mat, form: &Mat, x: &Mat) -> Mat {
    let mut main = form.clone();
    let product = x * dynamics;
    for i in 0..x.nrows() {
        for j in 0..main.ncols() {
            main[(i, j)] += product[(i, j)];
            main[(j, i)] += product[(i, j)];
        }
    }
    main
}

/// The Riccati equation of the inequality with `M + clear I = [Q S; S' R]` in place of M:
/// `A'X + XA + Q = (XB + S) R^-1 (XB + S)'`.
struct Riccati {
    a: Mat,
    b: Mat,
    q: Mat,
    s: Mat,
    r: Mat,
}

impl Riccati {
    fn new(dynamics: &Mat, form: &Mat, clear: f64) -> Self {
        let (n, all) = dynamics.shape();
        let m = all - n;
        let raised = form + Mat::identity(all, all) * clear;
        let part = |i, j, rows, cols| raised.view((i, j), (rows, cols)).into_owned();
        let (a, b) = (dynamics.columns(0, n).into_owned(), dynamics.columns(n, m).into_owned());
        Self { a, b, q: part(0, 0, n, n), s: part(0, n, n, m), r: part(n, n, m, m) }
    }

    /// Returns the solution with a stable `A + B K`, `K = -R^-1 (B'X + S')`; `None` if the inequality does not hold at
    /// every frequency. (The other extremal X does not exist if two filters have the same input.)
    ///
    /// J. C. Willems, IEEE Trans. Automatic Control 16(6), 1971.
    fn stabilising(&self) -> Option<Mat> {
        let Self { a, b, q, s, r } = self;
        let n = a.nrows();
        (-r).cholesky()?;
        let (rs, rb) = (solve(r, &s.transpose())?, solve(r, &b.transpose())?);
        let l = a - b * &rs;
        let g = symmetric_part(&(b * rb));
        let rest = symmetric_part(&(q - s * rs));
        let hamiltonian = block(&[&[&l, &-&g], &[&-rest, &-l.transpose()]]);
        let basis = growing_basis(&-hamiltonian)?;
        let (upper, lower) = (basis.rows(0, n).into_owned(), basis.rows(n, n).into_owned());
        Some(symmetric_part(&solve(&upper.transpose(), &lower.transpose())?))
    }

    /// Returns X with about twice as many digits: that of `(A + BK)'X + X(A + BK) + [I; K]'[Q S; S' R][I; K] = 0` with
    /// the K of the previous one. D. L. Kleinman, IEEE Trans. Automatic Control 13(1), 1968.
    fn refined(&self, x: &Mat) -> Option<Mat> {
        let Self { a, b, q, s, r } = self;
        let k = -solve(r, &(s.transpose() + b.transpose() * x))?;
        let cross = s * &k;
        let closed = q + &cross + cross.transpose() + k.transpose() * r * &k;
        lyapunov(&(a + b * k), &symmetric_part(&closed))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::dmatrix;

    /// The form `x^2/2 - u^2` for `x' = -x + u` gives `-2X + 1/2 + X^2 = 0`, with the stabilising solution
    /// `1 - 1/sqrt(2)`. Newton's error is at most the square of the previous one over `2 (1 - X)`.
    #[test]
    fn a_refined_solution_has_twice_the_digits() {
        let riccati = Riccati::new(&dmatrix![-1.0, 1.0], &dmatrix![0.5, 0.0; 0.0, -1.0], 0.0);
        let exact = 1.0 - 0.5f64.sqrt();
        assert!((riccati.stabilising().unwrap()[0] - exact).abs() < 1e-12);
        let mut x = dmatrix![exact + 0.01];
        for error in [1e-4, 1e-8] {
            x = riccati.refined(&x).unwrap();
            assert!((x[0] - exact).abs() < error, "{x}");
        }
    }
}
