//! `fmi2GetXXX` and `fmi2SetXXX`.

use std::ffi::{c_char, c_int};

use crate::abi::component::{Component, call};
use crate::abi::logger::c_string;
use crate::abi::pointers::{slice, slice_mut, text};
use crate::abi::types::{self, Status};
use crate::{Function, Model};

/// `fmi2GetReal`.
///
/// # Safety
/// `component` is NULL or a live handle of this model; the arrays have `count` elements.
pub unsafe extern "C" fn get_real<M: Model>(
    component: types::Component,
    references: *const u32,
    count: usize,
    values: *mut f64,
) -> Status {
    let body = |component: &mut Component<M>| {
        // SAFETY: the importer vouches for its arrays.
        let (references, values) =
            unsafe { (slice(references, count, "vr")?, slice_mut(values, count, "value")?) };
        let take = |position: usize, value| values[position] = value;
        component.instance.get(references, &mut component.logger, take)
    };
    // SAFETY: the importer vouches for the handle.
    unsafe { call(component, Function::GetReal, body) }
}

/// `fmi2GetInteger`, also for enumerations.
///
/// # Safety
/// As [`get_real`].
pub unsafe extern "C" fn get_integer<M: Model>(
    component: types::Component,
    references: *const u32,
    count: usize,
    values: *mut c_int,
) -> Status {
    let body = |component: &mut Component<M>| {
        // SAFETY: the importer vouches for its arrays.
        let (references, values) =
            unsafe { (slice(references, count, "vr")?, slice_mut(values, count, "value")?) };
        let take = |position: usize, value: i32| values[position] = value;
        component.instance.get(references, &mut component.logger, take)
    };
    // SAFETY: the importer vouches for the handle.
    unsafe { call(component, Function::GetInteger, body) }
}

/// `fmi2GetBoolean`.
///
/// # Safety
/// As [`get_real`].
pub unsafe extern "C" fn get_boolean<M: Model>(
    component: types::Component,
    references: *const u32,
    count: usize,
    values: *mut c_int,
) -> Status {
    let body = |component: &mut Component<M>| {
        // SAFETY: the importer vouches for its arrays.
        let (references, values) =
            unsafe { (slice(references, count, "vr")?, slice_mut(values, count, "value")?) };
        let take = |position: usize, value: bool| values[position] = c_int::from(value);
        component.instance.get(references, &mut component.logger, take)
    };
    // SAFETY: the importer vouches for the handle.
    unsafe { call(component, Function::GetBoolean, body) }
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

/// `fmi2SetReal`.
///
/// # Safety
/// As [`get_real`].
pub unsafe extern "C" fn set_real<M: Model>(
    component: types::Component,
    references: *const u32,
    count: usize,
    values: *const f64,
) -> Status {
    let body = |component: &mut Component<M>| {
        // SAFETY: the importer vouches for its arrays.
        let (references, values) =
            unsafe { (slice(references, count, "vr")?, slice(values, count, "value")?) };
        Ok(component.instance.set(references, |position| values[position])?)
    };
    // SAFETY: the importer vouches for the handle.
    unsafe { call(component, Function::SetReal, body) }
}

/// `fmi2SetInteger`, also for enumerations.
///
/// # Safety
/// As [`get_real`].
pub unsafe extern "C" fn set_integer<M: Model>(
    component: types::Component,
    references: *const u32,
    count: usize,
    values: *const c_int,
) -> Status {
    let body = |component: &mut Component<M>| {
        // SAFETY: the importer vouches for its arrays.
        let (references, values) =
            unsafe { (slice(references, count, "vr")?, slice(values, count, "value")?) };
        Ok(component.instance.set(references, |position| values[position])?)
    };
    // SAFETY: the importer vouches for the handle.
    unsafe { call(component, Function::SetInteger, body) }
}

/// `fmi2SetBoolean`; any number but 0 is true.
///
/// # Safety
/// As [`get_real`].
pub unsafe extern "C" fn set_boolean<M: Model>(
    component: types::Component,
    references: *const u32,
    count: usize,
    values: *const c_int,
) -> Status {
    let body = |component: &mut Component<M>| {
        // SAFETY: the importer vouches for its arrays.
        let (references, values) =
            unsafe { (slice(references, count, "vr")?, slice(values, count, "value")?) };
        Ok(component.instance.set(references, |position| values[position] != 0)?)
    };
    // SAFETY: the importer vouches for the handle.
    unsafe { call(component, Function::SetBoolean, body) }
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
