//! Design of a proved controller from a vehicle and the requirements on its autopilot, stage by stage.
//!
//! ```text
//! inputs -> linearise -> fit -> augment -> synthesise -> check -> certify -> freeze -> verdict -> store
//! ```
//!
//! [`run::run`] runs all of them; each stage is a module of that name. The crate does not print, plot or pack: progress
//! is reported by callbacks ([`squid_base::progress::Progress`]), and the result is a value ([`run::Finished`]).

pub mod augment;
pub mod axis;
pub mod certify;
pub mod check;
pub mod error;
mod findings;
pub mod fit;
pub mod inputs;
pub mod linearise;
#[cfg(test)]
#[path = "../../base/tests/masked/mod.rs"]
mod masked;
pub mod run;
pub mod store;
pub mod synthesise;
pub mod uncertain;
pub mod verdict;

/// Example in the guide, compiled by the documentation tests.
#[cfg(doctest)]
#[doc = include_str!("../../../docs/guide.md")]
struct Guide;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
