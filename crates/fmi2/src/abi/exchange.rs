//! Functions of model exchange only.

use std::ffi::c_int;

use crate::abi::component::{Component, Outcome, call, calls};
use crate::abi::pointers::{place, slice, slice_mut};
use crate::abi::types::{self, EventInfo, Status};
use crate::{Function, Model};

calls! {
    /// `fmi2EnterEventMode`.
    enter_event_mode = EnterEventMode, |own| Ok(own.instance.enter_event_mode()?);
    /// `fmi2EnterContinuousTimeMode`.
    enter_continuous_time_mode = EnterContinuousTimeMode, |own| Ok(own.instance.enter_continuous_time_mode()?);
}

/// `fmi2NewDiscreteStates`.
///
/// # Safety
/// As [`enter_event_mode`]; `info` is NULL or a place to write to.
pub unsafe extern "C" fn new_discrete_states<M: Model>(
    component: types::Component,
    info: *mut EventInfo,
) -> Status {
    let body = |component: &mut Component<M>| {
        // SAFETY: the importer vouches for its pointer.
        let info = unsafe { place(info, "eventInfo") }?;
        let next = component.instance.new_discrete_states(&mut component.logger)?.next;
        info.write(EventInfo {
            next_event_time_defined: c_int::from(next.is_some()),
            next_event_time: next.unwrap_or_default(),
            ..EventInfo::default()
        });
        Ok(())
    };
    // SAFETY: the importer vouches for the handle.
    unsafe { call(component, Function::NewDiscreteStates, body) }
}

/// `fmi2CompletedIntegratorStep`.
///
/// # Safety
/// As [`enter_event_mode`]; the pointers are NULL or places to write to.
pub unsafe extern "C" fn completed_integrator_step<M: Model>(
    component: types::Component,
    _no_set_state_prior_to_current_point: c_int,
    enter_event_mode: *mut c_int,
    terminate: *mut c_int,
) -> Status {
    let body = |component: &mut Component<M>| {
        // SAFETY: the importer vouches for its pointers.
        let (event, end) =
            unsafe { (place(enter_event_mode, "enterEventMode")?, place(terminate, "terminateSimulation")?) };
        component.instance.integrator_step_completed(&mut component.logger)?;
        event.write(0);
        end.write(0);
        Ok(())
    };
    // SAFETY: the importer vouches for the handle.
    unsafe { call(component, Function::CompletedIntegratorStep, body) }
}

/// `fmi2SetTime`.
///
/// # Safety
/// As [`enter_event_mode`].
pub unsafe extern "C" fn set_time<M: Model>(component: types::Component, time: f64) -> Status {
    let body = |component: &mut Component<M>| Ok(component.instance.set_time(time)?);
    // SAFETY: the importer vouches for the handle.
    unsafe { call(component, Function::SetTime, body) }
}

/// `fmi2SetContinuousStates`.
///
/// # Safety
/// As [`enter_event_mode`]; the array has `count` elements.
pub unsafe extern "C" fn set_continuous_states<M: Model>(
    component: types::Component,
    states: *const f64,
    count: usize,
) -> Status {
    let body = |component: &mut Component<M>| {
        // SAFETY: the importer vouches for its array.
        let states = unsafe { slice(states, count, "x") }?;
        Ok(component.instance.set_continuous_states(states)?)
    };
    // SAFETY: the importer vouches for the handle.
    unsafe { call(component, Function::SetContinuousStates, body) }
}

/// C functions that fill an array of `count` numbers, which has a name in the standard.
macro_rules! arrays {
    ($($(#[$about:meta])* $name:ident = $function:ident, $argument:literal, $write:expr;)+) => {
        $(
            $(#[$about])*
            ///
            /// # Safety
            /// As [`set_continuous_states`].
            pub unsafe extern "C" fn $name<M: Model>(
                component: types::Component,
                values: *mut f64,
                count: usize,
            ) -> Status {
                let write: fn(&mut Component<M>, &mut [f64]) -> Outcome<M> = $write;
                let body = |component: &mut Component<M>| {
                    // SAFETY: the importer vouches for its array.
                    let values = unsafe { slice_mut(values, count, $argument) }?;
                    write(component, values)
                };
                // SAFETY: the importer vouches for the handle.
                unsafe { call(component, Function::$function, body) }
            }
        )+
    };
}

arrays! {
    /// `fmi2GetDerivatives`; `fmi2Discard` where the derivatives are undefined.
    get_derivatives = GetDerivatives, "derivatives",
        |own, values| own.instance.derivatives(values, &mut own.logger);
    /// `fmi2GetEventIndicators`.
    get_event_indicators = GetEventIndicators, "eventIndicators",
        |own, values| Ok(own.instance.event_indicators(values)?);
    /// `fmi2GetContinuousStates`.
    get_continuous_states = GetContinuousStates, "x",
        |own, values| own.instance.continuous_states(values, &mut own.logger);
    /// `fmi2GetNominalsOfContinuousStates`.
    get_nominals_of_continuous_states = GetNominalsOfContinuousStates, "x_nominal",
        |own, values| Ok(own.instance.nominals(values)?);
}
