//! Conversion of C pointers to Rust references; NULL is refused.

use std::ffi::{CStr, c_char};

use crate::Refusal;

/// Returns a slice of `count` elements; NULL is allowed if `count` is 0.
///
/// # Safety
/// `pointer` is NULL or points to `count` elements that do not change during the lifetime of the slice.
pub(crate) unsafe fn slice<'a, T>(
    pointer: *const T,
    count: usize,
    argument: &'static str,
) -> Result<&'a [T], Refusal> {
    if count == 0 {
        return Ok(&[]);
    }
    check(pointer, count, argument)?;
    // SAFETY: the pointer passed the check, and the caller guarantees the rest.
    Ok(unsafe { std::slice::from_raw_parts(pointer, count) })
}

/// Returns a mutable slice of numbers or pointers, for which any bytes are valid.
///
/// # Safety
/// `pointer` is NULL or points to `count` elements that are not aliased during the lifetime of the slice.
pub(crate) unsafe fn slice_mut<'a, T>(
    pointer: *mut T,
    count: usize,
    argument: &'static str,
) -> Result<&'a mut [T], Refusal> {
    if count == 0 {
        return Ok(&mut []);
    }
    check(pointer, count, argument)?;
    // SAFETY: the pointer passed the check, and the caller guarantees the rest.
    Ok(unsafe { std::slice::from_raw_parts_mut(pointer, count) })
}

/// Refuses NULL, a count larger than any memory, such as -1 read as a size, and a misaligned address.
fn check<T>(pointer: *const T, count: usize, argument: &'static str) -> Result<(), Refusal> {
    if pointer.is_null() {
        return Err(Refusal::NullPointer { argument });
    }
    let most = isize::MAX.unsigned_abs() / size_of::<T>().max(1);
    if count > most || !pointer.is_aligned() {
        return Err(Refusal::BadArray { argument, count });
    }
    Ok(())
}

/// Memory for one value, which need not be initialised.
pub(crate) struct Place<T>(*mut T);

impl<T: Copy> Place<T> {
    /// Writes the value.
    pub(crate) fn write(self, value: T) {
        // SAFETY: the pointer is not NULL, and the caller of `place` guaranteed the rest.
        unsafe { self.0.write(value) }
    }
}

/// Checks a pointer to which one value is written.
///
/// # Safety
/// `pointer` is NULL or has space for a `T` that is not aliased during the lifetime of the result.
pub(crate) unsafe fn place<T>(pointer: *mut T, argument: &'static str) -> Result<Place<T>, Refusal> {
    check(pointer, 1, argument)?;
    Ok(Place(pointer))
}

/// Returns a reference to a value that may be read concurrently.
///
/// # Safety
/// `pointer` is NULL or points to a `T` that does not change during the lifetime of the reference.
pub(crate) unsafe fn shared<'a, T>(pointer: *const T, argument: &'static str) -> Result<&'a T, Refusal> {
    check(pointer, 1, argument)?;
    // SAFETY: not NULL, and the caller guarantees the rest.
    Ok(unsafe { &*pointer })
}

/// Returns a reference to a value that is read and overwritten.
///
/// # Safety
/// `pointer` is NULL or points to a `T` that is not aliased during the lifetime of the reference.
pub(crate) unsafe fn exclusive<'a, T>(pointer: *mut T, argument: &'static str) -> Result<&'a mut T, Refusal> {
    check(pointer, 1, argument)?;
    // SAFETY: not NULL, and the caller guarantees the rest.
    Ok(unsafe { &mut *pointer })
}

/// Converts a C string.
///
/// # Safety
/// `pointer` is NULL or a NUL-terminated string that does not change during the lifetime of the reference.
pub(crate) unsafe fn text<'a>(pointer: *const c_char, argument: &'static str) -> Result<&'a str, Refusal> {
    if pointer.is_null() {
        return Err(Refusal::NullPointer { argument });
    }
    // SAFETY: not NULL, and the caller guarantees the rest.
    let text = unsafe { CStr::from_ptr(pointer) };
    text.to_str().map_err(|_| Refusal::NotUnicode { argument })
}
