//! Simulated vehicle: commands and current as inputs, motion as output.

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
use crate::simulation::whole::{LateralState, SixDofFlow, join, motion_of, split};
use crate::vehicle::Vehicle;
use crate::vehicle::actuator::{Actuator, ActuatorForces};
use crate::vehicle::ballast::Ballast;
use crate::vehicle::coefficients::CoefficientError;

/// Equations of motion to integrate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fidelity {
    /// Nonlinear equations.
    Nonlinear,
    /// LPV model.
    Lpv,
}

/// Position and motion of the vehicle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State {
    /// Motion through the water.
    pub motion: Motion,
    /// Horizontal distance in the earth frame \[m\], positive along the vehicle's heading, or north for six degrees of
    /// freedom.
    pub x: f64,
    /// Depth \[m\].
    pub depth: f64,
    /// Heading psi, clockwise from north, not wrapped \[rad\]; 0 for a vehicle in the vertical plane.
    pub heading: f64,
    /// Distance east \[m\]; 0 for a vehicle in the vertical plane.
    pub east: f64,
    /// Depth of the bottom below the vehicle \[m\]; a plant, which has no bottom, returns the default one.
    pub bottom: f64,
}

impl State {
    /// Returns position and attitude of the vehicle.
    pub fn pose(&self) -> Pose {
        let Self { motion: Motion { phi, theta, .. }, x, depth, heading, east, .. } = *self;
        Pose { north: x, east, depth, roll: phi, pitch: theta, heading }
    }

    /// Returns a state in the vertical plane.
    pub fn in_plane(motion: Motion, x: f64, depth: f64) -> Self {
        Self { motion, x, depth, heading: 0.0, east: 0.0, bottom: Bottom::default().depth_at(x, 0.0) }
    }
}

/// Simulated vehicle with its workspace: no step allocates.
///
/// A vehicle with coefficients of sway, roll and yaw moves in six degrees of freedom, by the nonlinear equations;
/// others move in the vertical plane.
///
/// Commands, current and operating speed are held between calls of [`Plant::advance`]. The lag of an actuator is
/// integrated in closed form, everything else by an adaptive Runge-Kutta method of order 6, so that the motion barely
/// depends on the division of an interval.
#[derive(Clone)]
pub struct Plant {
    pub(crate) dynamics: Dynamics,
    pub(crate) actuators: Arc<[Actuator]>,
    /// Forces of the actuators.
    pub(crate) actuator_forces: Arc<[ActuatorForces]>,
    pub(crate) lpv: Option<Arc<LpvModel>>,
    pub(crate) fidelity: Fidelity,
    pub(crate) time: f64,
    pub(crate) body: Body,
    /// Lateral state \[v p r phi psi east\]; `None` for a vehicle in the vertical plane.
    pub(crate) lateral: Option<LateralState>,
    /// `true` if surge, heave and pitch are held.
    pub(crate) is_held: bool,
    pub(crate) outputs: Vec<f64>,
    pub(crate) commands: Vec<f64>,
    pub(crate) current: Current,
    pub(crate) water: Option<Arc<dyn Water>>,
    pub(crate) operating_speed: f64,
    pub(crate) given_speed: f64,
    pub(crate) load: Load,
    pub(crate) slopes: Slopes,
    /// `true` if any of the slopes is nonzero.
    pub(crate) has_slopes: bool,
    pub(crate) frozen: Frozen,
    pub(crate) integrator: Integrator,
}

impl Plant {
    /// Returns a nonlinear plant at rest at the origin, with all commands zero.
    ///
    /// # Errors
    /// [`CoefficientError`] if the vehicle's coefficients are not allowed.
    pub fn new(vehicle: &Vehicle) -> Result<Self, CoefficientError> {
        let inputs = vehicle.actuators.len();
        Ok(Self {
            dynamics: Dynamics::new(&vehicle.coefficients)?,
            actuators: vehicle.actuators.as_slice().into(),
            actuator_forces: vehicle.actuators.iter().map(ActuatorForces::of).collect(),
            lpv: None,
            fidelity: Fidelity::Nonlinear,
            time: 0.0,
            body: [0.0; 6],
            lateral: vehicle.coefficients.leaves_plane().then_some([0.0; 6]),
            is_held: false,
            outputs: vec![0.0; inputs],
            commands: vec![0.0; inputs],
            current: Current::default(),
            water: None,
            operating_speed: 0.0,
            given_speed: 0.0,
            load: Load::default(),
            slopes: Slopes::held(inputs),
            has_slopes: false,
            frozen: Frozen::new(inputs),
            integrator: Integrator::new(),
        })
    }

    /// Adds an LPV model to the plant; [`Plant::set_fidelity`] switches to it.
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

    /// Selects the equations of motion.
    ///
    /// # Errors
    /// [`SimulationError::NoLpvModel`] if the LPV model is selected but the plant has none.
    pub fn set_fidelity(&mut self, fidelity: Fidelity) -> Result<(), SimulationError> {
        // An LPV model of the vertical plane is not valid for six degrees of freedom.
        if fidelity == Fidelity::Lpv && (self.lpv.is_none() || self.lateral.is_some()) {
            return Err(SimulationError::NoLpvModel);
        }
        self.fidelity = fidelity;
        Ok(())
    }

    /// Sets the plant to a trim at x = 0, heading north: every actuator output and command at trim, operating speed and
    /// given speed those of the trim; the current is unchanged.
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
        self.lateral = self.lateral.map(|_| [v, p, r, phi, state.heading, state.east]);
    }

    /// Holds surge, heave and pitch at a trim from now on, regardless of the forces, as if another autopilot kept level
    /// flight.
    pub fn hold_level(&mut self, trim: &Trim) {
        let Motion { u, w, q, theta, .. } = trim.motion();
        self.body[..4].copy_from_slice(&[u, w, q, theta]);
        self.is_held = true;
    }

    /// Sets the command of an actuator \[N or rad\]; beyond its limits it saturates.
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

    /// Sets the current. The velocity over ground is continuous because of the inertia of the vehicle: the velocity
    /// through the water changes instead.
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

    /// Puts the plant into moving water in addition to the current. The velocity over ground is continuous.
    #[must_use]
    pub fn with_water(mut self, water: Arc<dyn Water>) -> Self {
        let instant = self.instant();
        self.water = Some(water);
        self.set_motion_over_ground(&instant);
        self
    }

    /// Replaces the water around the plant, before it is [restored](Plant::restore) in it.
    pub fn set_water(&mut self, water: Option<Arc<impl Water + 'static>>) {
        self.water = water.map(|water| water as Arc<dyn Water>);
    }

    /// Returns the velocity of the water at the vehicle: the current plus the motion of the water.
    pub fn flow(&self) -> Current {
        let water = self.water.as_ref().map(|water| water.at(self.time, &self.state().pose()));
        let all = self.current + water.unwrap_or_default().velocity;
        self.project_velocity(all.in_earth()).into()
    }

    /// Returns a velocity north, east and down, without its east component for a vehicle in the vertical plane.
    pub(crate) fn project_velocity<D: Scalar>(&self, [north, east, down]: [D; 3]) -> [D; 3] {
        [north, if self.lateral.is_some() { east } else { D::from(0.0) }, down]
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

    /// Sets the given speed u through the water \[m/s\]; unused by vehicles with free surge.
    ///
    /// # Errors
    /// [`SimulationError::InputNotFinite`].
    pub fn set_given_speed(&mut self, speed: f64) -> Result<(), SimulationError> {
        finite("given speed", speed)?;
        self.given_speed = speed;
        Ok(())
    }

    /// Sets an external load; X has no effect if the speed is given.
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

    /// Returns the external load.
    pub fn load(&self) -> Load {
        self.load
    }

    /// Sets weight, buoyancy and centre of gravity, and the mass with them; the motion is continuous.
    ///
    /// # Errors
    /// [`CoefficientError`]; the plant is unchanged then.
    pub fn set_ballast(&mut self, ballast: &Ballast) -> Result<(), CoefficientError> {
        self.dynamics.set_ballast(ballast)
    }

    /// Returns weight, buoyancy, centre of gravity and mass in use.
    pub fn ballast(&self) -> Ballast {
        self.dynamics.coefficients().ballast()
    }

    /// Sets constant rates of change of the inputs; [`Plant::advance`] applies them.
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
        self.has_slopes = !held || slopes.commands.iter().any(|rate| *rate != 0.0);
        Ok(())
    }

    /// Advances the vehicle to an instant \[s\], with all inputs held or changing at their rates.
    ///
    /// # Errors
    /// [`SimulationError`] if time would run backwards or the motion diverges; the plant is unchanged then.
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
            Some(model) if self.has_slopes => Model::Scheduled(model, self.operating_speed),
            Some(_) => Model::Frozen(&self.frozen),
        };
        let State { x, east, .. } = self.state();
        let mut flow = Flow {
            dynamics: &self.dynamics,
            actuators: &self.actuators,
            actuator_forces: &self.actuator_forces,
            outputs: &self.outputs,
            commands: &self.commands,
            current: self.current,
            depth: self.body[5],
            model,
            given: self.given_speed,
            load: self.load,
            slopes: self.has_slopes.then_some(&self.slopes),
            water: self.water.as_deref().map(|water| (water, from, [x, east])),
        };
        let [u, w, q, theta, x, depth] = self.body;
        let start = [u, w, q, theta, 0.0, 0.0];
        let integration_error = |source| SimulationError::Integration { from, to, source };
        let end = match self.lateral {
            None => self.integrator.advance(&mut flow, &start, duration).map_err(integration_error)?,
            Some([v, p, r, phi, heading, east]) => {
                let mut flow_six_dof = SixDofFlow { flow, is_held: self.is_held, last_usual: None };
                let start = join(start, [v, p, r, phi, heading, 0.0]);
                let end = self
                    .integrator
                    .advance(&mut flow_six_dof, &start, duration)
                    .map_err(integration_error)?;
                let (body, [v, p, r, phi, heading, travelled]) = split(&flow_six_dof.with_usual_angles(&end));
                self.lateral = Some([v, p, r, phi, heading, east + travelled]);
                body
            }
        };
        self.body = [end[0], end[1], end[2], end[3], x + end[4], depth + end[5]];
        self.advance_inputs(duration);
        self.time = to;
        Ok(())
    }

    /// Advances the outputs of the actuators and the inputs.
    pub(crate) fn advance_inputs(&mut self, duration: f64) {
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

    /// Returns the speed at which the LPV model is evaluated \[m/s\].
    pub fn operating_speed(&self) -> f64 {
        self.operating_speed
    }

    /// Returns the given speed \[m/s\]; unused by vehicles with free surge.
    pub fn given_speed(&self) -> f64 {
        self.given_speed
    }

    /// Sets the output of an actuator \[N or rad\], bypassing its lag.
    ///
    /// # Panics
    /// Panics if there is no such actuator.
    pub fn set_output(&mut self, index: usize, output: f64) {
        self.outputs[index] = output;
    }

    /// Returns the present time \[s\].
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Returns position, and motion through the water.
    pub fn state(&self) -> State {
        let [_, _, _, _, x, depth] = self.body;
        let (motion, heading) = motion_of(&join(self.body, self.lateral.unwrap_or_default()));
        let east = self.lateral.map_or(0.0, |lateral| lateral[5]);
        State { motion, x, depth, heading, east, bottom: Bottom::default().depth_at(x, east) }
    }

    /// Returns the actuators.
    pub fn actuators(&self) -> &[Actuator] {
        &self.actuators
    }

    /// Returns the output of each actuator \[N or rad\].
    pub fn outputs(&self) -> &[f64] {
        &self.outputs
    }

    /// Returns the current.
    pub fn current(&self) -> Current {
        self.current
    }

    /// Returns the speed through the water, sqrt(u^2 + v^2 + w^2) \[m/s\].
    pub fn speed(&self) -> f64 {
        let Motion { u, v, w, .. } = self.state().motion;
        u.hypot(w).hypot(v)
    }

    /// Returns the velocity over ground in body axes \[m/s\]: surge, sway, heave.
    pub fn velocity_over_ground(&self) -> [f64; 3] {
        let State { motion, heading, .. } = self.state();
        let [u_c, v_c, w_c] = motion.along_body(heading, self.flow().in_earth());
        [motion.u + u_c, motion.v + v_c, motion.w + w_c]
    }

    /// Returns the velocity over ground in the earth frame \[m/s\]: north, or horizontal in the vertical plane; east;
    /// and down (the depth rate).
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

    /// Many short intervals, with inputs held at their midpoint values, agree with a ramp to second order.
    #[test]
    fn ramp_is_the_limit_of_a_staircase() {
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
                let is_ramp = *pieces == 1;
                let at = if is_ramp { from } else { middle };
                plant.set_command(0, command + slope * at).unwrap();
                plant.set_current(current(at)).unwrap();
                if is_ramp {
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
    fn command_across_both_limits_saturates_at_each() {
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
