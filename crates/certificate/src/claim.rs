//! Claims of a certificate, each with its matrices, the check of their sizes, the proof, and its statement.

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

use proved::Provable;
use serde::{Deserialize, Serialize};

/// Claim about the closed loop of a certificate, with the matrices that prove it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Claim {
    /// Gain for parameters that vary arbitrarily fast.
    Gain(Gain),
    /// Gain for a parameter with a bounded rate.
    Rate(Rate),
    /// Step with saturated commands.
    Limits(Limits),
    /// Gain with some parameters constant.
    Constant(Constant),
}

impl Claim {
    /// Returns the key in the file, and the claim as a trait object.
    pub(crate) fn parts(&self) -> (&'static str, &dyn Provable) {
        match self {
            Self::Gain(claim) => ("gain", claim),
            Self::Rate(claim) => ("rate", claim),
            Self::Limits(claim) => ("limits", claim),
            Self::Constant(claim) => ("constant", claim),
        }
    }

    /// Returns `true` if the claim is available in discrete time.
    pub(crate) fn holds_in_discrete_time(&self) -> bool {
        matches!(self, Self::Gain(Gain { lambda: None, .. }))
    }
}
