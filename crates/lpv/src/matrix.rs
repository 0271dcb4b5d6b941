//! Dense matrices: block matrices, subspaces, eigenvalues.

use faer::Side;
use nalgebra::{Complex, ComplexField, DMatrix, DVector, Schur, SymmetricTridiagonal};

/// A real matrix of any size.
pub type Mat = DMatrix<f64>;

/// A complex vector of any size.
pub type ComplexVector = DVector<Complex<f64>>;

/// Returns the block matrix: `block(&[&[a, b], &[c, d]])` is `[a b; c d]`.
///
/// All blocks of a row have one height and all of a column one width; blocks without rows or columns are allowed. A
/// mismatch is a defect of this crate.
pub fn block(rows: &[&[&Mat]]) -> Mat {
    let heights: Vec<usize> = rows.iter().map(|row| row.first().map_or(0, |b| b.nrows())).collect();
    let widths: Vec<usize> = rows.first().map_or(Vec::new(), |row| row.iter().map(|b| b.ncols()).collect());
    let mut out = Mat::zeros(heights.iter().sum(), widths.iter().sum());
    let mut top = 0;
    for (row, height) in rows.iter().zip(&heights) {
        let mut left = 0;
        for (b, width) in row.iter().zip(&widths) {
            debug_assert_eq!(b.shape(), (*height, *width), "blocks of different shapes");
            out.view_mut((top, left), b.shape()).copy_from(b);
            left += width;
        }
        top += height;
    }
    out
}

/// Returns the block diagonal matrix of `blocks`.
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

/// Returns `(A + A')/2`. A is n x n.
pub fn symmetric_part(a: &Mat) -> Mat {
    (a + a.transpose()) * 0.5
}

/// Returns `(A - A')/2`. A is n x n.
pub fn skew_part(a: &Mat) -> Mat {
    (a - a.transpose()) * 0.5
}

/// Makes faer compute on one thread instead of all, so that sums are formed in the same order on every machine.
pub(crate) fn on_one_thread() {
    faer::set_global_parallelism(faer::Par::Seq);
}

/// Converts a matrix to faer, whose decompositions are accurate; `None` if an entry is not finite.
fn to_faer<T: ComplexField>(a: &DMatrix<T>) -> Option<faer::Mat<T>> {
    on_one_thread();
    let finite = a.iter().all(ComplexField::is_finite);
    finite.then(|| faer::Mat::from_fn(a.nrows(), a.ncols(), |i, j| a[(i, j)].clone()))
}

fn from_faer<T: ComplexField + Copy>(a: faer::MatRef<'_, T>) -> DMatrix<T> {
    DMatrix::from_fn(a.nrows(), a.ncols(), |i, j| a[(i, j)])
}

/// The singular value decomposition `A = U diag(s) V'`, all columns of U and V, s descending.
///
/// All NaN if A has a NaN or the iteration fails: no comparison then succeeds.
pub struct Svd {
    /// Left singular vectors, m x m, orthogonal.
    pub u: Mat,
    /// Singular values, min(m, n).
    pub s: Vec<f64>,
    /// Right singular vectors, n x n, orthogonal.
    pub v: Mat,
}

/// Returns the singular value decomposition of A, m x n.
pub fn svd(a: &Mat) -> Svd {
    let (m, n) = a.shape();
    if a.is_empty() {
        return Svd { u: Mat::identity(m, m), s: vec![], v: Mat::identity(n, n) };
    }
    match to_faer(a).and_then(|a| a.svd().ok()) {
        Some(d) => Svd {
            u: from_faer(d.U()),
            s: d.S().column_vector().iter().copied().collect(),
            v: from_faer(d.V()),
        },
        None => Svd {
            u: Mat::from_element(m, m, f64::NAN),
            s: vec![f64::NAN; m.min(n)],
            v: Mat::from_element(n, n, f64::NAN),
        },
    }
}

/// Returns the pseudo-inverse, with singular values below `tolerance` times the largest taken as zero. n x m for an m x
/// n matrix.
pub fn pseudo_inverse(a: &Mat, tolerance: f64) -> Mat {
    let Svd { u, s, v } = svd(a);
    let largest = s.first().copied().unwrap_or(0.0);
    let mut out = Mat::zeros(a.ncols(), a.nrows());
    for (k, value) in s.iter().enumerate().filter(|(_, value)| **value > tolerance * largest) {
        out += v.column(k) * u.column(k).transpose() / *value;
    }
    out
}

/// Returns the eigenvalues of a symmetric matrix, ascending; NaN if the matrix has a NaN.
pub fn symmetric_eigenvalues(a: &Mat) -> Vec<f64> {
    ascending_eigenvalues(&symmetric_part(a))
}

/// Returns the ascending eigenvalues by nalgebra, in a third of faer's time for up to about 80 rows.
fn ascending_eigenvalues<T: ComplexField<RealField = f64>>(a: &DMatrix<T>) -> Vec<f64> {
    if a.is_empty() {
        return vec![];
    }
    if !a.iter().all(ComplexField::is_finite) {
        return vec![f64::NAN; a.nrows()];
    }
    let mut values: Vec<f64> = a.symmetric_eigenvalues().iter().copied().collect();
    values.sort_by(f64::total_cmp);
    values
}

/// Returns the largest eigenvalue of a symmetric matrix (minus infinity for an empty one).
pub fn largest_eigenvalue(a: &Mat) -> f64 {
    symmetric_eigenvalues(a).last().copied().unwrap_or(f64::NEG_INFINITY)
}

/// Returns the least eigenvalue of a symmetric matrix (infinity for an empty one).
pub fn least_eigenvalue(a: &Mat) -> f64 {
    symmetric_eigenvalues(a).first().copied().unwrap_or(f64::INFINITY)
}

/// Returns the least eigenvalue of a symmetric matrix, to rounding, or at most a relative 1e-9 less; NaN if the matrix
/// has one, infinity for an empty one.
///
/// By bisection with Sturm sequences, in a fifth of the time of all eigenvalues: W. Barth, R. S. Martin, J. H.
/// Wilkinson, Numerische Mathematik 9, 1967.
pub(crate) fn quick_least_eigenvalue(a: Mat) -> f64 {
    if a.len() < 2 || a.iter().any(|v| !v.is_finite()) {
        return a
            .iter()
            .copied()
            .fold(f64::INFINITY, |least, v| if v.is_finite() { least.min(v) } else { f64::NAN });
    }
    let (diagonal, off_diagonal) = SymmetricTridiagonal::new(a).unpack_tridiagonal();
    let size = |i: usize| off_diagonal.get(i).map_or(0.0, |v: &f64| v.abs());
    let radius = |i: usize| size(i) + if i > 0 { size(i - 1) } else { 0.0 };
    let circles = || diagonal.iter().enumerate();
    let mut low = circles().map(|(i, d)| d - radius(i)).fold(f64::INFINITY, f64::min);
    let mut high = diagonal.min();
    let rounding = f64::EPSILON * circles().map(|(i, d)| d.abs() + radius(i)).fold(0.0, f64::max);
    let some_below = |shift: f64| {
        let mut pivot = f64::INFINITY;
        circles().any(|(i, d)| {
            pivot = d - shift - if i > 0 { off_diagonal[i - 1] * off_diagonal[i - 1] / pivot } else { 0.0 };
            pivot < 0.0
        })
    };
    while high - low > rounding.max(RESOLUTION * low.abs()) {
        let middle = 0.5 * (low + high);
        if some_below(middle) { high = middle } else { low = middle }
    }
    low
}

/// The relative accuracy of [`quick_least_eigenvalue`].
const RESOLUTION: f64 = 1e-9;

/// Returns the largest eigenvalue of a symmetric matrix after the diagonal congruence that makes its diagonal -1. The
/// sign is that of the largest eigenvalue, and rounding enters in proportion. 1 if the diagonal is not negative.
pub(crate) fn scaled_largest_eigenvalue(m: &Mat) -> f64 {
    if m.iter().any(|v| !v.is_finite()) {
        return f64::INFINITY;
    }
    if m.diagonal().iter().any(|d| *d >= 0.0) {
        return 1.0;
    }
    let scale = Mat::from_diagonal(&m.diagonal().map(|d| 1.0 / (-d).sqrt()));
    largest_eigenvalue(&(&scale * m * &scale))
}

/// Returns the least eigenvalue of a nominally positive matrix, scaled as in [`scaled_largest_eigenvalue`].
pub(crate) fn scaled_least_eigenvalue(m: &Mat) -> f64 {
    -scaled_largest_eigenvalue(&-m)
}

/// An eigenvalue that cannot be computed: no comparison with it succeeds.
const UNKNOWN: Complex<f64> = Complex::new(f64::NAN, f64::NAN);

/// Returns the eigenvalues of a square matrix, sorted by real and then imaginary part.
///
/// All NaN if the matrix has a NaN or the QR iteration fails: no comparison then succeeds.
pub fn eigenvalues(a: &Mat) -> Vec<Complex<f64>> {
    if a.is_empty() {
        return vec![];
    }
    let mut values = quick_eigenvalues(a)
        .or_else(|| to_faer(a)?.eigenvalues_from_real().ok())
        .unwrap_or_else(|| vec![UNKNOWN; a.nrows()]);
    values.sort_by(|p, q| p.re.total_cmp(&q.re).then(p.im.total_cmp(&q.im)));
    values
}

/// Returns the eigenvalues by nalgebra, in half of faer's time or less for up to about 80 rows; `None` if an entry is
/// not finite or the iteration fails, as for a cyclic permutation: it has no exceptional shifts. Of a pair of equal
/// real eigenvalues it may take the square root of a number that rounding made negative.
fn quick_eigenvalues(a: &Mat) -> Option<Vec<Complex<f64>>> {
    if !a.iter().all(|v| v.is_finite()) {
        return None;
    }
    let schur = Schur::try_new(a.clone(), f64::EPSILON, MOST_SWEEPS * a.nrows())?;
    let values = schur.complex_eigenvalues();
    values.iter().all(|value| value.is_finite()).then(|| values.iter().copied().collect())
}

/// The largest number of QR sweeps per row; two or three are usual.
const MOST_SWEEPS: usize = 20;

/// Returns a basis of the invariant subspace of the eigenvalues with positive real parts, as columns; `None` unless
/// these are half of all eigenvalues.
pub(crate) fn growing_basis(a: &Mat) -> Option<Mat> {
    let n = a.nrows();
    let decomposition = to_faer(a)?.eigen_from_real().ok()?;
    let (vectors, values) = (decomposition.U(), decomposition.S().column_vector());
    let mut basis: Vec<DVector<f64>> = vec![];
    // The real and the imaginary part of one vector of each complex pair.
    for k in (0..n).filter(|k| values[*k].re > 0.0 && values[*k].im >= 0.0) {
        basis.push(DVector::from_fn(n, |i, _| vectors[(i, k)].re));
        if values[k].im > 0.0 {
            basis.push(DVector::from_fn(n, |i, _| vectors[(i, k)].im));
        }
    }
    (2 * basis.len() == n).then(|| Mat::from_fn(n, n / 2, |i, j| basis[j][i]))
}

/// Returns the largest real part of the eigenvalues (minus infinity for an empty matrix).
pub fn spectral_abscissa(a: &Mat) -> f64 {
    largest(f64::NEG_INFINITY, eigenvalues(a).into_iter().map(|v| v.re))
}

/// Returns the largest of some values and of `least`; NaN if one of them is, which `f64::max` would ignore.
pub fn largest(least: f64, values: impl IntoIterator<Item = f64>) -> f64 {
    values.into_iter().fold(least, |most, v| if most.is_nan() || v.is_nan() { f64::NAN } else { most.max(v) })
}

/// Returns the solution of `A X = B` by LU with partial pivoting; `None` if A is singular. Empty systems are allowed. A
/// is n x n, B n x k.
pub fn solve(a: &Mat, b: &Mat) -> Option<Mat> {
    if a.is_empty() { Some(b.clone()) } else { a.clone().lu().solve(b) }
}

/// The size of a tile of a large matrix that fits into the cache of a core together with its mirror image.
const TILE: usize = 32;

/// A factorised symmetric positive definite matrix, possibly badly conditioned.
pub(crate) struct Definite {
    /// `D A D` with a unit diagonal, regularised.
    matrix: Mat,
    /// The diagonal of D.
    scale: Vec<f64>,
    factor: faer::linalg::solvers::Llt<f64>,
}

impl Definite {
    /// Factorises the matrix with the given lower triangle, its diagonal raised as little as necessary; `None` if a
    /// relative 1e-8 is not enough.
    pub(crate) fn new(lower: Mat) -> Option<Self> {
        let n = lower.nrows();
        if lower.iter().any(|v| !v.is_finite()) || lower.diagonal().iter().any(|d| *d <= 0.0) {
            return None;
        }
        let scale: Vec<f64> = lower.diagonal().iter().map(|d| 1.0 / d.sqrt()).collect();
        let mut matrix = lower;
        // Tiles: the upper triangle is written across its columns, and a large matrix does not fit into the cache.
        for tile in (0..n).step_by(TILE) {
            for below in (tile..n).step_by(TILE) {
                for j in tile..n.min(tile + TILE) {
                    for i in below.max(j)..n.min(below + TILE) {
                        matrix[(i, j)] *= scale[i] * scale[j];
                        matrix[(j, i)] = matrix[(i, j)];
                    }
                }
            }
        }
        on_one_thread();
        for raise in [0.0, 1e-15, 1e-14, 1e-13, 1e-12, 1e-11, 1e-10, 1e-9, 1e-8] {
            matrix.fill_diagonal(1.0 + raise);
            if let Ok(factor) =
                faer::MatRef::from_column_major_slice(matrix.as_slice(), n, n).llt(Side::Lower)
            {
                return Some(Self { matrix, scale, factor });
            }
        }
        None
    }

    /// Returns the solution of `A x = b` as accurately as possible.
    pub(crate) fn solve(&self, b: &[f64]) -> Vec<f64> {
        self.solve_to(b, 1e-14)
    }

    /// Returns the solution of `A x = b` to a relative residual, by conjugate gradients with the factor as
    /// preconditioner: two steps if the factor is good.
    pub(crate) fn solve_to(&self, b: &[f64], residual: f64) -> Vec<f64> {
        use faer::linalg::solvers::Solve;
        let n = b.len();
        let precondition = |v: &DVector<f64>| {
            let solved = self.factor.solve(faer::Mat::from_fn(n, 1, |i, _| v[i]));
            DVector::from_fn(n, |i, _| solved[(i, 0)])
        };
        let mut x = DVector::zeros(n);
        let mut left = DVector::from_fn(n, |i, _| b[i] * self.scale[i]);
        let (mut best, mut least) = (x.clone(), left.norm());
        let enough = residual * least;
        let mut push = precondition(&left);
        let mut product = left.dot(&push);
        for _ in 0..MOST_REFINEMENTS {
            let moved = &self.matrix * &push;
            let curvature = push.dot(&moved);
            if curvature <= 0.0 || !curvature.is_finite() {
                break;
            }
            let length = product / curvature;
            x += &push * length;
            left -= moved * length;
            if left.norm() < least {
                (best, least) = (x.clone(), left.norm());
            }
            if least <= enough {
                break;
            }
            let conditioned = precondition(&left);
            let next = left.dot(&conditioned);
            push = conditioned + push * (next / product);
            product = next;
        }
        best.iter().zip(&self.scale).map(|(x, s)| x * s).collect()
    }
}

/// The largest number of conjugate gradient steps: more would only reduce rounding.
const MOST_REFINEMENTS: usize = 3;

/// Returns `f(A) = V f(Lambda) V'` for a symmetric matrix.
pub fn symmetric_function(a: &Mat, f: impl Fn(f64) -> f64) -> Mat {
    if a.is_empty() {
        return a.clone();
    }
    let decomposition = to_faer(&symmetric_part(a)).and_then(|a| a.self_adjoint_eigen(Side::Lower).ok());
    let Some(decomposition) = decomposition else { return Mat::from_element(a.nrows(), a.ncols(), f64::NAN) };
    let vectors = from_faer(decomposition.U());
    let values = decomposition.S().column_vector().iter().map(|v| f(*v));
    &vectors * diagonal(values) * vectors.transpose()
}

/// Returns an orthonormal basis of the kernel of A, as columns.
///
/// Singular values below `1e-10` of the largest are taken as zero. n x k for an m x n matrix with a k-dimensional
/// kernel.
pub fn kernel(a: &Mat) -> Mat {
    let Svd { s, v, .. } = svd(a);
    let largest = s.first().copied().unwrap_or(0.0);
    let rank = s.iter().filter(|value| **value > 1e-10 * largest).count();
    v.columns(rank, a.ncols() - rank).into_owned()
}

/// Returns `A = L R` with as few columns in L as `tolerance` allows: singular values up to it are dropped. L is m x k,
/// R k x n.
pub fn rank_factors(a: &Mat, tolerance: f64) -> (Mat, Mat) {
    let Svd { u, s, v } = svd(a);
    let rank = s.iter().filter(|value| **value > tolerance).count();
    let (mut left, mut right) = (u.columns(0, rank).into_owned(), v.columns(0, rank).transpose());
    for (k, value) in s.iter().take(rank).enumerate() {
        // The singular value is split between the factors, so that both are of one size.
        left.column_mut(k).scale_mut(value.sqrt());
        right.row_mut(k).scale_mut(value.sqrt());
    }
    (left, right)
}

/// Returns the largest singular value (0 for an empty matrix).
pub fn largest_singular_value(a: &Mat) -> f64 {
    svd(a).s.first().copied().unwrap_or(0.0)
}

/// Returns the largest singular value of a complex matrix (0 for an empty matrix).
pub fn largest_complex_singular_value(a: &DMatrix<Complex<f64>>) -> f64 {
    complex_singular_values(a).first().copied().unwrap_or(0.0)
}

/// Returns the singular values of a complex matrix, descending; NaN if the matrix has a NaN.
pub fn complex_singular_values(a: &DMatrix<Complex<f64>>) -> Vec<f64> {
    let least = a.nrows().min(a.ncols());
    if least == 0 {
        return vec![];
    }
    to_faer(a).and_then(|a| a.singular_values().ok()).unwrap_or_else(|| vec![f64::NAN; least])
}

/// Returns the eigenvalues of a square complex matrix; all NaN if it has a NaN or the iteration fails.
pub fn complex_eigenvalues(a: &DMatrix<Complex<f64>>) -> Vec<Complex<f64>> {
    if a.is_empty() {
        return vec![];
    }
    to_faer(a).and_then(|a| a.eigenvalues().ok()).unwrap_or_else(|| vec![UNKNOWN; a.nrows()])
}

/// The singular value decomposition of a complex matrix, values descending.
pub(crate) struct ComplexSvd {
    /// Left singular vectors as columns.
    pub(crate) u: DMatrix<Complex<f64>>,
    pub(crate) s: Vec<f64>,
    /// Right singular vectors as columns.
    pub(crate) v: DMatrix<Complex<f64>>,
}

/// Returns the singular value decomposition of a complex matrix; `None` if it is empty or an entry is not finite.
pub(crate) fn complex_svd(a: &DMatrix<Complex<f64>>) -> Option<ComplexSvd> {
    if a.is_empty() {
        return None;
    }
    let decomposition = to_faer(a)?.svd().ok()?;
    let s = decomposition.S().column_vector().iter().map(|v| v.re).collect();
    Some(ComplexSvd { u: from_faer(decomposition.U()), s, v: from_faer(decomposition.V()) })
}

/// Eigenvalues of a square matrix with its right and left eigenvectors.
pub(crate) struct Modes {
    pub(crate) values: Vec<Complex<f64>>,
    /// Right eigenvectors as columns.
    pub(crate) right: DMatrix<Complex<f64>>,
    /// Left eigenvectors as rows, the inverse of the right ones.
    pub(crate) left: DMatrix<Complex<f64>>,
}

/// Returns eigenvalues and eigenvectors of a square matrix; `None` if it is not diagonalisable or not finite.
pub(crate) fn eigenvectors(a: &Mat) -> Option<Modes> {
    if a.is_empty() {
        let none = || DMatrix::zeros(0, 0);
        return Some(Modes { values: vec![], right: none(), left: none() });
    }
    let decomposition = to_faer(a)?.eigen_from_real().ok()?;
    let values = decomposition.S().column_vector().iter().copied().collect();
    let right = from_faer(decomposition.U());
    let left = right.clone().try_inverse()?;
    Some(Modes { values, right, left })
}

/// Returns the left and right singular vectors of the largest singular value.
pub fn largest_singular_vectors(a: &DMatrix<Complex<f64>>) -> Option<(ComplexVector, ComplexVector)> {
    singular_vectors(a, 0)
}

/// Returns the left and right singular vectors of the least singular value of a square complex matrix.
pub fn least_singular_vectors(a: &DMatrix<Complex<f64>>) -> Option<(ComplexVector, ComplexVector)> {
    singular_vectors(a, a.nrows().checked_sub(1)?)
}

/// Returns the left and right singular vectors of the singular value of index `number`, from the largest.
fn singular_vectors(a: &DMatrix<Complex<f64>>, number: usize) -> Option<(ComplexVector, ComplexVector)> {
    let ComplexSvd { u, v, .. } = complex_svd(a)?;
    Some((u.column(number).into_owned(), v.column(number).into_owned()))
}

/// Returns the eigenvalues of a Hermitian matrix, ascending; NaN if the matrix has a NaN.
pub fn hermitian_eigenvalues(a: &DMatrix<Complex<f64>>) -> Vec<f64> {
    if a.nrows() == 1 { vec![a[(0, 0)].re] } else { ascending_eigenvalues(a) }
}

/// Returns the eigenvectors of a Hermitian matrix as columns, in ascending order of the eigenvalues; `None` if an entry
/// is not finite.
pub(crate) fn hermitian_eigenvectors(a: &DMatrix<Complex<f64>>) -> Option<DMatrix<Complex<f64>>> {
    Some(from_faer(to_faer(a)?.self_adjoint_eigen(Side::Lower).ok()?.U()))
}

/// Returns the diagonal matrix with the given entries.
pub(crate) fn diagonal(values: impl IntoIterator<Item = f64>) -> Mat {
    Mat::from_diagonal(&DVector::from_vec(values.into_iter().collect()))
}

/// Returns column `index` of the identity, n x 1.
pub(crate) fn unit(n: usize, index: usize) -> Mat {
    Mat::from_fn(n, 1, |i, _| if i == index { 1.0 } else { 0.0 })
}

/// Returns `A^1/2` and `A^-1/2` of a symmetric positive definite matrix.
pub(crate) fn roots(a: &Mat) -> (Mat, Mat) {
    (symmetric_function(a, f64::sqrt), symmetric_function(a, |v| 1.0 / v.sqrt()))
}

/// Converts the matrix to a list of rows, as in the files.
pub fn to_rows(a: &Mat) -> Vec<Vec<f64>> {
    a.row_iter().map(|row| row.iter().copied().collect()).collect()
}

/// Builds a matrix with `cols` columns from a list of rows; `None` if a row has another length.
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
    fn kernel_of_a_matrix_without_rows_is_the_full_space() {
        assert_eq!(kernel(&Mat::zeros(0, 3)), Mat::identity(3, 3));
    }

    #[test]
    fn rank_factors_multiply_to_the_matrix() {
        let a = dmatrix![1.0, 2.0; 2.0, 4.0; 3.0, 6.0];
        let (l, r) = rank_factors(&a, 1e-12);
        assert_eq!(l.ncols(), 1);
        assert!((l * r - a).amax() < 1e-12);
    }

    /// A cyclic permutation, on which the quick iteration fails for an even n, has the roots of unity as eigenvalues;
    /// a matrix that is not finite has none.
    #[test]
    fn a_cyclic_permutation_has_the_roots_of_unity() {
        for n in 1..20 {
            let cyclic = Mat::from_fn(n, n, |i, j| if j == (i + 1) % n { 1.0 } else { 0.0 });
            assert!(n % 2 == 1 || n < 4 || quick_eigenvalues(&cyclic).is_none(), "{n}");
            let found = eigenvalues(&cyclic);
            for k in 0..n {
                let root = Complex::from_polar(1.0, std::f64::consts::TAU * k as f64 / n as f64);
                assert!(found.iter().any(|value| (value - root).norm() < 1e-12), "{n}: {found:?}");
            }
        }
        assert!(eigenvalues(&dmatrix![1.0, f64::NAN; 0.0, 1.0]).iter().all(|value| value.re.is_nan()));
        assert!(symmetric_eigenvalues(&dmatrix![f64::INFINITY]).iter().all(|value| value.is_nan()));
    }

    /// The second difference has the eigenvalues 2 - 2 cos(k pi/(n + 1)); it is transformed by a reflection, and
    /// shifted.
    #[test]
    fn the_quick_least_eigenvalue_is_the_least() {
        for (n, shift) in [(1, -3.0), (2, -1.0), (7, 0.0), (40, -2.5), (40, 1e6)] {
            let second =
                Mat::from_fn(n, n, |i, j| if i == j { 2.0 + shift } else { -f64::from(i.abs_diff(j) == 1) });
            let v = DVector::from_fn(n, |i, _| (1.0 + i as f64).sin());
            let turn = Mat::identity(n, n) - &v * v.transpose() * (2.0 / v.norm_squared());
            let least = 2.0 - 2.0 * (std::f64::consts::PI / (n as f64 + 1.0)).cos() + shift;
            let found = quick_least_eigenvalue(symmetric_part(&(&turn * second * &turn)));
            let rounding = 1e-14 * (4.0 + shift.abs()) * n as f64;
            assert!(
                found <= least + rounding && found >= least - 1e-9 * least.abs() - rounding,
                "{found} {least}"
            );
        }
        assert_eq!(quick_least_eigenvalue(Mat::zeros(0, 0)), f64::INFINITY);
        assert_eq!(quick_least_eigenvalue(Mat::zeros(3, 3)), 0.0);
        assert!(quick_least_eigenvalue(Mat::from_element(1, 1, f64::NAN)).is_nan());
    }

    #[test]
    fn empty_blocks_are_allowed() {
        let a = Mat::identity(2, 2);
        let none = Mat::zeros(2, 0);
        assert_eq!(block(&[&[&a, &none]]), a);
        assert_eq!(diagonal_blocks(&[&a, &Mat::zeros(0, 1)]).shape(), (2, 3));
    }
}
