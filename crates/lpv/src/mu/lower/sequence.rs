//! Pseudo-random numbers that are the same in every run.

/// State of the generator: G. Marsaglia, "Xorshift RNGs", J. Statistical Software 8(14), 2003.
pub(in crate::mu) struct Sequence(pub(in crate::mu) u64);

impl Sequence {
    fn bits(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    /// Returns a number in [-1, 1].
    pub(super) fn next(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    /// Returns 1 or -1.
    pub(in crate::mu) fn sign(&mut self) -> f64 {
        if self.bits() & (1 << 30) == 0 { 1.0 } else { -1.0 }
    }
}
