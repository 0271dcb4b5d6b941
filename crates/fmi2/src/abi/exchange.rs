//! Functions of model exchange only.

use std::ffi::c_int;

use crate::abi::component::{Component, call, functions};
use crate::abi::pointers::{place, slice, slice_mut};
use crate::abi::types::{self, EventInfo, Status};
use crate::instance::Outcome;
use crate::{Function, Model};

functions! {
    /// `fmi2EnterEventMode`.
    enter_event_mode() = EnterEventMode, |own| Ok(own.instance.enter_event_mode()?);
    /// `fmi2NewDiscreteStates`.
    new_discrete_states(info: *mut EventInfo) = NewDiscreteStates, |own| {
        // SAFETY: the importer guarantees its pointers and arrays, here and below.
        let info = unsafe { place(info, "eventInfo") }?;
        let next = own.instance.new_discrete_states(&mut own.logger)?.next;
        info.write(EventInfo {
            next_event_time_defined: c_int::from(next.is_some()),
            next_event_time: next.unwrap_or_default(),
            ..EventInfo::default()
        });
        Ok(())
    };
    /// `fmi2EnterContinuousTimeMode`.
    enter_continuous_time_mode() = EnterContinuousTimeMode, |own| Ok(own.instance.enter_continuous_time_mode()?);
    /// `fmi2CompletedIntegratorStep`.
    completed_integrator_step(
        _no_set_state_prior_to_current_point: c_int,
        enter_event_mode: *mut c_int,
        terminate: *mut c_int
    ) = CompletedIntegratorStep, |own| {
        // SAFETY: as above.
        let (event, end) =
            unsafe { (place(enter_event_mode, "enterEventMode")?, place(terminate, "terminateSimulation")?) };
        own.instance.integrator_step_completed(&mut own.logger)?;
        event.write(0);
        end.write(0);
        Ok(())
    };
    /// `fmi2SetTime`.
    set_time(time: f64) = SetTime, |own| Ok(own.instance.set_time(time)?);
    /// `fmi2SetContinuousStates`.
    set_continuous_states(states: *const f64, count: usize) = SetContinuousStates, |own| {
        // SAFETY: as above.
        Ok(own.instance.set_continuous_states(unsafe { slice(states, count, "x") }?)?)
    };
    /// `fmi2GetDerivatives`; `fmi2Discard` if the derivatives are undefined.
    get_derivatives(derivatives: *mut f64, count: usize) = GetDerivatives, |own| {
        // SAFETY: as above.
        let derivatives = unsafe { slice_mut(derivatives, count, "derivatives") }?;
        own.instance.derivatives(derivatives, &mut own.logger)
    };
    /// `fmi2GetEventIndicators`.
    get_event_indicators(indicators: *mut f64, count: usize) = GetEventIndicators, |own| {
        // SAFETY: as above.
        Ok(own.instance.event_indicators(unsafe { slice_mut(indicators, count, "eventIndicators") }?)?)
    };
    /// `fmi2GetContinuousStates`.
    get_continuous_states(states: *mut f64, count: usize) = GetContinuousStates, |own| {
        // SAFETY: as above.
        let states = unsafe { slice_mut(states, count, "x") }?;
        own.instance.continuous_states(states, &mut own.logger)
    };
    /// `fmi2GetNominalsOfContinuousStates`.
    get_nominals_of_continuous_states(nominals: *mut f64, count: usize) = GetNominalsOfContinuousStates, |own| {
        // SAFETY: as above.
        Ok(own.instance.nominals(unsafe { slice_mut(nominals, count, "x_nominal") }?)?)
    };
}
