//! Every reason for which a call is refused, as one sentence.

use crate::{DescribeError, ResourceError, UriError};

/// Why a call was refused; nothing in the instance has changed.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)]
pub enum Refusal {
    #[error("may not be called in state '{phase}'")]
    IllegalCall { phase: &'static str },
    #[error("the pointer '{argument}' is NULL")]
    NullPointer { argument: &'static str },
    #[error("the text '{argument}' is not UTF-8")]
    NotUnicode { argument: &'static str },
    #[error("there is no variable with value reference {reference}, only 0 .. {}", count.saturating_sub(1))]
    UnknownReference { reference: u32, count: usize },
    #[error("variable '{name}' is not of type {wanted}")]
    WrongType { name: String, wanted: &'static str },
    #[error("variable '{name}' may not be set in state '{phase}'")]
    NotSettable { name: String, phase: &'static str },
    #[error("variable '{name}' cannot be set to {value}, only to finite numbers")]
    NotFinite { name: String, value: f64 },
    #[error("variable '{name}' cannot be set to {value}, only to 1 .. {last}")]
    NoSuchItem { name: String, value: i32, last: i32 },
    #[error("start time {start} s, stop time {stop} s and tolerance {tolerance} make no experiment")]
    BadExperiment { start: f64, stop: f64, tolerance: f64 },
    #[error("the step size is {size} s, but must be finite and above 0")]
    BadStepSize { size: f64 },
    #[error("the step starts at {given} s, but the last one ended at {expected} s")]
    WrongCommunicationPoint { given: f64, expected: f64 },
    #[error("the step ends at {end} s, after the stop time {stop} s")]
    BeyondStopTime { end: f64, stop: f64 },
    #[error("log category '{category}' is unknown")]
    UnknownCategory { category: String },
    #[error("is not supported: the model description says {flag}")]
    Unsupported { flag: &'static str },
    #[error("the instance name is empty")]
    EmptyName,
    #[error("only co-simulation is supported, the FMU type {given} is not")]
    WrongFmuType { given: i32 },
    #[error("the resource location is NULL, but the model reads its design from there")]
    NoResourceLocation,
    #[error(transparent)]
    BadResourceLocation(#[from] UriError),
    #[error(transparent)]
    BadResources(#[from] ResourceError),
    #[error(transparent)]
    BadDescription(#[from] DescribeError),
    #[error("the GUID is '{given}', but binary and resources belong to '{expected}'")]
    WrongGuid { given: String, expected: String },
}

/// A refused call, or a model that could not compute.
#[derive(Debug, thiserror::Error)]
pub enum Failure<E> {
    /// The call was refused.
    #[error(transparent)]
    Refused(#[from] Refusal),
    /// The model could not compute.
    #[error("{0}")]
    Model(E),
}
