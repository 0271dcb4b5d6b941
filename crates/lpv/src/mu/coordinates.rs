//! A perturbed system in units and coordinates in which its numbers are of one size.
//!
//! mu does not change with the coordinates of the states, nor with a unit for each block, the same on the side of w
//! and of z. What is computed does: eigenvalues of a matrix whose entries range over ten powers of ten are rounding.
//!
//! Units: E. E. Osborne, J. ACM 7(4), 1960. Coordinates in which both gramians are equal and diagonal: B. C. Moore,
//! IEEE Trans. Automatic Control 26(1), 1981, from Cholesky factors by A. J. Laub, M. T. Heath, C. C. Paige, R. C.
//! Ward, IEEE Trans. Automatic Control 32(2), 1987. The change itself is carried out with products as exact as in
//! twice the digits: T. Ogita, S. M. Rump, S. Oishi, SIAM J. Scientific Computing 26(6), 2005.

use super::structure::Structure;
use crate::matrix::{Mat, block, diagonal, eigenvalues, largest_singular_value, solve, svd};
use crate::system::lyapunov::gramian_factors;
use crate::system::state_space::StateSpace;

/// Rounds of Osborne's iteration.
const ROUNDS: usize = 50;

/// How often the gramians are made equal, at most: those of a badly conditioned system are filled up, and known better
/// in better coordinates.
const PASSES: usize = 8;

/// A change of coordinates with a condition number below this is none.
const LEAST_CHANGE: f64 = 2.0;

/// Corrections of a quotient of matrices, and how small the last one is, relatively.
const CORRECTIONS: usize = 3;
const SETTLED: f64 = 1e-14;

/// The same system with a unit for each block and each state in which what it sends is as large as what it receives.
/// Inputs and outputs are those of the structure.
pub(super) fn in_own_units(system: &StateSpace, structure: &Structure) -> StateSpace {
    let n = system.a.nrows();
    // Of one size as well: what A does in a unit of time in which the modes are about 1.
    let root = median_time_scale(&system.a).sqrt();
    let mut m =
        block(&[&[&(&system.a / (root * root)), &(&system.b / root)], &[&(&system.c / root), &system.d]]);
    let states = (0..n).map(|i| (i..i + 1, i..i + 1));
    let behind = |range: std::ops::Range<usize>| range.start + n..range.end + n;
    let blocks = structure.places().into_iter().map(|(_, w, z)| (behind(z), behind(w)));
    let units: Vec<_> = states.chain(blocks).collect();
    for _ in 0..ROUNDS {
        for (rows, columns) in &units {
            let own = m.view_range(rows.clone(), columns.clone()).norm_squared();
            let received = m.rows_range(rows.clone()).norm_squared() - own;
            let sent = m.columns_range(columns.clone()).norm_squared() - own;
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

/// The geometric mean of the modes, rad/s; 1 where there is none.
fn median_time_scale(a: &Mat) -> f64 {
    let speeds: Vec<f64> = eigenvalues(a).iter().map(|p| p.norm().ln()).filter(|v| v.is_finite()).collect();
    (speeds.iter().sum::<f64>() / speeds.len().max(1) as f64).exp()
}

/// The same stable system in coordinates in which its gramians are about equal and diagonal, and without the states
/// that have no part in it.
pub(super) fn balanced(system: &StateSpace, structure: &Structure) -> StateSpace {
    let mut out = in_own_units(&system.without_idle_states(), structure);
    for _ in 0..PASSES {
        let Some(next) = with_equal_gramians(&out) else { break };
        out = next;
    }
    out
}

/// `None` where that changes little, or there are no gramians.
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

/// `left right T^-1`, from an inverse of T that is not exact; `None` where it is too far from that.
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

/// The sum of products, `sign left right`, rounded once but for what twice the digits leave.
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

    /// A sum whose largest terms cancel: plain products leave nothing of it.
    #[test]
    fn products_are_rounded_once() {
        let (left, right) = (dmatrix![1e16, 1.0, -1e16], dmatrix![1.0; 0.5; 1.0]);
        assert_eq!(exact_product(&[(&left, &right, 1.0)])[(0, 0)], 0.5);
        let (left, right) = (dmatrix![1.0 + f64::EPSILON], dmatrix![1.0 - f64::EPSILON]);
        let rest = exact_product(&[(&left, &right, 1.0), (&dmatrix![1.0], &dmatrix![1.0], -1.0)])[(0, 0)];
        assert_eq!(rest, -f64::EPSILON * f64::EPSILON);
    }

    /// The response stays, but for the units of the blocks, which a product along each block does not show.
    #[test]
    fn the_response_stays() {
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
            let (m, own) = (system.response(s).unwrap(), other.response(s).unwrap());
            for (found, right) in [
                (own[(0, 0)], m[(0, 0)]),
                (own[(1, 1)], m[(1, 1)]),
                (own[(0, 1)] * own[(1, 0)], m[(0, 1)] * m[(1, 0)]),
            ] {
                assert!((found - right).norm() < 1e-9 * right.norm(), "{omega} {found} {right}");
            }
        }
    }
}
