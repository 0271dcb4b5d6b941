//! C pointers to Rust references, with NULL refused.

use std::ffi::{CStr, c_char};

use crate::Refusal;

/// A slice of `count` elements; NULL is fine when there are none.
///
/// # Safety
/// `pointer` is NULL or points to `count` elements that nobody changes while the slice lives.
pub(crate) unsafe fn slice<'a, T>(
    pointer: *const T,
    count: usize,
    argument: &'static str,
) -> Result<&'a [T], Refusal> {
    if count == 0 {
        return Ok(&[]);
    }
    if pointer.is_null() {
        return Err(Refusal::NullPointer { argument });
    }
    // SAFETY: not NULL, and the caller vouches for the rest.
    Ok(unsafe { std::slice::from_raw_parts(pointer, count) })
}

/// A slice to write to.
///
/// # Safety
/// `pointer` is NULL or points to `count` elements that nobody else uses while the slice lives.
pub(crate) unsafe fn slice_mut<'a, T>(
    pointer: *mut T,
    count: usize,
    argument: &'static str,
) -> Result<&'a mut [T], Refusal> {
    if count == 0 {
        return Ok(&mut []);
    }
    if pointer.is_null() {
        return Err(Refusal::NullPointer { argument });
    }
    // SAFETY: not NULL, and the caller vouches for the rest.
    Ok(unsafe { std::slice::from_raw_parts_mut(pointer, count) })
}

/// A place to write one value to.
///
/// # Safety
/// `pointer` is NULL or points to a `T` that nobody else uses while the reference lives.
pub(crate) unsafe fn place<'a, T>(pointer: *mut T, argument: &'static str) -> Result<&'a mut T, Refusal> {
    // SAFETY: the caller vouches for it.
    unsafe { pointer.as_mut() }.ok_or(Refusal::NullPointer { argument })
}

/// A text.
///
/// # Safety
/// `pointer` is NULL or points to a NUL-terminated text that nobody changes while the reference lives.
pub(crate) unsafe fn text<'a>(pointer: *const c_char, argument: &'static str) -> Result<&'a str, Refusal> {
    if pointer.is_null() {
        return Err(Refusal::NullPointer { argument });
    }
    // SAFETY: not NULL, and the caller vouches for the rest.
    let text = unsafe { CStr::from_ptr(pointer) };
    text.to_str().map_err(|_| Refusal::NotUnicode { argument })
}
