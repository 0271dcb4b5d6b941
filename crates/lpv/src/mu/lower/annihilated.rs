//! Null vectors of a singular matrix.

use crate::matrix::ComplexVector;
use crate::mu::CMat;
use nalgebra::Complex;

/// The number of inverse iterations: the second corrects a start that was nearly orthogonal.
const INVERSE_ITERATIONS: usize = 2;

/// The least pivot, relative to the matrix: far below rounding.
const LEAST_PIVOT: f64 = 1e-30;

/// Returns the left and right unit vectors that a square matrix nearly annihilates, by inverse iteration with `A* A`;
/// `None` if the numbers overflow. They belong to the least singular value if it is zero to rounding.
pub(super) fn annihilated(a: CMat) -> Option<(ComplexVector, ComplexVector)> {
    let n = a.nrows();
    let size = a.norm();
    let lu = if size > 0.0 { a.unscale(size) } else { a }.lu();
    let (lower, mut upper) = (lu.l(), lu.u());
    for k in 0..n {
        // A pivot must not be exactly zero.
        if upper[(k, k)].norm() < LEAST_PIVOT {
            upper[(k, k)] = Complex::new(LEAST_PIVOT, 0.0);
        }
    }
    let mut v = ComplexVector::from_fn(n, |i, _| Complex::new(1.0, 0.5 + i as f64)).normalize();
    let mut u = v.clone();
    for _ in 0..INVERSE_ITERATIONS {
        u = upper.ad_solve_upper_triangular(&v)?;
        lower.ad_solve_lower_triangular_mut(&mut u);
        lu.p().inv_permute_rows(&mut u);
        u.normalize_mut();
        v.copy_from(&u);
        lu.p().permute_rows(&mut v);
        lower.solve_lower_triangular_mut(&mut v);
        v = upper.solve_upper_triangular(&v)?;
        v.normalize_mut();
    }
    (u.iter().chain(v.iter()).all(|x| x.re.is_finite() && x.im.is_finite())).then_some((u, v))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mu::structure::random::problem;
    use proptest::prelude::*;

    proptest! {
        /// Both vectors of a matrix minus an eigenvalue.
        #[test]
        fn null_vectors_are_annihilated((_, m) in problem()) {
            let n = m.nrows().min(m.ncols());
            let square = m.view((0, 0), (n, n)).into_owned();
            let lambda = square.clone().schur().eigenvalues().unwrap()[0];
            let singular = &square - CMat::identity(n, n) * lambda;
            let (u, v) = annihilated(singular.clone()).unwrap();
            let size = square.norm();
            prop_assert!((&singular * v).norm() < 1e-12 * size && (singular.adjoint() * u).norm() < 1e-12 * size);
        }
    }
}
