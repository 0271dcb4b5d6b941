//! The vehicle in motion: commands and current in, motion out.

use std::fmt;
use std::sync::Arc;

use crate::bottom::Bottom;
use crate::motion::dynamics::{Dynamics, Motion};
use crate::motion::trim::Trim;
use crate::scalar::Scalar;
use crate::simulation::current::Current;
use crate::simulation::error::{SimulationError, finite};
use crate::simulation::flow::{Flow, Model};
use crate::simulation::frozen::Frozen;
use crate::simulation::integrator::{Body, Integrator};
use crate::simulation::load::Load;
use crate::simulation::lpv_model::{LpvModel, LpvModelError};
use crate::simulation::slopes::Slopes;
use crate::simulation::water::{Pose, Water};
use crate::simulation::whole::{Side, WholeFlow, joined, motion_of, split};
use crate::vehicle::Vehicle;
use crate::vehicle::actuator::{Actuator, Push};
use crate::vehicle::ballast::Ballast;
use crate::vehicle::coefficients::CoefficientError;

/// Which equations of motion are integrated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fidelity {
    /// The nonlinear equations.
    Nonlinear,
    /// The LPV model.
    Lpv,
}

/// Position and motion of the vehicle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State {
    /// Motion through the water.
    pub motion: Motion,
    /// Horizontal distance in the earth frame, positive the way the vehicle faces, or north for one that turns \[m\].
    pub x: f64,
    /// Depth \[m\].
    pub depth: f64,
    /// Heading psi, clockwise from north, not wrapped \[rad\]; 0 of a vehicle in the vertical plane, as the next.
    pub heading: f64,
    /// Way made east \[m\].
    pub east: f64,
    /// Depth of the bottom under the vehicle \[m\]. A plant knows of no bottom, and gives the default one.
    pub bottom: f64,
}

impl State {
    /// Where the vehicle is and how it lies.
    pub fn pose(&self) -> Pose {
        let Self { motion: Motion { phi, theta, .. }, x, depth, heading, east, .. } = *self;
        Pose { north: x, east, depth, roll: phi, pitch: theta, heading }
    }

    /// In the vertical plane.
    pub fn in_plane(motion: Motion, x: f64, depth: f64) -> Self {
        Self { motion, x, depth, heading: 0.0, east: 0.0, bottom: Bottom::default().depth_at(x, 0.0) }
    }
}

/// A vehicle in motion, with its workspace: no step allocates.
///
/// A vehicle with coefficients of sway, roll and yaw moves in six degrees of freedom, by the nonlinear equations;
/// others in the vertical plane.
///
/// Commands, current and operating speed are held between calls of [`Plant::advance`]. The lag of an actuator is
/// integrated in closed form, everything else by an adaptive Runge-Kutta method of order 6, so that the motion
/// hardly depends on how an interval is divided.
#[derive(Clone)]
pub struct Plant {
    pub(crate) dynamics: Dynamics,
    pub(crate) actuators: Arc<[Actuator]>,
    /// Those of the actuators.
    pub(crate) pushes: Arc<[Push]>,
    pub(crate) lpv: Option<Arc<LpvModel>>,
    pub(crate) fidelity: Fidelity,
    pub(crate) time: f64,
    pub(crate) body: Body,
    /// What leaves the vertical plane, of a vehicle that does.
    pub(crate) side: Option<Side>,
    /// Whether surge, heave and pitch are held.
    pub(crate) is_held: bool,
    pub(crate) outputs: Vec<f64>,
    pub(crate) commands: Vec<f64>,
    pub(crate) current: Current,
    pub(crate) water: Option<Arc<dyn Water>>,
    pub(crate) operating_speed: f64,
    pub(crate) given_speed: f64,
    pub(crate) load: Load,
    pub(crate) slopes: Slopes,
    /// Whether any of the slopes is not zero.
    pub(crate) moving: bool,
    pub(crate) frozen: Frozen,
    pub(crate) integrator: Integrator,
}

impl Plant {
    /// Creates a plant at rest at the origin, nonlinear, every command zero.
    ///
    /// # Errors
    /// [`CoefficientError`] if the vehicle's coefficients are not allowed.
    pub fn new(vehicle: &Vehicle) -> Result<Self, CoefficientError> {
        let inputs = vehicle.actuators.len();
        Ok(Self {
            dynamics: Dynamics::new(&vehicle.coefficients)?,
            actuators: vehicle.actuators.as_slice().into(),
            pushes: vehicle.actuators.iter().map(Push::of).collect(),
            lpv: None,
            fidelity: Fidelity::Nonlinear,
            time: 0.0,
            body: [0.0; 6],
            side: vehicle.coefficients.leaves_plane().then_some([0.0; 6]),
            is_held: false,
            outputs: vec![0.0; inputs],
            commands: vec![0.0; inputs],
            current: Current::default(),
            water: None,
            operating_speed: 0.0,
            given_speed: 0.0,
            load: Load::default(),
            slopes: Slopes::held(inputs),
            moving: false,
            frozen: Frozen::new(inputs),
            integrator: Integrator::new(),
        })
    }

    /// Gives the plant an LPV model; [`Plant::set_fidelity`] switches to it.
    ///
    /// # Errors
    /// [`LpvModelError`] if the model is malformed or for another number of actuators.
    pub fn with_lpv(mut self, model: impl Into<Arc<LpvModel>>) -> Result<Self, LpvModelError> {
        let model = model.into();
        model.check()?;
        let (found, expected) = (model.inputs(), self.actuators.len());
        if found != expected {
            return Err(LpvModelError::Actuators { key: "trim", found, expected });
        }
        self.lpv = Some(model);
        Ok(self)
    }

    /// Chooses the equations of motion.
    ///
    /// # Errors
    /// [`SimulationError::NoLpvModel`] if the LPV model is selected but the plant has none.
    pub fn set_fidelity(&mut self, fidelity: Fidelity) -> Result<(), SimulationError> {
        // That of a vehicle in the vertical plane is none of one that leaves it.
        if fidelity == Fidelity::Lpv && (self.lpv.is_none() || self.side.is_some()) {
            return Err(SimulationError::NoLpvModel);
        }
        self.fidelity = fidelity;
        Ok(())
    }

    /// Puts the plant into a trim at x = 0, heading north: every actuator at its trim output and commanded to stay
    /// there, the operating speed and a given one those of the trim, the current as it is.
    ///
    /// # Errors
    /// [`SimulationError::TrimActuators`] if the trim has another number of actuators.
    pub fn start(&mut self, time: f64, trim: &Trim) -> Result<(), SimulationError> {
        let (found, expected) = (trim.actuators.len(), self.actuators.len());
        if found != expected {
            return Err(SimulationError::TrimActuators { found, expected });
        }
        self.time = time;
        self.is_held = false;
        self.set_state(&State::in_plane(trim.motion(), 0.0, trim.depth));
        self.outputs.copy_from_slice(&trim.actuators);
        self.commands.copy_from_slice(&trim.actuators);
        self.operating_speed = trim.speed;
        self.given_speed = trim.forward_speed;
        Ok(())
    }

    /// Sets position and motion.
    pub fn set_state(&mut self, state: &State) {
        let Motion { u, v, w, p, q, r, phi, theta } = state.motion;
        self.body = [u, w, q, theta, state.x, state.depth];
        self.side = self.side.map(|_| [v, p, r, phi, state.heading, state.east]);
    }

    /// Holds surge, heave and pitch from now on as they are in a trim, whatever acts there: a vehicle on which another
    /// autopilot keeps level flight.
    pub fn hold_level(&mut self, trim: &Trim) {
        let Motion { u, w, q, theta, .. } = trim.motion();
        self.body[..4].copy_from_slice(&[u, w, q, theta]);
        self.is_held = true;
    }

    /// Commands an actuator \[N or rad\]; beyond its limits it goes to the limit.
    ///
    /// # Errors
    /// [`SimulationError`] if the command is not finite or there is no such actuator.
    pub fn set_command(&mut self, index: usize, command: f64) -> Result<(), SimulationError> {
        finite("command", command)?;
        let actuators = self.commands.len();
        match self.commands.get_mut(index) {
            Some(held) => *held = command,
            None => return Err(SimulationError::NoSuchActuator { index, actuators }),
        }
        Ok(())
    }

    /// Sets the current. The velocity over ground does not jump: the vehicle has mass, so the
    /// velocity through the water changes instead.
    ///
    /// # Errors
    /// [`SimulationError::InputNotFinite`].
    pub fn set_current(&mut self, current: Current) -> Result<(), SimulationError> {
        finite("horizontal current", current.horizontal)?;
        finite("vertical current", current.vertical)?;
        finite("current east", current.east)?;
        let mut state = self.state();
        let [old, new] =
            [self.current, current].map(|one| state.motion.along_body(state.heading, one.in_earth()));
        state.motion.v += old[1] - new[1];
        if !self.is_held {
            state.motion.u += old[0] - new[0];
            state.motion.w += old[2] - new[2];
        }
        self.set_state(&state);
        self.current = current;
        Ok(())
    }

    /// Puts the plant into water that moves beside the current. The velocity over ground does not jump.
    #[must_use]
    pub fn with_water(mut self, water: Arc<dyn Water>) -> Self {
        let now = self.instant();
        self.water = Some(water);
        self.set_motion_over_ground(&now);
        self
    }

    /// Puts other water about the plant, which is yet to be [restored](Plant::restore) in it.
    pub fn set_water(&mut self, water: Option<Arc<impl Water + 'static>>) {
        self.water = water.map(|water| water as Arc<dyn Water>);
    }

    /// The velocity of the water where the vehicle is: the current, and what moves beside it.
    pub fn flow(&self) -> Current {
        let water = self.water.as_ref().map(|water| water.at(self.time, &self.state().pose()));
        let all = self.current + water.unwrap_or_default().velocity;
        self.meets(all.in_earth()).into()
    }

    /// A velocity north, east and down without what a vehicle in the vertical plane does not meet.
    pub(crate) fn meets<D: Scalar>(&self, [north, east, down]: [D; 3]) -> [D; 3] {
        [north, if self.side.is_some() { east } else { D::from(0.0) }, down]
    }

    /// Sets the speed at which the LPV model is evaluated \[m/s\]; the nonlinear equations do not use it.
    ///
    /// # Errors
    /// [`SimulationError::InputNotFinite`].
    pub fn set_operating_speed(&mut self, speed: f64) -> Result<(), SimulationError> {
        finite("operating speed", speed)?;
        self.operating_speed = speed;
        Ok(())
    }

    /// Gives a speed u through the water \[m/s\] to a vehicle that takes one; others do not use it.
    ///
    /// # Errors
    /// [`SimulationError::InputNotFinite`].
    pub fn set_given_speed(&mut self, speed: f64) -> Result<(), SimulationError> {
        finite("given speed", speed)?;
        self.given_speed = speed;
        Ok(())
    }

    /// Sets a load from outside. Where the speed is given, X has no effect.
    ///
    /// # Errors
    /// [`SimulationError::InputNotFinite`].
    pub fn set_load(&mut self, load: Load) -> Result<(), SimulationError> {
        for value in load {
            finite("load from outside", value)?;
        }
        self.load = load;
        Ok(())
    }

    /// The load from outside.
    pub fn load(&self) -> Load {
        self.load
    }

    /// Changes weight, buoyancy and centre of gravity, and the mass with them; the motion goes on as it is.
    ///
    /// # Errors
    /// [`CoefficientError`]; the plant is then as it was.
    pub fn set_ballast(&mut self, ballast: &Ballast) -> Result<(), CoefficientError> {
        self.dynamics.set_ballast(ballast)
    }

    /// Weight, buoyancy, centre of gravity and mass in use.
    pub fn ballast(&self) -> Ballast {
        self.dynamics.coefficients().ballast()
    }

    /// Lets the inputs change at constant rates from now on; [`Plant::advance`] carries them along.
    ///
    /// # Errors
    /// [`SimulationError`] if a rate is not finite or belongs to no actuator.
    pub fn set_slopes(&mut self, slopes: &Slopes) -> Result<(), SimulationError> {
        let (found, expected) = (slopes.commands.len(), self.actuators().len());
        if found != expected {
            return Err(SimulationError::TrimActuators { found, expected });
        }
        let Current { horizontal, east, vertical } = slopes.current;
        let speeds = [slopes.operating_speed, slopes.given_speed];
        for &rate in
            [horizontal, east, vertical].iter().chain(&speeds).chain(&slopes.load).chain(&slopes.commands)
        {
            finite("rate of an input", rate)?;
        }
        self.slopes.commands.copy_from_slice(&slopes.commands);
        self.slopes.current = slopes.current;
        [self.slopes.operating_speed, self.slopes.given_speed] = speeds;
        self.slopes.load = slopes.load;
        let held = slopes.current == Current::default() && speeds == [0.0; 2] && slopes.load == [0.0; 6];
        self.moving = !held || slopes.commands.iter().any(|rate| *rate != 0.0);
        Ok(())
    }

    /// Moves the vehicle to an instant \[s\], all inputs held or changing at their rates.
    ///
    /// # Errors
    /// [`SimulationError`] if time would run backwards or the motion runs off; the plant then stays where it was.
    pub fn advance(&mut self, to: f64) -> Result<(), SimulationError> {
        finite("time", to)?;
        let (from, duration) = (self.time, to - self.time);
        if duration < 0.0 {
            return Err(SimulationError::Backwards { from, to });
        }
        if duration == 0.0 {
            return Ok(());
        }
        let lpv = self.lpv.as_deref().filter(|_| self.fidelity == Fidelity::Lpv);
        if let Some(model) = lpv {
            self.frozen.evaluate(model, self.operating_speed);
        }
        let model = match lpv {
            None => Model::Nonlinear,
            Some(model) if self.moving => Model::Scheduled(model, self.operating_speed),
            Some(_) => Model::Frozen(&self.frozen),
        };
        let State { x, east, .. } = self.state();
        let mut flow = Flow {
            dynamics: &self.dynamics,
            actuators: &self.actuators,
            pushes: &self.pushes,
            outputs: &self.outputs,
            commands: &self.commands,
            current: self.current,
            depth: self.body[5],
            model,
            given: self.given_speed,
            load: self.load,
            slopes: self.moving.then_some(&self.slopes),
            water: self.water.as_deref().map(|water| (water, from, [x, east])),
        };
        let [u, w, q, theta, x, depth] = self.body;
        let start = [u, w, q, theta, 0.0, 0.0];
        let failed = |source| SimulationError::Integration { from, to, source };
        let end = match self.side {
            None => self.integrator.advance(&mut flow, &start, duration).map_err(failed)?,
            Some([v, p, r, phi, heading, east]) => {
                let mut whole = WholeFlow { flow, is_held: self.is_held, last_usual: None };
                let start = joined(start, [v, p, r, phi, heading, 0.0]);
                let end = self.integrator.advance(&mut whole, &start, duration).map_err(failed)?;
                let (body, [v, p, r, phi, heading, made]) = split(&whole.with_usual_angles(&end));
                self.side = Some([v, p, r, phi, heading, east + made]);
                body
            }
        };
        self.body = [end[0], end[1], end[2], end[3], x + end[4], depth + end[5]];
        self.carry_inputs(duration);
        self.time = to;
        Ok(())
    }

    /// Advances the outputs of the actuators and the inputs.
    pub(crate) fn carry_inputs(&mut self, duration: f64) {
        let actuators = self.actuators.iter().zip(&mut self.outputs);
        let inputs = self.commands.iter_mut().zip(&self.slopes.commands);
        for ((actuator, output), (command, slope)) in actuators.zip(inputs) {
            *output = actuator.output_along(duration, *output, *command, *slope);
            *command += slope * duration;
        }
        self.current = self.current.after(duration, self.slopes.current);
        self.operating_speed += self.slopes.operating_speed * duration;
        self.given_speed += self.slopes.given_speed * duration;
        for (load, slope) in self.load.iter_mut().zip(self.slopes.load) {
            *load += slope * duration;
        }
    }

    /// The speed at which the LPV model is evaluated \[m/s\].
    pub fn operating_speed(&self) -> f64 {
        self.operating_speed
    }

    /// The speed that is given to a vehicle that takes one \[m/s\].
    pub fn given_speed(&self) -> f64 {
        self.given_speed
    }

    /// Sets the output of an actuator \[N or rad\], whatever its lag.
    ///
    /// # Panics
    /// If there is no such actuator.
    pub fn set_output(&mut self, index: usize, output: f64) {
        self.outputs[index] = output;
    }

    /// The time reached \[s\].
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Position, and motion through the water.
    pub fn state(&self) -> State {
        let [_, _, _, _, x, depth] = self.body;
        let (motion, heading) = motion_of(&joined(self.body, self.side.unwrap_or_default()));
        let east = self.side.map_or(0.0, |side| side[5]);
        State { motion, x, depth, heading, east, bottom: Bottom::default().depth_at(x, east) }
    }

    /// The actuators.
    pub fn actuators(&self) -> &[Actuator] {
        &self.actuators
    }

    /// The output of each actuator \[N or rad\].
    pub fn outputs(&self) -> &[f64] {
        &self.outputs
    }

    /// The current.
    pub fn current(&self) -> Current {
        self.current
    }

    /// Speed through the water, sqrt(u^2 + v^2 + w^2) \[m/s\].
    pub fn speed(&self) -> f64 {
        let Motion { u, v, w, .. } = self.state().motion;
        u.hypot(w).hypot(v)
    }

    /// Velocity over ground along the body axes \[m/s\]: surge, sway, heave.
    pub fn velocity_over_ground(&self) -> [f64; 3] {
        let State { motion, heading, .. } = self.state();
        let [u_c, v_c, w_c] = motion.along_body(heading, self.flow().in_earth());
        [motion.u + u_c, motion.v + v_c, motion.w + w_c]
    }

    /// Velocity over ground in the earth frame \[m/s\]: north, or horizontal in the vertical plane, east, and down (the
    /// rate of depth).
    pub fn earth_velocity(&self) -> [f64; 3] {
        let State { motion, heading, .. } = self.state();
        let ([north, east, down], [north_c, east_c, down_c]) =
            (motion.velocity(heading), self.flow().in_earth());
        [north + north_c, east + east_c, down + down_c]
    }
}

impl fmt::Debug for Plant {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut debug = f.debug_struct("Plant");
        debug.field("fidelity", &self.fidelity).field("time", &self.time).field("state", &self.state());
        debug
            .field("outputs", &self.outputs)
            .field("commands", &self.commands)
            .field("current", &self.current);
        debug.finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Motion, Speed, Vehicle, trim};

    fn vehicle() -> Vehicle {
        let file = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../vehicles/squid/vehicle.toml");
        Vehicle::parse(&std::fs::read_to_string(file).unwrap(), "vehicle.toml").unwrap()
    }

    /// Many short intervals with held inputs in the middle of each come to the same, to second order.
    #[test]
    fn a_ramp_is_the_limit_of_stairs() {
        let vehicle = vehicle();
        let (command, slope) = (20.0, 200.0);
        let mut plants = [1, 4000].map(|pieces| {
            let mut plant = Plant::new(&vehicle).unwrap();
            plant.start(0.0, &trim(&vehicle, Speed::Path(1.5), 30.0).unwrap()).unwrap();
            (plant, pieces)
        });
        for (plant, pieces) in &mut plants {
            let h = 1.0 / f64::from(*pieces);
            let current =
                |time: f64| Current { horizontal: 0.3 * time, vertical: -0.2 * time, ..Current::default() };
            for piece in 0..*pieces {
                let (from, middle) = (f64::from(piece) * h, (f64::from(piece) + 0.5) * h);
                let whole = *pieces == 1;
                let at = if whole { from } else { middle };
                plant.set_command(0, command + slope * at).unwrap();
                plant.set_current(current(at)).unwrap();
                if whole {
                    let mut slopes = Slopes::held(vehicle.actuators.len());
                    (slopes.commands[0], slopes.current) = (slope, current(1.0));
                    plant.set_slopes(&slopes).unwrap();
                }
                plant.advance(from + h).unwrap();
            }
            plant.set_current(current(1.0)).unwrap();
        }
        let [(ramp, _), (stairs, _)] = plants;
        assert_eq!(ramp.commands[0], 220.0, "the input has moved along");
        let (Motion { u, w, q, theta, .. }, other) = (ramp.state().motion, stairs.state().motion);
        for (one, other) in [(u, other.u), (w, other.w), (q, other.q), (theta, other.theta)] {
            assert!((one - other).abs() < 1e-6 * (1.0 + other.abs()), "{one} and {other}");
        }
        assert!((ramp.outputs()[0] - stairs.outputs()[0]).abs() < 1e-4);
        assert!((ramp.state().x - stairs.state().x).abs() < 1e-6);
    }

    #[test]
    fn a_command_that_crosses_both_limits_is_cut_at_each() {
        let mut actuator = vehicle().actuators[0].clone();
        (actuator.min, actuator.max) = (-10.0, 30.0);
        for lag in [0.0, 0.2] {
            actuator.lag = lag;
            for (command, slope) in [(-50.0, 100.0), (60.0, -100.0), (0.0, 100.0), (-50.0, -1.0), (5.0, 2.0)]
            {
                let (mut output, pieces) = (3.0, 100_000);
                for piece in 0..pieces {
                    let middle = (f64::from(piece) + 0.5) / f64::from(pieces);
                    output = actuator.output_after(1.0 / f64::from(pieces), output, command + slope * middle);
                }
                let result = actuator.output_along(1.0, 3.0, command, slope);
                assert!((result - output).abs() < 1e-3, "{lag} {command} {slope}: {result} and {output}");
            }
        }
    }
}
