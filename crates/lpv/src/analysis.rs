//! Bounds on the gain of a finished loop.
//!
//! - [`bounded_gain()`]: for every course of the parameters, however fast;
//! - [`rate`]: when the parameter moves at a bounded rate, on a grid;
//! - [`ladder`]: what each assumption on the parameter costs, from frozen to arbitrarily fast.

pub mod bounded_gain;
pub(crate) mod bounded_real;
pub mod gain_bound;
pub mod ladder;
pub mod lyapunov_polynomial;
pub mod rate;
pub(crate) mod rate_program;

pub use bounded_gain::bounded_gain;
pub use gain_bound::GainBound;
pub use lyapunov_polynomial::LyapunovPolynomial;
