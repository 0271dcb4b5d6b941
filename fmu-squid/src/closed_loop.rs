//! The loop of plant and autopilot, in the order in which a master steps the two.

use fmi2::{ContinuousModel, Log, Model};
use fmu_controller::Controller;
use fmu_plant::PlantModel;

use crate::ClosedLoopError;
use auv::State;
use scheduled::{Manoeuvre, ManoeuvreError};
use signals::{Curve, DEPTH, PITCH, SPEED, measured};

/// External references, held between two steps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Override {
    /// Whether they replace the manoeuvre.
    pub manual: bool,
    /// Pitch angle \[rad\], absolute.
    pub pitch_reference: f64,
    /// Depth \[m\].
    pub depth_reference: f64,
    /// Forward speed through the water, along the body axis \[m/s\].
    pub speed_reference: f64,
    /// The rate of the pitch reference \[rad/s\]; [`ClosedLoop::advance`] advances the reference.
    pub pitch_slope: f64,
    /// The rate of the depth reference \[m/s\].
    pub depth_slope: f64,
    /// The rate of the speed reference \[m/s2\].
    pub speed_slope: f64,
}

impl Override {
    /// Every number of it.
    pub(crate) fn numbers(&mut self) -> [&mut f64; 6] {
        [
            &mut self.pitch_reference,
            &mut self.depth_reference,
            &mut self.speed_reference,
            &mut self.pitch_slope,
            &mut self.depth_slope,
            &mut self.speed_slope,
        ]
    }
}

/// The references of the autopilot at one instant.
#[derive(Debug, Clone, Copy)]
struct References {
    pitch: f64,
    depth: f64,
    /// Along the body axis.
    forward_speed: f64,
    /// Along the path.
    path_speed: f64,
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
    pub controller: Controller,
    /// The manoeuvre flown by default.
    pub manoeuvre: Manoeuvre,
    /// The external references, flown while `manual` is true.
    pub outside: Override,
}

/// Checks a manoeuvre; its speeds must be ahead where the vehicle has trims for flight ahead only.
fn check(manoeuvre: &Manoeuvre, plant: &PlantModel) -> Result<(), ManoeuvreError> {
    manoeuvre.check()?;
    if plant.only_ahead() { manoeuvre.check_ahead() } else { Ok(()) }
}

impl ClosedLoop {
    /// Combines vehicle and autopilot.
    ///
    /// # Errors
    /// [`ClosedLoopError::OtherVehicle`], [`ClosedLoopError::OtherActuators`], [`ClosedLoopError::Manoeuvre`].
    pub fn new(
        plant: PlantModel,
        controller: Controller,
        manoeuvre: Manoeuvre,
    ) -> Result<Self, ClosedLoopError> {
        check(&manoeuvre, &plant)?;
        let (vehicle, design) = (plant.vehicle(), controller.design());
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
        let speed_reference = trim.forward_speed(manoeuvre.speed_from);
        let outside = Override {
            manual: false,
            pitch_reference: trim.pitch(speed_reference),
            depth_reference: plant.settings.initial_depth,
            speed_reference,
            pitch_slope: 0.0,
            depth_slope: 0.0,
            speed_slope: 0.0,
        };
        Ok(Self { plant, controller, manoeuvre, outside })
    }

    /// Puts the vehicle into level trim at the manoeuvre's speed, and the autopilot's state to zero, at a time \[s\].
    ///
    /// # Errors
    /// [`ClosedLoopError::Manoeuvre`], [`ClosedLoopError::Plant`], [`ClosedLoopError::Controller`].
    pub fn start(&mut self, time: f64, log: &mut dyn Log) -> Result<(), ClosedLoopError> {
        check(&self.manoeuvre, &self.plant)?;
        self.plant.settings.initial_speed = self.manoeuvre.speed_reference(time);
        self.plant.initialise(time, log)?;
        self.measure(time);
        self.controller.initialise(time, log)?;
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
            outside.pitch_reference += outside.pitch_slope * (to - now);
            outside.depth_reference += outside.depth_slope * (to - now);
            outside.speed_reference += outside.speed_slope * (to - now);
        }
        Ok(())
    }

    /// Passes measurements and references to the autopilot, and the operating speed to the LPV model.
    fn measure(&mut self, time: f64) {
        let references = self.references(time);
        let State { motion, depth, .. } = self.plant.state();
        let inputs = &mut self.controller.inputs;
        inputs.measured = measured([motion.u, motion.w, motion.q, motion.theta, depth]);
        let wanted = &mut inputs.references;
        (wanted[PITCH], wanted[DEPTH]) = (references.pitch, references.depth);
        wanted[SPEED] = references.forward_speed;

        self.plant.inputs.operating_speed = references.path_speed;
        self.plant.inputs.given_speed = references.forward_speed;
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

    /// The trim table of the design turns speed along the path into forward speed and gives the pitch of level flight.
    fn references(&self, time: f64) -> References {
        let trim = self.controller.autopilot().trim();
        if self.outside.manual {
            let Override { pitch_reference, depth_reference, speed_reference, .. } = self.outside;
            return References {
                pitch: pitch_reference,
                depth: depth_reference,
                forward_speed: speed_reference,
                path_speed: trim.speed(speed_reference),
            };
        }
        let path_speed = self.manoeuvre.speed_reference(time);
        let forward_speed = trim.forward_speed(path_speed);
        let steps = self.manoeuvre.above_trim(time);
        let pitch = trim.pitch(forward_speed) + steps[PITCH];
        let depth = self.plant.settings.initial_depth + steps[DEPTH];
        References { pitch, depth, forward_speed, path_speed }
    }
}
