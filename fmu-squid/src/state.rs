//! The state of the loop as bytes.

use fmi2::{Model, StateError, StateReader, StateWriter};

use crate::ClosedLoop;

impl ClosedLoop {
    /// Writes manoeuvre, references from outside, plant and controller.
    pub(crate) fn write(&self, to: &mut StateWriter) {
        let mut manoeuvre = self.manoeuvre.clone();
        manoeuvre.numbers().into_iter().for_each(|number| to.real(*number));
        to.boolean(self.outside.manual);
        to.reals(&[self.outside.pitch_reference, self.outside.speed_reference]);
        self.plant.save(to);
        self.controller.save(to);
    }

    /// Reads what [`ClosedLoop::write`] wrote, into a loop of the same vehicle and design.
    pub(crate) fn read(&mut self, from: &mut StateReader<'_>) -> Result<(), StateError> {
        for number in self.manoeuvre.numbers() {
            *number = from.finite()?;
        }
        self.outside.manual = from.boolean()?;
        self.outside.pitch_reference = from.finite()?;
        self.outside.speed_reference = from.finite()?;
        self.plant.recall(from)?;
        self.controller.recall(from)
    }
}
