//! Equations of motion in six degrees of freedom.

mod attitude;

use crate::motion::dynamics::{Motion, add};
use crate::simulation::current::Current;
use crate::simulation::flow::Flow;
use crate::simulation::integrator::{Equations, SWITCHES};
use crate::simulation::load::{in_plane, out_of_plane, sum};
use crate::simulation::water::Pose;
use crate::vehicle::actuator::ActuatorForces;
use attitude::{Angles, LEAST_COSINE, rotated, usual};

/// Lateral state: v, p, r, phi, psi, and the distance east.
pub(crate) type LateralState = [f64; 6];

/// State in six degrees of freedom: longitudinal state, then lateral state.
pub(crate) type FullState = [f64; 12];

/// Equations in six degrees of freedom over an interval; distances count from its start.
pub(crate) struct SixDofFlow<'a> {
    pub(crate) flow: Flow<'a>,
    /// `true` if surge, heave and pitch are held.
    pub(crate) is_held: bool,
    /// Last Euler angles about the earth axes; `Some` while the state has those about the rotated axes.
    pub(crate) last_usual: Option<Angles>,
}

impl SixDofFlow<'_> {
    /// Returns motion and heading with the Euler angles about the earth axes.
    fn usual(&self, state: &FullState) -> (Motion, f64) {
        let (motion, heading) = motion_of(state);
        let Some(last) = self.last_usual else { return (motion, heading) };
        let [phi, theta, heading] = usual([motion.phi, motion.theta, heading], last);
        (Motion { phi, theta, ..motion }, heading)
    }

    /// Returns the state with the Euler angles about the earth axes.
    pub(crate) fn with_usual_angles(&self, state: &FullState) -> FullState {
        let (Motion { phi, theta, .. }, heading) = self.usual(state);
        with_angles(state, [phi, theta, heading])
    }
}

/// Indices of the angles in the state.
const PITCH: usize = 3;
const ROLL: usize = 9;
const HEADING: usize = 10;

fn with_angles(state: &FullState, angles: Angles) -> FullState {
    let mut all = *state;
    [all[ROLL], all[PITCH], all[HEADING]] = angles;
    all
}

/// Joins longitudinal and lateral state.
pub(crate) fn join(body: [f64; 6], lateral: LateralState) -> FullState {
    std::array::from_fn(|i| if i < 6 { body[i] } else { lateral[i - 6] })
}

/// Splits a state into longitudinal and lateral state.
pub(crate) fn split(state: &FullState) -> ([f64; 6], LateralState) {
    (std::array::from_fn(|i| state[i]), std::array::from_fn(|i| state[6 + i]))
}

/// Returns the motion through the water, and the heading.
pub(crate) fn motion_of(state: &FullState) -> (Motion, f64) {
    let [u, w, q, theta, _, _, v, p, r, phi, heading, _] = *state;
    (Motion { u, v, w, p, q, r, phi, theta }, heading)
}

impl Equations<12> for SixDofFlow<'_> {
    /// Returns the rate of the state. A changing current leaves the velocity over ground unchanged, and so does other
    /// motion of the water, apart from its load.
    fn rate(&self, time: f64, state: &FullState) -> FullState {
        let Flow { dynamics, actuator_forces, .. } = self.flow;
        let (motion, heading) = self.usual(state);
        let attitude = motion.attitude();
        let [roll, pitch, yaw] = if self.last_usual.is_none() {
            motion.turning_at(&attitude)
        } else {
            motion_of(state).0.turning()
        };
        let given = self.flow.given + self.flow.slopes.map_or(0.0, |slopes| slopes.given_speed * time);
        let depth = self.flow.depth + state[5];
        let [x, z, m, y, k, n] =
            ActuatorForces::all(actuator_forces, motion.u, self.flow.outputs_after(time));
        let [du, dw, dq, _] = dynamics.rate_at(&attitude, &motion, depth, given, [x, z, m]);
        let [dv, dp, dr] = dynamics.lateral_acceleration_at(&attitude, &motion, depth, [y, k, n]);
        let du = dynamics.coefficients().surge.rate(motion.u, given).unwrap_or(du);
        let (mut current, mut current_rate, mut load) = self.flow.disturbances(time);
        let through = motion.velocity_at(&attitude, heading);
        let over_ground = |current: Current| add(through, current.in_earth());
        if let Some((water, start, [north, east])) = self.flow.water {
            let Motion { p, q, r, phi, theta, .. } = motion;
            let (north, east) = (north + state[4], east + state[11]);
            let water_motion =
                water.at(start + time, &Pose { north, east, depth, roll: phi, pitch: theta, heading });
            current = current + water_motion.velocity;
            current_rate = current_rate + water_motion.along(over_ground(current), [p, q, r]);
            load = sum(load, water_motion.load);
        }
        let still = self.flow.slopes.is_none() && self.flow.water.is_none();
        let [current_du, current_dv, current_dw] =
            if still { [0.0; 3] } else { motion.along_body(heading, current_rate.in_earth()) };
        let [load_u, load_w, load_q] = dynamics.load_acceleration(in_plane(load));
        let [load_v, load_p, load_r] = dynamics.lateral_load_acceleration(out_of_plane(load));
        let [north, east, down] = over_ground(current);
        let longitudinal = if self.is_held {
            [0.0, 0.0, 0.0, 0.0, north, 0.0]
        } else {
            let (du, dw) = (du + load_u - current_du, dw + load_w - current_dw);
            [du, dw, dq + load_q, pitch, north, down]
        };
        let (dv, dp, dr) = (dv + load_v - current_dv, dp + load_p, dr + load_r);
        join(longitudinal, [dv, dp, dr, roll, yaw, east])
    }

    /// Returns the switches: |u|, |v|, |w|, |p|, |q| and |r| have a corner at zero, friction has one at the least
    /// Reynolds number.
    fn switches(&self, state: &FullState) -> [f64; SWITCHES] {
        let (Motion { u, v, w, p, q, r, .. }, _) = motion_of(state);
        [u, w, q, u.abs() - self.flow.dynamics.least_friction_speed(), v, p, r]
    }

    fn motion(&self, state: &FullState) -> Motion {
        motion_of(state).0
    }

    fn rechart(&mut self, state: &FullState) -> Option<FullState> {
        let (Motion { phi, theta, .. }, heading) = self.usual(state);
        let is_upright = theta.cos().abs() < LEAST_COSINE && !self.is_held;
        if is_upright == self.last_usual.is_some() {
            return None;
        }
        let angles = [phi, theta, heading];
        self.last_usual = is_upright.then_some(angles);
        Some(with_angles(state, if is_upright { rotated(angles) } else { angles }))
    }
}
