//! One axis of the autopilot: a sampled controller with its held inputs and outputs.

use std::sync::Arc;

use squid_fmi2::{Log, ResourceError, Resources, SavedState, StateError, rounding_of_time};
use squid_scheduled::{
    Autopilot, ControllerDesign, DesignError, Health, Inputs, Reading, Supervised, Supervisor, TickError,
    Transition,
};

/// File of the first axis's frozen design in `resources/`; the second is `controller_2.json`, and so on.
pub const RESOURCE: &str = "controller.json";

/// A sampled controller with its held inputs and outputs.
#[derive(Debug, Clone)]
pub struct Axis {
    pub(crate) design: Arc<ControllerDesign>,
    pub(crate) autopilot: Autopilot,
    supervisor: Supervisor,
    /// Measurements and references, used by the next tick.
    pub inputs: Inputs,
    /// `true` for each signal whose measured value is valid.
    pub valid: Vec<bool>,
    /// Time after which a constant measurement that should have changed is considered lost \[s\]; 0 disables the check.
    pub stale_after: f64,
    /// Commands that the actuators receive, and their origin.
    pub applied: Applied,
    /// `true` if the autopilot was engaged at the last tick.
    was_engaged: bool,
}

/// Commands that the actuators receive, as reported to the autopilot.
#[derive(Debug, Clone)]
pub struct Applied {
    /// `true` if the actuators receive the autopilot's commands.
    pub engaged: bool,
    /// `true` if `commands` is what the actuators receive even while the autopilot is engaged.
    pub given: bool,
    /// Applied commands in the units of the FMU's outputs; for a thruster with a curve the argument of the curve.
    pub commands: Vec<f64>,
    /// Applied commands in the units of the actuators' outputs.
    outputs: Vec<f64>,
}

/// Errors of the controller.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs, reason = "the message says what each field is")]
pub enum ControllerError {
    /// The design cannot be read.
    #[error(transparent)]
    Resource(#[from] ResourceError),
    /// The design is invalid.
    #[error("resources/{file}: {reason}")]
    Design {
        file: String,
        #[source]
        reason: DesignError,
    },
    /// Two axes are incompatible.
    #[error("resources/{file}: {what} is '{found}', but that of the other axes is '{expected}'")]
    OtherAxes { file: String, what: &'static str, found: String, expected: String },
    /// Two axes command the same actuator.
    #[error("resources/{file}: the actuator '{name}' is also commanded by another axis")]
    SharedActuator { file: String, name: String },
    /// A tick failed.
    #[error(transparent)]
    Tick(#[from] TickError),
    /// Derivatives were requested for a tick that uses applied commands.
    #[error(
        "derivatives are not available while applied commands are used; set engaged to true and applied_given to \
            false"
    )]
    UsesApplied,
    /// Derivatives were requested for a tick during which the ranges of the commands widen.
    #[error(
        "derivatives are not available in the first second after the autopilot is engaged or a sensor is trusted \
         again, while the range of each command is opened"
    )]
    Opens,
    /// Derivatives were requested for a tick with a lost sensor.
    #[error("derivatives are not available while a sensor is lost")]
    SensorLost,
    /// More than one tick is overdue, which only a manipulated saved state can cause.
    #[error("the tick at {tick} s was missed: the time is already {time} s")]
    Behind { tick: f64, time: f64 },
}

impl Axis {
    /// Loads the axis of a design in `resources`.
    ///
    /// # Errors
    /// [`ControllerError::Resource`], [`ControllerError::Design`].
    pub fn load(resources: &Resources, file: &str) -> Result<Self, ControllerError> {
        let bad = |reason| ControllerError::Design { file: file.to_owned(), reason };
        Self::new(ControllerDesign::from_json(resources.text(file)?).map_err(bad)?).map_err(bad)
    }

    /// Creates the controller of a design, in level flight at the centre of the scheduled speeds, so that a simulation
    /// with default values stays in trim.
    ///
    /// # Errors
    /// [`DesignError`].
    pub fn new(design: ControllerDesign) -> Result<Self, DesignError> {
        let autopilot = Autopilot::new(&design)?;
        let inputs = autopilot.level(design.scheduling.centre);
        let forward = autopilot.trim().forward_speed(design.scheduling.centre);
        let outputs = |index: usize| autopilot.trim().command(forward, index);
        let outputs: Vec<f64> = (0..design.actuators.len()).map(outputs).collect();
        let commands = design.actuators.iter().zip(&outputs).map(|(one, output)| one.input_for(*output).0);
        let applied = Applied { engaged: true, given: false, commands: commands.collect(), outputs };
        Ok(Self {
            supervisor: Supervisor::new(&design, &autopilot, &inputs),
            valid: vec![true; design.signals.len()],
            stale_after: 0.0,
            design: Arc::new(design),
            autopilot,
            inputs,
            applied,
            was_engaged: true,
        })
    }

    /// Returns the frozen design.
    pub fn design(&self) -> &ControllerDesign {
        &self.design
    }

    /// Returns the autopilot with its outputs and ticks.
    pub fn autopilot(&self) -> &Autopilot {
        &self.autopilot
    }

    /// Returns the command to an actuator, passed through the inverse of its curve if it has one.
    pub fn command(&self, index: usize) -> f64 {
        self.design.actuators[index].input_for(self.supervisor.commands()[index]).0
    }

    /// Returns the status of the autopilot.
    pub fn health(&self) -> Health {
        self.supervisor.health(&self.autopilot)
    }

    /// Returns `true` if the next tick uses all sensors, as the last one did.
    pub(crate) fn is_complete(&self) -> bool {
        let mut next = self.supervisor.clone();
        next.judge(&self.autopilot, &self.inputs, &self.valid, self.stale_after);
        next.is_complete()
    }

    /// Restarts at the time `start` \[s\], with outputs for the current inputs.
    ///
    /// # Errors
    /// [`ControllerError::Tick`].
    pub fn initialise(&mut self, start: f64) -> Result<(), ControllerError> {
        self.autopilot.initialise(start, &self.inputs)?;
        self.was_engaged = self.applied.engaged && !self.applied.given;
        self.supervisor.initialise(&self.autopilot, &self.inputs);
        if !self.was_engaged {
            self.follow()?;
        }
        Ok(())
    }

    /// Makes the autopilot follow the applied commands.
    fn follow(&mut self) -> Result<(), TickError> {
        self.read_applied();
        self.supervisor.follow(&mut self.autopilot, &self.applied.outputs)
    }

    fn read_applied(&mut self) {
        let Applied { commands, outputs, .. } = &mut self.applied;
        for ((output, command), actuator) in outputs.iter_mut().zip(commands).zip(&self.design.actuators) {
            *output = actuator.given(*command);
        }
    }

    /// Returns `true` if the next tick follows commands other than the autopilot's.
    pub fn follows(&self) -> bool {
        !(self.applied.engaged && self.was_engaged)
    }

    /// Runs the ticks due before the time `to` \[s\]. The first tick initialises the controller from the inputs at that
    /// time, because importers may set them after initialisation.
    ///
    /// # Errors
    /// [`ControllerError::Behind`], [`ControllerError::Tick`].
    pub(crate) fn step(&mut self, from: f64, to: f64, log: &mut dyn Log) -> Result<(), ControllerError> {
        self.keeps_up(from)?;
        while self.autopilot.is_due_before(to) {
            if self.autopilot.ticks() == 0 {
                self.initialise(self.autopilot.next_tick_time())?;
            }
            self.tick(log)?;
        }
        Ok(())
    }

    /// Writes or reads every number of a saved state.
    ///
    /// # Errors
    /// Returns a [`StateError`] if the bytes that are read are too few, or not a state of this axis.
    pub fn pass_state(&mut self, state: &mut dyn SavedState) -> Result<(), StateError> {
        state.reals(&mut self.inputs.measured)?;
        state.reals(&mut self.inputs.references)?;
        self.valid.iter_mut().try_for_each(|valid| state.boolean(valid))?;
        state.real(&mut self.stale_after)?;
        state.boolean(&mut self.applied.engaged)?;
        state.boolean(&mut self.applied.given)?;
        state.reals(&mut self.applied.commands)?;
        state.boolean(&mut self.was_engaged)?;
        let Supervised { readings, commands, from, failed_for, changed } = self.supervisor.state();
        for reading in readings {
            let Reading { last, believed, mean, moved, anchor, .. } = reading;
            [last, believed, mean, moved, anchor].into_iter().try_for_each(|one| state.real(one))?;
            let Reading { same, lost_for, plausible_for, wrong_for, .. } = reading;
            [same, lost_for, plausible_for, wrong_for].into_iter().try_for_each(|one| count(state, one))?;
        }
        state.reals(commands)?;
        state.reals(from)?;
        count(state, failed_for)?;
        state.boolean(changed)?;
        let mut snapshot = self.autopilot.snapshot();
        state.reals(&mut snapshot.state)?;
        state.real(&mut snapshot.filtered_speed)?;
        state.reals(&mut snapshot.references)?;
        for transition in &mut snapshot.transitions {
            let Transition { start, rate, share, lag } = transition;
            [start, rate, share, lag].into_iter().try_for_each(|one| state.real(one))?;
        }
        for saturation in &mut snapshot.saturation {
            state.boolean(&mut saturation.now)?;
            count(state, &mut saturation.ticks)?;
        }
        state.reals(&mut snapshot.anchor)?;
        count(state, &mut snapshot.followed_for)?;
        state.reals(&mut snapshot.origins)?;
        let outputs = &mut snapshot.outputs;
        state.reals(&mut outputs.commands)?;
        state.real(&mut outputs.scheduling_parameter)?;
        state.reals(&mut outputs.trim)?;
        state.boolean(&mut outputs.out_of_range)?;
        state.boolean(&mut outputs.reference_limited)?;
        state.reals(&mut snapshot.delayed)?;
        state.real(&mut snapshot.start)?;
        state.integer(&mut snapshot.ticks)?;
        state.boolean(&mut snapshot.outside)?;
        if state.is_read() {
            self.autopilot.restore(&snapshot).map_err(StateError::inconsistent)
        } else {
            Ok(())
        }
    }

    /// Runs the next tick with the current inputs, regardless of the time.
    ///
    /// # Errors
    /// [`ControllerError::Tick`].
    pub fn tick(&mut self, log: &mut dyn Log) -> Result<(), ControllerError> {
        let follows = self.follows();
        if self.applied.given && !follows && !self.supervisor.has_failed() {
            self.read_applied();
            self.autopilot.feed_back(&self.applied.outputs)?;
        }
        self.supervisor.judge(&self.autopilot, &self.inputs, &self.valid, self.stale_after);
        if follows {
            self.follow()?;
        }
        if self.supervisor.tick(&mut self.autopilot)? {
            self.warn_of_range(log);
        }
        self.was_engaged = self.applied.engaged;
        Ok(())
    }

    /// Checks that at most one tick is overdue at a time \[s\].
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

    fn warn_of_range(&self, log: &mut dyn Log) {
        let (speed, rho) =
            (self.autopilot.speed(&self.inputs), self.autopilot.outputs().scheduling_parameter);
        let along_path = self.autopilot.trim().speed(speed);
        let scheduling = &self.design.scheduling;
        log.warn(&format!(
                "The forward speed {speed} m/s, in trim {along_path} m/s along the path, is outside the scheduled \
                 range of {} to {} m/s; the scheduling parameter is held at {rho} until it returns.",
                scheduling.minimum, scheduling.maximum
            ),
        );
    }
}

/// Writes or reads a number of ticks.
fn count(state: &mut dyn SavedState, ticks: &mut u32) -> Result<(), StateError> {
    let mut number = u64::from(*ticks);
    state.integer(&mut number)?;
    *ticks = u32::try_from(number).map_err(StateError::inconsistent)?;
    Ok(())
}
