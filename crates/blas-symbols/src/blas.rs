//! Matrix products under their BLAS names (Dongarra et al., ACM TOMS 16(1), 1990).

use crate::view::{is, read, write};
use faer::linalg::matmul::matmul;
use faer::linalg::matmul::triangular::{BlockStructure, matmul as triangular_matmul};
use faer::{Accum, MatMut, MatRef, Par, reborrow::ReborrowMut};
use std::ffi::{c_char, c_int};

/// Computes `C <- beta C`; a beta of zero also clears NaN, as BLAS requires.
fn scale(mut c: MatMut<'_, f64>, beta: f64) {
    if beta == 0.0 {
        c.fill(0.0);
    } else if beta != 1.0 {
        faer::zip!(&mut c).for_each(|faer::unzip!(c)| *c *= beta);
    }
}

/// Returns `op(A)` with the shape `rows x cols`.
unsafe fn operand<'a>(
    trans: *const c_char,
    a: *const f64,
    rows: c_int,
    cols: c_int,
    lda: *const c_int,
) -> MatRef<'a, f64> {
    // SAFETY: the caller passes a Fortran option letter and array.
    unsafe { if is(trans, b'N') { read(a, rows, cols, lda) } else { read(a, cols, rows, lda).transpose() } }
}

/// Computes `C = alpha op(A) op(B) + beta C`, op the identity or the transpose.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dgemm_(
    transa: *const c_char,
    transb: *const c_char,
    m: *const c_int,
    n: *const c_int,
    k: *const c_int,
    alpha: *const f64,
    a: *const f64,
    lda: *const c_int,
    b: *const f64,
    ldb: *const c_int,
    beta: *const f64,
    c: *mut f64,
    ldc: *const c_int,
) {
    // SAFETY: BLAS's contract on the arguments.
    unsafe {
        let (left, right) = (operand(transa, a, *m, *k, lda), operand(transb, b, *k, *n, ldb));
        let mut out = write(c, *m, *n, ldc);
        scale(out.rb_mut(), *beta);
        matmul(out, Accum::Add, left, right, *alpha, Par::Seq);
    }
}

/// Computes `y <- beta y + alpha sum over terms`, with strides; a negative stride runs backwards, as in BLAS.
unsafe fn strided_sum(
    length: usize,
    inner: usize,
    term: impl Fn(usize, usize) -> f64,
    alpha: f64,
    x: (*const f64, c_int),
    beta: f64,
    y: (*mut f64, c_int),
) {
    let place = |i: usize, stride: c_int, n: usize| -> isize {
        let first = if stride < 0 { -(stride as isize) * (n as isize - 1) } else { 0 };
        first + i as isize * stride as isize
    };
    for i in 0..length {
        let mut sum = 0.0;
        for j in 0..inner {
            // SAFETY: the caller's x holds `inner` numbers at its stride.
            sum += term(i, j) * unsafe { *x.0.offset(place(j, x.1, inner)) };
        }
        // SAFETY: the caller's y holds `length` numbers at its stride.
        let target = unsafe { &mut *y.0.offset(place(i, y.1, length)) };
        *target = alpha * sum + if beta == 0.0 { 0.0 } else { beta * *target };
    }
}

/// Computes `y = alpha op(A) x + beta y`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dgemv_(
    trans: *const c_char,
    m: *const c_int,
    n: *const c_int,
    alpha: *const f64,
    a: *const f64,
    lda: *const c_int,
    x: *const f64,
    incx: *const c_int,
    beta: *const f64,
    y: *mut f64,
    incy: *const c_int,
) {
    // SAFETY: BLAS's contract on the arguments.
    unsafe {
        let whole = read(a, *m, *n, lda);
        let a = if is(trans, b'N') { whole } else { whole.transpose() };
        strided_sum(a.nrows(), a.ncols(), |i, j| a[(i, j)], *alpha, (x, *incx), *beta, (y, *incy));
    }
}

/// Computes `y = alpha A x + beta y` for a symmetric A, of which one triangle is read.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dsymv_(
    uplo: *const c_char,
    n: *const c_int,
    alpha: *const f64,
    a: *const f64,
    lda: *const c_int,
    x: *const f64,
    incx: *const c_int,
    beta: *const f64,
    y: *mut f64,
    incy: *const c_int,
) {
    // SAFETY: BLAS's contract on the arguments.
    unsafe {
        let a = read(a, *n, *n, lda);
        let upper = is(uplo, b'U');
        let entry = |i: usize, j: usize| {
            let (small, large) = (i.min(j), i.max(j));
            if upper { a[(small, large)] } else { a[(large, small)] }
        };
        let n = *n as usize;
        strided_sum(n, n, entry, *alpha, (x, *incx), *beta, (y, *incy));
    }
}

/// Adds `alpha L R'` to one triangle of C.
fn add_to_triangle(
    c: MatMut<'_, f64>,
    upper: bool,
    left: MatRef<'_, f64>,
    right: MatRef<'_, f64>,
    alpha: f64,
) {
    let triangle = if upper { BlockStructure::TriangularUpper } else { BlockStructure::TriangularLower };
    triangular_matmul(
        c,
        triangle,
        Accum::Add,
        left,
        BlockStructure::Rectangular,
        right.transpose(),
        BlockStructure::Rectangular,
        alpha,
        Par::Seq,
    );
}

/// Computes `C <- beta C` on one triangle only.
fn scale_triangle(mut c: MatMut<'_, f64>, upper: bool, beta: f64) {
    for j in 0..c.ncols() {
        let rows = if upper { 0..j + 1 } else { j..c.nrows() };
        for i in rows {
            c[(i, j)] = if beta == 0.0 { 0.0 } else { beta * c[(i, j)] };
        }
    }
}

/// Computes `C = alpha op(A) op(A)' + beta C`, one triangle of C.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dsyrk_(
    uplo: *const c_char,
    trans: *const c_char,
    n: *const c_int,
    k: *const c_int,
    alpha: *const f64,
    a: *const f64,
    lda: *const c_int,
    beta: *const f64,
    c: *mut f64,
    ldc: *const c_int,
) {
    // SAFETY: BLAS's contract on the arguments.
    unsafe {
        let a = operand(trans, a, *n, *k, lda);
        let mut c = write(c, *n, *n, ldc);
        scale_triangle(c.rb_mut(), is(uplo, b'U'), *beta);
        add_to_triangle(c, is(uplo, b'U'), a, a, *alpha);
    }
}

/// Computes `C = alpha (op(A) op(B)' + op(B) op(A)') + beta C`, one triangle of C.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dsyr2k_(
    uplo: *const c_char,
    trans: *const c_char,
    n: *const c_int,
    k: *const c_int,
    alpha: *const f64,
    a: *const f64,
    lda: *const c_int,
    b: *const f64,
    ldb: *const c_int,
    beta: *const f64,
    c: *mut f64,
    ldc: *const c_int,
) {
    // SAFETY: BLAS's contract on the arguments.
    unsafe {
        let (a, b) = (operand(trans, a, *n, *k, lda), operand(trans, b, *n, *k, ldb));
        let mut c = write(c, *n, *n, ldc);
        let upper = is(uplo, b'U');
        scale_triangle(c.rb_mut(), upper, *beta);
        add_to_triangle(c.rb_mut(), upper, a, b, *alpha);
        add_to_triangle(c, upper, b, a, *alpha);
    }
}
