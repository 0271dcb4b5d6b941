//! The loop for an external integrator: the states are those of the plant, and every tick of the autopilot is a time
//! event.

use fmi2::{ContinuousModel, Log};

use crate::{ClosedLoop, ClosedLoopError};

impl ContinuousModel for ClosedLoop {
    fn states(&self, states: &mut [f64]) {
        self.plant.states(states);
    }

    fn set_states(&mut self, states: &[f64]) {
        self.plant.set_states(states);
    }

    fn set_time(&mut self, time: f64) {
        self.plant.set_time(time);
    }

    fn apply_inputs(&mut self) -> Result<(), ClosedLoopError> {
        Ok(self.plant.apply_inputs()?)
    }

    fn derivatives(&self, rates: &mut [f64]) {
        self.plant.derivatives(rates);
    }

    fn input_rates(&self, tangents: &mut [f64]) {
        self.plant.input_rates(tangents);
    }

    fn next_event(&self) -> Option<f64> {
        Some(self.controller.autopilot().next_tick_time())
    }

    /// Runs the tick that is due; one at a time, so that no event can take long.
    fn event(&mut self, time: f64, log: &mut dyn Log) -> Result<(), ClosedLoopError> {
        if self.controller.autopilot().is_due_at(time) {
            self.tick(log)?;
        }
        Ok(())
    }

    fn step_completed(&mut self, log: &mut dyn Log) {
        self.plant.step_completed(log);
    }
}
