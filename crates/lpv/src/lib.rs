//! Linear parameter-varying (LPV) control by linear matrix inequalities.
//!
//! ```text
//! samples of [A B] -> MatrixPolynomial -> Lft -> TrackingProblem -> GeneralisedPlant
//!                                                                        |
//!        Controller, GainBound <- bounded_gain <- reconstruct <- least_gamma, back-off
//! ```
//!
//! A plant that depends on parameters in `[-1, 1]`, measured in operation, is written as a linear fractional
//! transformation (LFT): a constant system closed by `Theta = blkdiag(theta_i I)`. The controller is an LFT in the same
//! parameters, and the gain of the closed loop is bounded for every trajectory of the parameters, at any rate.
//!
//! Modules:
//!
//! - [`system`]: LFTs, state space, the partition of plant, controller and loop, the tracking problem;
//! - [`lmi`]: linear matrix inequalities as expressions, and the solvers behind them;
//! - [`synthesis`]: controller synthesis for a generalised plant, with a bound on the gain;
//! - [`mixed_sensitivity`], [`h2`]: the plant of a mixed-sensitivity design; H2-optimal controllers;
//! - [`structured`]: controllers of fixed structure, whose gains are tuned;
//! - [`analysis`]: bounds on the gain of a closed loop;
//! - [`bounded_rate`]: designs for a parameter whose rate is bounded;
//! - [`robust`]: parameters that the controller does not measure;
//! - [`mu`]: structured singular values;
//! - [`matrix`], [`error`], [`stop`]: dense matrices, errors and cancellation, used by all others.
//!
//! Time is in seconds and frequencies in rad/s if the plant's are; the crate knows nothing of the plant's physics.
//!
//! # Example
//!
//! Example: the tutorial plant of LPVTools (LFT tutorial, numbers from its documentation), `x' = -rho x + rho u` with
//! rho in [1, 10], a weight on the tracking error and one on the control. Its least gamma is 1.788.
//!
//! ```
//! use squid_lpv::partition::Group::{T, U, W, X, Y, Z};
//! use squid_lpv::plant::GeneralisedPlant;
//! use squid_lpv::synthesis::{Options, synthesise};
//! use nalgebra::dmatrix;
//!
//! let blocks = [
//!     (X, X, dmatrix![-5.5, -5445.0, 0.0; 0.0, -100.0, 0.0; -1.0, 0.0, -1.0]),
//!     (X, T, dmatrix![4.5; 0.0; 0.0]),
//!     (X, W, dmatrix![0.0, 5.5; 0.0, 0.1; 1.0, 0.0]),
//!     (X, U, dmatrix![60.5; 1.0; 0.0]),
//!     (T, X, dmatrix![-1.0, -990.0, 0.0]),
//!     (T, W, dmatrix![0.0, 1.0]),
//!     (T, U, dmatrix![11.0]),
//!     (Z, X, dmatrix![-0.2, 0.0, 4.8; 0.0, -990.0, 0.0]),
//!     (Z, W, dmatrix![0.2, 0.0; 0.0, 1.0]),
//!     (Z, U, dmatrix![0.0; 10.0]),
//!     (Y, X, dmatrix![-1.0, 0.0, 0.0]),
//!     (Y, W, dmatrix![1.0, 0.0]),
//! ];
//! let plant = GeneralisedPlant::new(vec![1], &blocks)?;
//! let design = synthesise(&plant, Options::default())?;
//! assert!((design.gamma_optimum - 1.7877).abs() < 1e-3);
//!
//! // The bound of the closed loop, for every trajectory of the parameter, with the matrices that prove it.
//! let bound = &design.certified;
//! assert!(bound.largest_eigenvalue < 0.0);
//! let closed = plant.close(&design.controller);
//! for theta in [-1.0, 0.0, 1.0] {
//!     assert!(closed.frozen(&[theta])?.hinf_norm().value < bound.gamma);
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! The crate `certificate` proves such a bound in exact arithmetic.

pub mod analysis;
pub mod anti_windup;
pub mod bounded_rate;
pub mod error;
pub mod lmi;
pub mod matrix;
pub mod mixed_sensitivity;
pub mod mu;
pub(crate) mod riccati;
pub mod robust;
pub mod stop;
pub mod structured;
pub mod synthesis;
pub mod system;

pub use analysis::{ladder, rate};
pub use riccati::h2;
pub use robust::bound as robust_bound;
pub use synthesis::{direct_path, reduce, regularise, regularity};
pub use system::{
    bilinear, controller, lft, model_error, parameter_grid, partition, plant, polynomial, rational,
    state_space, tracking, weights,
};

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
