//! `fmi2GetXXX` and `fmi2SetXXX`.

use std::ffi::{c_char, c_int};

use crate::abi::component::{Component, call, functions};
use crate::abi::logger::c_string;
use crate::abi::pointers::{slice, slice_mut, text};
use crate::abi::types::{self, Status};
use crate::instance::Outcome;
use crate::{Function, Model, Value};

/// Writes the values of variables to an array, each converted to its C type.
///
/// # Safety
/// The arrays are NULL or have `count` elements.
unsafe fn get<M: Model, T: Value, C>(
    own: &mut Component<M>,
    references: *const u32,
    count: usize,
    values: *mut C,
    convert: impl Fn(T) -> C,
) -> Outcome<M> {
    // SAFETY: the caller guarantees the arrays.
    let (references, values) =
        unsafe { (slice(references, count, "vr")?, slice_mut(values, count, "value")?) };
    let take = |position: usize, value| values[position] = convert(value);
    own.instance.get(references, &mut own.logger, take)
}

/// Sets variables to the values of an array, each converted from its C type.
///
/// # Safety
/// The arrays are NULL or have `count` elements.
unsafe fn set<M: Model, T: Value, C: Copy>(
    own: &mut Component<M>,
    references: *const u32,
    count: usize,
    values: *const C,
    convert: impl Fn(C) -> T,
) -> Outcome<M> {
    // SAFETY: the caller guarantees the arrays.
    let (references, values) = unsafe { (slice(references, count, "vr")?, slice(values, count, "value")?) };
    Ok(own.instance.set(references, |position| convert(values[position]))?)
}

functions! {
    /// `fmi2GetReal`.
    get_real(references: *const u32, count: usize, values: *mut f64) = GetReal, |own| {
        // SAFETY: the importer guarantees its arrays, here and below.
        unsafe { get(own, references, count, values, |value: f64| value) }
    };
    /// `fmi2GetInteger`, also for enumerations.
    get_integer(references: *const u32, count: usize, values: *mut c_int) = GetInteger, |own| {
        // SAFETY: as above.
        unsafe { get(own, references, count, values, |value: i32| value) }
    };
    /// `fmi2GetBoolean`.
    get_boolean(references: *const u32, count: usize, values: *mut c_int) = GetBoolean, |own| {
        // SAFETY: as above.
        unsafe { get(own, references, count, values, |value: bool| c_int::from(value)) }
    };
    /// `fmi2SetReal`; in model exchange also for states.
    set_real(references: *const u32, count: usize, values: *const f64) = SetReal, |own| {
        // SAFETY: as above.
        let (references, values) =
            unsafe { (slice(references, count, "vr")?, slice(values, count, "value")?) };
        Ok(own.instance.set_real(references, values)?)
    };
    /// `fmi2SetInteger`, also for enumerations.
    set_integer(references: *const u32, count: usize, values: *const c_int) = SetInteger, |own| {
        // SAFETY: as above.
        unsafe { set(own, references, count, values, |value: c_int| value) }
    };
    /// `fmi2SetBoolean`; any number but 0 is true.
    set_boolean(references: *const u32, count: usize, values: *const c_int) = SetBoolean, |own| {
        // SAFETY: as above.
        unsafe { set(own, references, count, values, |value: c_int| value != 0) }
    };
    /// `fmi2GetString`; the strings are valid until the next call of this function.
    get_string(references: *const u32, count: usize, values: *mut *const c_char) = GetString, |own| {
        // SAFETY: as above.
        let (references, values) =
            unsafe { (slice(references, count, "vr")?, slice_mut(values, count, "value")?) };
        let mut strings = Vec::with_capacity(count);
        let take = |_, value: String| strings.push(c_string(&value));
        own.instance.get(references, &mut own.logger, take)?;
        own.strings = strings;
        for (value, string) in values.iter_mut().zip(&own.strings) {
            *value = string.as_ptr();
        }
        Ok(())
    };
    /// `fmi2SetString`.
    set_string(references: *const u32, count: usize, values: *const *const c_char) = SetString, |own| {
        // SAFETY: as above.
        let (references, values) =
            unsafe { (slice(references, count, "vr")?, slice(values, count, "value")?) };
        let mut texts = Vec::with_capacity(count);
        for &value in values {
            // SAFETY: the importer guarantees its strings.
            texts.push(unsafe { text(value, "value") }?.to_owned());
        }
        Ok(own.instance.set(references, |position| texts[position].clone())?)
    };
}
