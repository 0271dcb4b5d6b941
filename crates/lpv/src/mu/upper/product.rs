//! Products of complex matrices by faer, which uses vector instructions; nalgebra multiplies them entry by entry.

use crate::mu::CMat;
use faer::linalg::matmul::matmul;
use faer::{Accum, MatMut, MatRef, Par};
use nalgebra::Complex;

/// Returns `left right`.
pub(in crate::mu) fn product(left: &CMat, right: &CMat) -> CMat {
    let mut out = CMat::zeros(left.nrows(), right.ncols());
    let ((m, k), (l, n)) = (left.shape(), right.shape());
    matmul(
        MatMut::from_column_major_slice_mut(out.as_mut_slice(), m, n),
        Accum::Replace,
        MatRef::from_column_major_slice(left.as_slice(), m, k),
        MatRef::from_column_major_slice(right.as_slice(), l, n),
        Complex::new(1.0, 0.0),
        Par::Seq,
    );
    out
}
