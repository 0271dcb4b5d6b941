//! Exact derivatives of the commands by the inputs, from the LFT closed at the present speed.

use fmi2::Moment;
use scheduled::Inputs;

use crate::{Controller, ControllerError};

/// Numbers of the quantities: the four inputs, two monitors, then the commands.
pub(crate) const PITCH: usize = 0;
pub(crate) const SPEED: usize = 1;
pub(crate) const PITCH_REFERENCE: usize = 2;
pub(crate) const SPEED_REFERENCE: usize = 3;
pub(crate) const SCHEDULING_PARAMETER: usize = 4;
pub(crate) const TRIM_PITCH: usize = 5;
pub(crate) const COMMANDS: usize = 6;

impl Controller {
    /// Fills in the tangents of the outputs from those of the inputs.
    ///
    /// In the initialization they are those of the first outputs. Later they are those of the tick that the next step runs
    /// at once, if one is due, and zero between ticks.
    ///
    /// # Errors
    /// [`ControllerError::Tick`].
    pub fn carry(&self, moment: Moment, tangents: &mut [f64]) -> Result<(), ControllerError> {
        let due = self.autopilot.is_due_at(moment.time);
        if !moment.initial && !due {
            tangents[SCHEDULING_PARAMETER..].fill(0.0);
            return Ok(());
        }
        let direction = Inputs {
            pitch: tangents[PITCH],
            speed: tangents[SPEED],
            pitch_reference: tangents[PITCH_REFERENCE],
            speed_reference: tangents[SPEED_REFERENCE],
        };
        let moved = self.autopilot.tangents(&self.inputs, &direction)?;
        tangents[SCHEDULING_PARAMETER] = moved.scheduling_parameter;
        tangents[TRIM_PITCH] = moved.trim_pitch;
        tangents[COMMANDS..].copy_from_slice(&moved.commands);
        Ok(())
    }
}
