//! Bounds on the gain of a closed loop.
//!
//! - [`bounded_gain()`]: for every trajectory of the parameters, at any rate;
//! - [`given_loop()`]: the same, without an initial bound;
//! - [`rate`]: for a bounded parameter rate, on a grid;
//! - [`sampled_gain()`]: for a plant without parameters and a sampled controller, including the time between samples;
//! - [`at_ticks`]: the discrete-time loop with the same bounds, for every sequence of the parameters;
//! - [`ladder`]: the cost of each assumption on the parameter, from frozen to arbitrarily fast.

pub mod at_ticks;
pub mod bounded_gain;
pub(crate) mod bounded_real;
pub mod gain_bound;
pub mod given_loop;
pub mod ladder;
pub(crate) mod lifted;
pub mod lyapunov_polynomial;
pub mod rate;
pub(crate) mod rate_program;
pub mod sampled_gain;

pub use at_ticks::AtTicks;
pub use bounded_gain::bounded_gain;
pub use gain_bound::GainBound;
pub use given_loop::given_loop;
pub use lyapunov_polynomial::LyapunovPolynomial;
pub use sampled_gain::{Exogenous, SampledGain, sampled_gain, sampled_gain_near};
