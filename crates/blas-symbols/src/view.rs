//! Views of Fortran arrays as faer matrices.

use faer::{MatMut, MatRef};
use std::ffi::{c_char, c_int};

/// Returns a read-only view of `rows x cols` numbers at `a`, with columns `lda` apart.
///
/// # Safety
/// `a` must point to a Fortran array of at least `lda (cols - 1) + rows` numbers that outlives the view.
pub(crate) unsafe fn read<'a>(a: *const f64, rows: c_int, cols: c_int, lda: *const c_int) -> MatRef<'a, f64> {
    // SAFETY: the caller's contract.
    unsafe { MatRef::from_raw_parts(a, rows as usize, cols as usize, 1, *lda as isize) }
}

/// Returns a writable view, like [`read`].
///
/// # Safety
/// Same as [`read`], and nothing else may access the array meanwhile.
pub(crate) unsafe fn write<'a>(a: *mut f64, rows: c_int, cols: c_int, lda: *const c_int) -> MatMut<'a, f64> {
    // SAFETY: the caller's contract.
    unsafe { MatMut::from_raw_parts_mut(a, rows as usize, cols as usize, 1, *lda as isize) }
}

/// Returns `true` if a Fortran option letter is `letter`, in upper or lower case.
///
/// # Safety
/// `option` must point to one character.
pub(crate) unsafe fn is(option: *const c_char, letter: u8) -> bool {
    // SAFETY: the caller's contract.
    unsafe { (*option as u8).eq_ignore_ascii_case(&letter) }
}
