//! Errors of a certificate: in the file, or in its proof.

use std::fmt;
use thiserror::Error;

/// Why a text is not a certificate.
#[derive(Debug, Error)]
#[allow(missing_docs, reason = "the message says what each field is")]
pub enum ReadError {
    /// The text is not JSON, a key occurs twice, or a number is not a finite f64.
    #[error("the certificate is not JSON with finite numbers: {0}")]
    Json(#[from] serde_json::Error),
    /// Another format, or another version of it.
    #[error("format: found {found}, allowed is {allowed}")]
    Format { found: String, allowed: String },
    /// A key is missing.
    #[error("{field}: missing; {object} must have the keys {keys}")]
    Missing { field: String, object: String, keys: String },
    /// A key that the format does not know.
    #[error("{field}: unknown key; {object} may have the keys {keys}")]
    Unknown { field: String, object: String, keys: String },
    /// A value of the wrong kind.
    #[error("{field}: found {found}, allowed is {allowed}")]
    Kind { field: String, found: String, allowed: &'static str },
    /// A matrix whose number of rows is wrong.
    #[error("{field}: found {found} rows, must have {expected} ({meaning})")]
    Rows { field: String, found: usize, expected: usize, meaning: &'static str },
    /// A row whose length is wrong.
    #[error("{field}: row {row} has {found} numbers, must have {expected} ({meaning})")]
    Columns {
        field: String,
        /// The first row that does not fit, from 0.
        row: usize,
        found: usize,
        expected: usize,
        meaning: &'static str,
    },
    /// A signal without components, for which the claim is empty.
    #[error("{field}: has no {part}, must have at least one ({meaning})")]
    Empty { field: &'static str, part: &'static str, meaning: &'static str },
    /// The repetitions do not add up to the channels of the matrices.
    #[error("{field}: adds up to {found}, but {matrix} has {expected} rows: one for each channel")]
    Blocks { field: &'static str, found: usize, matrix: &'static str, expected: usize },
    /// A loop that is larger than can be proved in reasonable time and memory.
    #[error("the inequality has {rows} rows, at most {most} are proved")]
    Large { rows: usize, most: usize },
    /// A bounded rate of other than one parameter.
    #[error("bounded_rate: is of 1 parameter, but blocks and controller_blocks have {found}")]
    NotOneParameter { found: usize },
    /// A section about parameters that move however fast, without that claim.
    #[error("{field}: needs the claim for parameters that move however fast: gamma, X, S and T")]
    NoAnyRate { field: &'static str },
    /// No claim at all.
    #[error("the certificate claims nothing: it must have gamma, X, S and T, or the section bounded_rate")]
    NoClaim,
    /// A section about the model error, without the model error.
    #[error("{field}: needs the section residual, which has E, F and Fu")]
    NoModelError { field: &'static str },
    /// A section that is of continuous time alone.
    #[error("{field}: is of a loop in continuous time, but `discrete` is true")]
    Discrete { field: &'static str },
    /// Limits in a loop whose commands go straight to what is measured.
    #[error("{field}: is of plants without a direct path from u to y, but plant.D22 is not 0")]
    DirectPath { field: &'static str },
    /// Steps of an input that there is not.
    #[error("limits.input: found {found}, must be below {inputs}, the number of inputs w")]
    NoInput { found: usize, inputs: usize },
    /// A list whose length is wrong.
    #[error("{field}: has {found} entries, must have {expected}")]
    Length { field: String, found: usize, expected: String },
    /// Breakpoints that do not ascend from -1 to 1.
    #[error("{field}: must ascend from -1 to 1")]
    Breakpoints { field: String },
    /// A parameter on which neither plant nor controller depends.
    #[error(
        "{field}[{index}]: is 0 or missing in blocks and controller_blocks alike, must be above 0 in one of \
            them: no channel has parameter {index}"
    )]
    NoChannel {
        field: &'static str,
        /// The parameter, from 0.
        index: usize,
    },
}

impl ReadError {
    /// [`ReadError::Kind`].
    pub(crate) fn kind(field: &str, found: String, allowed: &'static str) -> Self {
        Self::Kind { field: field.into(), found, allowed }
    }
}

/// A matrix of the proof.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Proved {
    /// The Lyapunov matrix X.
    X,
    /// The symmetric scaling S.
    S,
    /// The skew scaling T.
    T,
    /// The matrix of the linear matrix inequality.
    Inequality,
    /// The matrix `X[k]` of a polynomial X(theta).
    Coefficient(usize),
    /// A Bernstein coefficient of the inequality on the interval after this breakpoint, from 0.
    OnInterval(usize),
    /// The Lyapunov matrix L of the loop without its parameters.
    Lyapunov,
    /// `A'L + LA`.
    Decay,
    /// The multiplier of a parameter, from 0.
    Multiplier(usize),
    /// The multiplier of the rate of a parameter, from 0.
    RateMultiplier(usize),
    /// `[X h'; h limit^2/(4 beta)]` of a command, from 0.
    Limit(usize),
    /// `[X h'; h limit^2/(gamma beta)]` of a command, from 0.
    LimitOfEnergy(usize),
}

impl fmt::Display for Proved {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::X => f.write_str("X"),
            Self::S => f.write_str("S"),
            Self::T => f.write_str("T"),
            Self::Inequality => f.write_str("the matrix of the inequality"),
            Self::Coefficient(k) => write!(f, "X[{k}]"),
            Self::OnInterval(i) => {
                write!(f, "a Bernstein coefficient of the inequality between breakpoints {i} and {}", i + 1)
            }
            Self::Lyapunov => f.write_str("L"),
            Self::Decay => f.write_str("A'L + LA"),
            Self::Limit(place) => write!(f, "[X h'; h limit^2/(4 beta)] of limit {place}"),
            Self::LimitOfEnergy(command) => write!(f, "[X h'; h limit^2/(gamma beta)] of command {command}"),
            Self::Multiplier(parameter) => write!(f, "the multiplier of parameter {parameter}"),
            Self::RateMultiplier(parameter) => {
                write!(f, "the multiplier of the rate of parameter {parameter}")
            }
        }
    }
}

/// One of the claims of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Claim {
    /// The loop of plant and controller.
    Nominal,
    /// The same loop with the norm-bounded model error of `residual`.
    WithModelError,
    /// The loop with a parameter that moves at a bounded rate.
    BoundedRate,
    /// The same with the model error of `residual`.
    BoundedRateWithModelError,
    /// The loop whose commands are cut off at limits, with the model error of `residual`.
    WithLimits,
    /// A bound for w of bounded energy, from 0, of the loop whose commands are cut off.
    OfEnergy(u16),
}

impl fmt::Display for Claim {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Nominal => f.write_str("the claim"),
            Self::WithModelError => f.write_str("the claim with model error (residual)"),
            Self::BoundedRate => f.write_str("the claim of a bounded rate"),
            Self::BoundedRateWithModelError => f.write_str("the claim of a bounded rate with model error"),
            Self::WithLimits => f.write_str("the claim with limits"),
            Self::OfEnergy(k) => write!(f, "claim {k} of bounded energy"),
        }
    }
}

/// The first thing that failed in a proof. Rows and columns count from 0.
#[derive(Debug, Error)]
#[allow(missing_docs, reason = "the message says what each field is")]
pub enum Failure {
    /// The sizes of a certificate that was built in memory do not agree.
    #[error("not proved: {0}")]
    Malformed(#[from] ReadError),
    /// Plant and controller do not determine u and y.
    #[error(
        "the claim is not proved: the loop is not well posed, for I - Duy D22 is singular (its determinant is \
            exactly 0); another controller is needed, one with another Duy"
    )]
    NotWellPosed,
    /// A number that must be positive is not.
    #[error("{claim} is not proved: {name} is {found:e}, must be above 0")]
    NotPositive { claim: Claim, name: &'static str, found: f64 },
    /// A bound on a magnitude is negative.
    #[error("the claim of a bounded rate is not proved: the rate is {rate:e}, must be at least 0")]
    NegativeRate { rate: f64 },
    /// A step that takes the state out of its region, or a command to its limit.
    #[error("the claim with limits is not proved: a step of {size:e} {beyond}")]
    TooLarge { size: f64, beyond: String },
    /// Two entries that must be equal, or opposite, are not.
    #[error(
        "{claim} is not proved: {matrix} is not {property}: entry [{row}][{column}] is {entry:e}, entry \
            [{column}][{row}] is {mirror:e}"
    )]
    NotMirrored {
        claim: Claim,
        matrix: Proved,
        property: &'static str,
        row: usize,
        column: usize,
        entry: f64,
        mirror: f64,
    },
    /// A scaling couples channels of different parameters.
    #[error(
        "{claim} is not proved: {matrix} does not commute with Theta: entry [{row}][{column}] is {entry:e}, must be 0, \
         because channel {row} carries parameter {row_parameter} and channel {column} parameter {column_parameter}"
    )]
    NotCommuting {
        claim: Claim,
        matrix: Proved,
        row: usize,
        column: usize,
        entry: f64,
        /// The parameter of the row, from 0.
        row_parameter: usize,
        /// The parameter of the column, from 0.
        column_parameter: usize,
    },
    /// No factor shows that a matrix is definite.
    #[error("{claim} is not proved: {matrix} is not shown to be {sign} definite")]
    NotShown { claim: Claim, matrix: Proved, sign: &'static str },
    /// A matrix is not definite.
    #[error(
        "{claim} is not proved: {matrix} is not {sign} definite: in its elimination the pivot of row {row}, \
         row {row_in_block} of block {block}, is {}, must be {} 0",
        signed(*pivot, *exactly_zero), if *sign == "positive" { "above" } else { "below" }
    )]
    NotDefinite {
        claim: Claim,
        matrix: Proved,
        sign: &'static str,
        row: usize,
        block: &'static str,
        row_in_block: usize,
        pivot: f64,
        exactly_zero: bool,
    },
}

fn signed(pivot: f64, exactly_zero: bool) -> String {
    if exactly_zero { "exactly 0".into() } else { format!("about {pivot:+.3e}") }
}
