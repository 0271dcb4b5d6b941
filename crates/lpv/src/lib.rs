//! Linear parameter-varying (LPV) control by linear matrix inequalities.
//!
//! ```text
//! samples of [A B] -> MatrixPolynomial -> Lft -> TrackingProblem -> GeneralisedPlant
//!                                                                        |
//!        Controller, GainBound <- bounded_gain <- reconstruct <- least_gamma, back-off
//! ```
//!
//! A plant that depends on parameters in `[-1, 1]`, measured while it runs, is written as a linear fractional transformation
//! (LFT): a constant system closed by `Theta = blkdiag(theta_i I)`. The controller that comes out is an LFT in the same
//! parameters, and the gain of the closed loop is bounded for every course of the parameters, however fast.
//!
//! - [`polynomial`]: matrices that are polynomials in a parameter, fitted to samples;
//! - [`lft`]: LFTs, their algebra, the smallest one of a polynomial;
//! - [`tracking`]: the augmented plant of a tracking problem, from model and weights;
//! - [`partition`]: a matrix with named rows and columns, of which [`plant`], [`controller`] and closed loop are made;
//! - [`synthesis`]: from a generalised plant to a controller and a bound; [`reconstruct`] is its last step;
//! - [`direct_path`]: the same for a plant with a direct path from u to y;
//! - [`analysis`]: a bound on the gain of a finished loop;
//! - [`rate`]: its gain when the parameter moves at a bounded rate, on a grid;
//! - [`ladder`]: what each assumption on the parameter costs, from frozen to arbitrarily fast;
//! - [`model_error`]: a norm-bounded difference between the plant and what it stands for;
//! - [`balance`]: coordinates in which the inequalities are well conditioned;
//! - [`parameter_grid`]: points of the parameter box, for what is checked and not proved;
//! - [`reduce`]: removing controller states that hardly matter;
//! - [`robust`], [`robust_bound`]: parameters that no controller sees: a bound for them, and a controller that bears more;
//! - [`regularity`]: controls without a weight, measurements without noise; [`regularise`]: controllers for such problems;
//! - [`lmi`], [`solver`]: linear matrix inequalities as expressions, and the solver behind them;
//! - [`modes`], [`state_space`], [`matrix`]: reachability of modes, H-infinity norm, dense matrices.
//!
//! Time is in seconds and frequencies in rad/s wherever the plant's are; nothing here knows what a plant stands for.
//!
//! # Example
//!
//! The tutorial plant of LPVTools (LFT tutorial; rebuilt from the numbers in its documentation): `x' = -rho x + rho u` with
//! rho anywhere in [1, 10], a weight on the tracking error and one on the control. Its least gamma is 1.788.
//!
//! ```
//! use lpv::partition::Signal::{T, U, W, X, Y, Z};
//! use lpv::plant::GeneralisedPlant;
//! use lpv::synthesis::{Options, synthesise};
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
//! // The bound of the finished loop, for every course of the parameter, with the matrices that show it.
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

mod affine;
pub mod analysis;
mod back_off;
pub mod balance;
mod bounded_real;
mod conic;
pub mod controller;
pub mod direct_path;
mod dual;
pub mod error;
mod fast_modes;
mod inequalities;
mod interior_point;
pub mod ladder;
mod least_gamma;
pub mod lft;
pub mod lmi;
mod low_rank;
mod lyapunov;
pub mod matrix;
pub mod model_error;
pub mod modes;
pub mod mu;
pub mod parameter_grid;
pub mod partition;
pub mod plant;
pub mod polynomial;
mod quadratic;
pub mod rate;
mod rate_program;
pub mod reconstruct;
pub mod reduce;
pub mod regularise;
pub mod regularity;
mod riccati;
pub mod robust;
pub mod robust_bound;
pub mod solver;
pub mod state_space;
pub mod synthesis;
pub mod tracking;
