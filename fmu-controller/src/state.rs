//! The state of the controller as bytes.

use fmi2::{StateError, StateReader, StateWriter};

use crate::Controller;

impl Controller {
    /// Writes the inputs and the state of the autopilot.
    pub(crate) fn write(&self, to: &mut StateWriter) {
        let inputs = &self.inputs;
        to.reals(&inputs.measured);
        to.reals(&inputs.references);
        let snapshot = self.autopilot.snapshot();
        to.reals(&snapshot.state);
        to.reals(&[snapshot.filtered_speed, snapshot.depth]);
        to.reals(&snapshot.outputs.commands);
        to.reals(&[snapshot.outputs.scheduling_parameter, snapshot.outputs.trim_pitch]);
        to.boolean(snapshot.outputs.out_of_range);
        to.reals(&snapshot.waiting);
        to.real(snapshot.start);
        to.integer(snapshot.ticks);
        to.boolean(snapshot.outside);
    }

    /// Reads what [`Controller::write`] wrote, into a controller of the same design.
    pub(crate) fn read(&mut self, from: &mut StateReader<'_>) -> Result<(), StateError> {
        let inputs = &mut self.inputs;
        for number in inputs.measured.iter_mut().chain(&mut inputs.references) {
            *number = from.finite()?;
        }
        let mut snapshot = self.autopilot.snapshot();
        from.reals(&mut snapshot.state)?;
        snapshot.filtered_speed = from.finite()?;
        snapshot.depth = from.finite()?;
        from.reals(&mut snapshot.outputs.commands)?;
        snapshot.outputs.scheduling_parameter = from.finite()?;
        snapshot.outputs.trim_pitch = from.finite()?;
        snapshot.outputs.out_of_range = from.boolean()?;
        from.reals(&mut snapshot.waiting)?;
        snapshot.start = from.finite()?;
        snapshot.ticks = from.integer()?;
        snapshot.outside = from.boolean()?;
        self.autopilot.restore(&snapshot).map_err(StateError::inconsistent)
    }
}
