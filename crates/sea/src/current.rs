//! Currents: layers over depth, and a part that wanders.

use crate::error::{SeaError, check};
use crate::random::Purpose;
use rand::rngs::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use std::sync::Arc;

/// A horizontal current over depth: linear between the layers, and as at the first and the last one beyond them.
#[derive(Clone, Debug, PartialEq)]
pub struct Layers {
    /// Depth \[m\], rising, and velocity \[m/s\], positive the way the vehicle faces.
    layers: Arc<[[f64; 2]]>,
}

impl Layers {
    /// What the layers must be.
    pub const ALLOWED: &str = "one pair [depth in m, velocity in m/s] or more, depths from 0 on and rising";

    /// A current by its layers; one of them is a current that does not change with depth.
    ///
    /// # Errors
    /// [`SeaError::NotAllowed`] with the first depth that is not allowed.
    pub fn new(layers: &[[f64; 2]]) -> Result<Self, SeaError> {
        check("layers", layers.len() as f64, !layers.is_empty(), Self::ALLOWED)?;
        let mut above = -f64::MIN_POSITIVE;
        for &[depth, velocity] in layers {
            check("layers", depth, depth > above, Self::ALLOWED)?;
            check("layers", velocity, true, Self::ALLOWED)?;
            above = depth;
        }
        Ok(Self { layers: layers.into() })
    }

    /// The velocity of a current that does not change with depth \[m/s\].
    pub fn steady(&self) -> Option<f64> {
        match *self.layers {
            [[_, velocity]] => Some(velocity),
            _ => None,
        }
    }

    /// Returns the velocity at a depth \[m/s\], and its derivative by depth \[1/s\].
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

/// The numbers of a [`GaussMarkov`] process.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wandering {
    /// The inverse of the correlation time \[1/s\]; 0 for a random walk.
    pub mu: f64,
    /// The density of the white noise \[m/s per sqrt(s)\]: without limits it reaches the deviation
    /// `noise/sqrt(2 mu)`.
    pub noise: f64,
    /// The least value \[m/s\].
    pub min: f64,
    /// The largest value \[m/s\].
    pub max: f64,
}

impl Wandering {
    /// Refuses numbers that are not allowed.
    ///
    /// # Errors
    /// [`SeaError::NotAllowed`].
    pub fn check(&self) -> Result<(), SeaError> {
        let Self { mu, noise, min, max } = *self;
        check("mu", mu, mu >= 0.0, "0 or above (1/s)")?;
        check("noise", noise, noise >= 0.0, "0 or above (m/s per sqrt(s))")?;
        check("min", min, min <= 0.0, "0 or below (m/s): it is off the mean")?;
        check("max", max, max >= 0.0, "0 or above (m/s): it is off the mean")
    }
}

/// A Gauss-Markov process of first order about zero: `v' = -mu v + noise n(t)`, n white, clamped to its limits.
///
/// Source: Fossen, Handbook of Marine Craft Hydrodynamics and Motion Control (2011), section 8.3.
#[derive(Debug)]
pub struct GaussMarkov {
    numbers: Wandering,
    value: f64,
    random: ChaCha8Rng,
}

impl GaussMarkov {
    /// A process that begins at zero.
    ///
    /// # Errors
    /// [`SeaError::NotAllowed`].
    pub fn new(numbers: Wandering, seed: u64) -> Result<Self, SeaError> {
        numbers.check()?;
        Ok(Self { numbers, value: 0.0, random: Purpose::Current.stream(seed) })
    }

    /// The present value \[m/s\].
    pub fn value(&self) -> f64 {
        self.value
    }

    /// Advances by a step \[s\], exactly for any step length: `v exp(-mu h)`, and a normal number of the variance
    /// `noise^2 (1 - exp(-2 mu h))/(2 mu)`.
    pub fn advance(&mut self, step: f64) {
        let Wandering { mu, noise, min, max } = self.numbers;
        let variance = if mu > 0.0 { -(-2.0 * mu * step).exp_m1() / (2.0 * mu) } else { step };
        let normal: f64 = StandardNormal.sample(&mut self.random);
        self.value = (self.value * (-mu * step).exp() + noise * variance.sqrt() * normal).clamp(min, max);
    }
}
