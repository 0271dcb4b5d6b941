//! Inputs that change at constant rates over an interval, instead of being held.

use crate::simulation::current::Current;
use crate::simulation::load::Load;
use crate::vehicle::actuator::Actuator;

/// The rates at which the inputs of a plant change; all zero where they are held.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Slopes {
    /// Of the command of each actuator \[N/s or rad/s\].
    pub commands: Vec<f64>,
    /// Of the current \[m/s2\].
    pub current: Current,
    /// Of the speed at which the LPV model is evaluated \[m/s2\].
    pub operating_speed: f64,
    /// Of the speed that is given to a vehicle that takes one \[m/s2\].
    pub given_speed: f64,
    /// Of the load from outside.
    pub load: Load,
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
    /// The command crosses each limit at most once, and is constant beyond. While it is `c + s t`, `tau T' = c + s t
    /// - T` has the solution `T = c + s (t - tau) + (start - c + s tau) exp(-t / tau)`.
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
                output = if moving {
                    self.output_on_ramp(length, output, now, slope)
                } else {
                    self.output_after(length, output, now + 0.5 * slope * length)
                };
            }
            time = end;
        }
        output
    }

    /// The error `e = c + s t - T` moves one way, since e' depends on e alone: from the limit of the rate, if it begins
    /// there, to `s tau`, or through it to the other limit.
    fn output_on_ramp(&self, elapsed: f64, start: f64, command: f64, slope: f64) -> f64 {
        if self.lag <= 0.0 {
            return (command + slope * elapsed).clamp(self.min, self.max);
        }
        let (time, start) = self.at_full_rate(elapsed, start, command, slope);
        let (elapsed, command, lagging) = (elapsed - time, command + slope * time, slope * self.lag);
        let (lasting, rate) = match self.rate.map(|rate| rate.copysign(slope)) {
            Some(rate) if slope.abs() > rate.abs() => {
                let error = (command - start - lagging) / (rate * self.lag - lagging);
                ((self.lag * error.max(1.0).ln()).min(elapsed), rate)
            }
            _ => (elapsed, 0.0),
        };
        command + slope * lasting - lagging
            + (start - command + lagging) * (-lasting / self.lag).exp()
            + rate * (elapsed - lasting)
    }
}
