//! The state of the loop as bytes.

use fmi2::{Model, StateError, StateReader, StateWriter};

use crate::ClosedLoop;

impl ClosedLoop {
    /// Writes manoeuvre, external references, plant and controller.
    pub(crate) fn write(&self, to: &mut StateWriter) {
        let mut manoeuvre = self.manoeuvre.clone();
        manoeuvre.numbers().into_iter().for_each(|number| to.real(*number));
        to.boolean(self.outside.manual);
        let mut outside = self.outside;
        outside.numbers().for_each(|number| to.real(*number));
        self.plant.save(to);
        self.controller.save(to);
    }

    /// Reads what [`ClosedLoop::write`] wrote, into a loop of the same vehicle and design.
    pub(crate) fn read(&mut self, from: &mut StateReader<'_>) -> Result<(), StateError> {
        for number in self.manoeuvre.numbers() {
            *number = from.finite()?;
        }
        self.outside.manual = from.boolean()?;
        for number in self.outside.numbers() {
            *number = from.finite()?;
        }
        self.plant.restore(from)?;
        self.controller.restore(from)
    }
}
