//! Comparison of each symbol with its definition, on random matrices, with the calls of clarabel.
#![cfg(not(feature = "openblas"))]
#![allow(unsafe_code, clippy::unwrap_used, clippy::panic)]

use faer::Mat;
use proptest::prelude::*;
use squid_blas_symbols::*;
use std::ffi::{c_char, c_int};

fn letter(l: u8) -> c_char {
    l as c_char
}

/// Returns the column-major storage of a matrix.
fn flat(a: &Mat<f64>) -> Vec<f64> {
    (0..a.ncols()).flat_map(|j| (0..a.nrows()).map(move |i| a[(i, j)])).collect()
}

fn unflat(v: &[f64], rows: usize, cols: usize) -> Mat<f64> {
    Mat::from_fn(rows, cols, |i, j| v[i + j * rows])
}

fn close(a: &Mat<f64>, b: &Mat<f64>) -> bool {
    (a - b).norm_max() < 1e-10
}

prop_compose! {
    fn matrix(rows: usize, cols: usize)(v in prop::collection::vec(-2.0..2.0f64, rows * cols)) -> Mat<f64> {
        unflat(&v, rows, cols)
    }
}

fn shapes() -> impl Strategy<Value = (Mat<f64>, Mat<f64>, Mat<f64>)> {
    (1..9usize, 1..9usize, 1..9usize).prop_flat_map(|(m, n, k)| (matrix(m, k), matrix(k, n), matrix(m, n)))
}

fn square() -> impl Strategy<Value = (Mat<f64>, Mat<f64>)> {
    (1..12usize).prop_flat_map(|n| (matrix(n, n), matrix(n, n)))
}

proptest! {
    #[test]
    fn dgemm((a, b, c) in shapes(), ta: bool, tb: bool, alpha in -2.0..2.0f64, beta in -2.0..2.0f64) {
        let (m, k, n) = (a.nrows() as c_int, a.ncols() as c_int, b.ncols() as c_int);
        let stored_a = if ta { flat(&a.transpose().to_owned()) } else { flat(&a) };
        let stored_b = if tb { flat(&b.transpose().to_owned()) } else { flat(&b) };
        let (lda, ldb) = (if ta { k } else { m }, if tb { n } else { k });
        let mut out = flat(&c);
        let (la, lb) = (letter(if ta { b'T' } else { b'N' }), letter(if tb { b'T' } else { b'N' }));
        unsafe {
            dgemm_(&la, &lb, &m, &n, &k, &alpha, stored_a.as_ptr(), &lda, stored_b.as_ptr(), &ldb, &beta,
                   out.as_mut_ptr(), &m);
        }
        let expected = faer::Scale(alpha) * &a * &b + faer::Scale(beta) * &c;
        prop_assert!(close(&unflat(&out, m as usize, n as usize), &expected));
    }

    #[test]
    fn dgemv_and_dsymv((a, b) in square(), alpha in -2.0..2.0f64, beta in -2.0..2.0f64, upper: bool) {
        let n = a.nrows() as c_int;
        let symmetric = &a + a.transpose();
        let x: Vec<f64> = (0..n as usize).map(|i| b[(i, 0)]).collect();
        let y: Vec<f64> = (0..n as usize).map(|i| b[(0, i)]).collect();
        let column = |v: &[f64]| unflat(v, n as usize, 1);
        let (mut general, mut from_triangle) = (y.clone(), y.clone());
        let (no, triangle) = (letter(b'T'), letter(if upper { b'U' } else { b'L' }));
        // The other triangle is poisoned: it must not be read.
        let mut half = symmetric.clone();
        for j in 0..n as usize { for i in 0..n as usize {
            if (upper && i > j) || (!upper && i < j) { half[(i, j)] = f64::NAN; }
        } }
        unsafe {
            dgemv_(&no, &n, &n, &alpha, flat(&a).as_ptr(), &n, x.as_ptr(), &1, &beta, general.as_mut_ptr(), &1);
            dsymv_(&triangle, &n, &alpha, flat(&half).as_ptr(), &n, x.as_ptr(), &1, &beta,
                   from_triangle.as_mut_ptr(), &1);
        }
        let expected = faer::Scale(alpha) * a.transpose() * column(&x) + faer::Scale(beta) * column(&y);
        prop_assert!(close(&column(&general), &expected));
        let expected = faer::Scale(alpha) * &symmetric * column(&x) + faer::Scale(beta) * column(&y);
        prop_assert!(close(&column(&from_triangle), &expected));
    }

    #[test]
    fn rank_updates_touch_one_triangle((a, b) in square(), upper: bool, transposed: bool, alpha in -2.0..2.0f64) {
        let n = a.nrows() as c_int;
        let (triangle, trans) = (letter(if upper { b'U' } else { b'L' }), letter(if transposed { b'T' } else { b'N' }));
        let (mut k, mut k2) = (vec![7.0; flat(&a).len()], vec![7.0; flat(&a).len()]);
        unsafe {
            dsyrk_(&triangle, &trans, &n, &n, &alpha, flat(&a).as_ptr(), &n, &0.0, k.as_mut_ptr(), &n);
            dsyr2k_(&triangle, &trans, &n, &n, &alpha, flat(&a).as_ptr(), &n, flat(&b).as_ptr(), &n, &2.0,
                    k2.as_mut_ptr(), &n);
        }
        let (k, k2) = (unflat(&k, n as usize, n as usize), unflat(&k2, n as usize, n as usize));
        let (l, r) = if transposed { (a.transpose().to_owned(), b.transpose().to_owned()) } else { (a, b) };
        let syrk = faer::Scale(alpha) * &l * l.transpose();
        let syr2k = faer::Scale(alpha) * (&l * r.transpose() + &r * l.transpose());
        for j in 0..n as usize { for i in 0..n as usize {
            if (upper && i <= j) || (!upper && i >= j) {
                prop_assert!((k[(i, j)] - syrk[(i, j)]).abs() < 1e-10);
                prop_assert!((k2[(i, j)] - syr2k[(i, j)] - 14.0).abs() < 1e-10);
            } else {
                prop_assert_eq!(k[(i, j)], 7.0);
                prop_assert_eq!(k2[(i, j)], 7.0);
            }
        } }
    }

    #[test]
    fn cholesky_solves((a, b) in square(), upper: bool) {
        let n = a.nrows() as c_int;
        let definite = &a * a.transpose() + Mat::<f64>::identity(n as usize, n as usize);
        let triangle = letter(if upper { b'U' } else { b'L' });
        let (mut factor, mut x, mut info) = (flat(&definite), flat(&b), 9);
        unsafe {
            dpotrf_(&triangle, &n, factor.as_mut_ptr(), &n, &mut info);
            prop_assert_eq!(info, 0);
            dpotrs_(&triangle, &n, &n, factor.as_ptr(), &n, x.as_mut_ptr(), &n, &mut info);
        }
        prop_assert!(close(&(definite * unflat(&x, n as usize, n as usize)), &b));
    }

    #[test]
    fn lu_solves((a, b) in square()) {
        let n = a.nrows() as c_int;
        let shifted = &a + faer::Scale(9.0) * Mat::<f64>::identity(n as usize, n as usize);
        let (mut stored, mut x, mut pivots, mut info) = (flat(&shifted), flat(&b), vec![0; n as usize], 9);
        unsafe { dgesv_(&n, &n, stored.as_mut_ptr(), &n, pivots.as_mut_ptr(), x.as_mut_ptr(), &n, &mut info) };
        prop_assert_eq!(info, 0);
        prop_assert!(close(&(shifted * unflat(&x, n as usize, n as usize)), &b));
    }

    #[test]
    fn svd_reconstructs_matrix((a, _, _) in shapes()) {
        let (m, n) = (a.nrows() as c_int, a.ncols() as c_int);
        let p = m.min(n);
        let (mut stored, mut info, mut work) = (flat(&a), 9, [0.0]);
        let mut s = vec![0.0; p as usize];
        let (mut u, mut vt) = (vec![0.0; (m * p) as usize], vec![0.0; (p * n) as usize]);
        unsafe {
            dgesvd_(&letter(b'S'), &letter(b'S'), &m, &n, stored.as_mut_ptr(), &m, s.as_mut_ptr(), u.as_mut_ptr(), &m,
                    vt.as_mut_ptr(), &p, work.as_mut_ptr(), &1, &mut info);
        }
        prop_assert_eq!(info, 0);
        let (u, vt) = (unflat(&u, m as usize, p as usize), unflat(&vt, p as usize, n as usize));
        let sigma = Mat::from_fn(p as usize, p as usize, |i, j| if i == j { s[i] } else { 0.0 });
        prop_assert!(close(&(u * sigma * vt), &a));
        prop_assert!(s.windows(2).all(|w| w[0] >= w[1]));
    }

    #[test]
    fn eigenvectors_reconstruct_matrix((a, _) in square(), upper: bool) {
        let n = a.nrows() as c_int;
        let symmetric = &a + a.transpose();
        let mut w = vec![0.0; n as usize];
        let (mut stored, mut z) = (flat(&symmetric), flat(&symmetric));
        let (mut found, mut info, mut work, mut iwork, mut support) = (0, 9, [0.0], [0], vec![0; 2 * n as usize]);
        unsafe {
            dsyevr_(&letter(b'V'), &letter(b'A'), &letter(if upper { b'U' } else { b'L' }), &n, stored.as_mut_ptr(), &n,
                    &0.0, &0.0, &0, &0, &0.0, &mut found, w.as_mut_ptr(), z.as_mut_ptr(), &n, support.as_mut_ptr(),
                    work.as_mut_ptr(), &1, iwork.as_mut_ptr(), &1, &mut info);
        }
        prop_assert_eq!((info, found), (0, n));
        let z = unflat(&z, n as usize, n as usize);
        let lambda = Mat::from_fn(n as usize, n as usize, |i, j| if i == j { w[i] } else { 0.0 });
        prop_assert!(close(&(&z * lambda * z.transpose()), &symmetric));
    }
}

#[test]
fn reports_minor_of_indefinite_matrix() {
    let mut a = [1.0, 0.0, 0.0, -1.0];
    let mut info = 0;
    unsafe { dpotrf_(&letter(b'L'), &2, a.as_mut_ptr(), &2, &mut info) };
    assert_eq!(info, 2);
}

#[test]
fn rejects_unsupported_jobs() {
    let (mut a, mut s, mut work, mut info) = ([1.0], [0.0], [0.0], 0);
    let mut u = [0.0];
    let p = u.as_mut_ptr();
    unsafe {
        dgesdd_(
            &letter(b'O'),
            &1,
            &1,
            a.as_mut_ptr(),
            &1,
            s.as_mut_ptr(),
            p,
            &1,
            p,
            &1,
            work.as_mut_ptr(),
            &1,
            std::ptr::null_mut(),
            &mut info,
        );
    }
    assert_eq!(info, -1);
}

#[test]
fn all_symbols_are_linked() {
    assert_eq!(link(), 11);
}
