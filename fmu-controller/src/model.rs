//! The autopilot as a model: a sampled controller with its held inputs and outputs.

use std::sync::Arc;

use fmi2::{Log, ResourceError, rounding_of_time};
use scheduled::{Autopilot, ControllerDesign, DesignError, Inputs, TickError};

/// The frozen design in `resources/`.
pub const RESOURCE: &str = "controller.json";

/// A sampled controller with its held inputs and outputs.
#[derive(Debug, Clone)]
pub struct Controller {
    pub(crate) design: Arc<ControllerDesign>,
    pub(crate) autopilot: Autopilot,
    /// Measurements and references; the next tick uses them.
    pub inputs: Inputs,
}

/// Errors of the controller.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs, reason = "the message says what each field is")]
pub enum ControllerError {
    /// The design cannot be read.
    #[error(transparent)]
    Resource(#[from] ResourceError),
    /// The design is not allowed.
    #[error("resources/{RESOURCE}: {0}")]
    Design(#[from] DesignError),
    /// A tick could not be computed.
    #[error(transparent)]
    Tick(#[from] TickError),
    /// More ticks are due at once than in any flight, which only a manipulated state can cause.
    #[error("the next tick belongs to {tick} s, and the flight has come to {time} s without it")]
    Behind { tick: f64, time: f64 },
}

impl Controller {
    /// The controller of a design, flying level in the middle of the scheduled speeds, so that a simulation with
    /// default values stays in trim.
    ///
    /// # Errors
    /// [`DesignError`].
    pub fn new(design: ControllerDesign) -> Result<Self, DesignError> {
        let autopilot = Autopilot::new(&design)?;
        let inputs = autopilot.level(design.scheduling.centre);
        Ok(Self { design: Arc::new(design), autopilot, inputs })
    }

    /// The frozen design.
    pub fn design(&self) -> &ControllerDesign {
        &self.design
    }

    /// The autopilot with its outputs and ticks.
    pub fn autopilot(&self) -> &Autopilot {
        &self.autopilot
    }

    /// What an actuator gets: the autopilot's command, through the inverse of its curve if it has one.
    pub fn command(&self, index: usize) -> f64 {
        self.design.actuators[index].taken(self.autopilot.outputs().commands[index]).0
    }

    /// Runs the next tick with the present inputs, whatever the time.
    ///
    /// # Errors
    /// [`ControllerError::Tick`].
    pub fn tick(&mut self, log: &mut dyn Log) -> Result<(), ControllerError> {
        if self.autopilot.tick(&self.inputs)? {
            self.warn_of_range(log);
        }
        Ok(())
    }

    /// Checks that at most one tick is overdue at a time in s.
    ///
    /// # Errors
    /// [`ControllerError::Behind`].
    pub fn keeps_up(&self, time: f64) -> Result<(), ControllerError> {
        let tick = self.autopilot.next_tick_time();
        if time - tick <= self.design.sample_time + rounding_of_time(time) {
            Ok(())
        } else {
            Err(ControllerError::Behind { tick, time })
        }
    }

    pub(crate) fn warn_of_range(&self, log: &mut dyn Log) {
        let (speed, rho) =
            (self.autopilot.speed(&self.inputs), self.autopilot.outputs().scheduling_parameter);
        let along_path = self.autopilot.trim().speed(speed);
        let scheduling = &self.design.scheduling;
        log.warn(&format!(
                "The forward speed {speed} m/s, in trim {along_path} m/s along the path, lies outside the scheduled \
                 range of {} to {} m/s; the scheduling parameter is held at {rho} until it returns.",
                scheduling.minimum, scheduling.maximum
            ),
        );
    }
}
