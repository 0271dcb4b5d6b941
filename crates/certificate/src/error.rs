//! Errors of a certificate: in the file, or in its proof.

use crate::strict::JsonError;
use std::fmt::Display;
use thiserror::Error;

/// Why a certificate cannot be read, or the first thing that failed in its proof. Rows and columns count from 0.
#[derive(Debug, Error)]
#[allow(missing_docs, reason = "the message says what each field is")]
pub enum Failure {
    /// The text is not JSON, or a value is of the wrong kind.
    #[error(transparent)]
    Json(#[from] JsonError),
    /// Sizes do not agree, a number is not finite, or a claim lacks another that it extends.
    #[error("{path}: {reason}")]
    Malformed { path: String, reason: String },
    /// Plant and controller do not determine u and y.
    #[error(
        "the claim is not proved: the loop is not well posed, for I - Duy D22 is singular (its determinant is \
            exactly 0); another controller is needed, one with another Duy"
    )]
    NotWellPosed,
    /// A number violates a condition.
    #[error("{claim} is not proved: {reason}")]
    Condition { claim: String, reason: String },
    /// A matrix is not symmetric or skew, or couples channels of different parameters.
    #[error("{claim} is not proved: {reason}")]
    Structure { claim: String, reason: String },
    /// A matrix is not definite, or not shown to be; with a pivot of its elimination that shows so.
    #[error("{claim} is not proved: {reason}")]
    NotDefinite { claim: String, reason: String, pivot: Option<f64> },
}

impl Failure {
    /// [`Failure::Malformed`].
    pub(crate) fn malformed(path: impl Into<String>, reason: impl Display) -> Self {
        Self::Malformed { path: path.into(), reason: reason.to_string() }
    }

    /// [`Failure::Malformed`] of a value that is not allowed.
    pub(crate) fn found(path: impl Into<String>, found: impl Display, allowed: &str) -> Self {
        Self::malformed(path, format_args!("found {found}, allowed is {allowed}"))
    }

    /// [`Failure::Condition`].
    pub(crate) fn condition(claim: &str, reason: impl Display) -> Self {
        Self::Condition { claim: claim.into(), reason: reason.to_string() }
    }
}
