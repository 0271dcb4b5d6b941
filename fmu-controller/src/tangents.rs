//! Exact derivatives of the commands with respect to the inputs, from the LFT frozen at the current speed.

use squid_fmi2::Moment;
use squid_scheduled::{ControllerDesign, Inputs, OutputTangents};

use crate::{Axis, ControllerError};

/// Quantities, in the order of their numbers.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Quantity {
    /// Measured value of a signal.
    Measured(usize),
    /// Reference of a signal.
    Reference(usize),
    SchedulingParameter,
    /// Reference as used by the controller.
    Used(usize),
    /// Trim value that is an output.
    Trim(usize),
    Command(usize),
    /// Applied command of an actuator.
    Applied(usize),
}

impl Quantity {
    /// Returns the number of quantities.
    pub(crate) fn count(design: &ControllerDesign) -> usize {
        Self::Applied(design.actuators.len()).number(design)
    }

    pub(crate) fn number(self, design: &ControllerDesign) -> usize {
        let measured = design.signals.len();
        let references = measured + design.references().count();
        match self {
            Self::Measured(signal) => signal,
            Self::Reference(signal) => measured + signal,
            Self::SchedulingParameter => references,
            Self::Used(signal) => references + 1 + signal,
            Self::Trim(index) => Self::Used(design.references().count()).number(design) + index,
            Self::Command(index) => Self::Trim(design.trimmed().count()).number(design) + index,
            Self::Applied(index) => Self::Command(design.actuators.len()).number(design) + index,
        }
    }
}

impl Axis {
    /// Returns the tangents of the outputs along a direction of the inputs, as [`squid_scheduled::Autopilot::tangents`]
    /// does, those of the commands through the inverse of their curves. `is_first` is `true` for the first tick of
    /// `step`, which initialises the controller.
    ///
    /// # Errors
    /// [`ControllerError::Tick`], [`ControllerError::UsesApplied`], [`ControllerError::Opens`],
    /// [`ControllerError::SensorLost`].
    pub fn tangents(
        &self,
        initial: bool,
        is_first: bool,
        direction: &Inputs,
    ) -> Result<OutputTangents, ControllerError> {
        if self.follows() || self.applied.given {
            return Err(ControllerError::UsesApplied);
        }
        if self.autopilot.opens() {
            return Err(ControllerError::Opens);
        }
        if !initial && !self.is_complete() {
            return Err(ControllerError::SensorLost);
        }
        let mut moved = if is_first && !initial {
            self.autopilot.first_tangents(&self.inputs, direction)?
        } else {
            self.autopilot.tangents(initial, &self.inputs, direction)?
        };
        let computed = moved.computed.iter().zip(&self.design.actuators);
        for (tangent, (command, actuator)) in moved.commands.iter_mut().zip(computed) {
            *tangent *= actuator.input_for(*command).1;
        }
        Ok(moved)
    }

    /// Computes the tangents of the outputs from those of the inputs.
    ///
    /// During initialisation they are those of the first outputs; later those of a tick due at the start of the next
    /// step, and zero between ticks.
    ///
    /// # Errors
    /// [`ControllerError::Tick`].
    pub fn carry(&self, moment: Moment, tangents: &mut [f64]) -> Result<(), ControllerError> {
        let due = self.autopilot.is_due_at(moment.time);
        let number = |quantity: Quantity| quantity.number(&self.design);
        // Applied commands affect no output here: the cases in which they do are refused above.
        let (tangents, _) = tangents.split_at_mut(number(Quantity::Applied(0)));
        let (knowns, outputs) = tangents.split_at_mut(number(Quantity::SchedulingParameter));
        if !moment.initial && !due {
            outputs.fill(0.0);
            return Ok(());
        }
        let (measured, references) = knowns.split_at(number(Quantity::Reference(0)));
        let direction = Inputs { measured: measured.to_vec(), references: references.to_vec() };
        let moved = self.tangents(moment.initial, self.autopilot.ticks() == 0, &direction)?;
        let first = std::iter::once(moved.scheduling_parameter).chain(moved.references);
        let all = first.chain(moved.trim).chain(moved.commands);
        outputs.iter_mut().zip(all).for_each(|(tangent, value)| *tangent = value);
        Ok(())
    }
}
