//! Ocean current: layers over depth, and a random component.

use crate::error::{SeaError, check};
use crate::random::Purpose;
use rand::rngs::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use std::sync::Arc;

/// Horizontal current over depth: linear between the layers, constant above the first and below the last.
#[derive(Clone, Debug, PartialEq)]
pub struct Layers {
    /// Depth \[m\], increasing, and velocity \[m/s\], positive along the vehicle's heading.
    layers: Arc<[[f64; 2]]>,
}

impl Layers {
    /// Condition on the layers, for messages.
    pub const ALLOWED: &str =
        "at least one pair [depth in m, velocity in m/s], with increasing depths of at least 0";

    /// Returns the current with these layers; a single layer gives a current that is constant over depth.
    ///
    /// # Errors
    /// [`SeaError::NotAllowed`] with the first depth or velocity that is not allowed.
    pub fn new(layers: &[[f64; 2]]) -> Result<Self, SeaError> {
        check("layers", layers.len() as f64, !layers.is_empty(), Self::ALLOWED)?;
        let mut previous = -f64::MIN_POSITIVE;
        for &[depth, velocity] in layers {
            check("layers", depth, depth > previous, Self::ALLOWED)?;
            check("layers", velocity, true, Self::ALLOWED)?;
            previous = depth;
        }
        Ok(Self { layers: layers.into() })
    }

    /// Returns the velocity of a current that is constant over depth \[m/s\].
    pub fn steady(&self) -> Option<f64> {
        match *self.layers {
            [[_, velocity]] => Some(velocity),
            _ => None,
        }
    }

    /// Returns the velocity at a depth \[m/s\] and its derivative with respect to depth \[1/s\].
    pub fn at(&self, depth: f64) -> (f64, f64) {
        let layers = &self.layers;
        let below = layers.partition_point(|layer| layer[0] <= depth);
        match (below.checked_sub(1).map(|above| layers[above]), layers.get(below)) {
            (Some([top, from]), Some([bottom, to])) => {
                let slope = (to - from) / (bottom - top);
                (from + slope * (depth - top), slope)
            }
            (Some([_, velocity]), None) => (velocity, 0.0),
            (None, layer) => (layer.map_or(0.0, |layer| layer[1]), 0.0),
        }
    }
}

/// Parameters of a [`GaussMarkov`] process.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wandering {
    /// Inverse of the correlation time \[1/s\]; 0 for a random walk.
    pub mu: f64,
    /// Intensity of the white noise \[m/s per sqrt(s)\]: the stationary standard deviation, without limits, is
    /// `noise/sqrt(2 mu)`.
    pub noise: f64,
    /// Lower limit \[m/s\].
    pub min: f64,
    /// Upper limit \[m/s\].
    pub max: f64,
}

impl Wandering {
    /// Refuses parameters outside their ranges.
    ///
    /// # Errors
    /// [`SeaError::NotAllowed`].
    pub fn check(&self) -> Result<(), SeaError> {
        let Self { mu, noise, min, max } = *self;
        check("mu", mu, mu >= 0.0, "at least 0 (1/s)")?;
        check("noise", noise, noise >= 0.0, "at least 0 (m/s per sqrt(s))")?;
        check("min", min, min <= 0.0, "at most 0 (m/s), relative to the mean")?;
        check("max", max, max >= 0.0, "at least 0 (m/s), relative to the mean")
    }
}

/// First-order Gauss-Markov process about zero: `v' = -mu v + noise n(t)`, n white, clamped to its limits.
///
/// Source: Fossen, Handbook of Marine Craft Hydrodynamics and Motion Control (2011), section 8.3.
#[derive(Debug)]
pub struct GaussMarkov {
    parameters: Wandering,
    value: f64,
    random: ChaCha8Rng,
}

impl GaussMarkov {
    /// Returns a process that starts at zero.
    ///
    /// # Errors
    /// [`SeaError::NotAllowed`].
    pub fn new(parameters: Wandering, seed: u64) -> Result<Self, SeaError> {
        parameters.check()?;
        Ok(Self { parameters, value: 0.0, random: Purpose::Current.stream(seed) })
    }

    /// Returns the present value \[m/s\].
    pub fn value(&self) -> f64 {
        self.value
    }

    /// Advances by a step \[s\], exactly for any step length: `v exp(-mu h)` plus a normal random number of variance
    /// `noise^2 (1 - exp(-2 mu h))/(2 mu)`.
    pub fn advance(&mut self, step: f64) {
        let Wandering { mu, noise, min, max } = self.parameters;
        let variance = if mu > 0.0 { -(-2.0 * mu * step).exp_m1() / (2.0 * mu) } else { step };
        let normal: f64 = StandardNormal.sample(&mut self.random);
        self.value = (self.value * (-mu * step).exp() + noise * variance.sqrt() * normal).clamp(min, max);
    }
}
