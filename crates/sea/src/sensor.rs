//! Errors of a sensor.

use crate::error::{SeaError, check};
use crate::random::Purpose;
use rand::rngs::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// A time that is shorter by this part of a tick is the tick's, for the rounding of times.
const ROUNDING: f64 = 1e-9;

/// The errors of a sensor, in the unit of its signal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorErrors {
    /// The standard deviation of each sample.
    pub noise: f64,
    /// The bias of each sample.
    pub bias: f64,
    /// Samples are whole multiples of this; 0 for a sensor without steps.
    pub quantum: f64,
    /// Samples a second \[Hz\]; infinity for one that samples at every tick. The last sample is held.
    pub rate: f64,
    /// The delay of a sample \[s\].
    pub delay: f64,
}

impl SensorErrors {
    /// A sensor without errors.
    pub const NONE: Self = Self { noise: 0.0, bias: 0.0, quantum: 0.0, rate: f64::INFINITY, delay: 0.0 };

    /// Refuses numbers that are not allowed.
    ///
    /// # Errors
    /// [`SeaError::NotAllowed`].
    pub fn check(&self) -> Result<(), SeaError> {
        let Self { noise, bias, quantum, rate, delay } = *self;
        check("noise", noise, noise >= 0.0, "0 or above")?;
        check("bias", bias, true, "a finite number")?;
        check("quantum", quantum, quantum >= 0.0, "0, for none, or above")?;
        check("rate", rate.min(1.0), rate > 0.0, "above 0 (Hz)")?;
        check("delay", delay, (0.0..=10.0).contains(&delay), "from 0 to 10 (s)")
    }
}

/// A sensor that is read at every tick of an autopilot.
///
/// Tick n, at `n T`, takes a sample where `n T rate` has passed a whole number since the last; delays are rounded up
/// to whole ticks. Before, the first sample is read.
#[derive(Debug)]
pub struct Sensor {
    errors: SensorErrors,
    tick: f64,
    ticks: u64,
    held: f64,
    /// What was held at the last ticks, as many as the delay has, and now.
    line: Vec<f64>,
    random: ChaCha8Rng,
}

impl Sensor {
    /// A sensor for a tick of T \[s\]; sensors of one seed differ by their number.
    ///
    /// # Errors
    /// [`SeaError::NotAllowed`].
    pub fn new(errors: SensorErrors, tick: f64, seed: u64, number: u32) -> Result<Self, SeaError> {
        errors.check()?;
        check("tick", tick, tick > 0.0, "above 0 (s)")?;
        let late = (errors.delay / tick - ROUNDING).ceil().max(0.0) as usize;
        let random = Purpose::Sensor(number).stream(seed);
        Ok(Self { errors, tick, ticks: 0, held: 0.0, line: vec![0.0; late + 1], random })
    }

    /// Returns the reading at the next tick for a value of the signal.
    pub fn read(&mut self, value: f64) -> f64 {
        if self.samples() {
            let SensorErrors { noise, bias, quantum, .. } = self.errors;
            let normal: f64 = StandardNormal.sample(&mut self.random);
            let found = value + bias + noise * normal;
            self.held = if quantum > 0.0 { (found / quantum).round() * quantum } else { found };
        }
        if self.ticks == 0 {
            self.line.fill(self.held);
        }
        let length = self.line.len() as u64;
        self.line[(self.ticks % length) as usize] = self.held;
        self.ticks += 1;
        self.line[(self.ticks % length) as usize]
    }

    /// Whether a sample is due at this tick.
    fn samples(&self) -> bool {
        let taken = |ticks: u64| (ticks as f64 * self.tick * self.errors.rate + ROUNDING).floor();
        self.ticks == 0 || self.tick * self.errors.rate >= 1.0 || taken(self.ticks) > taken(self.ticks - 1)
    }
}
