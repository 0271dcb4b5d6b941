//! `fmi2GetXXX` and `fmi2SetXXX`.

use std::ffi::{c_char, c_int};

use crate::abi::component::{Component, call};
use crate::abi::logger::c_string;
use crate::abi::pointers::{slice, slice_mut, text};
use crate::abi::types::{self, Status};
use crate::{Function, Model, Value};

/// Writes the values of variables to an array, each converted to its C type.
///
/// # Safety
/// As [`get_real`].
unsafe fn get<M: Model, T: Value, C>(
    component: types::Component,
    references: *const u32,
    count: usize,
    values: *mut C,
    convert: impl Fn(T) -> C,
) -> Status {
    let body = |component: &mut Component<M>| {
        // SAFETY: the caller vouches for the arrays.
        let (references, values) =
            unsafe { (slice(references, count, "vr")?, slice_mut(values, count, "value")?) };
        let take = |position: usize, value| values[position] = convert(value);
        component.instance.get(references, &mut component.logger, take)
    };
    // SAFETY: the caller vouches for the handle.
    unsafe { call(component, T::GET, body) }
}

/// Sets variables to the values of an array, each converted from its C type.
///
/// # Safety
/// As [`get_real`].
unsafe fn set<M: Model, T: Value, C: Copy>(
    component: types::Component,
    references: *const u32,
    count: usize,
    values: *const C,
    convert: impl Fn(C) -> T,
) -> Status {
    let body = |component: &mut Component<M>| {
        // SAFETY: the caller vouches for the arrays.
        let (references, values) =
            unsafe { (slice(references, count, "vr")?, slice(values, count, "value")?) };
        Ok(component.instance.set(references, |position| convert(values[position]))?)
    };
    // SAFETY: the caller vouches for the handle.
    unsafe { call(component, T::SET, body) }
}

/// The functions that pass each value on as it is, or converted: the names of function and C type, and the conversion.
macro_rules! accessors {
    ($($(#[$about:meta])* $name:ident = $function:ident $values:ty, $convert:expr;)+) => {
        $(
            $(#[$about])*
            ///
            /// # Safety
            /// `component` is NULL or a live handle of this model; the arrays have `count` elements.
            pub unsafe extern "C" fn $name<M: Model>(
                component: types::Component,
                references: *const u32,
                count: usize,
                values: $values,
            ) -> Status {
                // SAFETY: the importer vouches for handle and arrays.
                unsafe { $function::<M, _, _>(component, references, count, values, $convert) }
            }
        )+
    };
}

accessors! {
    /// `fmi2GetReal`.
    get_real = get *mut f64, |value: f64| value;
    /// `fmi2GetInteger`, also for enumerations.
    get_integer = get *mut c_int, |value: i32| value;
    /// `fmi2GetBoolean`.
    get_boolean = get *mut c_int, |value: bool| c_int::from(value);
    /// `fmi2SetReal`.
    set_real = set *const f64, |value: f64| value;
    /// `fmi2SetInteger`, also for enumerations.
    set_integer = set *const c_int, |value: c_int| value;
    /// `fmi2SetBoolean`; any number but 0 is true.
    set_boolean = set *const c_int, |value: c_int| value != 0;
}

/// `fmi2GetString`; the texts live until the next call of this function.
///
/// # Safety
/// As [`get_real`].
pub unsafe extern "C" fn get_string<M: Model>(
    component: types::Component,
    references: *const u32,
    count: usize,
    values: *mut *const c_char,
) -> Status {
    let body = |component: &mut Component<M>| {
        // SAFETY: the importer vouches for its arrays.
        let (references, values) =
            unsafe { (slice(references, count, "vr")?, slice_mut(values, count, "value")?) };
        let mut strings = Vec::with_capacity(count);
        let take = |_, value: String| strings.push(c_string(&value));
        component.instance.get(references, &mut component.logger, take)?;
        component.strings = strings;
        for (value, string) in values.iter_mut().zip(&component.strings) {
            *value = string.as_ptr();
        }
        Ok(())
    };
    // SAFETY: the importer vouches for the handle.
    unsafe { call(component, Function::GetString, body) }
}

/// `fmi2SetString`.
///
/// # Safety
/// As [`get_real`]; each text is NULL or NUL-terminated.
pub unsafe extern "C" fn set_string<M: Model>(
    component: types::Component,
    references: *const u32,
    count: usize,
    values: *const *const c_char,
) -> Status {
    let body = |component: &mut Component<M>| {
        // SAFETY: the importer vouches for its arrays.
        let (references, values) =
            unsafe { (slice(references, count, "vr")?, slice(values, count, "value")?) };
        let mut texts = Vec::with_capacity(count);
        for &value in values {
            // SAFETY: the importer vouches for its texts.
            texts.push(unsafe { text(value, "value") }?.to_owned());
        }
        Ok(component.instance.set(references, |position| texts[position].clone())?)
    };
    // SAFETY: the importer vouches for the handle.
    unsafe { call(component, Function::SetString, body) }
}
