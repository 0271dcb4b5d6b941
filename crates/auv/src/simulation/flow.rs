//! The equations of motion between two instants.

use crate::motion::dynamics::{Attitude, Dynamics, Motion};
use crate::simulation::current::{Current, earth_velocity};
use crate::simulation::frozen::Frozen;
use crate::simulation::integrator::{Body, Equations, SWITCHES};
use crate::simulation::load::{Load, in_plane, sum};
use crate::simulation::lpv_model::LpvModel;
use crate::simulation::slopes::Slopes;
use crate::simulation::water::{Pose, Water};
use crate::vehicle::actuator::{Actuator, Push};

/// Which equations apply over the interval.
pub(crate) enum Model<'a> {
    /// The nonlinear ones.
    Nonlinear,
    /// The LPV model at one operating speed.
    Frozen(&'a Frozen),
    /// The LPV model at an operating speed that changes from this initial value \[m/s\].
    Scheduled(&'a LpvModel, f64),
}

/// The equations of motion over an interval; time and the way made count from its start.
pub(crate) struct Flow<'a> {
    pub(crate) dynamics: &'a Dynamics,
    pub(crate) actuators: &'a [Actuator],
    /// Those of the actuators.
    pub(crate) pushes: &'a [Push],
    pub(crate) outputs: &'a [f64],
    pub(crate) commands: &'a [f64],
    pub(crate) current: Current,
    pub(crate) depth: f64,
    pub(crate) model: Model<'a>,
    /// The speed that is given to a vehicle that takes one \[m/s\].
    pub(crate) given: f64,
    /// The load from outside.
    pub(crate) load: Load,
    /// How the inputs change; `None` where all are held.
    pub(crate) slopes: Option<&'a Slopes>,
    /// Water that moves beside the current, with the time and the ways made north and east at the start.
    pub(crate) water: Option<(&'a dyn Water, f64, [f64; 2])>,
}

impl Flow<'_> {
    /// The outputs of the actuators a time later; one exponential serves neighbours with the same lag.
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

    /// The current a time later, its rate, and the load.
    pub(crate) fn outside(&self, time: f64) -> (Current, Current, Load) {
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
    /// A changing current leaves the velocity over ground unchanged: the velocity through the water loses what the
    /// current gains. So it does in other water that moves, which pushes the vehicle besides, as a load from outside.
    fn rate(&self, time: f64, body: &Body) -> Body {
        let [u, w, q, theta, made, sunk] = *body;
        let (sin, cos) = theta.sin_cos();
        let outputs = self.outputs_after(time);
        let given = self.given + self.slopes.map_or(0.0, |slopes| slopes.given_speed * time);
        let [du, dw, dq, dtheta] = match &self.model {
            Model::Frozen(frozen) => frozen.derivative([u, w, q, theta], outputs),
            Model::Scheduled(model, speed) => {
                let gained = self.slopes.map_or(0.0, |slopes| slopes.operating_speed * time);
                model.derivative(speed + gained, [u, w, q, theta], outputs)
            }
            Model::Nonlinear => {
                let motion = Motion::in_plane(u, w, q, theta);
                let [surge, heave, pitch] = Push::all(self.pushes, u, outputs);
                let attitude = Attitude { sin, cos, sin_phi: 0.0, cos_phi: 1.0 };
                let depth = self.depth + sunk;
                self.dynamics.rate_at(&attitude, &motion, depth, given, [surge, heave, pitch])
            }
        };
        let du = self.dynamics.coefficients().surge.rate(u, given).unwrap_or(du);
        let (current, gained, load) = self.outside(time);
        let (gained_u, gained_w) = if self.slopes.is_some() { gained.along_body(theta) } else { (0.0, 0.0) };
        let Some((water, start, [x, _])) = self.water else {
            let (x_rate, depth_rate) = earth_velocity([u, w], [sin, cos], current);
            let [push_u, push_w, push_q] = self.dynamics.pushed(in_plane(load));
            return [du + push_u - gained_u, dw + push_w - gained_w, dq + push_q, dtheta, x_rate, depth_rate];
        };
        let motion = water.at(start + time, &Pose::in_plane(x + made, self.depth + sunk, theta));
        let (x_rate, depth_rate) = earth_velocity([u, w], [sin, cos], current + motion.velocity);
        let (met_u, met_w) = motion.along([x_rate, 0.0, depth_rate], [0.0, dtheta, 0.0]).along_body(theta);
        let [push_u, push_w, push_q] = self.dynamics.pushed(in_plane(sum(load, motion.load)));
        let (du, dw) = (du + push_u - gained_u - met_u, dw + push_w - gained_w - met_w);
        [du, dw, dq + push_q, dtheta, x_rate, depth_rate]
    }

    /// |u|, |w| and |q| have a corner at zero, and friction has one at the least Reynolds number. The LPV model has no
    /// corners.
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
