//! The equations of motion in six degrees of freedom.

use differential_equations::ode::ODE;

use crate::motion::dynamics::{Motion, lateral_actuator_force};
use crate::simulation::flow::Flow;
use crate::simulation::integrator::{Equations, SWITCHES};
use crate::simulation::load::{in_plane, sideways};

/// v, p, r, phi, psi, and the way east.
pub(crate) type Side = [f64; 6];

/// Those of the vertical plane, and those that leave it.
pub(crate) type Whole = [f64; 12];

/// The equations in six degrees of freedom over an interval; ways made count from its start.
pub(crate) struct WholeFlow<'a> {
    pub(crate) flow: Flow<'a>,
    /// Whether surge, heave and pitch are held as they are.
    pub(crate) is_held: bool,
}

/// Body and side as one state.
pub(crate) fn joined(body: [f64; 6], side: Side) -> Whole {
    std::array::from_fn(|i| if i < 6 { body[i] } else { side[i - 6] })
}

/// Body and side.
pub(crate) fn split(whole: &Whole) -> ([f64; 6], Side) {
    (std::array::from_fn(|i| whole[i]), std::array::from_fn(|i| whole[6 + i]))
}

/// The motion through the water, and the heading.
pub(crate) fn motion_of(whole: &Whole) -> (Motion, f64) {
    let [u, w, q, theta, _, _, v, p, r, phi, heading, _] = *whole;
    (Motion { u, v, w, p, q, r, phi, theta }, heading)
}

impl ODE<f64, Whole> for WholeFlow<'_> {
    /// A changing current leaves the velocity over ground unchanged.
    fn diff(&self, time: f64, whole: &Whole, rate: &mut Whole) {
        let Flow { dynamics, actuators, .. } = self.flow;
        let (motion, heading) = motion_of(whole);
        let outputs = || self.flow.outputs_after(time);
        let given = self.flow.given + self.flow.slopes.map_or(0.0, |slopes| slopes.given_speed * time);
        let depth = self.flow.depth + whole[5];
        let [du, dw, dq, _] = dynamics.rate(actuators, &motion, depth, given, outputs());
        let lateral = lateral_actuator_force(actuators, motion.u, outputs());
        let [dv, dp, dr] = dynamics.lateral_acceleration(&motion, depth, lateral);
        let du = dynamics.coefficients().surge.rate(motion.u, given).unwrap_or(du);
        let (current, gained, load) = self.flow.outside(time);
        let [gained_u, gained_v, gained_w] = motion.along_body(heading, gained.in_earth());
        let [push_u, push_w, push_q] = dynamics.pushed(in_plane(load));
        let [push_v, push_p, push_r] = dynamics.pushed_sideways(sideways(load));
        let [roll, pitch, yaw] = motion.turning();
        let [north, east, down] = motion.velocity(heading);
        let [north_c, east_c, down_c] = current.in_earth();
        let ahead = if self.is_held {
            [0.0, 0.0, 0.0, 0.0, north + north_c, 0.0]
        } else {
            let (du, dw) = (du + push_u - gained_u, dw + push_w - gained_w);
            [du, dw, dq + push_q, pitch, north + north_c, down + down_c]
        };
        let (dv, dp, dr) = (dv + push_v - gained_v, dp + push_p, dr + push_r);
        *rate = joined(ahead, [dv, dp, dr, roll, yaw, east + east_c]);
    }
}

impl Equations<12> for WholeFlow<'_> {
    /// |u|, |v|, |w|, |p|, |q| and |r| have a corner at zero, and friction has one at the least Reynolds number.
    fn switches(&self, whole: &Whole) -> [f64; SWITCHES] {
        let (Motion { u, v, w, p, q, r, .. }, _) = motion_of(whole);
        [u, w, q, u.abs() - self.flow.dynamics.least_friction_speed(), v, p, r]
    }
}
