//! Motion at one instant as states and their rates, for external integrators and for exact derivatives.
//!
//! The states are the velocities over ground in body axes, not those through the water: because of the inertia of the
//! vehicle they are continuous when the current jumps.

use crate::motion::dynamics::{Motion, add};
use crate::scalar::Scalar;
use crate::simulation::current::Current;
use crate::simulation::load::{Load, in_plane, out_of_plane, sum};
use crate::simulation::lpv_model::LpvModel;
use crate::simulation::plant::{Fidelity, Plant, State};
use crate::simulation::water::{Pose, WaterMotion};
use crate::vehicle::actuator::{Actuator, ActuatorForces};

/// Indices of the states in an [`Instant`], and of their rates in [`Rates`].
#[allow(missing_docs, reason = "the text beside each says what it is")]
pub mod index {
    // Velocities over ground in body axes, m/s: forward, to starboard, down.
    pub const SURGE: usize = 0;
    pub const SWAY: usize = 1;
    pub const HEAVE: usize = 2;
    // Angular velocities about the body axes, rad/s.
    pub const P: usize = 3;
    pub const Q: usize = 4;
    pub const R: usize = 5;
    // Angles, rad.
    pub const ROLL: usize = 6;
    pub const PITCH: usize = 7;
    pub const HEADING: usize = 8;
    // Position, m: north, or the horizontal distance in the vertical plane; east; depth.
    pub const NORTH: usize = 9;
    pub const EAST: usize = 10;
    pub const DEPTH: usize = 11;
    // Number of states.
    pub const STATES: usize = 12;
}

use index::{DEPTH, EAST, HEADING, NORTH, PITCH, ROLL, STATES};

/// Motion and inputs at one instant. In the vertical plane sway, p, r, roll, heading and east are 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instant<D = f64> {
    /// Time \[s\].
    pub time: D,
    /// States, by [`index`].
    pub state: [D; STATES],
    /// Velocity of the water at the vehicle, north (or horizontal), east and down \[m/s\].
    pub current: [D; 3],
    /// Speed at which the LPV model is evaluated \[m/s\].
    pub operating_speed: D,
    /// Given speed \[m/s\]; unused by vehicles with free surge.
    pub given_speed: D,
    /// External load.
    pub load: Load<D>,
}

/// Time derivatives of the states of an [`Instant`], by [`index`].
pub type Rates<D = f64> = [D; STATES];

impl<D: Scalar> Instant<D> {
    /// Returns an instant with all values zero, for use with derivatives only.
    pub fn zero() -> Self {
        let zero = D::from(0.0);
        Self {
            time: zero,
            state: [zero; STATES],
            current: [zero; 3],
            operating_speed: zero,
            given_speed: zero,
            load: [zero; 6],
        }
    }

    /// Returns the motion over ground.
    fn over_ground(&self) -> Motion<D> {
        let [u, v, w, p, q, r, phi, theta, ..] = self.state;
        Motion { u, v, w, p, q, r, phi, theta }
    }

    /// Returns the velocity of the water in body axes.
    fn water(&self) -> [D; 3] {
        self.over_ground().along_body(self.state[HEADING], self.current)
    }

    /// Returns the time and the pose of the vehicle.
    fn pose(&self) -> (f64, Pose) {
        let [.., roll, pitch, heading, north, east, depth] = self.state.map(|one| one.re());
        (self.time.re(), Pose { north, east, depth, roll, pitch, heading })
    }

    /// Returns the derivative parts of time, north, east and depth, and of the rotation about each body axis: the
    /// inverse of [`Motion::turning`].
    fn variations(&self) -> [D; 7] {
        let of = |one: D| one - one.re();
        let [roll, pitch, heading] = [ROLL, PITCH, HEADING].map(|index| of(self.state[index]));
        let ((sin, cos), (sin_phi, cos_phi)) =
            (self.state[PITCH].re().sin_cos(), self.state[ROLL].re().sin_cos());
        let [north, east, depth] = [NORTH, EAST, DEPTH].map(|index| of(self.state[index]));
        let starboard = pitch * cos_phi + heading * (cos * sin_phi);
        let down = heading * (cos * cos_phi) - pitch * sin_phi;
        [of(self.time), north, east, depth, roll - heading * sin, starboard, down]
    }

    /// Returns the motion through the water.
    pub fn motion(&self) -> Motion<D> {
        let (motion, [u_c, v_c, w_c]) = (self.over_ground(), self.water());
        Motion { u: motion.u - u_c, v: motion.v - v_c, w: motion.w - w_c, ..motion }
    }
}

/// Returns values with derivatives, from their slopes with respect to the quantities of [`Instant::variations`].
fn along<D: Scalar, const N: usize>(instant: &Instant<D>, values: [f64; N], slopes: [[f64; N]; 7]) -> [D; N] {
    let variations = instant.variations();
    let of = |i: usize| {
        variations
            .into_iter()
            .zip(slopes)
            .fold(D::from(values[i]), |sum, (variation, slope)| sum + variation * slope[i])
    };
    std::array::from_fn(of)
}

/// Returns a value clamped to limits.
fn clamp<D: Scalar>(value: D, least: f64, greatest: f64) -> D {
    if value.re() < least {
        D::from(least)
    } else if value.re() > greatest {
        D::from(greatest)
    } else {
        value
    }
}

impl Actuator {
    /// Returns the command clamped to the limits.
    pub fn saturate<D: Scalar>(&self, command: D) -> D {
        clamp(command, self.min, self.max)
    }

    /// Returns the rate of the output, `(sat(command) - output) / lag` within the rate limit; zero without lag, where
    /// the output is no state.
    pub fn output_rate<D: Scalar>(&self, output: D, command: D) -> D {
        if self.lag <= 0.0 {
            return D::from(0.0);
        }
        let limit = self.rate.unwrap_or(f64::INFINITY);
        clamp((self.saturate(command) - output) / self.lag, -limit, limit)
    }
}

impl Plant {
    /// Returns the motion at the present instant, with velocities over ground, and the inputs.
    pub fn instant(&self) -> Instant {
        let State { motion, x, depth, heading, east, .. } = self.state();
        let [surge, sway, heave] = self.velocity_over_ground();
        let Motion { p, q, r, phi, theta, .. } = motion;
        Instant {
            time: self.time,
            state: [surge, sway, heave, p, q, r, phi, theta, heading, x, east, depth],
            current: self.flow().in_earth(),
            operating_speed: self.operating_speed,
            given_speed: self.given_speed,
            load: self.load,
        }
    }

    /// Sets the motion from its velocities over ground, in the water at the vehicle.
    pub fn set_motion_over_ground(&mut self, instant: &Instant) {
        let [.., heading, x, east, depth] = instant.state;
        let over_ground = instant.over_ground();
        self.set_state(&State { motion: over_ground, x, depth, heading, east, ..self.state() });
        let [u_c, v_c, w_c] = over_ground.along_body(heading, self.flow().in_earth());
        let Motion { u, v, w, .. } = over_ground;
        let motion = Motion { u: u - u_c, v: v - v_c, w: w - w_c, ..over_ground };
        self.set_state(&State { motion, x, depth, heading, east, ..self.state() });
    }

    /// Sets the time \[s\] at constant motion over ground, for an external integrator.
    pub fn set_time(&mut self, time: f64) {
        if self.water.is_none() {
            self.time = time;
            return;
        }
        let now = self.instant();
        self.time = time;
        self.set_motion_over_ground(&now);
    }

    /// Adds the motion of the water at the vehicle to an instant that contains only the current. Derivatives of the
    /// instant are propagated.
    #[must_use]
    pub fn in_water<D: Scalar>(&self, current: &Instant<D>) -> Instant<D> {
        let Some(water) = &self.water else { return *current };
        let (time, pose) = current.pose();
        let WaterMotion { velocity, by_time, by_place: [x, y, z], by_turn: [p, q, r], .. } =
            water.at(time, &pose);
        let slopes = [by_time, x, y, z, p, q, r].map(Current::in_earth);
        let water_velocity = along(current, velocity.in_earth(), slopes);
        Instant { current: add(current.current, self.project_velocity(water_velocity)), ..*current }
    }

    /// Returns the load of the water plus the external load.
    fn load_at<D: Scalar>(&self, instant: &Instant<D>) -> Load<D> {
        let Some(water) = &self.water else { return instant.load };
        let (time, pose) = instant.pose();
        let push = water.at(time, &pose).load;
        // Slopes are needed only if there are derivatives.
        let slopes = if D::NDERIV == 0 { [[0.0; 6]; 7] } else { water.load_slopes(time, &pose) };
        sum(instant.load, along(instant, push, slopes))
    }

    /// Returns the rates of the motion; `output(i)` is the output of actuator i \[N or rad\].
    ///
    /// The water has the velocity \[u_c v_c w_c\] in the rotating body axes: with `u = u_g - u_c`, and so on,
    ///
    /// ```text
    /// u_g' = u' - q w_c + r v_c   v_g' = v' - r u_c + p w_c   w_g' = w' + q u_c - p v_c
    /// ```
    ///
    /// and u' to r' from the selected equations of motion under a steady current; other motion of the water changes the
    /// velocities over ground through its load only. In the LPV model q is theta'.
    pub fn rates<D: Scalar>(&self, instant: &Instant<D>, output: impl Fn(usize) -> D) -> Rates<D> {
        let motion = instant.motion();
        let (actuators, dynamics) = (self.actuators(), self.dynamics.lifted());
        let outputs = || (0..actuators.len()).map(&output);
        let force: [D; 6] = ActuatorForces::all(&self.actuator_forces, motion.u, outputs());
        let depth = instant.state[DEPTH];
        let [du, dw, dq, q, turning] = match (self.fidelity, &self.lpv) {
            (Fidelity::Lpv, Some(model)) => {
                let state = [motion.u, motion.w, motion.q, motion.theta];
                let [du, dw, dq, dtheta] = model.derivative(instant.operating_speed, state, outputs());
                [du, dw, dq, dtheta, dtheta]
            }
            _ => {
                let given = instant.given_speed;
                let force = [force[0], force[1], force[2]];
                let [du, dw, dq, _] = dynamics.rate(&motion, depth, given, force);
                [du, dw, dq, motion.q, motion.turning()[1]]
            }
        };
        let [dv, dp, dr] = if self.lateral.is_some() {
            dynamics.lateral_acceleration(&motion, depth, [force[3], force[4], force[5]])
        } else {
            [D::from(0.0); 3]
        };
        let du = self.dynamics.coefficients().surge.rate(motion.u, instant.given_speed).unwrap_or(du);
        let [u_c, v_c, w_c] = instant.water();
        let load = self.load_at(instant);
        let ([load_u, load_w, load_q], [load_v, load_p, load_r]) = (
            dynamics.load_acceleration(in_plane(load)),
            dynamics.lateral_load_acceleration(out_of_plane(load)),
        );
        let over_ground = instant.over_ground();
        let [roll, _, heading] = over_ground.turning();
        let [north, east, down] = over_ground.velocity(instant.state[HEADING]);
        let Motion { p, r, .. } = motion;
        [
            du - q * w_c + r * v_c + load_u,
            dv - r * u_c + p * w_c + load_v,
            dw + q * u_c - p * v_c + load_w,
            dp + load_p,
            dq + load_q,
            dr + load_r,
            roll,
            turning,
            heading,
            north,
            east,
            down,
        ]
    }
}

impl LpvModel {
    /// Returns `A(rho) (x - x_trim(V)) + B(rho) (T - T_trim(V))` at a speed V \[m/s\] that may carry derivatives, the
    /// right-hand ones at a corner.
    pub(crate) fn derivative<D: Scalar>(
        &self,
        speed: D,
        x: [D; 4],
        outputs: impl Iterator<Item = D>,
    ) -> [D; 4] {
        let rho = (speed - self.speed_centre) / self.speed_half_range;
        let rho = if rho.re() < -1.0 {
            D::from(-1.0)
        } else if rho.re() >= 1.0 {
            D::from(1.0)
        } else {
            rho
        };
        let entry = |terms: &[Vec<Vec<f64>>], i: usize, j: usize| {
            terms.iter().rev().fold(D::from(0.0), |sum, term| sum * rho + term[i][j])
        };
        let (below, above, held) = self.bracket(speed.re());
        let span = above.speed - below.speed;
        let inside = speed.re() >= below.speed && held < 1.0 && span > 0.0;
        let weight = if inside { (speed - below.speed) / span } else { D::from(held) };
        let between = |from: f64, to: f64| weight * (to - from) + from;
        let trim = [
            between(below.forward_speed, above.forward_speed),
            between(below.heave, above.heave),
            D::from(0.0),
            between(below.pitch, above.pitch),
        ];
        let mut derivative = [D::from(0.0); 4];
        for (i, sum) in derivative.iter_mut().enumerate() {
            for (j, (x, trim)) in x.into_iter().zip(trim).enumerate() {
                *sum += entry(&self.a, i, j) * (x - trim);
            }
        }
        for (j, output) in outputs.enumerate() {
            let deviation = output - between(below.actuators[j], above.actuators[j]);
            for (i, sum) in derivative.iter_mut().enumerate() {
                *sum += entry(&self.b, i, j) * deviation;
            }
        }
        derivative
    }
}

#[cfg(test)]
mod tests {
    use super::index::HEAVE;
    use super::*;
    use crate::{Current, Speed, Surroundings, Vehicle, trim};
    use squid_sea::{Spectrum, Waves};
    use std::sync::Arc;

    fn vehicle() -> Vehicle {
        let file =
            std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../vehicles/remus100/vehicle.toml");
        Vehicle::parse(&std::fs::read_to_string(file).unwrap(), "vehicle.toml").unwrap()
    }

    /// A short flight agrees with the rates to second order in its length, in still water and under oblique waves, in
    /// six degrees of freedom and in the vertical plane.
    #[test]
    fn rates_match_the_flight() {
        for mut vehicle in [vehicle(), vehicle().in_plane()] {
            // A centre of buoyancy off the origin, so that it moves as the body turns.
            (vehicle.coefficients.x_B, vehicle.coefficients.z_B) = (0.001, -0.01);
            let still = Plant::new(&vehicle).unwrap();
            let waves = Waves::new(&Spectrum::jonswap(1.0, 4.0, 3.3).unwrap(), 1.5, 20, 3).unwrap();
            let (geometry, coefficients) = (vehicle.geometry.unwrap(), &vehicle.coefficients);
            let water = Surroundings::still(coefficients).with_waves(waves, geometry, coefficients).unwrap();
            for (plant, depth) in [(still.clone(), 30.0), (still.with_water(Arc::new(water)), 3.0)] {
                check_rates(plant, &vehicle, depth);
            }
        }
    }

    fn check_rates(mut plant: Plant, vehicle: &Vehicle, depth: f64) {
        let level = trim(vehicle, Speed::Path(1.5), depth).unwrap();
        plant.start(0.0, &level).unwrap();
        let turns = vehicle.coefficients.leaves_plane();
        let mut state = plant.state();
        state.heading = 2.5;
        plant.set_state(&state);
        plant
            .set_current(Current { horizontal: 0.3, vertical: -0.1, east: if turns { 0.2 } else { 0.0 } })
            .unwrap();
        plant.set_load([1.0, -2.0, 3.0, 0.1, 0.2, -0.3]).unwrap();
        for index in 0..vehicle.actuators.len() {
            plant.set_command(index, 0.7 * vehicle.actuators[index].max).unwrap();
        }
        plant.advance(0.5).unwrap();
        let before = plant.instant();
        let rates = plant.rates(&before, |i| plant.outputs()[i]);
        let outputs = plant.outputs().to_vec();
        let h = 1e-5;
        plant.advance(0.5 + h).unwrap();
        let after = plant.instant();
        for (row, expected) in rates.into_iter().enumerate() {
            let change = after.state[row] - before.state[row];
            assert!((change / h - expected).abs() < 1e-3 * (1.0 + expected.abs()), "{row}: {expected}");
            let in_plane = [index::SURGE, HEAVE, index::Q, PITCH, NORTH, DEPTH].contains(&row);
            assert_eq!(expected != 0.0, in_plane || turns, "{row}");
        }
        for (index, actuator) in vehicle.actuators.iter().enumerate().filter(|(_, one)| one.lag > 0.0) {
            let rate = actuator.output_rate(outputs[index], plant.commands[index]);
            let mean = (plant.outputs()[index] - outputs[index]) / h;
            assert!((mean - rate).abs() < 1e-3 * (1.0 + rate.abs()), "{}", actuator.name);
        }
    }
}
