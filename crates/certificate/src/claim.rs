//! The claims of a certificate: each has its matrices, the check of their sizes, the proof, and what it states.

pub(crate) mod constant;
mod filtered;
pub(crate) mod gain;
pub(crate) mod limits;
pub(crate) mod proved;
pub(crate) mod rate;
mod saturated;

pub use constant::{Constant, ConstantTheorem};
pub use filtered::Filter;
pub use gain::Gain;
pub use limits::{LimitTheorem, Limits};
pub use rate::{Rate, RateTheorem};

use proved::Proved;
use serde::{Deserialize, Serialize};

/// A claim about the closed loop of a certificate, with the matrices that prove it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Claim {
    /// The gain for parameters that vary arbitrarily fast.
    Gain(Gain),
    /// The gain for a parameter with a bounded rate.
    Rate(Rate),
    /// A step with saturated commands.
    Limits(Limits),
    /// The gain for parameters some of which are constant.
    Constant(Constant),
}

impl Claim {
    /// The key of the file, and the claim as the prover sees it.
    pub(crate) fn parts(&self) -> (&'static str, &dyn Proved) {
        match self {
            Self::Gain(claim) => ("gain", claim),
            Self::Rate(claim) => ("rate", claim),
            Self::Limits(claim) => ("limits", claim),
            Self::Constant(claim) => ("constant", claim),
        }
    }

    /// Whether it may be made of a loop in discrete time.
    pub(crate) fn holds_in_discrete_time(&self) -> bool {
        matches!(self, Self::Gain(Gain { lambda: None, .. }))
    }
}
