//! Scaling and balancing of a perturbed system.
//!
//! mu does not change with the coordinates of the states, nor with a unit for each block, the same for w and z. The
//! numerics do: the eigenvalues of a matrix whose entries range over ten decades are dominated by rounding.
//!
//! Units: E. E. Osborne, J. ACM 7(4), 1960. Coordinates in which both gramians are equal and diagonal: B. C. Moore,
//! IEEE Trans. Automatic Control 26(1), 1981, from Cholesky factors by A. J. Laub, M. T. Heath, C. C. Paige, R. C.
//! Ward, IEEE Trans. Automatic Control 32(2), 1987. The transformation is computed with products as in twice the
//! precision: T. Ogita, S. M. Rump, S. Oishi, SIAM J. Scientific Computing 26(6), 2005.

use super::structure::Structure;
use crate::matrix::{Mat, block, diagonal, eigenvalues, largest_singular_value, solve, svd};
use crate::system::{StateSpace, gramian_factors};

/// The number of sweeps of Osborne's iteration.
const ROUNDS: usize = 50;

/// The largest number of balancing passes: the gramians of a badly conditioned system are regularised, and more
/// accurate in better coordinates.
const PASSES: usize = 8;

/// The condition number of a change of coordinates below which balancing ends.
const LEAST_CHANGE: f64 = 2.0;

/// The number of corrections of a matrix quotient, and the relative size allowed for the last.
const CORRECTIONS: usize = 3;
const SETTLED: f64 = 1e-14;

/// Returns the system with a unit for each block and each state that equalises its gains in and out. Inputs and outputs
/// are those of the structure.
pub(super) fn block_scaled(system: &StateSpace, structure: &Structure) -> StateSpace {
    let n = system.a.nrows();
    // The effect of A is included, in a unit of time in which the modes are about 1.
    let root = mean_time_scale(&system.a).sqrt();
    let mut m =
        block(&[&[&(&system.a / (root * root)), &(&system.b / root)], &[&(&system.c / root), &system.d]]);
    let states = (0..n).map(|i| (i..i + 1, i..i + 1));
    let behind = |range: std::ops::Range<usize>| range.start + n..range.end + n;
    let blocks = structure.places().into_iter().map(|(_, w, z)| (behind(z), behind(w)));
    let units: Vec<_> = states.chain(blocks).collect();
    for _ in 0..ROUNDS {
        for (rows, columns) in &units {
            let inner = m.view_range(rows.clone(), columns.clone()).norm_squared();
            let received = m.rows_range(rows.clone()).norm_squared() - inner;
            let sent = m.columns_range(columns.clone()).norm_squared() - inner;
            if received > 0.0 && sent > 0.0 {
                let unit = (sent / received).powf(0.25);
                m.rows_range_mut(rows.clone()).scale_mut(unit);
                m.columns_range_mut(columns.clone()).unscale_mut(unit);
            }
        }
    }
    let part = |rows: std::ops::Range<usize>, columns| m.view_range(rows, columns).into_owned();
    let (outputs, inputs) = (n..m.nrows(), n..m.ncols());
    StateSpace {
        a: part(0..n, 0..n) * (root * root),
        b: part(0..n, inputs.clone()) * root,
        c: part(outputs.clone(), 0..n) * root,
        d: part(outputs, inputs),
    }
}

/// Returns the geometric mean of |lambda| over the modes, rad/s; 1 if there are none.
fn mean_time_scale(a: &Mat) -> f64 {
    let logs: Vec<f64> = eigenvalues(a).iter().map(|p| p.norm().ln()).filter(|v| v.is_finite()).collect();
    (logs.iter().sum::<f64>() / logs.len().max(1) as f64).exp()
}

/// Returns a stable system in coordinates in which its gramians are about equal and diagonal, without idle states.
pub(super) fn balanced(system: &StateSpace, structure: &Structure) -> StateSpace {
    let mut out = block_scaled(&system.without_idle_states(), structure);
    for _ in 0..PASSES {
        let Some(next) = with_equal_gramians(&out) else { break };
        out = next;
    }
    out
}

/// Balances a system; `None` if balancing changes little, or there are no gramians.
fn with_equal_gramians(s: &StateSpace) -> Option<StateSpace> {
    let (p, q) = gramian_factors(s)?;
    // P = p p', Q = q q', q'p = u s v':  T = s^-1/2 u' q'.
    let parts = svd(&(q.transpose() * p));
    let root = diagonal(parts.s.iter().map(|value| 1.0 / value.sqrt()));
    let t = root * parts.u.transpose() * q.transpose();
    let inverse = solve(&t, &Mat::identity(t.nrows(), t.nrows()))?;
    let change = largest_singular_value(&t) * largest_singular_value(&inverse);
    if !change.is_finite() || change < LEAST_CHANGE {
        return None;
    }
    let one = Mat::identity(s.c.nrows(), s.c.nrows());
    Some(StateSpace {
        a: quotient(&t, &s.a, &t, &inverse)?,
        b: exact_product(&[(&t, &s.b, 1.0)]),
        c: quotient(&one, &s.c, &t, &inverse)?,
        d: s.d.clone(),
    })
}

/// Returns `left right T^-1` by an approximate inverse of T; `None` if that is too inaccurate.
fn quotient(left: &Mat, right: &Mat, t: &Mat, inverse: &Mat) -> Option<Mat> {
    let mut out = left * right * inverse;
    let mut change = f64::INFINITY;
    for _ in 0..CORRECTIONS {
        let correction = exact_product(&[(left, right, 1.0), (&out, t, -1.0)]) * inverse;
        change = correction.norm();
        out += correction;
    }
    (change <= SETTLED * out.norm()).then_some(out)
}

/// Returns the sum of products `sign left right`, accumulated in twice the precision and rounded once.
fn exact_product(terms: &[(&Mat, &Mat, f64)]) -> Mat {
    let Some((left, right, _)) = terms.first() else { return Mat::zeros(0, 0) };
    Mat::from_fn(left.nrows(), right.ncols(), |i, j| {
        let (mut sum, mut rest) = (0.0f64, 0.0f64);
        for (left, right, sign) in terms {
            for (a, b) in left.row(i).iter().zip(right.column(j).iter()) {
                let product = sign * a * b;
                let next = sum + product;
                let shift = next - sum;
                rest += (sum - (next - shift)) + (product - shift) + (sign * a).mul_add(*b, -product);
                sum = next;
            }
        }
        sum + rest
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mu::structure::Block;
    use nalgebra::{Complex, dmatrix};

    /// Plain products lose a sum completely if its largest terms cancel.
    #[test]
    fn products_are_rounded_once() {
        let (left, right) = (dmatrix![1e16, 1.0, -1e16], dmatrix![1.0; 0.5; 1.0]);
        assert_eq!(exact_product(&[(&left, &right, 1.0)])[(0, 0)], 0.5);
        let (left, right) = (dmatrix![1.0 + f64::EPSILON], dmatrix![1.0 - f64::EPSILON]);
        let rest = exact_product(&[(&left, &right, 1.0), (&dmatrix![1.0], &dmatrix![1.0], -1.0)])[(0, 0)];
        assert_eq!(rest, -f64::EPSILON * f64::EPSILON);
    }

    /// The response is unchanged, except for the units of the blocks, which cancel in products along each block.
    #[test]
    fn the_response_is_unchanged() {
        let system = StateSpace {
            a: dmatrix![-1.0, 1e9, 0.0; 0.0, -30.0, 1e-5; -1e-6, 0.0, -2e3],
            b: dmatrix![0.0, 1e7; 1.0, 0.0; 2e-3, 1.0],
            c: dmatrix![1e-9, 0.0, 3.0; 0.0, 1e4, 1.0],
            d: dmatrix![0.5, 0.0; 1e5, -0.2],
        };
        let structure = Structure::new(vec![Block::Real(1), Block::Complex(1)]).unwrap();
        let other = balanced(&system, &structure);
        for omega in [0.0, 0.1, 3.0, 500.0, 1e5] {
            let s = Complex::new(0.0, omega);
            let (m, scaled) = (system.response(s).unwrap(), other.response(s).unwrap());
            for (found, right) in [
                (scaled[(0, 0)], m[(0, 0)]),
                (scaled[(1, 1)], m[(1, 1)]),
                (scaled[(0, 1)] * scaled[(1, 0)], m[(0, 1)] * m[(1, 0)]),
            ] {
                assert!((found - right).norm() < 1e-9 * right.norm(), "{omega} {found} {right}");
            }
        }
    }
}
