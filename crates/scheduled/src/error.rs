//! Errors of a design and of a tick.

use crate::design::CONTROLLER_FORMAT;

/// Error of a design; `key` is the path in the JSON file.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)]
pub enum DesignError {
    /// Invalid JSON, or a key that is missing, unknown or of another type.
    #[error("the controller design cannot be read: {0}")]
    Json(#[from] serde_json::Error),
    /// Unsupported format or version.
    #[error("format is '{found}'; it must be '{CONTROLLER_FORMAT}'")]
    WrongFormat { found: String },
    /// Number out of its allowed range.
    #[error("{key} is {value:?}; it must be {allowed}")]
    BadNumber { key: String, value: f64, allowed: &'static str },
    /// Text that is not allowed.
    #[error("{key} is '{found}'; it must be {allowed}")]
    BadText { key: String, found: String, allowed: String },
    /// Duplicate name.
    #[error("{key} is '{name}', which is used twice")]
    NameTaken { key: String, name: String },
    /// Empty list that must not be empty.
    #[error("{key} is empty")]
    Empty { key: &'static str },
    /// List of the wrong length.
    #[error("{key} has {found} entries; it must have {expected}")]
    WrongLength { key: String, found: usize, expected: usize },
    /// More than one scheduling parameter; only the speed is measured.
    #[error("lft.blocks has {found} parameters; the only scheduling parameter is the speed")]
    SeveralParameters { found: usize },
    /// Range with its ends swapped or equal.
    #[error("{key} is the empty range {minimum:?} to {maximum:?}")]
    EmptyRange { key: String, minimum: f64, maximum: f64 },
    /// Centre and half range that disagree with minimum and maximum.
    #[error("scheduling: rho is {rho:?} at {end:?} m/s; it must be {expected:?}")]
    SchedulingMismatch { end: f64, rho: f64, expected: f64 },
    /// Column that does not increase.
    #[error("{key} must increase; {next:?} follows {previous:?}")]
    NotIncreasing { key: &'static str, previous: f64, next: f64 },
    /// Trim table that does not cover the scheduled speeds.
    #[error(
        "trim.speed covers {first:?} to {last:?} m/s; scheduling requires {minimum:?} to {maximum:?} m/s"
    )]
    TrimTooShort { first: f64, last: f64, minimum: f64, maximum: f64 },
    /// Trim command outside the limits of its actuator.
    #[error("{key} is {value:?}, outside the limits {minimum:?} to {maximum:?} of the actuator")]
    TrimBeyondLimits { key: String, value: f64, minimum: f64, maximum: f64 },
    /// Pole at 2/T, where the trapezoidal rule is singular.
    #[error("I - A T/2 is singular at T = {sample_time:?} s: the controller is too fast for its sample time")]
    TooFast { sample_time: f64 },
}

/// Error of a tick.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[allow(missing_docs)]
pub enum TickError {
    /// Input that is infinite or not a number.
    #[error("the input {name} is {value:?}; it must be finite")]
    InputNotFinite { name: String, value: f64 },
    /// Input at the first tick outside its plausible range, such as one in another unit or with another sign.
    #[error("{name} is {found} at the first tick; it must be {allowed}")]
    OtherUnit { name: String, found: String, allowed: String },
    /// Applied command far beyond the limits of its actuator.
    #[error(
        "the applied command of {name} is {value:?} {unit}; it must be finite and of a magnitude of at most {most:?} \
         {unit}, ten times its limits"
    )]
    AppliedTooLarge { name: String, value: f64, unit: String, most: f64 },
    /// `I - Dtt Theta` has no inverse.
    #[error(
        "the algebraic loop of the controller is singular (pivot {pivot:e}) at scheduling parameter {parameter}"
    )]
    SingularLoop { parameter: f64, pivot: f64 },
    /// Command that is infinite or not a number.
    #[error(
        "command {index} of the controller is {value:?}: an input is far too large, or the loop has diverged"
    )]
    Diverged { index: usize, value: f64 },
}
