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
    #[error("may not be called at all: it belongs to {needed}, and the instance was made for {interface}")]
    OtherInterface { needed: &'static str, interface: &'static str },
    #[error("the pointer '{argument}' is NULL")]
    NullPointer { argument: &'static str },
    #[error("the pointer '{argument}' cannot point to {count} elements")]
    BadArray { argument: &'static str, count: usize },
    #[error("the text '{argument}' is not UTF-8")]
    NotUnicode { argument: &'static str },
    #[error("there is no variable with value reference {reference}, only 0 .. {}", count.saturating_sub(1))]
    UnknownReference { reference: u32, count: usize },
    #[error("variable '{name}' is not of type {wanted}")]
    WrongType { name: String, wanted: &'static str },
    #[error("variable '{name}' may not be set in state '{phase}'")]
    NotSettable { name: String, phase: &'static str },
    #[error("variable '{name}' cannot be set to {}, only to finite numbers", Number(*value))]
    NotFinite { name: String, value: f64 },
    #[error("variable '{name}' cannot be set to {value}, only to 1 .. {last}")]
    NoSuchItem { name: String, value: i32, last: i32 },
    #[error("the tunable parameters stay as they were: {reason}")]
    NotTuned { reason: String },
    #[error(
        "start time {} s, stop time {} s and tolerance {} make no experiment",
        Number(*start), Number(*stop), Number(*tolerance)
    )]
    BadExperiment { start: f64, stop: f64, tolerance: f64 },
    #[error("the step size is {} s, but must be above 0 and at most {}", Number(*size), Number(*longest))]
    BadStepSize { size: f64, longest: f64 },
    #[error("a step of {} s does not move the time {} s", Number(*size), Number(*time))]
    StepTooShort { size: f64, time: f64 },
    #[error(
        "the step starts at {} s, but the last one ended at {} s",
        Number(*given), Number(*expected)
    )]
    WrongCommunicationPoint { given: f64, expected: f64 },
    #[error("the step ends at {} s, after the stop time {} s", Number(*end), Number(*stop))]
    BeyondStopTime { end: f64, stop: f64 },
    #[error("the time is {} s, but must be finite", Number(*time))]
    BadTime { time: f64 },
    #[error("{found} numbers are given, but there are {expected} {what}")]
    WrongCount { what: &'static str, found: usize, expected: usize },
    #[error("{what} '{name}' is {} here", Number(*value))]
    Undefined { what: &'static str, name: String, value: f64 },
    #[error(
        "no derivative by variable '{name}' can be asked for in state '{phase}', only by {}",
        if *initial { "inputs, for states follow from them" } else { "inputs and states" }
    )]
    NotKnown { name: String, phase: &'static str, initial: bool },
    #[error(
        "derivatives by parameters, such as '{name}', are not computed; set another value before the initialization, \
         and take the difference"
    )]
    ByParameter { name: String },
    #[error(
        "no derivative of variable '{name}' can be asked for, only of outputs, states and their derivatives"
    )]
    NotUnknown { name: String },
    #[error("variable '{name}' is no output")]
    NotOutput { name: String },
    #[error("variable '{name}' cannot be interpolated: it is no continuous input")]
    NotInterpolated { name: String },
    #[error("the derivative of order {order} of variable '{name}' is not known, only that of order 1")]
    BadOrder { name: String, order: i32 },
    #[error(transparent)]
    BadState(#[from] StateError),
    #[error("the state belongs to an FMU with another GUID")]
    ForeignState,
    #[error("the state is that of an instance made for {found}, and this one was made for {interface}")]
    OtherInterfaceState { found: &'static str, interface: &'static str },
    #[error("the buffer has {found} bytes, but the state needs {expected}")]
    BufferTooSmall { found: usize, expected: usize },
    #[error("log category '{category}' is unknown")]
    UnknownCategory { category: String },
    #[error("is not supported: the model description says {flag}")]
    Unsupported { flag: &'static str },
    #[error("the instance name is empty")]
    EmptyName,
    #[error("the FMU type {given} is not supported, only {supported}")]
    WrongFmuType { given: i32, supported: &'static str },
    #[error(
        "the FMU was packed without {interface}; `squid package --kind both` packs it with all interfaces"
    )]
    InterfaceNotPacked { interface: &'static str },
    #[error("the resource location is NULL, but the model reads its design from there")]
    NoResourceLocation,
    #[error(transparent)]
    BadResourceLocation(#[from] UriError),
    #[error(transparent)]
    BadResources(#[from] ResourceError),
    #[error(transparent)]
    BadDescription(#[from] LoadError),
    #[error(
        "the GUID is '{given}', but binary and resources belong to '{expected}': they are of another FMU, or a \
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
