//! The equations of motion between two instants, and the current in which they hold.

use differential_equations::ode::ODE;

use crate::actuator::Actuator;
use crate::dynamics::{Dynamics, Motion, actuator_force};
use crate::frozen::Frozen;
use crate::integrator::{Body, Equations};
use crate::lpv_model::LpvModel;
use crate::slopes::Slopes;

/// A steady, uniform current, in the earth frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Current {
    /// Horizontal velocity U_c \[m/s\].
    pub horizontal: f64,
    /// Vertical velocity W_c \[m/s\], positive down.
    pub vertical: f64,
}

impl Current {
    /// Returns the current along the body axes: `u_c = U_c cos - W_c sin`, `w_c = U_c sin + W_c cos`.
    pub(crate) fn along_body(self, theta: f64) -> (f64, f64) {
        let (sin, cos) = theta.sin_cos();
        (self.horizontal * cos - self.vertical * sin, self.horizontal * sin + self.vertical * cos)
    }
}

impl Current {
    /// The current a time later \[s\], changing at constant rates.
    pub(crate) fn after(self, elapsed: f64, rates: Self) -> Self {
        Self {
            horizontal: self.horizontal + rates.horizontal * elapsed,
            vertical: self.vertical + rates.vertical * elapsed,
        }
    }
}

/// `x' = u cos + w sin + U_c`, `z' = -u sin + w cos + W_c`.
pub(crate) fn earth_velocity(body: &Body, current: Current) -> (f64, f64) {
    let [u, w, _, theta, ..] = *body;
    let (sin, cos) = theta.sin_cos();
    (u * cos + w * sin + current.horizontal, w * cos - u * sin + current.vertical)
}

/// The equations of motion over an interval in which all inputs are held; time and the way made count from its start.
pub(crate) struct Flow<'a> {
    pub(crate) dynamics: &'a Dynamics,
    pub(crate) actuators: &'a [Actuator],
    pub(crate) outputs: &'a [f64],
    pub(crate) commands: &'a [f64],
    pub(crate) current: Current,
    pub(crate) depth: f64,
    pub(crate) frozen: Option<&'a Frozen>,
    pub(crate) slopes: Option<Moving<'a>>,
}

/// Inputs that change during the interval, with the LPV model in use.
pub(crate) struct Moving<'a> {
    pub(crate) slopes: &'a Slopes,
    pub(crate) lpv: Option<(&'a LpvModel, f64)>,
}

impl ODE<f64, Body> for Flow<'_> {
    fn diff(&self, time: f64, body: &Body, rate: &mut Body) {
        if let Some(moving) = &self.slopes {
            *rate = self.along(moving, time, body);
            return;
        }
        let [u, w, q, theta, _, sunk] = *body;
        let held = self.actuators.iter().zip(self.outputs).zip(self.commands);
        let outputs = held.map(|((actuator, start), command)| actuator.output_after(time, *start, *command));
        let (x_rate, depth_rate) = earth_velocity(body, self.current);
        let [du, dw, dq, dtheta] = match self.frozen {
            Some(frozen) => frozen.derivative([u, w, q, theta], outputs),
            None => {
                let force = actuator_force(self.actuators, u, outputs);
                let [du, dw, dq] =
                    self.dynamics.acceleration(&Motion { u, w, q, theta }, self.depth + sunk, force);
                [du, dw, dq, q]
            }
        };
        *rate = [du, dw, dq, dtheta, x_rate, depth_rate];
    }
}

impl Flow<'_> {
    /// The same with inputs on ramps. The velocity over ground does not feel a changing current, so that the one through the
    /// water loses what the current gains.
    fn along(&self, moving: &Moving<'_>, time: f64, body: &Body) -> Body {
        let Moving { slopes, lpv } = moving;
        let [u, w, q, theta, _, sunk] = *body;
        let held = self.actuators.iter().zip(self.outputs).zip(self.commands).zip(&slopes.commands);
        let outputs = held.map(|(((actuator, start), command), slope)| {
            actuator.output_along(time, *start, *command, *slope)
        });
        let (x_rate, depth_rate) = earth_velocity(body, self.current.after(time, slopes.current));
        let [du, dw, dq, dtheta] = match lpv {
            Some((model, speed)) => {
                model.derivative(speed + slopes.operating_speed * time, [u, w, q, theta], outputs)
            }
            None => {
                let force = actuator_force(self.actuators, u, outputs);
                let [du, dw, dq] =
                    self.dynamics.acceleration(&Motion { u, w, q, theta }, self.depth + sunk, force);
                [du, dw, dq, q]
            }
        };
        let (gained_u, gained_w) = slopes.current.along_body(theta);
        [du - gained_u, dw - gained_w, dq, dtheta, x_rate, depth_rate]
    }
}

impl Equations for Flow<'_> {
    /// |u|, |w| and |q| have a corner at zero, and friction has one at the least Reynolds number; the LPV model has none.
    fn switches(&self, body: &Body) -> [f64; 4] {
        let [u, w, q, ..] = *body;
        match self.frozen {
            Some(_) => [1.0; 4],
            None => [u, w, q, u.abs() - self.dynamics.least_friction_speed()],
        }
    }
}
