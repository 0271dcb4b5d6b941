//! Why there is no model of the vehicle, or no generalised plant.

use thiserror::Error;

/// Why there is no model of the vehicle, or no generalised plant.
#[derive(Debug, Error)]
pub enum ModelError {
    /// The vehicle does not trim somewhere in the range.
    #[error("{reason}")]
    Trim {
        /// Where.
        speed: f64,
        /// Why.
        reason: auv::TrimError,
    },
    /// A coefficient is not allowed.
    #[error(transparent)]
    Coefficient(#[from] auv::CoefficientError),
    /// The polynomial fit failed.
    #[error(transparent)]
    Fit(#[from] lpv::error::FitError),
    /// An LFT has no value at some parameter.
    #[error(transparent)]
    Lft(#[from] lpv::error::LftError),
    /// The matrices of a problem file do not fit together.
    #[error(transparent)]
    Shape(#[from] lpv::error::ShapeError),
    /// Model and weights make no generalised plant.
    #[error(transparent)]
    Augment(#[from] lpv::error::AugmentError),
}
