//! Random numbers that are the same for the same seed, on every machine.

use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;

/// The use of random numbers. Each has a stream of its own, so that one does not change with another.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Purpose {
    Waves,
    Current,
    /// By its number.
    Sensor(u32),
}

impl Purpose {
    /// The stream of a seed.
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
