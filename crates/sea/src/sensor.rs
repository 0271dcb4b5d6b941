//! Errors of a sensor.

use crate::error::{SeaError, check};
use crate::random::Purpose;
use rand::rngs::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Tolerance for the rounding of times, as a fraction of a tick.
const ROUNDING: f64 = 1e-9;

/// Errors of a sensor, in the unit of its signal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorErrors {
    /// Standard deviation of the noise of each sample.
    pub noise: f64,
    /// Bias of each sample.
    pub bias: f64,
    /// Quantisation step of the samples; 0 for none.
    pub quantum: f64,
    /// Sampling rate \[Hz\]; infinity for a sample at every tick. The last sample is held.
    pub rate: f64,
    /// Delay of a sample \[s\].
    pub delay: f64,
}

impl SensorErrors {
    /// Sensor without errors.
    pub const NONE: Self = Self { noise: 0.0, bias: 0.0, quantum: 0.0, rate: f64::INFINITY, delay: 0.0 };

    /// Refuses numbers outside their ranges.
    ///
    /// # Errors
    /// [`SeaError::NotAllowed`].
    pub fn check(&self) -> Result<(), SeaError> {
        let Self { noise, bias, quantum, rate, delay } = *self;
        check("noise", noise, noise >= 0.0, "at least 0")?;
        check("bias", bias, true, "a finite number")?;
        check("quantum", quantum, quantum >= 0.0, "at least 0 (0 for none)")?;
        check("rate", rate.min(1.0), rate > 0.0, "above 0 (Hz)")?;
        check("delay", delay, (0.0..=10.0).contains(&delay), "from 0 to 10 (s)")
    }
}

/// Sensor that is read at every tick of an autopilot.
///
/// Tick n, at `n T`, takes a sample if `n T rate` has passed an integer since the last tick; delays are rounded up to
/// whole ticks. Until the delay has passed, the first sample is read.
#[derive(Debug)]
pub struct Sensor {
    errors: SensorErrors,
    tick: f64,
    ticks: u64,
    held: f64,
    /// Ring buffer of the held samples of the last ticks: as many as the delay, and the present one.
    buffer: Vec<f64>,
    random: ChaCha8Rng,
}

impl Sensor {
    /// Returns a sensor for a tick of T \[s\]; sensors with the same seed differ by their number.
    ///
    /// # Errors
    /// [`SeaError::NotAllowed`].
    pub fn new(errors: SensorErrors, tick: f64, seed: u64, number: u32) -> Result<Self, SeaError> {
        errors.check()?;
        check("tick", tick, tick > 0.0, "above 0 (s)")?;
        let delay_ticks = (errors.delay / tick - ROUNDING).ceil().max(0.0) as usize;
        let random = Purpose::Sensor(number).stream(seed);
        Ok(Self { errors, tick, ticks: 0, held: 0.0, buffer: vec![0.0; delay_ticks + 1], random })
    }

    /// Returns the reading at the next tick for a value of the signal.
    pub fn read(&mut self, value: f64) -> f64 {
        if self.is_due() {
            let SensorErrors { noise, bias, quantum, .. } = self.errors;
            let normal: f64 = StandardNormal.sample(&mut self.random);
            let sample = value + bias + noise * normal;
            self.held = if quantum > 0.0 { (sample / quantum).round() * quantum } else { sample };
        }
        if self.ticks == 0 {
            self.buffer.fill(self.held);
        }
        let length = self.buffer.len() as u64;
        self.buffer[(self.ticks % length) as usize] = self.held;
        self.ticks += 1;
        self.buffer[(self.ticks % length) as usize]
    }

    /// Returns `true` if a sample is due at this tick.
    fn is_due(&self) -> bool {
        let sample_count = |ticks: u64| (ticks as f64 * self.tick * self.errors.rate + ROUNDING).floor();
        self.ticks == 0
            || self.tick * self.errors.rate >= 1.0
            || sample_count(self.ticks) > sample_count(self.ticks - 1)
    }
}
