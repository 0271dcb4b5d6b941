//! Reasons to refuse a call, each with a message of one sentence.

use crate::{ResourceError, StateError, UriError};

/// A number displayed with an exponent if it would need more than fifteen zeros.
struct Number(f64);

impl std::fmt::Display for Number {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self(value) = *self;
        let is_plain = value == 0.0 || !value.is_finite() || (1e-15..1e15).contains(&value.abs());
        if is_plain { write!(f, "{value}") } else { write!(f, "{value:e}") }
    }
}

/// Error of loading a model.
#[derive(Debug, thiserror::Error)]
#[error("the model cannot be loaded from its resources: {0}")]
pub struct LoadError(#[source] pub(crate) Box<dyn std::error::Error + Send + Sync>);

/// Reason for a refused call; the instance is unchanged.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)]
pub enum Refusal {
    #[error("may not be called in state '{phase}'")]
    IllegalCall { phase: &'static str },
    #[error("may not be called: it belongs to {needed}, but the instance was created for {interface}")]
    OtherInterface { needed: &'static str, interface: &'static str },
    #[error("the pointer '{argument}' is NULL")]
    NullPointer { argument: &'static str },
    #[error("the pointer '{argument}' cannot point to {count} elements")]
    BadArray { argument: &'static str, count: usize },
    #[error("the string '{argument}' is not UTF-8")]
    NotUnicode { argument: &'static str },
    #[error(
        "there is no variable with value reference {reference}; value references are 0 to {}",
        count.saturating_sub(1)
    )]
    UnknownReference { reference: u32, count: usize },
    #[error("variable '{name}' is not of type {expected}")]
    WrongType { name: String, expected: &'static str },
    #[error("variable '{name}' may not be set in state '{phase}'")]
    NotSettable { name: String, phase: &'static str },
    #[error("variable '{name}' cannot be set to {}; only finite numbers are allowed", Number(*value))]
    NotFinite { name: String, value: f64 },
    #[error("variable '{name}' cannot be set to {value}; only 1 to {last} are allowed")]
    NoSuchItem { name: String, value: i32, last: i32 },
    #[error("the tunable parameters are unchanged: {reason}")]
    NotTuned { reason: String },
    #[error(
        "start time {} s, stop time {} s and tolerance {} do not define an experiment",
        Number(*start), Number(*stop), Number(*tolerance)
    )]
    BadExperiment { start: f64, stop: f64, tolerance: f64 },
    #[error("the step size is {} s; it must be above 0 and at most {}", Number(*size), Number(*longest))]
    BadStepSize { size: f64, longest: f64 },
    #[error("a step of {} s is too small to change the time {} s", Number(*size), Number(*time))]
    StepTooShort { size: f64, time: f64 },
    #[error(
        "the step starts at {} s, but the previous one ended at {} s",
        Number(*given), Number(*expected)
    )]
    WrongCommunicationPoint { given: f64, expected: f64 },
    #[error("the step ends at {} s, after the stop time {} s", Number(*end), Number(*stop))]
    BeyondStopTime { end: f64, stop: f64 },
    #[error("the time is {} s; it must be finite", Number(*time))]
    BadTime { time: f64 },
    #[error("the number of values is {found}; the number of {what} is {expected}")]
    WrongCount { what: &'static str, found: usize, expected: usize },
    #[error("{what} '{name}' is {}", Number(*value))]
    Undefined { what: &'static str, name: String, value: f64 },
    #[error(
        "derivatives with respect to variable '{name}' are not available in state '{phase}', only those with respect \
            to {}",
        if *initial { "inputs, because states follow from them" } else { "inputs and states" }
    )]
    NotKnown { name: String, phase: &'static str, initial: bool },
    #[error(
        "derivatives with respect to parameters, such as '{name}', are not available; initialize with another value \
         and take the difference"
    )]
    ByParameter { name: String },
    #[error(
        "derivatives of variable '{name}' are not available, only those of outputs, states and their derivatives"
    )]
    NotUnknown { name: String },
    #[error("variable '{name}' is not an output")]
    NotOutput { name: String },
    #[error("variable '{name}' cannot be interpolated: it is not a continuous input")]
    NotInterpolated { name: String },
    #[error("the derivative of order {order} of variable '{name}' is not available, only that of order 1")]
    BadOrder { name: String, order: i32 },
    #[error(transparent)]
    BadState(#[from] StateError),
    #[error("the state belongs to an FMU with another GUID")]
    ForeignState,
    #[error("the state is that of an instance created for {found}; this one was created for {interface}")]
    OtherInterfaceState { found: &'static str, interface: &'static str },
    #[error("the buffer has {found} bytes; the state requires {expected}")]
    BufferTooSmall { found: usize, expected: usize },
    #[error("log category '{category}' is unknown")]
    UnknownCategory { category: String },
    #[error("is not supported: the model description has {flag}")]
    Unsupported { flag: &'static str },
    #[error("the instance name must not be empty")]
    EmptyName,
    #[error("the FMU type {given} is not supported, only {supported}")]
    WrongFmuType { given: i32, supported: &'static str },
    #[error(
        "the FMU was packed without {interface}; `squid package --kind both` packs it with all interfaces"
    )]
    InterfaceNotPacked { interface: &'static str },
    #[error("the resource location is NULL, but the model reads its design from the resources")]
    NoResourceLocation,
    #[error(transparent)]
    BadResourceLocation(#[from] UriError),
    #[error(transparent)]
    BadResources(#[from] ResourceError),
    #[error(transparent)]
    BadDescription(#[from] LoadError),
    #[error(
        "the GUID is '{given}', but binary and resources belong to '{expected}': they come from another FMU, or a \
            file in resources was changed or added"
    )]
    WrongGuid { given: String, expected: String },
}

/// A refused call, or a failure of the model.
#[derive(Debug, thiserror::Error)]
pub enum Failure<E> {
    /// A refused call.
    #[error(transparent)]
    Refused(#[from] Refusal),
    /// A failure of the model.
    #[error("{0}")]
    Model(E),
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn displays_large_and_small_numbers_with_an_exponent() {
        let shown = [0.0, -0.25, 1e14, 1e308, -5e-324, f64::NAN].map(|one| Number(one).to_string());
        assert_eq!(shown, ["0", "-0.25", "100000000000000", "1e308", "-5e-324", "NaN"]);
    }
}
