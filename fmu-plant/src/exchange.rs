//! The plant for an external integrator: states, their rates, and inputs that act at once.
//!
//! The states are velocities over ground along the body, angular velocities, angles, the place, and the output of each
//! actuator that lags; in the vertical plane surge, heave, pitch rate, pitch, distance and depth. The equations have no
//! jumps, only corners, where a velocity or the Reynolds number of friction passes its threshold and where a command or
//! its rate passes a limit, so that no event is needed.

use squid_auv::{Instant, Rates};

use crate::{PlantError, PlantModel};

impl PlantModel {
    /// The present motion under the present inputs; a new current does not change the velocity over ground.
    pub fn instant(&self) -> Instant {
        let under_inputs = Instant {
            current: self.inputs.current.in_earth(),
            operating_speed: self.inputs.operating_speed,
            given_speed: self.inputs.given_speed,
            load: self.inputs.load,
            ..self.plant.instant()
        };
        self.plant.in_water(&under_inputs)
    }

    /// The rates of the present motion under the present inputs.
    pub fn rates(&self) -> Rates {
        self.plant.rates(&self.instant(), |index| self.output_under_inputs(index))
    }

    /// The present rate of an actuator's output.
    pub fn output_rate(&self, index: usize) -> f64 {
        let output = self.plant.outputs()[index];
        self.plant.actuators()[index].output_rate(output, self.asked(index))
    }

    /// The output that an input asks an actuator for.
    fn asked(&self, index: usize) -> f64 {
        self.plant.actuators()[index].asked(self.inputs.commands[index]).0
    }

    /// Applies the commands: an actuator without lag follows at once.
    pub(crate) fn obey_commands(&mut self) -> Result<(), PlantError> {
        for index in 0..self.inputs.commands.len() {
            self.plant.set_command(index, self.asked(index))?;
            let output = self.output_under_inputs(index);
            self.plant.set_output(index, output);
        }
        Ok(())
    }

    fn output_under_inputs(&self, index: usize) -> f64 {
        let actuator = &self.plant.actuators()[index];
        if actuator.lag > 0.0 { self.plant.outputs()[index] } else { actuator.saturate(self.asked(index)) }
    }

    /// Indices of the actuators whose output is a state.
    pub(crate) fn lagging(&self) -> impl Iterator<Item = usize> {
        let actuators = self.vehicle.actuators.iter().enumerate();
        actuators.filter(|(_, actuator)| actuator.lag > 0.0).map(|(index, _)| index)
    }
}
