//! Errors of export and of the comparison of sources.

use thiserror::Error as ThisError;

/// Reason for which a design cannot be written as C.
#[derive(Debug, ThisError)]
#[allow(missing_docs, reason = "the message says what each field is")]
pub enum ExportError {
    /// An invalid design.
    #[error(transparent)]
    Design(#[from] squid_scheduled::DesignError),
    /// An actuator whose name is a reserved word of C or C++.
    #[error(
        "the actuator name '{name}' is a reserved word of C or C++ and cannot be a member of a struct; rename the \
            actuator in vehicle.toml"
    )]
    Keyword { name: String },
    /// More actuators than bits in the status.
    #[error("the status word has bits for {most} actuators; the design has {found}")]
    Actuators { found: usize, most: usize },
    /// No quasi-triangular form of Dtt.
    #[error(
        "the iteration for the Schur form of Dtt does not converge; without this form each tick would need pivoting"
    )]
    NoSchurForm,
    /// A controller without states.
    #[error("the controller has no states, and C has no arrays of length 0")]
    NoStates,
    /// Two rows of the trim table that are equal in single precision.
    #[error("{what} cannot be represented as a float; export with --real double")]
    Float { what: &'static str },
}

/// First difference between a source and that of a design.
#[derive(Debug, PartialEq, Eq, ThisError)]
#[allow(missing_docs, reason = "the message says what each field is")]
pub enum SourceError {
    /// Characters that can hide code from the comparison.
    #[error("line {line}: '{found}' does not occur in sources written by squid")]
    Hides { line: usize, found: &'static str },
    /// A different number in a table.
    #[error("line {line}: table {table} has {found}; the controller of the certificate has {expected}")]
    Number { line: usize, table: String, found: String, expected: String },
    /// Any other different token.
    #[error("line {line}: found {found}; squid writes {expected}")]
    Other { line: usize, found: String, expected: String },
}
