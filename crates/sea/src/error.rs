//! Errors in the parameters of a sea.

use thiserror::Error;

/// Invalid parameter of a sea, with its name.
#[derive(Clone, Debug, Error, PartialEq)]
#[allow(missing_docs, reason = "the message says what each field is")]
pub enum SeaError {
    /// A number outside its range.
    #[error("{key} is {found}; it must be {allowed}")]
    NotAllowed { key: &'static str, found: f64, allowed: &'static str },
    /// Waves that would break.
    #[error(
        "height {height} m with period {period} s gives a mean steepness of {steepness:.3}, but waves break beyond \
         {limit:.3}; for this height the period must be at least {least_period:.2} s"
    )]
    TooSteep { height: f64, period: f64, steepness: f64, limit: f64, least_period: f64 },
}

/// Refuses a number that is not finite or not allowed.
pub(crate) fn check(
    key: &'static str,
    found: f64,
    is_allowed: bool,
    allowed: &'static str,
) -> Result<(), SeaError> {
    if found.is_finite() && is_allowed { Ok(()) } else { Err(SeaError::NotAllowed { key, found, allowed }) }
}
