//! Why a design cannot be written as C, or a source is not that of a design.

use thiserror::Error as ThisError;

/// Why a design cannot be written as C.
#[derive(Debug, ThisError)]
#[allow(missing_docs, reason = "the message says what each field is")]
pub enum ExportError {
    /// The design is wrong.
    #[error(transparent)]
    Design(#[from] squid_scheduled::DesignError),
    /// An actuator's name that C or C++ keeps for itself.
    #[error(
        "the actuator '{name}' cannot be a member of a struct: the word belongs to C or C++; rename it in vehicle.toml"
    )]
    Keyword { name: String },
    /// More actuators than the status has bits.
    #[error("the status has bits for {most} actuators, but the design has {found}")]
    Actuators { found: usize, most: usize },
    /// No quasi-triangular form of Dtt.
    #[error(
        "the iteration for the Schur form of Dtt does not converge, so that a tick would have to choose pivots"
    )]
    NoSchurForm,
    /// A controller without states.
    #[error("the controller has no states; C has no arrays of length 0")]
    NoStates,
    /// Two rows of the trim table that are the same in a float.
    #[error("{what} is lost in a float; export it with --real double")]
    Float { what: &'static str },
}

/// Why a source is not that of a design.
#[derive(Debug, PartialEq, Eq, ThisError)]
#[allow(missing_docs, reason = "the message says what each field is")]
pub enum SourceError {
    /// Characters that hide what a compiler reads.
    #[error("line {line} has '{found}', which squid never writes")]
    Hides { line: usize, found: &'static str },
    /// A number of a table.
    #[error("line {line}: the table {table} has {found} where the certificate's controller has {expected}")]
    Number { line: usize, table: String, found: String, expected: String },
    /// Anything else.
    #[error("line {line}: it has {found} where squid writes {expected}")]
    Other { line: usize, found: String, expected: String },
}
