//! One axis of the autopilot: a sampled controller with its held inputs and outputs.

use std::sync::Arc;

use squid_fmi2::{Log, ResourceError, Resources, SavedState, StateError, rounding_of_time};
use squid_scheduled::{
    Autopilot, ControllerDesign, DesignError, Health, Inputs, Reading, Supervised, Supervisor, TickError,
    Transition,
};

/// The frozen design of the first axis in `resources/`; that of the second is `controller_2.json`, and so on.
pub const RESOURCE: &str = "controller.json";

/// A sampled controller with its held inputs and outputs.
#[derive(Debug, Clone)]
pub struct Axis {
    pub(crate) design: Arc<ControllerDesign>,
    pub(crate) autopilot: Autopilot,
    supervisor: Supervisor,
    /// Measurements and references; the next tick uses them.
    pub inputs: Inputs,
    /// Whether the measured value of each signal is valid.
    pub valid: Vec<bool>,
    /// A measurement that is the same for this long, and should have moved, is lost, s; 0 if it never is for that.
    pub stale_after: f64,
    /// What the actuators get, and from whom.
    pub applied: Applied,
    /// Whether the last tick was the autopilot's.
    was_engaged: bool,
}

/// What the actuators get, as it is known to the autopilot.
#[derive(Debug, Clone)]
pub struct Applied {
    /// Whether the actuators get the autopilot's commands.
    pub engaged: bool,
    /// Whether the commands here are what they get, also while it is engaged.
    pub given: bool,
    /// The commands, as the outputs are: of a thruster with a curve what it takes.
    pub commands: Vec<f64>,
    /// The same in units of the actuators' outputs.
    outputs: Vec<f64>,
}

/// Errors of the controller.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs, reason = "the message says what each field is")]
pub enum ControllerError {
    /// The design cannot be read.
    #[error(transparent)]
    Resource(#[from] ResourceError),
    /// The design is not allowed.
    #[error("resources/{file}: {reason}")]
    Design {
        file: String,
        #[source]
        reason: DesignError,
    },
    /// Two axes do not fit together.
    #[error("resources/{file}: {what} is '{found}', and that of the axes before it is '{expected}'")]
    OtherAxes { file: String, what: &'static str, found: String, expected: String },
    /// Two axes command an actuator.
    #[error("resources/{file}: the actuator '{name}' is commanded by an axis before it")]
    SharedActuator { file: String, name: String },
    /// A tick could not be computed.
    #[error(transparent)]
    Tick(#[from] TickError),
    /// Derivatives of a tick that uses applied commands.
    #[error(
        "there are no derivatives while applied commands are used: set engaged to true and applied_given to false"
    )]
    UsesApplied,
    /// Derivatives of a tick in which the ranges of the commands open.
    #[error(
        "there are no derivatives in the second after the autopilot is engaged or believes a sensor again, while the \
         range of each command opens"
    )]
    Opens,
    /// Derivatives of a tick without a sensor.
    #[error("there are no derivatives while a sensor is lost")]
    SensorLost,
    /// More ticks are due at once than in any flight, which only a manipulated state can cause.
    #[error("the next tick belongs to {tick} s, and the flight has come to {time} s without it")]
    Behind { tick: f64, time: f64 },
}

impl Axis {
    /// The axis of a design in `resources`.
    ///
    /// # Errors
    /// [`ControllerError::Resource`], [`ControllerError::Design`].
    pub fn load(resources: &Resources, file: &str) -> Result<Self, ControllerError> {
        let bad = |reason| ControllerError::Design { file: file.to_owned(), reason };
        Self::new(ControllerDesign::from_json(resources.text(file)?).map_err(bad)?).map_err(bad)
    }

    /// The controller of a design, flying level in the middle of the scheduled speeds, so that a simulation with
    /// default values stays in trim.
    ///
    /// # Errors
    /// [`DesignError`].
    pub fn new(design: ControllerDesign) -> Result<Self, DesignError> {
        let autopilot = Autopilot::new(&design)?;
        let inputs = autopilot.level(design.scheduling.centre);
        let forward = autopilot.trim().forward_speed(design.scheduling.centre);
        let outputs = |index: usize| autopilot.trim().command(forward, index);
        let outputs: Vec<f64> = (0..design.actuators.len()).map(outputs).collect();
        let commands = design.actuators.iter().zip(&outputs).map(|(one, output)| one.taken(*output).0);
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
        self.design.actuators[index].taken(self.supervisor.commands()[index]).0
    }

    /// How the autopilot is.
    pub fn health(&self) -> Health {
        self.supervisor.health(&self.autopilot)
    }

    /// Whether the next tick believes all sensors, as the last one did.
    pub(crate) fn is_complete(&self) -> bool {
        let mut next = self.supervisor.clone();
        next.judge(&self.autopilot, &self.inputs, &self.valid, self.stale_after);
        next.is_complete()
    }

    /// Restarts at a time in s, with outputs for the present inputs.
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

    /// Follows the applied commands.
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

    /// Whether the next tick follows commands that are not the autopilot's.
    pub fn follows(&self) -> bool {
        !(self.applied.engaged && self.was_engaged)
    }

    /// Runs the ticks that are due before a time in s. The first takes its bearings from the inputs as they are then:
    /// importers may set them after the initialization.
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

    /// Passes every number that a saved state needs.
    ///
    /// # Errors
    /// Of a state that is read: the bytes end early, or are not a state of this axis.
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

    /// Runs the next tick with the present inputs, whatever the time.
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

    fn warn_of_range(&self, log: &mut dyn Log) {
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

/// Passes a number of ticks.
fn count(state: &mut dyn SavedState, ticks: &mut u32) -> Result<(), StateError> {
    let mut number = u64::from(*ticks);
    state.integer(&mut number)?;
    *ticks = u32::try_from(number).map_err(StateError::inconsistent)?;
    Ok(())
}
