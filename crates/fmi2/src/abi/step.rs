//! Functions of co-simulation only: steps, derivatives of inputs and outputs, and the status of a step.

use std::ffi::{c_char, c_int};

use crate::abi::component::{Component, call, functions};
use crate::abi::pointers::{place, slice, slice_mut};
use crate::abi::types::{self, DO_STEP_STATUS, LAST_SUCCESSFUL_TIME, Status, StatusKind, TERMINATED};
use crate::instance::Outcome;
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
    // SAFETY: the importer guarantees the handle, here and below.
    let status = unsafe { call(component, Function::DoStep, body) };
    // SAFETY: as above.
    if let Some(component) = unsafe { component.cast::<Component<M>>().as_mut() }
        && component.instance.phase() == Phase::Step
    {
        component.last_step = status;
    }
    status
}

functions! {
    /// `fmi2CancelStep`: always refused by the state table, because steps are synchronous.
    cancel_step() = CancelStep, |_own| Ok(());
    /// `fmi2SetRealInputDerivatives`, of order 1, if `canInterpolateInputs` is true.
    set_real_input_derivatives(
        references: *const u32,
        count: usize,
        orders: *const c_int,
        values: *const f64
    ) = SetRealInputDerivatives, |own| {
        // SAFETY: the importer guarantees its arrays.
        let (references, orders, values) = unsafe {
            (slice(references, count, "vr")?, slice(orders, count, "order")?, slice(values, count, "value")?)
        };
        Ok(own.instance.set_input_derivatives(references, orders, values)?)
    };
    /// `fmi2GetRealOutputDerivatives`, up to the order `maxOutputDerivativeOrder`.
    get_real_output_derivatives(
        references: *const u32,
        count: usize,
        orders: *const c_int,
        values: *mut f64
    ) = GetRealOutputDerivatives, |own| {
        // SAFETY: the importer guarantees its arrays.
        let (references, orders, values) = unsafe {
            (slice(references, count, "vr")?, slice(orders, count, "order")?, slice_mut(values, count, "value")?)
        };
        own.instance.output_derivatives(references, orders, values, &mut own.logger)
    };
}

/// Functions that return a status value of the requested kind, or `fmi2Discard` if the kind has no value.
macro_rules! statuses {
    ($($(#[$about:meta])* $name:ident($type:ty) = $function:ident, $read:expr;)+) => {
        $(
            $(#[$about])*
            ///
            /// # Safety
            /// The conditions of [`do_step`] hold; `value` is NULL or writable.
            pub unsafe extern "C" fn $name<M: Model>(
                component: types::Component,
                kind: StatusKind,
                value: *mut $type,
            ) -> Status {
                let read: fn(&Component<M>, StatusKind) -> Option<$type> = $read;
                let mut has_value = true;
                let body = |own: &mut Component<M>| {
                    match read(own, kind) {
                        // SAFETY: the importer guarantees its pointer.
                        Some(found) => unsafe { place(value, "value") }?.write(found),
                        None => has_value = false,
                    }
                    Ok(())
                };
                // SAFETY: the importer guarantees the handle.
                match unsafe { call(component, Function::$function, body) } {
                    Status::Ok if !has_value => Status::Discard,
                    status => status,
                }
            }
        )+
    };
}

statuses! {
    /// `fmi2GetStatus`: the status of the last step.
    get_status(Status) = GetStatus, |own, kind| (kind == DO_STEP_STATUS).then_some(own.last_step);
    /// `fmi2GetRealStatus`: the end of the last successful step.
    get_real_status(f64) = GetRealStatus, |own, kind| (kind == LAST_SUCCESSFUL_TIME).then(|| own.instance.time());
    /// `fmi2GetBooleanStatus`: the model never requests termination.
    get_boolean_status(c_int) = GetBooleanStatus, |_, kind| (kind == TERMINATED).then_some(0);
    /// `fmi2GetIntegerStatus`: no kind of status is an integer.
    get_integer_status(c_int) = GetIntegerStatus, |_, _| None;
    /// `fmi2GetStringStatus`: describes pending steps only, which do not occur.
    get_string_status(*const c_char) = GetStringStatus, |_, _| None;
}
