//! Eleven Fortran symbols of BLAS and LAPACK for clarabel's PSD cone, in pure Rust on [`faer`].
//!
//! clarabel calls BLAS and LAPACK by their Fortran names. Its own options for providing them download a library or need
//! a Fortran compiler. This crate defines only the names that clarabel uses, so that `cargo build` suffices for a
//! semidefinite solver.
//!
//! | symbol | result |
//! |---|---|
//! | `dgemm_` | `C = alpha op(A) op(B) + beta C` |
//! | `dgemv_` | `y = alpha op(A) x + beta y` |
//! | `dsymv_` | `y = alpha A x + beta y` for a symmetric A |
//! | `dsyrk_` | `C = alpha op(A) op(A)' + beta C`, one triangle |
//! | `dsyr2k_` | `C = alpha (op(A) op(B)' + op(B) op(A)') + beta C`, one triangle |
//! | `dpotrf_`, `dpotrs_` | Cholesky factor; solution with it |
//! | `dgesv_` | solution of a square system by LU with partial pivoting |
//! | `dgesdd_`, `dgesvd_` | singular value decomposition, thin |
//! | `dsyevr_` | eigenvalues and vectors of a symmetric matrix |
//!
//! Matrices are stored by columns; `lda` is the distance between two columns. A call with an unsupported job (such as
//! part of the spectrum) sets `info` to a negative number, as LAPACK does for an invalid argument.
//!
//! With the feature `openblas` nothing is defined here: the symbols come from the system's OpenBLAS, which must be
//! installed (`libopenblas-dev` on Debian). Set `OPENBLAS_NUM_THREADS=1` for small problems.
#![allow(unsafe_code)] // The symbols take raw pointers.
#![cfg_attr(not(feature = "openblas"), allow(clippy::too_many_arguments))] // The argument lists are LAPACK's.
#![cfg_attr(not(feature = "openblas"), allow(clippy::missing_safety_doc))] // One contract for all: LAPACK's reference.

#[cfg(not(feature = "openblas"))]
mod blas;
#[cfg(not(feature = "openblas"))]
mod lapack;
#[cfg(feature = "openblas")]
mod openblas;
#[cfg(not(feature = "openblas"))]
mod single;
#[cfg(not(feature = "openblas"))]
mod view;

#[cfg(not(feature = "openblas"))]
pub use blas::{dgemm_, dgemv_, dsymv_, dsyr2k_, dsyrk_};
#[cfg(not(feature = "openblas"))]
pub use lapack::{dgesdd_, dgesv_, dgesvd_, dpotrf_, dpotrs_, dsyevr_};
#[cfg(feature = "openblas")]
use openblas::{
    dgemm_, dgemv_, dgesdd_, dgesv_, dgesvd_, dpotrf_, dpotrs_, dsyevr_, dsymv_, dsyr2k_, dsyrk_,
};

/// Keeps the symbols in the linked binary; to be called once in the crate that links clarabel.
///
/// Returns the number of symbols provided.
pub fn link() -> usize {
    let symbols: [*const (); 11] = [
        dgemm_ as *const (),
        dgemv_ as *const (),
        dsymv_ as *const (),
        dsyrk_ as *const (),
        dsyr2k_ as *const (),
        dpotrf_ as *const (),
        dpotrs_ as *const (),
        dgesv_ as *const (),
        dgesdd_ as *const (),
        dgesvd_ as *const (),
        dsyevr_ as *const (),
    ];
    std::hint::black_box(symbols).len()
}

#[cfg(all(doctest, not(feature = "openblas")))]
#[doc = include_str!("../README.md")]
struct Readme;
