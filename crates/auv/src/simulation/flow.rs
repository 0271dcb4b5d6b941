//! Equations of motion between two instants.

use crate::motion::dynamics::{Attitude, Dynamics, Motion};
use crate::simulation::current::{Current, earth_velocity};
use crate::simulation::frozen::Frozen;
use crate::simulation::integrator::{Body, Equations, SWITCHES};
use crate::simulation::load::{Load, in_plane, sum};
use crate::simulation::lpv_model::LpvModel;
use crate::simulation::slopes::Slopes;
use crate::simulation::water::{Pose, Water};
use crate::vehicle::actuator::{Actuator, ActuatorForces};

/// Equations that apply over the interval.
pub(crate) enum Model<'a> {
    /// Nonlinear equations.
    Nonlinear,
    /// LPV model frozen at one operating speed.
    Frozen(&'a Frozen),
    /// LPV model at an operating speed that changes from this initial value \[m/s\].
    Scheduled(&'a LpvModel, f64),
}

/// Equations of motion over an interval; time and distance count from its start.
pub(crate) struct Flow<'a> {
    pub(crate) dynamics: &'a Dynamics,
    pub(crate) actuators: &'a [Actuator],
    /// Forces of the actuators.
    pub(crate) actuator_forces: &'a [ActuatorForces],
    pub(crate) outputs: &'a [f64],
    pub(crate) commands: &'a [f64],
    pub(crate) current: Current,
    pub(crate) depth: f64,
    pub(crate) model: Model<'a>,
    /// Given speed \[m/s\]; unused by vehicles with free surge.
    pub(crate) given: f64,
    /// External load.
    pub(crate) load: Load,
    /// Slopes of the inputs; `None` if all are held.
    pub(crate) slopes: Option<&'a Slopes>,
    /// Water with its own motion, with the time and the position north and east at the start.
    pub(crate) water: Option<(&'a dyn Water, f64, [f64; 2])>,
}

impl Flow<'_> {
    /// Returns the outputs of the actuators at a later time; actuators with equal lag share one exponential.
    pub(crate) fn outputs_after(&self, time: f64) -> impl Iterator<Item = f64> {
        let mut last = (0.0, 1.0);
        let mut exp = move |exponent: f64| {
            if exponent != last.0 {
                last = (exponent, exponent.exp());
            }
            last.1
        };
        let actuators = self.actuators.iter().zip(self.outputs).zip(self.commands).enumerate();
        actuators.map(move |(i, ((actuator, start), command))| match self.slopes {
            None => actuator.output_with(&mut exp, time, *start, *command),
            Some(slopes) => actuator.output_along(time, *start, *command, slopes.commands[i]),
        })
    }

    /// Returns the current at a later time, its rate, and the load.
    pub(crate) fn disturbances(&self, time: f64) -> (Current, Current, Load) {
        match self.slopes {
            None => (self.current, Current::default(), self.load),
            Some(slopes) => (
                self.current.after(time, slopes.current),
                slopes.current,
                sum(self.load, slopes.load.map(|slope| slope * time)),
            ),
        }
    }
}

impl Equations<6> for Flow<'_> {
    /// Returns the rate of the state. A changing current leaves the velocity over ground unchanged: the velocity
    /// through the water decreases by the change of the current. The same holds for other motion of the water, which
    /// also loads the vehicle.
    fn rate(&self, time: f64, body: &Body) -> Body {
        let [u, w, q, theta, travelled, descended] = *body;
        let (sin, cos) = theta.sin_cos();
        let outputs = self.outputs_after(time);
        let given = self.given + self.slopes.map_or(0.0, |slopes| slopes.given_speed * time);
        let [du, dw, dq, dtheta] = match &self.model {
            Model::Frozen(frozen) => frozen.derivative([u, w, q, theta], outputs),
            Model::Scheduled(model, speed) => {
                let change = self.slopes.map_or(0.0, |slopes| slopes.operating_speed * time);
                model.derivative(speed + change, [u, w, q, theta], outputs)
            }
            Model::Nonlinear => {
                let motion = Motion::in_plane(u, w, q, theta);
                let [surge, heave, pitch] = ActuatorForces::all(self.actuator_forces, u, outputs);
                let attitude = Attitude { sin, cos, sin_phi: 0.0, cos_phi: 1.0 };
                let depth = self.depth + descended;
                self.dynamics.rate_at(&attitude, &motion, depth, given, [surge, heave, pitch])
            }
        };
        let du = self.dynamics.coefficients().surge.rate(u, given).unwrap_or(du);
        let (current, current_rate, load) = self.disturbances(time);
        let (current_du, current_dw) =
            if self.slopes.is_some() { current_rate.along_body(theta) } else { (0.0, 0.0) };
        let Some((water, start, [x, _])) = self.water else {
            let (x_rate, depth_rate) = earth_velocity([u, w], [sin, cos], current);
            let [load_u, load_w, load_q] = self.dynamics.load_acceleration(in_plane(load));
            return [
                du + load_u - current_du,
                dw + load_w - current_dw,
                dq + load_q,
                dtheta,
                x_rate,
                depth_rate,
            ];
        };
        let motion = water.at(start + time, &Pose::in_plane(x + travelled, self.depth + descended, theta));
        let (x_rate, depth_rate) = earth_velocity([u, w], [sin, cos], current + motion.velocity);
        let (water_du, water_dw) =
            motion.along([x_rate, 0.0, depth_rate], [0.0, dtheta, 0.0]).along_body(theta);
        let [load_u, load_w, load_q] = self.dynamics.load_acceleration(in_plane(sum(load, motion.load)));
        let (du, dw) = (du + load_u - current_du - water_du, dw + load_w - current_dw - water_dw);
        [du, dw, dq + load_q, dtheta, x_rate, depth_rate]
    }

    /// Returns the switches: |u|, |w| and |q| have a corner at zero, friction has one at the least Reynolds number. The
    /// LPV model has no corners.
    fn switches(&self, body: &Body) -> [f64; SWITCHES] {
        let [u, w, q, ..] = *body;
        match self.model {
            Model::Nonlinear => [u, w, q, u.abs() - self.dynamics.least_friction_speed(), 1.0, 1.0, 1.0],
            Model::Frozen(_) | Model::Scheduled(..) => [1.0; SWITCHES],
        }
    }

    fn motion(&self, body: &Body) -> Motion {
        let [u, w, q, theta, ..] = *body;
        Motion::in_plane(u, w, q, theta)
    }
}
