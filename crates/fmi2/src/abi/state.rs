//! Stored states and directional derivatives.

use crate::abi::component::{Component, call};
use crate::abi::pointers::{exclusive, place, shared, slice, slice_mut};
use crate::abi::types::{self, FmuState, Status};
use crate::states::bytes::Identity;
use crate::{Failure, Function, Model, Refusal, Snapshot};

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
        let state = unsafe { exclusive(state, "FMUstate") }?;
        let snapshot = component.instance.snapshot()?;
        // SAFETY: the importer vouches that a state that is not NULL came from here.
        unsafe { hand_out(component, snapshot, state) }
    };
    // SAFETY: the importer vouches for the handle.
    unsafe { call(component, Function::GetFmuState, body) }
}

/// `fmi2SetFMUstate`.
///
/// # Safety
/// `component` is NULL or a live handle of this model; `state` is NULL or a state of the same model.
pub unsafe extern "C" fn set_fmu_state<M: Model>(component: types::Component, state: FmuState) -> Status {
    let body = |component: &mut Component<M>| {
        // SAFETY: the importer vouches that a state that is not NULL came from here.
        let snapshot = unsafe { held::<M>(component, state) }?;
        component.instance.restore(snapshot)?;
        component.last_step = Status::Ok;
        Ok(())
    };
    // SAFETY: the importer vouches for the handle.
    unsafe { call(component, Function::SetFmuState, body) }
}

/// `fmi2FreeFMUstate`; NULL is ignored.
///
/// # Safety
/// As [`get_fmu_state`].
pub unsafe extern "C" fn free_fmu_state<M: Model>(
    component: types::Component,
    state: *mut FmuState,
) -> Status {
    let body = |component: &mut Component<M>| {
        // SAFETY: the importer vouches for its pointer.
        let state = unsafe { exclusive(state, "FMUstate") }?;
        if !state.is_null() {
            // SAFETY: the importer vouches that a state that is not NULL came from here.
            unsafe { held::<M>(component, *state) }?;
            // SAFETY: it came from Box::into_raw, and the importer vouches that it was not freed.
            drop(unsafe { Box::from_raw(state.cast::<Snapshot<M>>()) });
            *state = std::ptr::null_mut();
        }
        Ok(())
    };
    // SAFETY: the importer vouches for the handle.
    unsafe { call(component, Function::FreeFmuState, body) }
}

/// `fmi2SerializedFMUstateSize`.
///
/// # Safety
/// As [`set_fmu_state`]; `size` is NULL or a place to write to.
pub unsafe extern "C" fn serialized_fmu_state_size<M: Model>(
    component: types::Component,
    state: FmuState,
    size: *mut usize,
) -> Status {
    let body = |component: &mut Component<M>| {
        // SAFETY: the importer vouches for its pointers.
        let (snapshot, size) = unsafe { (held::<M>(component, state)?, place(size, "size")?) };
        size.write(component.instance.serialise(snapshot)?.len());
        Ok(())
    };
    // SAFETY: the importer vouches for the handle.
    unsafe { call(component, Function::SerializedFmuStateSize, body) }
}

/// `fmi2SerializeFMUstate`.
///
/// # Safety
/// As [`set_fmu_state`]; `bytes` is NULL or has room for `size` bytes.
pub unsafe extern "C" fn serialize_fmu_state<M: Model>(
    component: types::Component,
    state: FmuState,
    bytes: *mut u8,
    size: usize,
) -> Status {
    let body = |component: &mut Component<M>| {
        // SAFETY: the importer vouches for its pointers.
        let (snapshot, room) =
            unsafe { (held::<M>(component, state)?, slice_mut(bytes, size, "serializedState")?) };
        let serialised = component.instance.serialise(snapshot)?;
        let (found, expected) = (room.len(), serialised.len());
        let Some(room) = room.get_mut(..expected) else {
            return Err(Refusal::BufferTooSmall { found, expected }.into());
        };
        room.copy_from_slice(&serialised);
        Ok(())
    };
    // SAFETY: the importer vouches for the handle.
    unsafe { call(component, Function::SerializeFmuState, body) }
}

/// `fmi2DeSerializeFMUstate`; a state that is passed in is overwritten.
///
/// # Safety
/// As [`get_fmu_state`]; `bytes` is NULL or points to `size` bytes.
pub unsafe extern "C" fn deserialize_fmu_state<M: Model>(
    component: types::Component,
    bytes: *const u8,
    size: usize,
    state: *mut FmuState,
) -> Status {
    let body = |component: &mut Component<M>| {
        // SAFETY: the importer vouches for its pointers.
        let (bytes, state) =
            unsafe { (slice(bytes, size, "serializedState")?, exclusive(state, "FMUstate")?) };
        let snapshot = component.instance.deserialise(bytes)?;
        // SAFETY: the importer vouches that a state that is not NULL came from here.
        unsafe { hand_out(component, snapshot, state) }
    };
    // SAFETY: the importer vouches for the handle.
    unsafe { call(component, Function::DeserializeFmuState, body) }
}

/// The state behind a handle, if it is one of this FMU. Several instances may restore it at the same time.
///
/// # Safety
/// `state` is NULL or a state of an FMU of this tool, that was not freed and is not overwritten while the reference
/// lives.
unsafe fn held<'a, M: Model>(component: &Component<M>, state: FmuState) -> Result<&'a Snapshot<M>, Refusal> {
    // SAFETY: every state of this tool begins with the identity of its FMU.
    let identity = unsafe { shared(state.cast::<Identity>(), "FMUstate") }?;
    if *identity != component.instance.now.identity {
        return Err(Refusal::ForeignState);
    }
    // SAFETY: the identity is that of this FMU, so that the state is one of this model.
    unsafe { shared(state.cast::<Snapshot<M>>(), "FMUstate") }
}

/// Overwrites the state behind a handle, or makes a new one where it is NULL.
///
/// # Safety
/// As [`held`], and nobody else uses the state.
unsafe fn hand_out<M: Model>(
    component: &Component<M>,
    snapshot: Snapshot<M>,
    state: &mut FmuState,
) -> Result<(), Failure<M::Error>> {
    if state.is_null() {
        *state = Box::into_raw(Box::new(snapshot)).cast();
        return Ok(());
    }
    // SAFETY: the caller vouches for it.
    unsafe {
        held(component, *state)?;
        *exclusive(state.cast::<Snapshot<M>>(), "FMUstate")? = snapshot;
    }
    Ok(())
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
    unsafe { call(component, Function::GetDirectionalDerivative, body) }
}
