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
        "the design {design} declares no uncertainty; add a section [uncertainty], as in vehicles/squid/design.toml"
    )]
    NothingUncertain { design: String },
    /// The model reduction removes all declared uncertainty.
    #[error(
        "{design}: [uncertainty]: no declared uncertainty is left in the model: at {:.0} % of their ranges, none of {} \
            changes the linear model, or an actuator's gain its own input, by more than {:.1} %; declare larger \
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
        "[uncertainty]: '{name}' does not enter the equations of motion linearly (relative error {error:.1e} \
            over its range), so it cannot be uncertain; declare what it acts through, for instance 'form_factor' \
            or 'drag_area' for friction"
    )]
    NotAffine {
        name: String,
        /// Relative difference.
        error: f64,
    },
    /// Three of the coefficients are multiplied together.
    #[error(
        "[uncertainty]: three of the coefficients are multiplied together (relative error {error:.1e} in the \
            equations of motion); declare two of them at most, for instance not density, form_factor and \
            wetted_area together"
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
    #[error("--robust: the bound of the {which} controller has too small a margin to be proved")]
    NotClear { which: &'static str },
}

/// Error of the proof of a gain for constant coefficients.
#[derive(Debug, Error, IntoStaticStr)]
#[strum(serialize_all = "snake_case")]
#[allow(missing_docs, reason = "the message says what each field is")]
pub enum ConstantError {
    /// The search found no multipliers.
    #[error("no bound: {0}")]
    NoBound(squid_lpv::error::SynthesisError),
    /// Exact arithmetic does not confirm a bound.
    #[error("a bound that exact arithmetic does not confirm: {0}")]
    NotProved(squid_certificate::Failure),
    /// Nothing was proved for any fraction of the declared box that was tried.
    #[error(
        "--constant: no gain within 1.25 times the nominal bound was proved for {:.1} % of the declared uncertainty or \
            more; the design itself is unchanged",
        100.0 * least
    )]
    NoShare { least: f64 },
}
