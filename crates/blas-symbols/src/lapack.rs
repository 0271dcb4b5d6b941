//! Factorisations under their LAPACK names (Anderson et al., LAPACK Users' Guide, 3rd ed., 1999).

use crate::view::{is, read, write};
use faer::linalg::solvers::Solve;
use faer::linalg::triangular_solve::{solve_lower_triangular_in_place, solve_upper_triangular_in_place};
use faer::reborrow::{Reborrow, ReborrowMut};
use faer::{Mat, MatRef, Par, Side};
use std::ffi::{c_char, c_int};

/// Returns the triangle selected by an option letter.
unsafe fn side(uplo: *const c_char) -> Side {
    // SAFETY: the caller passes a Fortran option letter.
    if unsafe { is(uplo, b'U') } { Side::Upper } else { Side::Lower }
}

/// Copies a faer matrix into a Fortran array.
unsafe fn store(from: MatRef<'_, f64>, to: *mut f64, ld: *const c_int) {
    // SAFETY: the caller's array has the shape of `from` at leading dimension `ld`.
    unsafe { write(to, from.nrows() as c_int, from.ncols() as c_int, ld) }.copy_from(from);
}

/// Computes the Cholesky factor of a positive definite matrix, in place: `A = L L'` (lower) or `A = U' U` (upper).
///
/// `info` is the order of the first leading minor that is not positive, or 0.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dpotrf_(
    uplo: *const c_char,
    n: *const c_int,
    a: *mut f64,
    lda: *const c_int,
    info: *mut c_int,
) {
    // SAFETY: LAPACK's contract on the arguments.
    unsafe {
        let mut a = write(a, *n, *n, lda);
        match a.rb().llt(side(uplo)) {
            Ok(factor) => {
                let l = factor.L();
                for j in 0..l.ncols() {
                    for i in j..l.nrows() {
                        let place = if is(uplo, b'U') { (j, i) } else { (i, j) };
                        a[place] = l[(i, j)];
                    }
                }
                *info = 0;
            }
            Err(faer::linalg::solvers::LltError::NonPositivePivot { index }) => *info = index as c_int + 1,
        }
    }
}

/// Solves `A X = B` with the factor of [`dpotrf_`]; X overwrites B.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dpotrs_(
    uplo: *const c_char,
    n: *const c_int,
    nrhs: *const c_int,
    a: *const f64,
    lda: *const c_int,
    b: *mut f64,
    ldb: *const c_int,
    info: *mut c_int,
) {
    // SAFETY: LAPACK's contract on the arguments.
    unsafe {
        let stored = read(a, *n, *n, lda);
        let l = if is(uplo, b'U') { stored.transpose() } else { stored };
        let mut b = write(b, *n, *nrhs, ldb);
        solve_lower_triangular_in_place(l, b.rb_mut(), Par::Seq);
        solve_upper_triangular_in_place(l.transpose(), b, Par::Seq);
        *info = 0;
    }
}

/// Solves `A X = B` by LU with partial pivoting; X overwrites B.
///
/// A is left unchanged and `ipiv` is filled with the identity: the factors are not returned. `info` is
/// the order of the first pivot that is exactly zero, or 0.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dgesv_(
    n: *const c_int,
    nrhs: *const c_int,
    a: *mut f64,
    lda: *const c_int,
    ipiv: *mut c_int,
    b: *mut f64,
    ldb: *const c_int,
    info: *mut c_int,
) {
    // SAFETY: LAPACK's contract on the arguments.
    unsafe {
        let lu = read(a, *n, *n, lda).partial_piv_lu();
        for i in 0..*n as usize {
            *ipiv.add(i) = i as c_int + 1;
            if lu.U()[(i, i)] == 0.0 {
                *info = i as c_int + 1;
                return;
            }
        }
        lu.solve_in_place(write(b, *n, *nrhs, ldb));
        *info = 0;
    }
}

/// Writes the singular value decomposition `A = U diag(s) Vt`, in thin form or the singular values alone.
unsafe fn singular_values(
    a: MatRef<'_, f64>,
    vectors: bool,
    s: *mut f64,
    (u, ldu): (*mut f64, *const c_int),
    (vt, ldvt): (*mut f64, *const c_int),
) -> c_int {
    let Ok(svd) = a.thin_svd() else { return 1 };
    for (i, value) in svd.S().column_vector().iter().enumerate() {
        // SAFETY: s holds min(m, n) numbers.
        unsafe { *s.add(i) = *value };
    }
    if vectors {
        // SAFETY: LAPACK's contract on the arrays of the thin form.
        unsafe {
            store(svd.U(), u, ldu);
            store(svd.V().transpose(), vt, ldvt);
        }
    }
    0
}

/// Answers a workspace query (`lwork = -1`); returns `true` if it was one.
unsafe fn answered_query(work: *mut f64, lwork: *const c_int) -> bool {
    // SAFETY: work holds at least one number.
    unsafe {
        let query = *lwork == -1;
        if query {
            *work = 1.0;
        }
        query
    }
}

/// Computes the thin singular value decomposition (`jobz` = 'S', or 'A' for a square matrix), or only the values ('N').
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dgesdd_(
    jobz: *const c_char,
    m: *const c_int,
    n: *const c_int,
    a: *mut f64,
    lda: *const c_int,
    s: *mut f64,
    u: *mut f64,
    ldu: *const c_int,
    vt: *mut f64,
    ldvt: *const c_int,
    work: *mut f64,
    lwork: *const c_int,
    _iwork: *mut c_int,
    info: *mut c_int,
) {
    // SAFETY: LAPACK's contract on the arguments.
    unsafe {
        *info = 0;
        let vectors = is(jobz, b'S') || (is(jobz, b'A') && *m == *n);
        if !vectors && !is(jobz, b'N') {
            *info = -1;
        } else if !answered_query(work, lwork) {
            *info = singular_values(read(a, *m, *n, lda), vectors, s, (u, ldu), (vt, ldvt));
        }
    }
}

/// Computes the same as [`dgesdd_`], with a job letter for each side; both must be the same.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dgesvd_(
    jobu: *const c_char,
    jobvt: *const c_char,
    m: *const c_int,
    n: *const c_int,
    a: *mut f64,
    lda: *const c_int,
    s: *mut f64,
    u: *mut f64,
    ldu: *const c_int,
    vt: *mut f64,
    ldvt: *const c_int,
    work: *mut f64,
    lwork: *const c_int,
    info: *mut c_int,
) {
    // SAFETY: LAPACK's contract on the arguments; the integer workspace is not read.
    unsafe {
        if *jobu != *jobvt {
            *info = -2;
            return;
        }
        dgesdd_(jobu, m, n, a, lda, s, u, ldu, vt, ldvt, work, lwork, std::ptr::null_mut(), info);
    }
}

/// Computes all eigenvalues of a symmetric matrix, ascending, and its eigenvectors if `jobz` = 'V'.
///
/// Only `range` = 'A' is supported.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dsyevr_(
    jobz: *const c_char,
    range: *const c_char,
    uplo: *const c_char,
    n: *const c_int,
    a: *mut f64,
    lda: *const c_int,
    _vl: *const f64,
    _vu: *const f64,
    _il: *const c_int,
    _iu: *const c_int,
    _abstol: *const f64,
    m: *mut c_int,
    w: *mut f64,
    z: *mut f64,
    ldz: *const c_int,
    _isuppz: *mut c_int,
    work: *mut f64,
    lwork: *const c_int,
    iwork: *mut c_int,
    _liwork: *const c_int,
    info: *mut c_int,
) {
    // SAFETY: LAPACK's contract on the arguments.
    unsafe {
        *info = 0;
        if !is(range, b'A') {
            *info = -2;
            return;
        }
        if answered_query(work, lwork) {
            *iwork = 1;
            return;
        }
        let a = read(a, *n, *n, lda);
        let decomposed: Option<(Vec<f64>, Option<Mat<f64>>)> = if is(jobz, b'V') {
            a.self_adjoint_eigen(side(uplo))
                .ok()
                .map(|e| (e.S().column_vector().iter().copied().collect(), Some(e.U().to_owned())))
        } else {
            a.self_adjoint_eigenvalues(side(uplo)).ok().map(|values| (values, None))
        };
        let Some((values, vectors)) = decomposed else {
            *info = 1;
            return;
        };
        for (i, value) in values.iter().enumerate() {
            *w.add(i) = *value;
        }
        *m = *n;
        if let Some(vectors) = vectors {
            store(vectors.as_ref(), z, ldz);
        }
    }
}
