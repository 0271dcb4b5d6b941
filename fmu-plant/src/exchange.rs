//! The plant for an external integrator: states, their rates, and inputs that act at once.
//!
//! The states are velocities over ground along the body, pitch rate, pitch, distance, depth, and the output of each
//! actuator that lags. The equations have no jumps, only corners, where a velocity or the Reynolds number
//! of friction passes its threshold and where a command or its rate passes a limit, so that no event is needed.

use auv::{Instant, Rates, Slopes};
use fmi2::{ContinuousModel, Log};

use crate::{PlantError, PlantModel, Quantity};

impl PlantModel {
    /// The present motion under the present inputs; a new current does not change the velocity over ground.
    pub fn instant(&self) -> Instant {
        let under_inputs = Instant {
            current_horizontal: self.inputs.current.horizontal,
            current_vertical: self.inputs.current.vertical,
            operating_speed: self.inputs.operating_speed,
            given_speed: self.inputs.given_speed,
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
        match actuator.lag > 0.0 {
            true => self.plant.outputs()[index],
            false => actuator.saturate(self.asked(index)),
        }
    }

    /// Indices of the actuators whose output is a state.
    pub(crate) fn lagging(&self) -> impl Iterator<Item = usize> {
        let actuators = self.vehicle.actuators.iter().enumerate();
        actuators.filter(|(_, actuator)| actuator.lag > 0.0).map(|(index, _)| index)
    }
}

impl ContinuousModel for PlantModel {
    fn states(&self, states: &mut [f64]) {
        let now = self.plant.instant();
        let motion = [now.surge, now.heave, now.pitch_rate, now.pitch, now.distance, now.depth];
        let outputs = self.lagging().map(|index| self.plant.outputs()[index]);
        for (state, value) in states.iter_mut().zip(motion.into_iter().chain(outputs)) {
            *state = value;
        }
    }

    fn set_states(&mut self, states: &[f64]) {
        let [surge, heave, pitch_rate, pitch, distance, depth, outputs @ ..] = states else { return };
        let (surge, heave, pitch_rate, pitch) = (*surge, *heave, *pitch_rate, *pitch);
        let (distance, depth) = (*distance, *depth);
        let instant = Instant { surge, heave, pitch_rate, pitch, distance, depth, ..self.plant.instant() };
        self.plant.set_motion_over_ground(&instant);
        let mut outputs = outputs.iter();
        for index in 0..self.vehicle.actuators.len() {
            if self.vehicle.actuators[index].lag > 0.0
                && let Some(&output) = outputs.next()
            {
                self.plant.set_output(index, output);
            }
        }
    }

    fn set_time(&mut self, time: f64) {
        self.plant.set_time(time);
    }

    fn apply_inputs(&mut self) -> Result<(), PlantError> {
        self.obey_commands()?;
        self.plant.set_current(self.inputs.current)?;
        self.plant.set_given_speed(self.inputs.given_speed)?;
        Ok(self.plant.set_operating_speed(self.inputs.operating_speed)?)
    }

    fn derivatives(&self, rates: &mut [f64]) {
        let Rates { surge, heave, pitch_rate, pitch, distance, depth } = self.rates();
        let motion = [surge, heave, pitch_rate, pitch, distance, depth];
        let outputs = self.lagging().map(|index| self.output_rate(index));
        for (rate, value) in rates.iter_mut().zip(motion.into_iter().chain(outputs)) {
            *rate = value;
        }
    }

    fn input_rates(&self, tangents: &mut [f64]) {
        let Slopes { commands, current, operating_speed, given_speed } = &self.slopes;
        for (index, &rate) in commands.iter().enumerate() {
            tangents[Quantity::Command(index).number()] = rate;
        }
        tangents[Quantity::CurrentHorizontal.number()] = current.horizontal;
        tangents[Quantity::CurrentVertical.number()] = current.vertical;
        tangents[Quantity::OperatingSpeed.number()] = *operating_speed;
        tangents[Quantity::GivenSpeed.number()] = *given_speed;
        tangents[Quantity::Time.number()] = 1.0;
    }

    fn step_completed(&mut self, log: &mut dyn Log) {
        self.warn(log);
    }
}
