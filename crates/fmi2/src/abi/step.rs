//! Functions of co-simulation only: steps, derivatives of inputs and outputs, and the status of a step.

use std::ffi::{c_char, c_int};

use crate::abi::component::{Component, call};
use crate::abi::pointers::{place, slice, slice_mut};
use crate::abi::types::{self, DO_STEP_STATUS, LAST_SUCCESSFUL_TIME, Status, StatusKind, TERMINATED};
use crate::{Function, Model, Phase};

/// `fmi2DoStep`.
///
/// # Safety
/// `component` is NULL or a live handle of this model.
pub unsafe extern "C" fn do_step<M: Model>(
    component: types::Component,
    at: f64,
    size: f64,
    _no_set_state_prior_to_current_point: c_int,
) -> Status {
    let body = |component: &mut Component<M>| component.instance.step(at, size, &mut component.logger);
    // SAFETY: the importer vouches for the handle, here and below.
    let status = unsafe { call(component, Function::DoStep, body) };
    // SAFETY: as above.
    if let Some(component) = unsafe { component.cast::<Component<M>>().as_mut() }
        && component.instance.phase() == Phase::Step
    {
        component.last_step = status;
    }
    status
}

/// `fmi2CancelStep`: refused, because no step is ever in progress.
///
/// # Safety
/// As [`do_step`].
pub unsafe extern "C" fn cancel_step<M: Model>(component: types::Component) -> Status {
    // SAFETY: the importer vouches for the handle. The state table refuses every call before the body.
    unsafe { call(component, Function::CancelStep, |_: &mut Component<M>| Ok(())) }
}

/// `fmi2SetRealInputDerivatives`, of order 1, if `canInterpolateInputs` is true.
///
/// # Safety
/// As [`do_step`]; the arrays have `count` elements.
pub unsafe extern "C" fn set_real_input_derivatives<M: Model>(
    component: types::Component,
    references: *const u32,
    count: usize,
    orders: *const c_int,
    values: *const f64,
) -> Status {
    let body = |component: &mut Component<M>| {
        // SAFETY: the importer vouches for its arrays.
        let (references, orders, values) = unsafe {
            (slice(references, count, "vr")?, slice(orders, count, "order")?, slice(values, count, "value")?)
        };
        Ok(component.instance.set_input_derivatives(references, orders, values)?)
    };
    // SAFETY: the importer vouches for the handle.
    unsafe { call(component, Function::SetRealInputDerivatives, body) }
}

/// `fmi2GetRealOutputDerivatives`, up to the order `maxOutputDerivativeOrder`.
///
/// # Safety
/// As [`do_step`]; the arrays have `count` elements.
pub unsafe extern "C" fn get_real_output_derivatives<M: Model>(
    component: types::Component,
    references: *const u32,
    count: usize,
    orders: *const c_int,
    values: *mut f64,
) -> Status {
    let body = |component: &mut Component<M>| {
        // SAFETY: the importer vouches for its arrays.
        let (references, orders, values) = unsafe {
            (
                slice(references, count, "vr")?,
                slice(orders, count, "order")?,
                slice_mut(values, count, "value")?,
            )
        };
        component.instance.output_derivatives(references, orders, values, &mut component.logger)
    };
    // SAFETY: the importer vouches for the handle.
    unsafe { call(component, Function::GetRealOutputDerivatives, body) }
}

/// `fmi2GetStatus`: the status of the last step.
///
/// # Safety
/// As [`do_step`]; `value` is NULL or a place to write to.
pub unsafe extern "C" fn get_status<M: Model>(
    component: types::Component,
    kind: StatusKind,
    value: *mut Status,
) -> Status {
    // SAFETY: the importer vouches for its pointers.
    unsafe {
        answer::<M, _>(component, Function::GetStatus, (kind, DO_STEP_STATUS), value, |own| own.last_step)
    }
}

/// `fmi2GetRealStatus`: the end of the last successful step.
///
/// # Safety
/// As [`get_status`].
pub unsafe extern "C" fn get_real_status<M: Model>(
    component: types::Component,
    kind: StatusKind,
    value: *mut f64,
) -> Status {
    let time = |own: &Component<M>| own.instance.time();
    // SAFETY: the importer vouches for its pointers.
    unsafe { answer::<M, _>(component, Function::GetRealStatus, (kind, LAST_SUCCESSFUL_TIME), value, time) }
}

/// `fmi2GetBooleanStatus`: whether the model wants to end the simulation, which it never does.
///
/// # Safety
/// As [`get_status`].
pub unsafe extern "C" fn get_boolean_status<M: Model>(
    component: types::Component,
    kind: StatusKind,
    value: *mut c_int,
) -> Status {
    // SAFETY: the importer vouches for its pointers.
    unsafe { answer::<M, _>(component, Function::GetBooleanStatus, (kind, TERMINATED), value, |_| 0) }
}

/// `fmi2GetIntegerStatus`: no kind of status is an integer.
///
/// # Safety
/// As [`do_step`].
pub unsafe extern "C" fn get_integer_status<M: Model>(
    component: types::Component,
    _kind: StatusKind,
    _value: *mut c_int,
) -> Status {
    // SAFETY: the importer vouches for the handle.
    unsafe { discard::<M>(component, Function::GetIntegerStatus) }
}

/// `fmi2GetStringStatus`: about pending steps only, which do not occur.
///
/// # Safety
/// As [`do_step`].
pub unsafe extern "C" fn get_string_status<M: Model>(
    component: types::Component,
    _kind: StatusKind,
    _value: *mut *const c_char,
) -> Status {
    // SAFETY: the importer vouches for the handle.
    unsafe { discard::<M>(component, Function::GetStringStatus) }
}

/// Writes the value if the kind is the one of this function, and returns `fmi2Discard` otherwise.
unsafe fn answer<M: Model, T: Copy>(
    component: types::Component,
    function: Function,
    (kind, known): (StatusKind, StatusKind),
    value: *mut T,
    read: impl FnOnce(&Component<M>) -> T,
) -> Status {
    if kind != known {
        // SAFETY: the caller vouches for the handle.
        return unsafe { discard::<M>(component, function) };
    }
    let body = |component: &mut Component<M>| {
        // SAFETY: the caller vouches for its pointer.
        let place = unsafe { place(value, "value") }?;
        place.write(read(component));
        Ok(())
    };
    // SAFETY: the caller vouches for the handle.
    unsafe { call(component, function, body) }
}

/// `fmi2Discard`: the status has no value.
unsafe fn discard<M: Model>(component: types::Component, function: Function) -> Status {
    // SAFETY: the caller vouches for the handle.
    match unsafe { call(component, function, |_: &mut Component<M>| Ok(())) } {
        Status::Ok => Status::Discard,
        status => status,
    }
}
