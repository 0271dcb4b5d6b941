//! Dense matrices: building from blocks, subspaces, eigenvalues.

use nalgebra::{Complex, DMatrix, DVector, SymmetricEigen};

/// A real matrix of any size.
pub type Mat = DMatrix<f64>;

/// Puts blocks together: `block(&[&[a, b], &[c, d]])` is `[a b; c d]`.
///
/// Each row of blocks has one height and each column of blocks one width; blocks with no rows or no columns
/// are welcome. The caller's types guarantee the shapes, so a mismatch is a defect of this crate.
pub fn block(rows: &[&[&Mat]]) -> Mat {
    let heights: Vec<usize> = rows.iter().map(|row| row.first().map_or(0, |b| b.nrows())).collect();
    let widths: Vec<usize> = rows.first().map_or(Vec::new(), |row| row.iter().map(|b| b.ncols()).collect());
    let mut out = Mat::zeros(heights.iter().sum(), widths.iter().sum());
    let mut top = 0;
    for (row, height) in rows.iter().zip(&heights) {
        let mut left = 0;
        for (b, width) in row.iter().zip(&widths) {
            debug_assert_eq!(b.shape(), (*height, *width), "blocks of unlike shape");
            out.view_mut((top, left), b.shape()).copy_from(b);
            left += width;
        }
        top += height;
    }
    out
}

/// The block diagonal matrix of `blocks`.
pub fn diagonal_blocks(blocks: &[&Mat]) -> Mat {
    let rows = blocks.iter().map(|b| b.nrows()).sum();
    let cols = blocks.iter().map(|b| b.ncols()).sum();
    let mut out = Mat::zeros(rows, cols);
    let (mut i, mut j) = (0, 0);
    for b in blocks {
        out.view_mut((i, j), b.shape()).copy_from(b);
        i += b.nrows();
        j += b.ncols();
    }
    out
}

/// `(A + A')/2`.
pub fn symmetric_part(a: &Mat) -> Mat {
    (a + a.transpose()) * 0.5
}

/// `(A - A')/2`.
pub fn skew_part(a: &Mat) -> Mat {
    (a - a.transpose()) * 0.5
}

/// Eigenvalues of a symmetric matrix, ascending.
pub fn symmetric_eigenvalues(a: &Mat) -> Vec<f64> {
    if a.is_empty() {
        return Vec::new();
    }
    let mut values: Vec<f64> = symmetric_part(a).symmetric_eigenvalues().iter().copied().collect();
    values.sort_by(f64::total_cmp);
    values
}

/// The largest eigenvalue of a symmetric matrix (minus infinity for an empty one).
pub fn largest_eigenvalue(a: &Mat) -> f64 {
    symmetric_eigenvalues(a).last().copied().unwrap_or(f64::NEG_INFINITY)
}

/// The least eigenvalue of a symmetric matrix (infinity for an empty one).
pub fn least_eigenvalue(a: &Mat) -> f64 {
    symmetric_eigenvalues(a).first().copied().unwrap_or(f64::INFINITY)
}

/// Eigenvalues of a square matrix, sorted by real and then imaginary part.
///
/// Not-a-number throughout if the matrix holds one or the QR iteration fails: no comparison then succeeds.
pub fn eigenvalues(a: &Mat) -> Vec<Complex<f64>> {
    let n = a.nrows();
    let unknown = Complex::new(f64::NAN, f64::NAN);
    if n == 0 || a.iter().any(|v| !v.is_finite()) {
        return vec![unknown; n];
    }
    // faer's QR iteration balances shifts better than nalgebra's, and it ends.
    let matrix = faer::Mat::from_fn(n, n, |i, j| a[(i, j)]);
    let mut values: Vec<Complex<f64>> = match matrix.eigenvalues_from_real() {
        Ok(values) => values.iter().map(|v| Complex::new(v.re, v.im)).collect(),
        Err(_) => vec![unknown; n],
    };
    values.sort_by(|p, q| p.re.total_cmp(&q.re).then(p.im.total_cmp(&q.im)));
    values
}

/// The largest real part of the eigenvalues (minus infinity for an empty matrix).
pub fn spectral_abscissa(a: &Mat) -> f64 {
    let real_parts = eigenvalues(a).into_iter().map(|v| v.re);
    real_parts
        .fold(f64::NEG_INFINITY, |most, v| if most.is_nan() || v.is_nan() { f64::NAN } else { most.max(v) })
}

/// The solution of `A X = B` by LU with partial pivoting; `None` when A is singular. Empty systems are welcome.
pub fn solve(a: &Mat, b: &Mat) -> Option<Mat> {
    if a.is_empty() { Some(b.clone()) } else { a.clone().lu().solve(b) }
}

/// `f(A) = V f(Lambda) V'` of a symmetric matrix.
pub fn symmetric_function(a: &Mat, f: impl Fn(f64) -> f64) -> Mat {
    let SymmetricEigen { eigenvectors, eigenvalues } = symmetric_part(a).symmetric_eigen();
    let mapped = DVector::from_iterator(eigenvalues.len(), eigenvalues.iter().map(|v| f(*v)));
    &eigenvectors * Mat::from_diagonal(&mapped) * eigenvectors.transpose()
}

/// An orthonormal basis of the kernel of A, as columns.
///
/// Singular values below `1e-10` of the largest count as zero.
pub fn kernel(a: &Mat) -> Mat {
    let n = a.ncols();
    if a.nrows() == 0 || n == 0 {
        return Mat::identity(n, n);
    }
    // The eigenvectors of A'A would square the condition number: take the SVD of A padded to be tall.
    let padded = if a.nrows() < n { a.clone().insert_rows(a.nrows(), n - a.nrows(), 0.0) } else { a.clone() };
    let svd = padded.svd(false, true);
    let Some(v_t) = svd.v_t else { return Mat::identity(n, n) };
    let largest = svd.singular_values.max();
    let columns: Vec<DVector<f64>> = (0..n)
        .filter(|&i| svd.singular_values[i] <= 1e-10 * largest)
        .map(|i| v_t.row(i).transpose())
        .collect();
    if columns.is_empty() { Mat::zeros(n, 0) } else { Mat::from_columns(&columns) }
}

/// `A = L R` with as few columns in L as `tolerance` allows: singular values up to it are dropped.
pub fn rank_factors(a: &Mat, tolerance: f64) -> (Mat, Mat) {
    if a.is_empty() {
        return (Mat::zeros(a.nrows(), 0), Mat::zeros(0, a.ncols()));
    }
    let svd = a.clone().svd(true, true);
    let (Some(u), Some(v_t)) = (svd.u, svd.v_t) else {
        return (a.clone(), Mat::identity(a.ncols(), a.ncols()));
    };
    let mut kept: Vec<usize> =
        (0..svd.singular_values.len()).filter(|&i| svd.singular_values[i] > tolerance).collect();
    kept.sort_by(|&i, &j| svd.singular_values[j].total_cmp(&svd.singular_values[i]));
    let mut left = Mat::zeros(a.nrows(), kept.len());
    let mut right = Mat::zeros(kept.len(), a.ncols());
    for (k, &i) in kept.iter().enumerate() {
        // The singular value is shared between the factors, so that both are of one size.
        let root = svd.singular_values[i].sqrt();
        left.set_column(k, &(u.column(i) * root));
        right.set_row(k, &(v_t.row(i) * root));
    }
    (left, right)
}

/// The largest singular value (0 for an empty matrix).
pub fn largest_singular_value(a: &Mat) -> f64 {
    if a.is_empty() { 0.0 } else { a.singular_values().max() }
}

/// The matrix as a list of rows, as the files hold it.
pub fn to_rows(a: &Mat) -> Vec<Vec<f64>> {
    a.row_iter().map(|row| row.iter().copied().collect()).collect()
}

/// A matrix of `cols` columns from a list of rows; `None` when a row has another length.
pub fn from_rows(rows: &[Vec<f64>], cols: usize) -> Option<Mat> {
    if rows.iter().any(|row| row.len() != cols) {
        return None;
    }
    Some(Mat::from_fn(rows.len(), cols, |i, j| rows[i][j]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::dmatrix;

    #[test]
    fn kernel_is_orthonormal_and_annihilated() {
        let a = dmatrix![1.0, 2.0, 3.0, 4.0; 2.0, 4.0, 6.0, 8.1];
        let n = kernel(&a);
        assert_eq!(n.ncols(), 2);
        assert!((&a * &n).amax() < 1e-12);
        assert!((n.transpose() * &n - Mat::identity(2, 2)).amax() < 1e-12);
    }

    #[test]
    fn kernel_of_no_rows_is_everything() {
        assert_eq!(kernel(&Mat::zeros(0, 3)), Mat::identity(3, 3));
    }

    #[test]
    fn rank_factors_rebuild() {
        let a = dmatrix![1.0, 2.0; 2.0, 4.0; 3.0, 6.0];
        let (l, r) = rank_factors(&a, 1e-12);
        assert_eq!(l.ncols(), 1);
        assert!((l * r - a).amax() < 1e-12);
    }

    #[test]
    fn blocks_may_be_empty() {
        let a = Mat::identity(2, 2);
        let none = Mat::zeros(2, 0);
        assert_eq!(block(&[&[&a, &none]]), a);
        assert_eq!(diagonal_blocks(&[&a, &Mat::zeros(0, 1)]).shape(), (2, 3));
    }
}
