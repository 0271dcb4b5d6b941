//! Stored states and directional derivatives.

use crate::abi::component::{Component, call};
use crate::abi::pointers::{place, slice, slice_mut};
use crate::abi::types::{self, FmuState, Status};
use crate::{Function, Model, Refusal, Snapshot};

/// `fmi2GetFMUstate`; a state that is passed in is overwritten.
///
/// # Safety
/// `component` is NULL or a live handle of this model; `*state` is NULL or a state of the same model.
pub unsafe extern "C" fn get_fmu_state<M: Model>(
    component: types::Component,
    state: *mut FmuState,
) -> Status {
    let body = |component: &mut Component<M>| {
        // SAFETY: the importer vouches for its pointer.
        let state = unsafe { place(state, "FMUstate") }?;
        let snapshot = component.instance.snapshot()?;
        // SAFETY: the importer vouches that a state that is not NULL came from here.
        match unsafe { state.cast::<Snapshot<M>>().as_mut() } {
            Some(old) => *old = snapshot,
            None => *state = Box::into_raw(Box::new(snapshot)).cast(),
        }
        Ok(())
    };
    // SAFETY: the importer vouches for the handle.
    unsafe { call(component, "fmi2GetFMUstate", Function::GetFmuState, body) }
}

/// `fmi2SetFMUstate`.
///
/// # Safety
/// `component` is NULL or a live handle of this model; `state` is NULL or a state of the same model.
pub unsafe extern "C" fn set_fmu_state<M: Model>(component: types::Component, state: FmuState) -> Status {
    let body = |component: &mut Component<M>| {
        // SAFETY: the importer vouches that a state that is not NULL came from here.
        let snapshot = unsafe { place(state.cast::<Snapshot<M>>(), "FMUstate") }?;
        Ok(component.instance.restore(snapshot)?)
    };
    // SAFETY: the importer vouches for the handle.
    unsafe { call(component, "fmi2SetFMUstate", Function::SetFmuState, body) }
}

/// `fmi2FreeFMUstate`; NULL is ignored.
///
/// # Safety
/// As [`get_fmu_state`].
pub unsafe extern "C" fn free_fmu_state<M: Model>(
    component: types::Component,
    state: *mut FmuState,
) -> Status {
    let body = |_: &mut Component<M>| {
        // SAFETY: the importer vouches for its pointer.
        let state = unsafe { place(state, "FMUstate") }?;
        if !state.is_null() {
            // SAFETY: it came from Box::into_raw, and the importer vouches that it was not freed.
            drop(unsafe { Box::from_raw(state.cast::<Snapshot<M>>()) });
            *state = std::ptr::null_mut();
        }
        Ok(())
    };
    // SAFETY: the importer vouches for the handle.
    unsafe { call(component, "fmi2FreeFMUstate", Function::FreeFmuState, body) }
}

/// `fmi2SerializedFMUstateSize`: refused, as `canSerializeFMUstate` says.
///
/// # Safety
/// `component` is NULL or a live handle of this model.
pub unsafe extern "C" fn serialized_fmu_state_size<M: Model>(
    component: types::Component,
    _state: FmuState,
    _size: *mut usize,
) -> Status {
    // SAFETY: the importer vouches for the handle.
    unsafe { refuse_serialization::<M>(component, "fmi2SerializedFMUstateSize") }
}

/// `fmi2SerializeFMUstate`: refused, as `canSerializeFMUstate` says.
///
/// # Safety
/// `component` is NULL or a live handle of this model.
pub unsafe extern "C" fn serialize_fmu_state<M: Model>(
    component: types::Component,
    _state: FmuState,
    _bytes: *mut u8,
    _size: usize,
) -> Status {
    // SAFETY: the importer vouches for the handle.
    unsafe { refuse_serialization::<M>(component, "fmi2SerializeFMUstate") }
}

/// `fmi2DeSerializeFMUstate`: refused, as `canSerializeFMUstate` says.
///
/// # Safety
/// `component` is NULL or a live handle of this model.
pub unsafe extern "C" fn deserialize_fmu_state<M: Model>(
    component: types::Component,
    _bytes: *const u8,
    _size: usize,
    _state: *mut FmuState,
) -> Status {
    // SAFETY: the importer vouches for the handle.
    unsafe { refuse_serialization::<M>(component, "fmi2DeSerializeFMUstate") }
}

unsafe fn refuse_serialization<M: Model>(component: types::Component, name: &str) -> Status {
    let body =
        |_: &mut Component<M>| Err(Refusal::Unsupported { flag: "canSerializeFMUstate = false" }.into());
    // SAFETY: the caller vouches for the handle.
    unsafe { call(component, name, Function::SerializeFmuState, body) }
}

/// `fmi2GetDirectionalDerivative`.
///
/// # Safety
/// `component` is NULL or a live handle of this model; the arrays have the lengths given.
pub unsafe extern "C" fn get_directional_derivative<M: Model>(
    component: types::Component,
    unknowns: *const u32,
    unknown_count: usize,
    knowns: *const u32,
    known_count: usize,
    seed: *const f64,
    sensitivity: *mut f64,
) -> Status {
    let body = |component: &mut Component<M>| {
        // SAFETY: the importer vouches for its arrays.
        let (unknowns, knowns, seed, sensitivity) = unsafe {
            (
                slice(unknowns, unknown_count, "vUnknown_ref")?,
                slice(knowns, known_count, "vKnown_ref")?,
                slice(seed, known_count, "dvKnown")?,
                slice_mut(sensitivity, unknown_count, "dvUnknown")?,
            )
        };
        let instance = &mut component.instance;
        instance.directional_derivative(unknowns, knowns, seed, sensitivity, &mut component.logger)
    };
    // SAFETY: the importer vouches for the handle.
    unsafe { call(component, "fmi2GetDirectionalDerivative", Function::GetDirectionalDerivative, body) }
}
