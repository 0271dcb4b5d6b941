//! The equations of motion in six degrees of freedom.

mod attitude;

use crate::motion::dynamics::{Motion, add};
use crate::simulation::current::Current;
use crate::simulation::flow::Flow;
use crate::simulation::integrator::{Equations, SWITCHES};
use crate::simulation::load::{in_plane, sideways, sum};
use crate::simulation::water::Pose;
use crate::vehicle::actuator::Push;
use attitude::{Angles, LEAST_COSINE, turned, usual};

/// v, p, r, phi, psi, and the way east.
pub(crate) type Side = [f64; 6];

/// Those of the vertical plane, and those that leave it.
pub(crate) type Whole = [f64; 12];

/// The equations in six degrees of freedom over an interval; ways made count from its start.
pub(crate) struct WholeFlow<'a> {
    pub(crate) flow: Flow<'a>,
    /// Whether surge, heave and pitch are held as they are.
    pub(crate) is_held: bool,
    /// The last usual angles, where those of the state are about the turned axes of the earth.
    pub(crate) last_usual: Option<Angles>,
}

impl WholeFlow<'_> {
    /// Motion and heading with the usual angles.
    fn usual(&self, whole: &Whole) -> (Motion, f64) {
        let (motion, heading) = motion_of(whole);
        let Some(last) = self.last_usual else { return (motion, heading) };
        let [phi, theta, heading] = usual([motion.phi, motion.theta, heading], last);
        (Motion { phi, theta, ..motion }, heading)
    }

    /// Returns the state with the usual angles.
    pub(crate) fn with_usual_angles(&self, whole: &Whole) -> Whole {
        let (Motion { phi, theta, .. }, heading) = self.usual(whole);
        with_angles(whole, [phi, theta, heading])
    }
}

/// Indices of the angles in the state.
const PITCH: usize = 3;
const ROLL: usize = 9;
const HEADING: usize = 10;

fn with_angles(whole: &Whole, angles: Angles) -> Whole {
    let mut all = *whole;
    [all[ROLL], all[PITCH], all[HEADING]] = angles;
    all
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

impl Equations<12> for WholeFlow<'_> {
    /// A changing current leaves the velocity over ground unchanged, and so does other water that moves, which pushes.
    fn rate(&self, time: f64, whole: &Whole) -> Whole {
        let Flow { dynamics, pushes, .. } = self.flow;
        let (motion, heading) = self.usual(whole);
        let attitude = motion.attitude();
        let [roll, pitch, yaw] = if self.last_usual.is_none() {
            motion.turning_at(&attitude)
        } else {
            motion_of(whole).0.turning()
        };
        let given = self.flow.given + self.flow.slopes.map_or(0.0, |slopes| slopes.given_speed * time);
        let depth = self.flow.depth + whole[5];
        let [x, z, m, y, k, n] = Push::all(pushes, motion.u, self.flow.outputs_after(time));
        let [du, dw, dq, _] = dynamics.rate_at(&attitude, &motion, depth, given, [x, z, m]);
        let [dv, dp, dr] = dynamics.lateral_acceleration_at(&attitude, &motion, depth, [y, k, n]);
        let du = dynamics.coefficients().surge.rate(motion.u, given).unwrap_or(du);
        let (mut current, mut gained, mut load) = self.flow.outside(time);
        let through = motion.velocity_at(&attitude, heading);
        let over_ground = |current: Current| add(through, current.in_earth());
        if let Some((water, start, [north, east])) = self.flow.water {
            let Motion { p, q, r, phi, theta, .. } = motion;
            let (north, east) = (north + whole[4], east + whole[11]);
            let met = water.at(start + time, &Pose { north, east, depth, roll: phi, pitch: theta, heading });
            current = current + met.velocity;
            gained = gained + met.along(over_ground(current), [p, q, r]);
            load = sum(load, met.load);
        }
        let still = self.flow.slopes.is_none() && self.flow.water.is_none();
        let [gained_u, gained_v, gained_w] =
            if still { [0.0; 3] } else { motion.along_body(heading, gained.in_earth()) };
        let [push_u, push_w, push_q] = dynamics.pushed(in_plane(load));
        let [push_v, push_p, push_r] = dynamics.pushed_sideways(sideways(load));
        let [north, east, down] = over_ground(current);
        let ahead = if self.is_held {
            [0.0, 0.0, 0.0, 0.0, north, 0.0]
        } else {
            let (du, dw) = (du + push_u - gained_u, dw + push_w - gained_w);
            [du, dw, dq + push_q, pitch, north, down]
        };
        let (dv, dp, dr) = (dv + push_v - gained_v, dp + push_p, dr + push_r);
        joined(ahead, [dv, dp, dr, roll, yaw, east])
    }

    /// |u|, |v|, |w|, |p|, |q| and |r| have a corner at zero, and friction has one at the least Reynolds number.
    fn switches(&self, whole: &Whole) -> [f64; SWITCHES] {
        let (Motion { u, v, w, p, q, r, .. }, _) = motion_of(whole);
        [u, w, q, u.abs() - self.flow.dynamics.least_friction_speed(), v, p, r]
    }

    fn motion(&self, whole: &Whole) -> Motion {
        motion_of(whole).0
    }

    fn rechart(&mut self, whole: &Whole) -> Option<Whole> {
        let (Motion { phi, theta, .. }, heading) = self.usual(whole);
        let is_upright = theta.cos().abs() < LEAST_COSINE && !self.is_held;
        if is_upright == self.last_usual.is_some() {
            return None;
        }
        let angles = [phi, theta, heading];
        self.last_usual = is_upright.then_some(angles);
        Some(with_angles(whole, if is_upright { turned(angles) } else { angles }))
    }
}
