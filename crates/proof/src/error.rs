//! Reasons why a certificate does not prove a claim about a loop.

use strum::IntoStaticStr;
use thiserror::Error;

/// Error in the proof of a claim about a loop.
#[derive(Debug, Error, IntoStaticStr)]
#[strum(serialize_all = "snake_case")]
#[allow(missing_docs, reason = "the message says what each field is")]
pub enum ProofError {
    /// Certificate that does not prove its claim.
    #[error(transparent)]
    Unproved(#[from] squid_certificate::Failure),
    /// Certificate that cannot be read.
    #[error("{file}: {reason}")]
    Certificate { file: String, reason: squid_certificate::Failure },
    /// Certificate of another controller.
    #[error("the certificate does not belong to this controller: {what} differs")]
    Mismatch { what: String },
    /// Certificate of another plant.
    #[error("the certificate does not belong to this plant: {what} differs")]
    WrongPlant { what: String },
    /// Certificate whose ball of models does not contain the true models.
    #[error(
        "the certificate's model error does not cover this vehicle: {}",
        .reach.map_or_else(
            || "E, F and Fu do not form a ball around the fit".to_owned(),
            |r| format!("the true linearisations reach {r:.4} times the radius of the ball")
        )
    )]
    Ball { reach: Option<f64> },
    /// Failed search for a bound.
    #[error(transparent)]
    Synthesis(#[from] squid_lpv::error::SynthesisError),
    /// Plant without a value at some parameter.
    #[error(transparent)]
    System(#[from] squid_lpv::error::SystemError),
}
