//! Errors of a certificate, in the file or in its proof.

use crate::strict::JsonError;
use std::fmt::{self, Display, Formatter};
use thiserror::Error;

/// First error of a certificate: in its file, or a violated condition of its proof. Rows and columns count from 0.
#[derive(Debug, Error)]
#[allow(missing_docs, reason = "the message says what each field is")]
pub enum Failure {
    /// Invalid JSON, or a value of the wrong type.
    #[error(transparent)]
    Json(#[from] JsonError),
    /// Inconsistent sizes, a number that is not finite, or a claim without another on which it rests.
    #[error("{path}: {reason}")]
    Malformed { path: String, reason: String },
    /// Plant and controller that do not determine u and y.
    #[error(
        "the claim is not proved: the loop is not well posed, because I - Duy D22 is singular (its determinant is \
            exactly 0); use a controller with another Duy"
    )]
    NotWellPosed,
    /// Number that violates a condition; `part` is its name, here and below that of the matrix.
    #[error("{claim} is not proved: {reason}")]
    Condition { claim: ClaimName, part: String, reason: String },
    /// Matrix that is not symmetric or skew, or couples channels of different parameters.
    #[error("{claim} is not proved: {reason}")]
    Structure { claim: ClaimName, part: String, reason: String },
    /// Matrix that is not definite, with the offending pivot of its elimination, or not shown to be definite, without
    /// one.
    #[error("{claim} is not proved: {reason}")]
    NotDefinite { claim: ClaimName, part: String, reason: String, pivot: Option<f64> },
}

impl Failure {
    /// Creates a [`Failure::Malformed`].
    pub(crate) fn malformed(path: impl Into<String>, reason: impl Display) -> Self {
        Self::Malformed { path: path.into(), reason: reason.to_string() }
    }

    /// Creates a [`Failure::Malformed`] for a value that is not allowed.
    pub(crate) fn found(path: impl Into<String>, found: impl Display, allowed: &str) -> Self {
        Self::malformed(path, format_args!("found {found}; it must be {allowed}"))
    }

    /// Creates a [`Failure::Condition`].
    pub(crate) fn condition(claim: ClaimName, part: &str, reason: impl Display) -> Self {
        Self::Condition { claim, part: part.into(), reason: reason.to_string() }
    }
}

/// Name of a claim in messages.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ClaimName {
    /// [`Claim::Gain`](crate::Claim::Gain).
    Gain,
    /// [`Claim::Gain`](crate::Claim::Gain) with a model error.
    RobustGain,
    /// [`Claim::Rate`](crate::Claim::Rate).
    Rate,
    /// [`Claim::Rate`](crate::Claim::Rate) with a model error.
    RobustRate,
    /// [`Claim::Limits`](crate::Claim::Limits).
    Limits,
    /// [`Claim::Constant`](crate::Claim::Constant).
    Constant,
}

impl Display for ClaimName {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Gain => "the claim",
            Self::RobustGain => "the claim with model error",
            Self::Rate => "the claim for a bounded rate",
            Self::RobustRate => "the claim for a bounded rate with model error",
            Self::Limits => "the claim with limits",
            Self::Constant => "the claim for constant parameters",
        })
    }
}
