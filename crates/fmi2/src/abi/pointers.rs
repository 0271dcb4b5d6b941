//! C pointers to Rust references, with NULL refused.

use std::ffi::{CStr, c_char};

use crate::Refusal;

/// A slice of `count` elements; NULL is allowed if `count` is 0.
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
    check(pointer, count, argument)?;
    // SAFETY: neither NULL nor absurd, and the caller vouches for the rest.
    Ok(unsafe { std::slice::from_raw_parts(pointer, count) })
}

/// A slice to write to, of numbers or pointers: of these any bytes make one.
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
    check(pointer, count, argument)?;
    // SAFETY: neither NULL nor absurd, and the caller vouches for the rest.
    Ok(unsafe { std::slice::from_raw_parts_mut(pointer, count) })
}

/// Refuses NULL, a count beyond any memory, such as -1 read as a size, and a misaligned address.
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

/// A place for one value, which need not be initialised.
pub(crate) struct Place<T>(*mut T);

impl<T: Copy> Place<T> {
    /// Puts a value there.
    pub(crate) fn write(self, value: T) {
        // SAFETY: the place is not NULL, and who made it vouched for the rest.
        unsafe { self.0.write(value) }
    }
}

/// A place to write one value to.
///
/// # Safety
/// `pointer` is NULL or has room for a `T`, that nobody else uses while the place lives.
pub(crate) unsafe fn place<T>(pointer: *mut T, argument: &'static str) -> Result<Place<T>, Refusal> {
    check(pointer, 1, argument)?;
    Ok(Place(pointer))
}

/// A value that others may read at the same time.
///
/// # Safety
/// `pointer` is NULL or points to a `T` that nobody changes while the reference lives.
pub(crate) unsafe fn shared<'a, T>(pointer: *const T, argument: &'static str) -> Result<&'a T, Refusal> {
    check(pointer, 1, argument)?;
    // SAFETY: not NULL, and the caller vouches for the rest.
    Ok(unsafe { &*pointer })
}

/// A value that is read and overwritten.
///
/// # Safety
/// `pointer` is NULL or points to a `T` that nobody else uses while the reference lives.
pub(crate) unsafe fn exclusive<'a, T>(pointer: *mut T, argument: &'static str) -> Result<&'a mut T, Refusal> {
    check(pointer, 1, argument)?;
    // SAFETY: not NULL, and the caller vouches for the rest.
    Ok(unsafe { &mut *pointer })
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
