//! The X of an inequality that holds at every frequency.

use crate::matrix::{Mat, block, growing_basis, scaled_largest_eigenvalue, solve, symmetric_part};

/// By how much the inequality is tightened so that it holds clearly, tried in turn.
const CLEARANCES: [f64; 7] = [1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10];

/// X with `[A'X + XA, XB; B'X, 0] + M < 0`, and the largest eigenvalue there, scaled; `None` where none was found.
pub(super) fn storage(dynamics: &Mat, form: &Mat) -> Option<(Mat, f64)> {
    CLEARANCES.into_iter().find_map(|clear| {
        let x = stabilising(dynamics, form, clear)?;
        let mut main = form.clone();
        let product = &x * dynamics;
        for i in 0..x.nrows() {
            for j in 0..main.ncols() {
                main[(i, j)] += product[(i, j)];
                main[(j, i)] += product[(i, j)];
            }
        }
        let largest = scaled_largest_eigenvalue(&main);
        (largest < 0.0).then_some((x, largest))
    })
}

/// X with `[A'X + XA, XB; B'X, 0] + M + clear I <= 0` whose `A + B K` is stable with the K that makes the form of (x,
/// Kx) zero; `None` where the inequality does not hold at every frequency. (The other extreme X does not exist where
/// a filter sees the same signal as another.)
///
/// A is n x n, B n x m, M symmetric, (n + m) x (n + m). J. C. Willems, IEEE Trans. Automatic Control 16(6), 1971.
fn stabilising(dynamics: &Mat, form: &Mat, clear: f64) -> Option<Mat> {
    let (n, all) = dynamics.shape();
    let m = all - n;
    let raised = form + Mat::identity(all, all) * clear;
    let part = |i: usize, j: usize, rows: usize, cols: usize| raised.view((i, j), (rows, cols)).into_owned();
    let (q, s, r) = (part(0, 0, n, n), part(0, n, n, m), part(n, n, m, m));
    let (a, b) = (dynamics.columns(0, n).into_owned(), dynamics.columns(n, m).into_owned());
    (-&r).cholesky()?;
    let (rs, rb) = (solve(&r, &s.transpose())?, solve(&r, &b.transpose())?);
    let l = a - &b * &rs;
    let g = symmetric_part(&(&b * rb));
    let rest = symmetric_part(&(q - s * rs));
    let hamiltonian = block(&[&[&l, &-&g], &[&-rest, &-l.transpose()]]);
    let basis = growing_basis(&-hamiltonian)?;
    let (upper, lower) = (basis.rows(0, n).into_owned(), basis.rows(n, n).into_owned());
    Some(symmetric_part(&solve(&upper.transpose(), &lower.transpose())?))
}
