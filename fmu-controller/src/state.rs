//! The state of the controller as bytes.

use fmi2::{StateError, StateReader, StateWriter};

use crate::Controller;

impl Controller {
    /// Writes the inputs and all that the autopilot remembers.
    pub(crate) fn write(&self, to: &mut StateWriter) {
        let inputs = &self.inputs;
        to.reals(&inputs.measured);
        to.reals(&inputs.references);
        let memory = self.autopilot.memory();
        to.reals(&memory.state);
        to.reals(&memory.outputs.commands);
        to.reals(&[memory.outputs.scheduling_parameter, memory.outputs.trim_pitch]);
        to.boolean(memory.outputs.out_of_range);
        to.real(memory.start);
        to.integer(memory.ticks);
        to.boolean(memory.outside);
    }

    /// Reads what [`Controller::write`] wrote, into a controller of the same design.
    pub(crate) fn read(&mut self, from: &mut StateReader<'_>) -> Result<(), StateError> {
        let inputs = &mut self.inputs;
        for number in inputs.measured.iter_mut().chain(&mut inputs.references) {
            *number = from.finite()?;
        }
        let mut memory = self.autopilot.memory();
        from.reals(&mut memory.state)?;
        from.reals(&mut memory.outputs.commands)?;
        memory.outputs.scheduling_parameter = from.finite()?;
        memory.outputs.trim_pitch = from.finite()?;
        memory.outputs.out_of_range = from.boolean()?;
        memory.start = from.finite()?;
        memory.ticks = from.integer()?;
        memory.outside = from.boolean()?;
        self.autopilot.recall(&memory).map_err(StateError::inconsistent)
    }
}
