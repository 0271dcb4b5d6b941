//! Inputs that change at constant rates over an interval, instead of being held.

use crate::actuator::Actuator;
use crate::flow::Current;
use crate::plant::Plant;
use crate::simulation_error::{SimulationError, finite};

/// The rates at which the inputs of a plant change; all zero where they are held.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Slopes {
    /// Of the command of each actuator \[N/s or rad/s\].
    pub commands: Vec<f64>,
    /// Of the current \[m/s2\].
    pub current: Current,
    /// Of the speed at which the LPV model is evaluated \[m/s2\].
    pub operating_speed: f64,
}

impl Slopes {
    /// Inputs that are held, for a number of actuators.
    pub fn held(actuators: usize) -> Self {
        Self { commands: vec![0.0; actuators], ..Self::default() }
    }
}

impl Actuator {
    /// Returns the output a time `elapsed` \[s\] after it was `start`, under a command that changes at a constant rate.
    ///
    /// The command crosses each limit at most once, and is constant beyond. While it is `c + s t`, `tau T' = c + s t - T` has
    /// the solution `T = c + s (t - tau) + (start - c + s tau) exp(-t / tau)`.
    pub fn output_along(&self, elapsed: f64, start: f64, command: f64, slope: f64) -> f64 {
        if slope == 0.0 {
            return self.output_after(elapsed, start, command);
        }
        let crossings = [(self.min - command) / slope, (self.max - command) / slope];
        let [first, second] = [crossings[0].min(crossings[1]), crossings[0].max(crossings[1])];
        let (mut time, mut output) = (0.0, start);
        for (end, moving) in [(first, false), (second, true), (f64::INFINITY, false)] {
            let end = end.clamp(time, elapsed);
            let (now, length) = (command + slope * time, end - time);
            if length > 0.0 {
                output = match moving {
                    true => self.output_on_ramp(length, output, now, slope),
                    false => self.output_after(length, output, now + 0.5 * slope * length),
                };
            }
            time = end;
        }
        output
    }

    fn output_on_ramp(&self, elapsed: f64, start: f64, command: f64, slope: f64) -> f64 {
        if self.lag <= 0.0 {
            return (command + slope * elapsed).clamp(self.min, self.max);
        }
        let lagging = slope * self.lag;
        command + slope * elapsed - lagging + (start - command + lagging) * (-elapsed / self.lag).exp()
    }
}

impl Plant {
    /// Lets the inputs change at constant rates from now on; [`Plant::advance`] carries them along.
    ///
    /// # Errors
    /// [`SimulationError`] if a rate is not finite or belongs to no actuator.
    pub fn set_slopes(&mut self, slopes: &Slopes) -> Result<(), SimulationError> {
        let (found, expected) = (slopes.commands.len(), self.actuators().len());
        if found != expected {
            return Err(SimulationError::TrimActuators { found, expected });
        }
        let Current { horizontal, vertical } = slopes.current;
        for &rate in [horizontal, vertical, slopes.operating_speed].iter().chain(&slopes.commands) {
            finite("rate of an input", rate)?;
        }
        self.slopes.commands.copy_from_slice(&slopes.commands);
        (self.slopes.current, self.slopes.operating_speed) = (slopes.current, slopes.operating_speed);
        let held = slopes.current == Current::default() && slopes.operating_speed == 0.0;
        self.moving = !held || slopes.commands.iter().any(|rate| *rate != 0.0);
        Ok(())
    }

    /// The rates at which the inputs change.
    pub fn slopes(&self) -> &Slopes {
        &self.slopes
    }

    /// Carries outputs of actuators and inputs along.
    pub(crate) fn carry_inputs(&mut self, duration: f64) {
        let actuators = self.actuators.iter().zip(&mut self.outputs);
        let inputs = self.commands.iter_mut().zip(&self.slopes.commands);
        for ((actuator, output), (command, slope)) in actuators.zip(inputs) {
            *output = actuator.output_along(duration, *output, *command, *slope);
            *command += slope * duration;
        }
        self.current = self.current.after(duration, self.slopes.current);
        self.operating_speed += self.slopes.operating_speed * duration;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Motion, Speed, Vehicle, trim};

    fn vehicle() -> Vehicle {
        let file = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../vehicles/squid/vehicle.toml");
        Vehicle::read(&file).unwrap()
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
            let current = |time: f64| Current { horizontal: 0.3 * time, vertical: -0.2 * time };
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
        assert_eq!(ramp.commands()[0], 220.0, "the input has moved along");
        let (Motion { u, w, q, theta }, other) = (ramp.state().motion, stairs.state().motion);
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
                let found = actuator.output_along(1.0, 3.0, command, slope);
                assert!((found - output).abs() < 1e-3, "{lag} {command} {slope}: {found} and {output}");
            }
        }
    }
}
