//! Errors of the model of the vehicle and of the generalised plant.

use strum::IntoStaticStr;
use thiserror::Error;

/// Error of the model of the vehicle or of the generalised plant.
#[derive(Debug, Error, IntoStaticStr)]
#[strum(serialize_all = "snake_case")]
#[allow(missing_docs, reason = "the message says what each field is")]
pub enum ModelError {
    /// The vehicle has no trim somewhere in the range.
    #[error(transparent)]
    Trim(#[from] squid_auv::TrimError),
    /// A motion that is not asymptotically stable is not controllable.
    #[error(
        "at {} m/s the {motion} is not stabilisable: it is not stable by itself, and no actuator acts on it; it \
         needs {actuation_hint}",
        squid_auv::rounded(*speed)
    )]
    Uncontrollable { speed: f64, motion: &'static str, actuation_hint: &'static str },
    /// A motion that is not asymptotically stable is not observable.
    #[error(
        "at {} m/s the {motion} is not detectable: it is not stable by itself, and no measurement depends on it; \
         {measurement_hint}",
        squid_auv::rounded(*speed)
    )]
    Unobservable { speed: f64, motion: &'static str, measurement_hint: &'static str },
    /// A coefficient is out of range.
    #[error(transparent)]
    Coefficient(#[from] squid_auv::CoefficientError),
    /// The waves of a design do not fit the hull.
    #[error("[sea]: {0}")]
    Waves(#[from] squid_sea::SeaError),
    /// The model has no polynomial fit or no value at some parameter, or forms no generalised plant.
    #[error(transparent)]
    System(#[from] squid_lpv::error::SystemError),
}
