//! Random numbers, reproducible by a seed on every machine.

use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;

/// Use of random numbers. Each has its own stream, so that no use affects another.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Purpose {
    Waves,
    Current,
    /// Sensor with its number.
    Sensor(u32),
}

impl Purpose {
    /// Returns the stream for a seed.
    pub(crate) fn stream(self, seed: u64) -> ChaCha8Rng {
        let mut numbers = ChaCha8Rng::seed_from_u64(seed);
        numbers.set_stream(match self {
            Self::Waves => 0,
            Self::Current => 1,
            Self::Sensor(number) => 2 + u64::from(number),
        });
        numbers
    }
}
