//! From a vehicle and what is asked of its autopilot to a proved controller, stage by stage.
//!
//! ```text
//! inputs -> linearise -> fit -> augment -> synthesise -> check -> certify -> freeze -> verdict -> store
//! ```
//!
//! [`run::run`] is the whole path; each stage is a file of that name. Nothing here prints, plots or packs: progress is
//! called back ([`base::progress::Progress`]), and what was designed is a value ([`run::Finished`]).

pub mod augment;
pub mod certify;
pub mod check;
pub mod error;
pub mod fit;
pub mod inputs;
pub mod linearise;
pub mod numbers;
pub mod run;
pub mod store;
pub mod synthesise;
pub mod uncertain;
pub mod verdict;

/// The example of the guide, compiled by the documentation tests.
#[cfg(doctest)]
#[doc = include_str!("../../../docs/guide.md")]
struct Guide;
