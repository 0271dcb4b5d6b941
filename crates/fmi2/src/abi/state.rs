//! Stored states and directional derivatives.

use crate::abi::component::{Component, call, functions};
use crate::abi::pointers::{exclusive, place, shared, slice, slice_mut};
use crate::abi::types::{self, FmuState, Status};
use crate::instance::Outcome;
use crate::states::bytes::Identity;
use crate::{Function, Model, Refusal, Snapshot};

functions! {
    /// `fmi2GetFMUstate`; a state that is passed in is overwritten.
    get_fmu_state(state: *mut FmuState) = GetFmuState, |own| {
        // SAFETY: the importer guarantees its pointers, here and below.
        let state = unsafe { exclusive(state, "FMUstate") }?;
        let snapshot = own.instance.snapshot()?;
        // SAFETY: the importer guarantees that a state other than NULL came from here, here and below.
        unsafe { hand_out(own, snapshot, state) }
    };
    /// `fmi2SetFMUstate`.
    set_fmu_state(state: FmuState) = SetFmuState, |own| {
        // SAFETY: as above.
        let snapshot = unsafe { held::<M>(own, state) }?;
        own.instance.restore(snapshot)?;
        own.last_step = Status::Ok;
        Ok(())
    };
    /// `fmi2FreeFMUstate`; NULL is ignored.
    free_fmu_state(state: *mut FmuState) = FreeFmuState, |own| {
        // SAFETY: as above.
        let state = unsafe { exclusive(state, "FMUstate") }?;
        if !state.is_null() {
            // SAFETY: as above.
            unsafe { held::<M>(own, *state) }?;
            // SAFETY: it came from Box::into_raw, and the importer guarantees that it was not freed.
            drop(unsafe { Box::from_raw(state.cast::<Snapshot<M>>()) });
            *state = std::ptr::null_mut();
        }
        Ok(())
    };
    /// `fmi2SerializedFMUstateSize`.
    serialized_fmu_state_size(state: FmuState, size: *mut usize) = SerializedFmuStateSize, |own| {
        // SAFETY: as above.
        let (snapshot, size) = unsafe { (held::<M>(own, state)?, place(size, "size")?) };
        size.write(own.instance.serialise(snapshot)?.len());
        Ok(())
    };
    /// `fmi2SerializeFMUstate`.
    serialize_fmu_state(state: FmuState, bytes: *mut u8, size: usize) = SerializeFmuState, |own| {
        // SAFETY: as above.
        let (snapshot, room) =
            unsafe { (held::<M>(own, state)?, slice_mut(bytes, size, "serializedState")?) };
        let serialised = own.instance.serialise(snapshot)?;
        let (found, expected) = (room.len(), serialised.len());
        let Some(room) = room.get_mut(..expected) else {
            return Err(Refusal::BufferTooSmall { found, expected }.into());
        };
        room.copy_from_slice(&serialised);
        Ok(())
    };
    /// `fmi2DeSerializeFMUstate`; a state that is passed in is overwritten.
    deserialize_fmu_state(bytes: *const u8, size: usize, state: *mut FmuState) = DeserializeFmuState, |own| {
        // SAFETY: as above.
        let (bytes, state) =
            unsafe { (slice(bytes, size, "serializedState")?, exclusive(state, "FMUstate")?) };
        let snapshot = own.instance.deserialise(bytes)?;
        // SAFETY: as above.
        unsafe { hand_out(own, snapshot, state) }
    };
    /// `fmi2GetDirectionalDerivative`.
    get_directional_derivative(
        unknowns: *const u32,
        unknown_count: usize,
        knowns: *const u32,
        known_count: usize,
        seed: *const f64,
        sensitivity: *mut f64
    ) = GetDirectionalDerivative, |own| {
        // SAFETY: as above.
        let (unknowns, knowns, seed, sensitivity) = unsafe {
            (
                slice(unknowns, unknown_count, "vUnknown_ref")?,
                slice(knowns, known_count, "vKnown_ref")?,
                slice(seed, known_count, "dvKnown")?,
                slice_mut(sensitivity, unknown_count, "dvUnknown")?,
            )
        };
        own.instance.directional_derivative(unknowns, knowns, seed, sensitivity, &mut own.logger)
    };
}

/// Returns the state behind a handle, if it belongs to this FMU. Several instances may restore it concurrently.
///
/// # Safety
/// `state` is NULL or a state of an FMU of this tool that is neither freed nor overwritten during the lifetime of the
/// reference.
unsafe fn held<'a, M: Model>(component: &Component<M>, state: FmuState) -> Result<&'a Snapshot<M>, Refusal> {
    // SAFETY: every state of this tool starts with the identity of its FMU.
    let identity = unsafe { shared(state.cast::<Identity>(), "FMUstate") }?;
    if *identity != component.instance.now.identity {
        return Err(Refusal::ForeignState);
    }
    // SAFETY: the identity is that of this FMU, so the state belongs to this model.
    unsafe { shared(state.cast::<Snapshot<M>>(), "FMUstate") }
}

/// Overwrites the state behind a handle, or allocates a new one if the handle is NULL.
///
/// # Safety
/// The conditions of [`held`] hold, and the state is not aliased.
unsafe fn hand_out<M: Model>(
    component: &Component<M>,
    snapshot: Snapshot<M>,
    state: &mut FmuState,
) -> Outcome<M> {
    if state.is_null() {
        *state = Box::into_raw(Box::new(snapshot)).cast();
        return Ok(());
    }
    // SAFETY: the caller guarantees the state.
    unsafe {
        held(component, *state)?;
        *exclusive(state.cast::<Snapshot<M>>(), "FMUstate")? = snapshot;
    }
    Ok(())
}
