//! Reasons why a certificate does not prove a claim about a loop.

use strum::IntoStaticStr;
use thiserror::Error;

/// Why a certificate does not prove a claim about a loop.
#[derive(Debug, Error, IntoStaticStr)]
#[strum(serialize_all = "snake_case")]
#[allow(missing_docs, reason = "the message says what each field is")]
pub enum ProofError {
    /// A certificate does not prove its claim.
    #[error(transparent)]
    Unproved(#[from] squid_certificate::Failure),
    /// A certificate cannot be read.
    #[error("{file}: {reason}")]
    Certificate { file: String, reason: squid_certificate::Failure },
    /// The certificate belongs to another controller.
    #[error("the certificate does not belong to this controller: {what} differs")]
    Mismatch { what: String },
    /// The certificate belongs to another plant.
    #[error("the certificate does not belong to this plant: {what} differs")]
    WrongPlant { what: String },
    /// The ball of models of a certificate does not contain the true models.
    #[error(
        "the certificate's model error does not cover this vehicle: {}",
        .reach.map_or_else(
            || "E, F and Fu do not form a ball around the fit".to_owned(),
            |r| format!("the true linearisations reach {r:.4} times as far from the fit as the ball does")
        )
    )]
    Ball { reach: Option<f64> },
    /// No bound was found.
    #[error(transparent)]
    Synthesis(#[from] squid_lpv::error::SynthesisError),
    /// The matrices of a certificate do not form a plant, or it has no value at some parameter.
    #[error(transparent)]
    System(#[from] squid_lpv::error::SystemError),
}
