//! What can be wrong with a vehicle file.

use thiserror::Error;

use crate::coefficients::CoefficientError;

/// A mistake in a vehicle file, and where it is.
#[derive(Debug, Error)]
#[error("{file}:{line}: {problem}")]
pub struct VehicleFileError {
    /// The file, as it was named.
    pub file: String,
    /// The line, counted from 1; 0 if the file could not be read at all.
    pub line: usize,
    /// What is wrong.
    pub problem: Box<FileProblem>,
}

impl VehicleFileError {
    pub(crate) fn unreadable(file: String, source: std::io::Error) -> Self {
        Self { file, line: 0, problem: Box::new(FileProblem::Unreadable { source }) }
    }
}

/// What is wrong with a vehicle file.
#[derive(Debug, Error)]
pub enum FileProblem {
    /// The file cannot be opened or is not UTF-8.
    #[error("cannot read the file: {source}")]
    Unreadable {
        /// The system's reason.
        source: std::io::Error,
    },
    /// The text is not TOML.
    #[error("not valid TOML: {message}")]
    NotToml {
        /// The parser's reason.
        message: String,
    },
    /// A key that no vehicle file may hold.
    #[error("unknown key `{key}`{}; allowed here: {allowed}", suggest(suggestion))]
    UnknownKey {
        /// The key, with the table that holds it.
        key: String,
        /// The allowed key that looks most like it.
        suggestion: Option<String>,
        /// All allowed keys.
        allowed: String,
    },
    /// A key that every vehicle file must hold.
    #[error("missing key `{key}`: {meaning}")]
    MissingKey {
        /// The key, with the table that should hold it.
        key: String,
        /// What it would say.
        meaning: String,
    },
    /// A value of the wrong type.
    #[error("`{key}` is of type {found}, and must be {expected}")]
    WrongType {
        /// The key, with the table that holds it.
        key: String,
        /// The TOML type found.
        found: &'static str,
        /// What is expected.
        expected: &'static str,
    },
    /// A word that is not in the list.
    #[error("`{key}` is \"{found}\"{}; allowed: {allowed}", suggest(suggestion))]
    WrongWord {
        /// The key, with the table that holds it.
        key: String,
        /// The word found.
        found: String,
        /// The allowed word that looks most like it.
        suggestion: Option<String>,
        /// The allowed words.
        allowed: String,
    },
    /// A text that must not be empty.
    #[error("`{key}` is empty, and must say something")]
    EmptyText {
        /// The key, with the table that holds it.
        key: String,
    },
    /// A character that no model description may hold.
    #[error("`{key}` holds the character U+{:04X}, and must hold printable ones", u32::from(*found))]
    Character {
        /// The key, with the table that holds it.
        key: String,
        /// The character found.
        found: char,
    },
    /// A unit that is not the expected one.
    #[error("`{key}` is in \"{found}\", and must be in {expected}")]
    WrongUnit {
        /// The key, with the table that holds it.
        key: String,
        /// The unit found.
        found: String,
        /// The unit or units expected.
        expected: String,
    },
    /// A number of the wrong sign or out of range.
    #[error("`{key}` is {found} {unit}, and must be {allowed}")]
    NotAllowed {
        /// The key, with the table that holds it.
        key: String,
        /// The number found.
        found: f64,
        /// Its unit.
        unit: String,
        /// What is allowed.
        allowed: &'static str,
    },
    /// The mass matrix is not positive definite.
    #[error(
        "the mass matrix (mass, I_yy, x_G, z_G and [added_mass]) is not positive definite: \
         its least eigenvalue is {least_eigenvalue:.6}, and must be above zero"
    )]
    MassMatrixNotPositiveDefinite {
        /// Least eigenvalue of its symmetric part (SI).
        least_eigenvalue: f64,
    },
    /// The coefficients, taken together, are not allowed.
    #[error("{source}")]
    Coefficient {
        /// The reason.
        source: CoefficientError,
    },
    /// Two actuators with one name.
    #[error("the actuator name \"{name}\" is already taken at line {first_line}; names must differ")]
    DuplicateActuator {
        /// The name.
        name: String,
        /// Where it was first used.
        first_line: usize,
    },
    /// A vehicle name that cannot name files and models.
    #[error(
        "`vehicle.name` is \"{name}\"; it must begin with a letter and hold only letters, digits, `_`, `-` and spaces, \
         64 of them at most"
    )]
    VehicleName {
        /// The name found.
        name: String,
    },
    /// An actuator name that cannot name a variable.
    #[error("the actuator name \"{name}\" must begin with a letter and hold only letters, digits and `_`")]
    ActuatorName {
        /// The name.
        name: String,
    },
    /// Limits in the wrong order.
    #[error("`{key}`: min is {min} {unit} and max is {max} {unit}; min must be below max")]
    LimitsReversed {
        /// The actuator.
        key: String,
        /// Its least output.
        min: f64,
        /// Its greatest output.
        max: f64,
        /// Their unit.
        unit: &'static str,
    },
    /// No actuator at all.
    #[error("no actuator: give at least one [[thruster]] or [[control_surface]]")]
    NoActuator,
}

fn suggest(suggestion: &Option<String>) -> String {
    suggestion.as_ref().map(|s| format!(" (did you mean `{s}`?)")).unwrap_or_default()
}
