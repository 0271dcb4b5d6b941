//! The motion at one instant as states and their rates, for other integrators and for exact derivatives.
//!
//! The states are the velocities over ground along the body, not those through the water: the vehicle has mass, so that
//! they are continuous where the current jumps. They are of the vertical plane.

use crate::motion::dynamics::Motion;
use crate::scalar::Scalar;
use crate::simulation::current::Current;
use crate::simulation::lpv_model::LpvModel;
use crate::simulation::plant::{Fidelity, Plant};
use crate::vehicle::actuator::Actuator;

/// The motion at one instant, and what acts on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instant<D = f64> {
    /// Time \[s\].
    pub time: D,
    /// Velocity over ground along the body, forward \[m/s\].
    pub surge: D,
    /// Velocity over ground along the body, down \[m/s\].
    pub heave: D,
    /// Pitch rate \[rad/s\].
    pub pitch_rate: D,
    /// Pitch \[rad\].
    pub pitch: D,
    /// Horizontal distance \[m\].
    pub distance: D,
    /// Depth \[m\].
    pub depth: D,
    /// Horizontal velocity of the water where the vehicle is \[m/s\].
    pub current_horizontal: D,
    /// Vertical velocity of the water there \[m/s\], positive down.
    pub current_vertical: D,
    /// Speed at which the LPV model is evaluated \[m/s\].
    pub operating_speed: D,
    /// The speed that is given to a vehicle that takes one \[m/s\].
    pub given_speed: D,
    /// The load \[X Z M\] from outside \[N, N, N m\].
    pub load: [D; 3],
}

/// Time derivatives of the states of an [`Instant`], in their order, with that of the distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rates<D = f64> {
    /// Of the surge velocity over ground \[m/s2\].
    pub surge: D,
    /// Of the heave velocity over ground \[m/s2\].
    pub heave: D,
    /// Of the pitch rate \[rad/s2\].
    pub pitch_rate: D,
    /// Of the pitch \[rad/s\].
    pub pitch: D,
    /// Of the horizontal distance over ground \[m/s\].
    pub distance: D,
    /// Of the depth \[m/s\].
    pub depth: D,
}

impl<D: Scalar> Instant<D> {
    /// The current along the body: `u_c = U_c cos - W_c sin`, `w_c = U_c sin + W_c cos`.
    fn current(&self) -> (D, D) {
        let (sin, cos) = self.pitch.sin_cos();
        let (u, w) = (self.current_horizontal, self.current_vertical);
        (u * cos - w * sin, u * sin + w * cos)
    }

    /// Where the water is that the vehicle meets, and when.
    fn place(&self) -> [D; 4] {
        [self.time, self.distance, self.depth, self.pitch]
    }

    /// The motion through the water.
    pub fn motion(&self) -> Motion<D> {
        let (u_c, w_c) = self.current();
        Motion::in_plane(self.surge - u_c, self.heave - w_c, self.pitch_rate, self.pitch)
    }
}

/// A number with its derivatives by time, distance, depth and pitch, where these carry derivatives.
fn along<D: Scalar>(instant: &Instant<D>, value: f64, slopes: [f64; 4]) -> D {
    let moved = instant.place().map(|one| one - one.re());
    moved.into_iter().zip(slopes).fold(D::from(value), |sum, (moved, slope)| sum + moved * slope)
}

/// A number between two others.
fn within<D: Scalar>(value: D, least: f64, most: f64) -> D {
    if value.re() < least {
        D::from(least)
    } else if value.re() > most {
        D::from(most)
    } else {
        value
    }
}

impl Actuator {
    /// Returns the command within the limits.
    pub fn saturate<D: Scalar>(&self, command: D) -> D {
        within(command, self.min, self.max)
    }

    /// Returns the rate of the output, `(sat(command) - output) / lag` within the limit of the rate; zero without lag,
    /// where the output is no state.
    pub fn output_rate<D: Scalar>(&self, output: D, command: D) -> D {
        if self.lag <= 0.0 {
            return D::from(0.0);
        }
        let most = self.rate.unwrap_or(f64::INFINITY);
        within((self.saturate(command) - output) / self.lag, -most, most)
    }
}

impl Plant {
    /// The motion at this instant, with velocities over ground, and what acts on it.
    pub fn instant(&self) -> Instant {
        let (surge, heave) = self.velocity_over_ground();
        let [_, _, pitch_rate, pitch, distance, depth] = self.body;
        let flow = self.flow();
        Instant {
            time: self.time,
            surge,
            heave,
            pitch_rate,
            pitch,
            distance,
            depth,
            current_horizontal: flow.horizontal,
            current_vertical: flow.vertical,
            operating_speed: self.operating_speed,
            given_speed: self.given_speed,
            load: self.load,
        }
    }

    /// Sets the motion by its velocities over ground, in the water there.
    pub fn set_motion_over_ground(&mut self, instant: &Instant) {
        let Instant { surge, heave, pitch_rate, pitch, distance, depth, .. } = *instant;
        self.body = [surge, heave, pitch_rate, pitch, distance, depth];
        let (u_c, w_c) = self.flow().along_body(pitch);
        self.body[0] -= u_c;
        self.body[1] -= w_c;
    }

    /// Goes to a time \[s\] as it moves over ground, for an integrator that moves it.
    pub fn set_time(&mut self, time: f64) {
        if self.water.is_none() {
            self.time = time;
            return;
        }
        let now = self.instant();
        self.time = time;
        self.set_motion_over_ground(&now);
    }

    /// Adds the motion of the water beside the current, where the vehicle is, to an instant whose water is the current.
    /// Derivatives that the instant carries are carried on.
    #[must_use]
    pub fn in_water<D: Scalar>(&self, current: &Instant<D>) -> Instant<D> {
        let Some(water) = &self.water else { return *current };
        let [time, x, depth, pitch] = current.place().map(|one| one.re());
        let motion = water.at(time, x, depth, pitch);
        let slopes = [motion.by_time, motion.by_x, motion.by_depth, motion.by_pitch];
        let of =
            |part: fn(&Current) -> f64| along(current, part(&motion.velocity), slopes.map(|one| part(&one)));
        Instant {
            current_horizontal: current.current_horizontal + of(|v| v.horizontal),
            current_vertical: current.current_vertical + of(|v| v.vertical),
            ..*current
        }
    }

    /// The load of the water and of what else pushes from outside.
    fn load_at<D: Scalar>(&self, instant: &Instant<D>) -> [D; 3] {
        let Some(water) = &self.water else { return instant.load };
        let [time, x, depth, pitch] = instant.place().map(|one| one.re());
        let push = water.at(time, x, depth, pitch).load;
        let slopes = water.load_slopes(time, x, depth, pitch);
        [0, 1, 2].map(|i| instant.load[i] + along(instant, push[i], slopes.map(|slope| slope[i])))
    }

    /// Returns the rates of the motion, `output(i)` being that of actuator i \[N or rad\].
    ///
    /// With `u = u_g - u_c(theta)`, `w = w_g - w_c(theta)`: `u_g' = u' - theta' w_c`, `w_g' = w' + theta' u_c`, and
    /// u', w', q', theta' by the equations of motion in use, under a steady current; water that moves otherwise
    /// changes the velocities over ground by its load alone.
    pub fn rates<D: Scalar>(&self, instant: &Instant<D>, output: impl Fn(usize) -> D) -> Rates<D> {
        let motion = instant.motion();
        let (actuators, dynamics) = (self.actuators(), self.dynamics.lifted());
        let outputs = (0..actuators.len()).map(output);
        let [du, dw, dq, dtheta] = match (self.fidelity, &self.lpv) {
            (Fidelity::Lpv, Some(model)) => model.derivative(
                instant.operating_speed,
                [motion.u, motion.w, motion.q, motion.theta],
                outputs,
            ),
            _ => dynamics.rate(actuators, &motion, instant.depth, instant.given_speed, outputs),
        };
        let du = self.dynamics.coefficients().surge.rate(motion.u, instant.given_speed).unwrap_or(du);
        let ((u_c, w_c), (sin, cos)) = (instant.current(), instant.pitch.sin_cos());
        let push = dynamics.pushed(self.load_at(instant));
        Rates {
            surge: du - dtheta * w_c + push[0],
            heave: dw + dtheta * u_c + push[1],
            pitch_rate: dq + push[2],
            pitch: dtheta,
            distance: instant.surge * cos + instant.heave * sin,
            depth: instant.heave * cos - instant.surge * sin,
        }
    }
}

impl LpvModel {
    /// Returns `A(rho) (x - x_trim(V)) + B(rho) (T - T_trim(V))` at a speed V \[m/s\] that may carry derivatives,
    /// the right-hand ones at a corner.
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
        let within = speed.re() >= below.speed && held < 1.0 && span > 0.0;
        let weight = if within { (speed - below.speed) / span } else { D::from(held) };
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
            let off = output - between(below.actuators[j], above.actuators[j]);
            for (i, sum) in derivative.iter_mut().enumerate() {
                *sum += entry(&self.b, i, j) * off;
            }
        }
        derivative
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Current, Speed, Surroundings, Vehicle, trim};
    use squid_sea::{Spectrum, Waves};
    use std::sync::Arc;

    fn vehicle() -> Vehicle {
        let file =
            std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../vehicles/remus100/vehicle.toml");
        Vehicle::parse(&std::fs::read_to_string(file).unwrap(), "vehicle.toml").unwrap().in_plane()
    }

    /// A short flight moves as the rates say, to second order in its length, in still water and under waves.
    #[test]
    fn rates_are_those_of_the_flight() {
        let vehicle = vehicle();
        let still = Plant::new(&vehicle).unwrap();
        let waves = Waves::new(&Spectrum::jonswap(1.0, 4.0, 3.3).unwrap(), 2.5, 20, 3).unwrap();
        let (geometry, coefficients) = (vehicle.geometry.unwrap(), &vehicle.coefficients);
        let water = Surroundings::still(coefficients).with_waves(waves, geometry, coefficients).unwrap();
        for (plant, depth) in [(still.clone(), 30.0), (still.with_water(Arc::new(water)), 3.0)] {
            moves_as_its_rates_say(plant, &vehicle, depth);
        }
    }

    fn moves_as_its_rates_say(mut plant: Plant, vehicle: &Vehicle, depth: f64) {
        plant.start(0.0, &trim(vehicle, Speed::Path(1.5), depth).unwrap()).unwrap();
        plant.set_current(Current { horizontal: 0.3, vertical: -0.1, ..Current::default() }).unwrap();
        for index in 0..vehicle.actuators.len() {
            plant.set_command(index, 0.7 * vehicle.actuators[index].max).unwrap();
        }
        plant.advance(0.5).unwrap();
        let before = plant.instant();
        let rates = plant.rates(&before, |i| plant.outputs()[i]);
        let x = plant.state().x;
        let outputs = plant.outputs().to_vec();
        let h = 1e-5;
        plant.advance(0.5 + h).unwrap();
        let after = plant.instant();
        for (name, change, expected) in [
            ("surge", after.surge - before.surge, rates.surge),
            ("heave", after.heave - before.heave, rates.heave),
            ("pitch_rate", after.pitch_rate - before.pitch_rate, rates.pitch_rate),
            ("pitch", after.pitch - before.pitch, rates.pitch),
            ("depth", after.depth - before.depth, rates.depth),
            ("distance", plant.state().x - x, rates.distance),
        ] {
            assert!((change / h - expected).abs() < 1e-3 * (1.0 + expected.abs()), "{name}");
            assert!(expected != 0.0, "{name}");
        }
        for (index, actuator) in vehicle.actuators.iter().enumerate().filter(|(_, one)| one.lag > 0.0) {
            let rate = actuator.output_rate(outputs[index], plant.commands[index]);
            let mean = (plant.outputs()[index] - outputs[index]) / h;
            assert!((mean - rate).abs() < 1e-3 * (1.0 + rate.abs()), "{}", actuator.name);
        }
    }
}
