//! Functions of model exchange only.

use std::ffi::c_int;

use crate::abi::component::{Component, Outcome, call};
use crate::abi::pointers::{place, slice, slice_mut};
use crate::abi::types::{self, EventInfo, Status};
use crate::{Function, Model};

/// `fmi2EnterEventMode`.
///
/// # Safety
/// `component` is NULL or a live handle of this model.
pub unsafe extern "C" fn enter_event_mode<M: Model>(component: types::Component) -> Status {
    let body = |component: &mut Component<M>| Ok(component.instance.enter_event_mode()?);
    // SAFETY: the importer vouches for the handle, here and below.
    unsafe { call(component, Function::EnterEventMode, body) }
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

/// `fmi2EnterContinuousTimeMode`.
///
/// # Safety
/// As [`enter_event_mode`].
pub unsafe extern "C" fn enter_continuous_time_mode<M: Model>(component: types::Component) -> Status {
    let body = |component: &mut Component<M>| Ok(component.instance.enter_continuous_time_mode()?);
    // SAFETY: the importer vouches for the handle.
    unsafe { call(component, Function::EnterContinuousTimeMode, body) }
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

/// `fmi2GetDerivatives`; `fmi2Discard` where the derivatives are undefined.
///
/// # Safety
/// As [`set_continuous_states`].
pub unsafe extern "C" fn get_derivatives<M: Model>(
    component: types::Component,
    derivatives: *mut f64,
    count: usize,
) -> Status {
    let write =
        |own: &mut Component<M>, values: &mut [f64]| own.instance.derivatives(values, &mut own.logger);
    // SAFETY: the importer vouches for handle and array.
    unsafe { fill(component, Function::GetDerivatives, (derivatives, count, "derivatives"), write) }
}

/// `fmi2GetEventIndicators`.
///
/// # Safety
/// As [`set_continuous_states`].
pub unsafe extern "C" fn get_event_indicators<M: Model>(
    component: types::Component,
    indicators: *mut f64,
    count: usize,
) -> Status {
    let write = |own: &mut Component<M>, values: &mut [f64]| Ok(own.instance.event_indicators(values)?);
    // SAFETY: the importer vouches for handle and array.
    unsafe { fill(component, Function::GetEventIndicators, (indicators, count, "eventIndicators"), write) }
}

/// `fmi2GetContinuousStates`.
///
/// # Safety
/// As [`set_continuous_states`].
pub unsafe extern "C" fn get_continuous_states<M: Model>(
    component: types::Component,
    states: *mut f64,
    count: usize,
) -> Status {
    let write =
        |own: &mut Component<M>, values: &mut [f64]| own.instance.continuous_states(values, &mut own.logger);
    // SAFETY: the importer vouches for handle and array.
    unsafe { fill(component, Function::GetContinuousStates, (states, count, "x"), write) }
}

/// `fmi2GetNominalsOfContinuousStates`.
///
/// # Safety
/// As [`set_continuous_states`].
pub unsafe extern "C" fn get_nominals_of_continuous_states<M: Model>(
    component: types::Component,
    nominals: *mut f64,
    count: usize,
) -> Status {
    let write = |own: &mut Component<M>, values: &mut [f64]| Ok(own.instance.nominals(values)?);
    // SAFETY: the importer vouches for handle and array.
    unsafe { fill(component, Function::GetNominalsOfContinuousStates, (nominals, count, "x_nominal"), write) }
}

/// Lets `write` fill an array of a name in the standard.
///
/// # Safety
/// As [`set_continuous_states`].
unsafe fn fill<M: Model>(
    component: types::Component,
    function: Function,
    (values, count, argument): (*mut f64, usize, &'static str),
    write: impl FnOnce(&mut Component<M>, &mut [f64]) -> Outcome<M>,
) -> Status {
    let body = |component: &mut Component<M>| {
        // SAFETY: the caller vouches for its array.
        let values = unsafe { slice_mut(values, count, argument) }?;
        write(component, values)
    };
    // SAFETY: the caller vouches for the handle.
    unsafe { call(component, function, body) }
}
