//! Exact derivatives of the commands with respect to the inputs, from the LFT closed at the present speed.

use fmi2::Moment;
use scheduled::{Inputs, OutputTangents};
use signals::{SIGNALS, TRACKED};

use crate::{Controller, ControllerError};

/// Numbers of the quantities: measurements, references, two monitors, then the commands.
pub(crate) const MEASURED: usize = 0;
pub(crate) const REFERENCES: usize = SIGNALS.len();
pub(crate) const SCHEDULING_PARAMETER: usize = REFERENCES + TRACKED;
pub(crate) const TRIM_PITCH: usize = SCHEDULING_PARAMETER + 1;
pub(crate) const COMMANDS: usize = TRIM_PITCH + 1;

impl Controller {
    /// The tangents of the outputs along a direction of the inputs, as [`scheduled::Autopilot::tangents`] gives them,
    /// the commands through the inverse of their curves.
    ///
    /// # Errors
    /// [`ControllerError::Tick`].
    pub fn tangents(&self, initial: bool, direction: &Inputs) -> Result<OutputTangents, ControllerError> {
        let mut moved = self.autopilot.tangents(initial, &self.inputs, direction)?;
        let computed = moved.computed.iter().zip(&self.design.actuators);
        for (tangent, (command, actuator)) in moved.commands.iter_mut().zip(computed) {
            *tangent *= actuator.taken(*command).1;
        }
        Ok(moved)
    }

    /// Fills in the tangents of the outputs from those of the inputs.
    ///
    /// In the initialization they are those of the first outputs. Later they are those of the tick that the next step
    /// runs at once, if one is due, and zero between ticks.
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
            measured: std::array::from_fn(|i| tangents[MEASURED + i]),
            references: std::array::from_fn(|i| tangents[REFERENCES + i]),
        };
        let moved = self.tangents(moment.initial, &direction)?;
        tangents[SCHEDULING_PARAMETER] = moved.scheduling_parameter;
        tangents[TRIM_PITCH] = moved.trim_pitch;
        tangents[COMMANDS..].copy_from_slice(&moved.commands);
        Ok(())
    }
}
