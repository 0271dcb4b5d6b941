//! The state of the loop as bytes.

use fmi2::{Model, StateError, StateReader, StateWriter};

use crate::{ClosedLoop, Override};

impl ClosedLoop {
    /// Writes manoeuvre, external references, plant and controller.
    pub(crate) fn write(&self, to: &mut StateWriter) {
        let mut manoeuvre = self.manoeuvre.clone();
        manoeuvre.numbers().into_iter().for_each(|number| to.real(*number));
        to.boolean(self.outside.manual);
        let Override { pitch_reference, speed_reference, pitch_slope, speed_slope, .. } = self.outside;
        to.reals(&[pitch_reference, speed_reference, pitch_slope, speed_slope]);
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
        self.outside.pitch_slope = from.finite()?;
        self.outside.speed_slope = from.finite()?;
        self.plant.restore(from)?;
        self.controller.restore(from)
    }
}
