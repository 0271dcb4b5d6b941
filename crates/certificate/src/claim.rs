//! The claims of a certificate: each has its matrices, the check of their sizes, the proof, and what it states.

pub(crate) mod constant;
pub(crate) mod energy;
mod filtered;
pub(crate) mod gain;
pub(crate) mod limits;
pub(crate) mod rate;
mod saturated;

pub use constant::{Constant, ConstantTheorem, Filter};
pub use energy::{Energy, EnergyBound, EnergyTheorem};
pub use gain::Gain;
pub use limits::{LimitTheorem, Limits};
pub use rate::{Rate, RateTheorem};

use crate::certificate::Certificate;
use crate::error::Failure;
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
    /// The gain with saturated commands, for w of bounded energy.
    Energy(Energy),
    /// The gain for parameters some of which are constant.
    Constant(Constant),
}

/// What the prover asks of a claim.
pub(crate) trait Proved {
    /// The name in messages.
    fn name(&self) -> &'static str;

    /// Checks the sizes of its matrices, and that the claims are there on which it rests; `path` is its own.
    ///
    /// # Errors
    /// [`Failure::Malformed`].
    fn check(&self, path: &str, of: &Certificate) -> Result<(), Failure>;

    /// Proves it for the loop of a checked certificate.
    ///
    /// # Errors
    /// [`Failure`], the first condition that is violated.
    fn prove(&self, of: &Certificate) -> Result<(), Failure>;
}

impl Claim {
    /// The key of the file, and the claim as the prover sees it.
    pub(crate) fn parts(&self) -> (&'static str, &dyn Proved) {
        match self {
            Self::Gain(claim) => ("gain", claim),
            Self::Rate(claim) => ("rate", claim),
            Self::Limits(claim) => ("limits", claim),
            Self::Energy(claim) => ("energy", claim),
            Self::Constant(claim) => ("constant", claim),
        }
    }

    /// Whether it may be made of a loop in discrete time.
    pub(crate) fn holds_in_discrete_time(&self) -> bool {
        matches!(self, Self::Gain(Gain { lambda: None, .. }))
    }
}
