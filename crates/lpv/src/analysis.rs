//! Bounds on the gain of a finished loop.
//!
//! - [`bounded_gain()`]: for every trajectory of the parameters, however fast;
//! - [`rate`]: when the parameter moves at a bounded rate, on a grid;
//! - [`sampled_gain()`]: of a plant without parameters and a controller that is sampled, between the ticks, too;
//! - [`at_ticks`]: the loop in discrete time that has the same bounds, for every sequence of the parameters;
//! - [`ladder`]: what each assumption on the parameter costs, from frozen to arbitrarily fast.

pub mod at_ticks;
pub mod bounded_gain;
pub(crate) mod bounded_real;
pub mod gain_bound;
pub mod ladder;
pub(crate) mod lifted;
pub mod lyapunov_polynomial;
pub mod rate;
pub(crate) mod rate_program;
pub mod sampled_gain;

pub use at_ticks::AtTicks;
pub use bounded_gain::bounded_gain;
pub use gain_bound::GainBound;
pub use lyapunov_polynomial::LyapunovPolynomial;
pub use sampled_gain::{Exogenous, SampledGain, sampled_gain};
