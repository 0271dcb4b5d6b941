//! Errors of the uncertain model and of the robust controller.

use strum::IntoStaticStr;
use thiserror::Error;

/// Error of the uncertain model.
#[derive(Debug, Clone, PartialEq, Error, IntoStaticStr)]
#[strum(serialize_all = "snake_case")]
#[allow(missing_docs, reason = "the message says what each field is")]
pub enum UncertainError {
    /// The design has no section `[uncertainty]`, or an empty one.
    #[error(
        "the design {design} declares no uncertainty; add a table [uncertainty], as in vehicles/squid/design.toml"
    )]
    NothingUncertain { design: String },
    /// The model reduction removes all declared uncertainty.
    #[error(
        "{design}: [uncertainty]: the declared uncertainty has no effect: at {:.0} % of their ranges, none of {} \
            changes the linear model, or the gain of an actuator its input, by more than {:.1} %; declare larger \
            ranges, or other coefficients",
        100.0 * size,
        names.join(", "),
        100.0 * tolerance
    )]
    NothingLeft {
        design: String,
        names: Vec<String>,
        /// Fraction of the ranges.
        size: f64,
        /// Allowed relative change of the model.
        tolerance: f64,
    },
    /// A coefficient does not enter the equations of motion affinely.
    #[error(
        "[uncertainty]: '{name}' enters the equations of motion nonlinearly (relative error {error:.1e} over its \
            range) and cannot be uncertain; declare the coefficient through which it acts, for instance \
            'form_factor' or 'drag_area' for friction"
    )]
    NotAffine {
        name: String,
        /// Relative difference.
        error: f64,
    },
    /// Three of the coefficients are multiplied together.
    #[error(
        "[uncertainty]: the equations of motion contain the product of three of the coefficients (relative error \
            {error:.1e}); declare at most two of them, for instance of density, form_factor and wetted_area"
    )]
    ThreeMultiply {
        /// Relative difference.
        error: f64,
    },
    /// The coefficients at some corner of the ranges are out of range.
    #[error("[uncertainty]: with every coefficient at an end of its range, {reason}")]
    Corner { reason: squid_auv::CoefficientError },
    /// The vehicle has no trim at some corner of the ranges.
    #[error("[uncertainty]: with every coefficient at an end of its range there is no trim: {reason}")]
    NoTrim { reason: squid_auv::TrimError },
}

/// Error of the robust design.
#[derive(Debug, Clone, PartialEq, Error, IntoStaticStr)]
#[strum(serialize_all = "snake_case")]
#[allow(missing_docs, reason = "the message says what each field is")]
pub enum RobustError {
    /// The nominal controller has no bound at any size of the uncertainty.
    #[error("--robust: {0}")]
    NoSize(#[from] squid_lpv::robust::NoSize),
    /// The margin of a bound is too small for a proof.
    #[error("--robust: the margin of the bound of the {which} controller is too small for a proof")]
    NotClear { which: &'static str },
}

/// Error of the proof of a gain for constant coefficients.
#[derive(Debug, Error, IntoStaticStr)]
#[strum(serialize_all = "snake_case")]
#[allow(missing_docs, reason = "the message says what each field is")]
pub enum ConstantError {
    /// The search found no multipliers.
    #[error("no bound found: {0}")]
    NoBound(squid_lpv::error::SynthesisError),
    /// Exact arithmetic does not confirm a bound.
    #[error("a bound was found, but exact arithmetic does not confirm it: {0}")]
    NotProved(squid_certificate::Failure),
    /// Nothing was proved for any fraction of the declared box that was tried.
    #[error(
        "--constant: no gain below 1.25 times the nominal bound was proved for {:.1} % or more of the declared \
            uncertainty; the design itself is unchanged",
        100.0 * least
    )]
    NoShare { least: f64 },
}
