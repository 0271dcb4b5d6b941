//! The loop of plant and autopilot, in the order in which a master steps the two.

use fmi2::{Log, Model};
use fmu_controller::Axis;
use fmu_plant::PlantModel;

use crate::ClosedLoopError;
use auv::State;
use auv::longitudinal::{DEPTH, EachTracked, PITCH, SIGNALS, SPEED, measured, tracked};
use scheduled::{ControllerDesign, Manoeuvre, ManoeuvreError, Trim};
use signals::Curve;

/// External references, held between two steps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Override {
    /// Whether they replace the manoeuvre.
    pub manual: bool,
    /// Of each signal that can be tracked, absolute, SI; the speed along the body axis, through the water.
    pub references: EachTracked<f64>,
    /// The rates of the references \[SI per s\]; [`ClosedLoop::advance`] advances the references.
    pub slopes: EachTracked<f64>,
}

/// A vehicle and its autopilot, flying a manoeuvre or external references.
///
/// At each tick, at t = start + k Ts, the autopilot measures the plant and commands it without delay; in between the
/// plant moves under held commands. Time is that of the experiment, also for the manoeuvre.
#[derive(Debug, Clone)]
pub struct ClosedLoop {
    /// The vehicle.
    pub plant: PlantModel,
    /// The autopilot.
    pub controller: Axis,
    /// The manoeuvre flown by default.
    pub manoeuvre: Manoeuvre,
    /// The external references, flown while `manual` is true.
    pub outside: Override,
}

/// Checks a manoeuvre; its speeds must be ahead where the vehicle has trims for flight ahead only.
fn check(manoeuvre: &Manoeuvre, plant: &PlantModel, design: &ControllerDesign) -> Result<(), ManoeuvreError> {
    manoeuvre.check()?;
    manoeuvre.check_steps(design)?;
    if plant.only_ahead() { manoeuvre.check_ahead() } else { Ok(()) }
}

impl ClosedLoop {
    /// Combines vehicle and autopilot.
    ///
    /// # Errors
    /// [`ClosedLoopError::OtherVehicle`], [`ClosedLoopError::OtherSignals`], [`ClosedLoopError::OtherActuators`],
    /// [`ClosedLoopError::Manoeuvre`].
    pub fn new(
        plant: PlantModel,
        controller: Axis,
        mut manoeuvre: Manoeuvre,
    ) -> Result<Self, ClosedLoopError> {
        let (vehicle, design) = (plant.vehicle(), controller.design());
        let found: Vec<_> = design.signals.iter().map(|signal| signal.name.clone()).collect();
        let expected = SIGNALS.each_ref().map(|signal| signal.name.to_owned()).to_vec();
        if found != expected {
            return Err(ClosedLoopError::OtherSignals { found, expected });
        }
        check(&manoeuvre, &plant, design)?;
        for (place, signal) in tracked().map(|(signal, _)| signal).enumerate() {
            if place != SPEED && design.has_reference(place) {
                manoeuvre.steps.entry(signal.name.to_owned()).or_default();
            }
        }
        if design.vehicle.name != vehicle.name {
            let (found, expected) = (design.vehicle.name.clone(), vehicle.name.clone());
            return Err(ClosedLoopError::OtherVehicle { found, expected });
        }
        let named = |name: &str, curve: Option<&Curve>| match curve {
            Some(curve) => format!("{name} [{}]", curve.unit()),
            None => name.to_owned(),
        };
        let found: Vec<_> = design.actuators.iter().map(|one| named(&one.name, one.curve.as_ref())).collect();
        let expected: Vec<_> =
            vehicle.actuators.iter().map(|one| named(&one.name, one.curve.as_ref())).collect();
        if found != expected {
            return Err(ClosedLoopError::OtherActuators { found, expected });
        }
        let trim = controller.autopilot().trim();
        let level = level(trim, manoeuvre.speed_from, plant.settings.initial_depth);
        let outside = Override { manual: false, references: level, slopes: EachTracked::default() };
        Ok(Self { plant, controller, manoeuvre, outside })
    }

    /// Puts the vehicle into level trim at the manoeuvre's speed, and the autopilot's state to zero, at a time \[s\].
    ///
    /// # Errors
    /// [`ClosedLoopError::Manoeuvre`], [`ClosedLoopError::Plant`], [`ClosedLoopError::Controller`].
    pub fn start(&mut self, time: f64, log: &mut dyn Log) -> Result<(), ClosedLoopError> {
        check(&self.manoeuvre, &self.plant, self.controller.design())?;
        self.plant.settings.initial_speed = self.manoeuvre.speed_reference(time);
        self.plant.initialise(time, log)?;
        self.measure(time);
        self.controller.initialise(time)?;
        self.command();
        // Actuators without lag follow the first commands at once.
        Ok(self.plant.apply_inputs()?)
    }

    /// Moves the loop to a time \[s\] without allocating.
    ///
    /// # Errors
    /// [`ClosedLoopError::Plant`], [`ClosedLoopError::Controller`].
    pub fn advance(&mut self, to: f64, log: &mut dyn Log) -> Result<(), ClosedLoopError> {
        // A tick at the present time must use the new inputs.
        self.plant.apply_inputs()?;
        while self.controller.autopilot().is_due_before(to) {
            let due = self.controller.autopilot().next_tick_time();
            self.move_plant(due, log)?;
            self.tick(log)?;
        }
        self.move_plant(to, log)
    }

    /// Runs the next tick on the plant as it is.
    ///
    /// # Errors
    /// [`ClosedLoopError::Controller`].
    pub fn tick(&mut self, log: &mut dyn Log) -> Result<(), ClosedLoopError> {
        self.measure(self.controller.autopilot().next_tick_time());
        self.controller.tick(log)?;
        self.command();
        Ok(())
    }

    /// Advances the plant and the external references; the plant may already be past a tick, by rounding.
    fn move_plant(&mut self, to: f64, log: &mut dyn Log) -> Result<(), ClosedLoopError> {
        let now = self.plant.time();
        if to > now {
            self.plant.step(now, to, log)?;
            let outside = &mut self.outside;
            for (reference, slope) in outside.references.iter_mut().zip(outside.slopes) {
                *reference += slope * (to - now);
            }
        }
        Ok(())
    }

    /// Passes measurements and references to the autopilot, and the operating speed to the LPV model.
    fn measure(&mut self, time: f64) {
        let (references, path_speed) = self.references(time);
        let State { motion, depth, .. } = self.plant.state();
        let inputs = &mut self.controller.inputs;
        inputs.measured.copy_from_slice(&measured([motion.u, motion.w, motion.q, motion.theta, depth]));
        inputs.references.copy_from_slice(&references);

        self.plant.inputs.operating_speed = path_speed;
        self.plant.inputs.given_speed = references[SPEED];
    }

    /// Passes the commands to the plant.
    fn command(&mut self) {
        for (index, command) in self.plant.inputs.commands.iter_mut().enumerate() {
            *command = self.controller.command(index);
        }
    }

    /// The output whose error is put out: the pitch if there is a reference of it, the depth otherwise.
    pub(crate) fn stepped(&self) -> usize {
        if self.controller.design().has_reference(PITCH) { PITCH } else { DEPTH }
    }

    /// The references of the autopilot, and the speed along the path.
    fn references(&self, time: f64) -> (EachTracked<f64>, f64) {
        let trim = self.controller.autopilot().trim();
        if self.outside.manual {
            let references = self.outside.references;
            return (references, trim.speed(references[SPEED]));
        }
        let path_speed = self.manoeuvre.speed_reference(time);
        let mut references = level(trim, path_speed, self.plant.settings.initial_depth);
        for (reference, (signal, _)) in references.iter_mut().zip(tracked()) {
            *reference += self.manoeuvre.above_trim(time, signal.name);
        }
        (references, path_speed)
    }
}

/// The references of level flight at a speed along the path \[m/s\] and a depth \[m\], by the trim table of the design.
fn level(trim: &Trim, path_speed: f64, depth: f64) -> EachTracked<f64> {
    let forward_speed = trim.forward_speed(path_speed);
    std::array::from_fn(|place| trim.signal(forward_speed, place, depth))
}
