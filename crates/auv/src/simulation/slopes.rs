//! Inputs that change at constant rates over an interval, instead of being held.

use crate::simulation::current::Current;
use crate::simulation::load::Load;
use crate::vehicle::actuator::Actuator;

/// Rates of change of the inputs of a plant; all zero if they are held.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Slopes {
    /// Rate of the command of each actuator \[N/s or rad/s\].
    pub commands: Vec<f64>,
    /// Rate of the current \[m/s2\].
    pub current: Current,
    /// Rate of the speed at which the LPV model is evaluated \[m/s2\].
    pub operating_speed: f64,
    /// Rate of a given speed \[m/s2\].
    pub given_speed: f64,
    /// Rate of the external load.
    pub load: Load,
}

impl Slopes {
    /// Returns slopes of held inputs, for a number of actuators.
    pub fn held(actuators: usize) -> Self {
        Self { commands: vec![0.0; actuators], ..Self::default() }
    }
}

impl Actuator {
    /// Returns the output at a time `elapsed` \[s\] after `start`, under a command that changes at a constant rate.
    ///
    /// The command crosses each limit at most once and saturates beyond. For a command `c + s t`, `tau T' = c + s t -
    /// T` has the solution `T = c + s (t - tau) + (start - c + s tau) exp(-t / tau)`.
    pub fn output_along(&self, elapsed: f64, start: f64, command: f64, slope: f64) -> f64 {
        if slope == 0.0 {
            return self.output_after(elapsed, start, command);
        }
        let crossings = [(self.min - command) / slope, (self.max - command) / slope];
        let [first, second] = [crossings[0].min(crossings[1]), crossings[0].max(crossings[1])];
        let (mut time, mut output) = (0.0, start);
        for (end, is_ramp) in [(first, false), (second, true), (f64::INFINITY, false)] {
            let end = end.clamp(time, elapsed);
            let (present, length) = (command + slope * time, end - time);
            if length > 0.0 {
                output = if is_ramp {
                    self.output_on_ramp(length, output, present, slope)
                } else {
                    self.output_after(length, output, present + 0.5 * slope * length)
                };
            }
            time = end;
        }
        output
    }

    /// Returns the output on a ramp within the limits. The error `e = c + s t - T` is monotonic, since e' depends on e
    /// only: from the rate limit, if it starts there, to `s tau`, or through zero to the opposite rate limit.
    fn output_on_ramp(&self, elapsed: f64, start: f64, command: f64, slope: f64) -> f64 {
        if self.lag <= 0.0 {
            return (command + slope * elapsed).clamp(self.min, self.max);
        }
        let (time, start) = self.at_full_rate(elapsed, start, command, slope);
        let (elapsed, command, ramp_lag) = (elapsed - time, command + slope * time, slope * self.lag);
        let (duration_on_ramp, rate) = match self.rate.map(|rate| rate.copysign(slope)) {
            Some(rate) if slope.abs() > rate.abs() => {
                let error = (command - start - ramp_lag) / (rate * self.lag - ramp_lag);
                ((self.lag * error.max(1.0).ln()).min(elapsed), rate)
            }
            _ => (elapsed, 0.0),
        };
        command + slope * duration_on_ramp - ramp_lag
            + (start - command + ramp_lag) * (-duration_on_ramp / self.lag).exp()
            + rate * (elapsed - duration_on_ramp)
    }
}
