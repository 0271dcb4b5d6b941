//! The plant for an external integrator: states, their derivatives, and inputs with immediate effect.
//!
//! The states are velocities over ground along the body axes, angular velocities, angles, position, and the output of
//! each actuator with a lag; in the vertical plane surge, heave, pitch rate, pitch, distance and depth. The right-hand
//! side is continuous. It is not smooth only where a velocity or the Reynolds number of friction crosses its threshold
//! and where a command or its rate reaches a limit, so that no events are needed.

use squid_auv::{Instant, Rates};

use crate::{PlantError, PlantModel};

impl PlantModel {
    /// Returns the current motion under the current inputs; a change of the water current does not change the velocity
    /// over ground.
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

    /// Returns the time derivatives of the current motion under the current inputs.
    pub fn rates(&self) -> Rates {
        self.plant.rates(&self.instant(), |index| self.output_under_inputs(index))
    }

    /// Returns the rate of an actuator's output.
    pub fn output_rate(&self, index: usize) -> f64 {
        let output = self.plant.outputs()[index];
        self.plant.actuators()[index].output_rate(output, self.requested_output(index))
    }

    /// Returns the output that an input requests from an actuator.
    fn requested_output(&self, index: usize) -> f64 {
        self.plant.actuators()[index].requested_output(self.inputs.commands[index]).0
    }

    /// Applies the commands; an actuator without lag follows immediately.
    pub(crate) fn apply_commands(&mut self) -> Result<(), PlantError> {
        for index in 0..self.inputs.commands.len() {
            self.plant.set_command(index, self.requested_output(index))?;
            let output = self.output_under_inputs(index);
            self.plant.set_output(index, output);
        }
        Ok(())
    }

    fn output_under_inputs(&self, index: usize) -> f64 {
        let actuator = &self.plant.actuators()[index];
        if actuator.lag > 0.0 {
            self.plant.outputs()[index]
        } else {
            actuator.saturate(self.requested_output(index))
        }
    }

    /// Returns the indices of the actuators whose output is a state.
    pub(crate) fn lagging(&self) -> impl Iterator<Item = usize> {
        let actuators = self.vehicle.actuators.iter().enumerate();
        actuators.filter(|(_, actuator)| actuator.lag > 0.0).map(|(index, _)| index)
    }
}
