//! Mistakes in a file written by people.

use std::fmt;

use serde::{Serialize, Serializer};
use thiserror::Error;

use crate::motion::parameter::UnknownParameter;
use crate::text::rounded;
use crate::vehicle::coefficients::CoefficientError;

/// Mistakes in a file, in its order, each on a line `FILE:LINE: the value and what is allowed`.
#[derive(Debug, Serialize)]
pub struct FileError {
    /// File, as named by the caller.
    pub file: String,
    /// One mistake or more.
    pub mistakes: Vec<Mistake>,
}

/// Mistake in a file, with its line.
#[derive(Debug, Serialize)]
pub struct Mistake {
    /// Line, counted from 1.
    pub line: usize,
    /// Description of the mistake.
    #[serde(flatten)]
    pub problem: FileProblem,
}

impl FileError {
    /// Returns the values read from all parts of a file, or the mistakes in all parts; identical ones on a shared line
    /// once.
    ///
    /// # Errors
    /// [`FileError`].
    pub fn collect<T>(parts: impl IntoIterator<Item = Result<T, Self>>) -> Result<Vec<T>, Self> {
        let (mut values, mut wrong) = (Vec::new(), None::<Self>);
        for part in parts {
            match (part, &mut wrong) {
                (Ok(part), _) => values.push(part),
                (Err(reason), None) => wrong = Some(reason),
                (Err(reason), Some(wrong)) => {
                    for mistake in reason.mistakes {
                        if !wrong.mistakes.iter().any(|known| known.is_same(&mistake)) {
                            wrong.mistakes.push(mistake);
                        }
                    }
                    wrong.mistakes.sort_by_key(|mistake| mistake.line);
                }
            }
        }
        wrong.map_or(Ok(values), Err)
    }
}

impl Mistake {
    fn is_same(&self, other: &Self) -> bool {
        self.line == other.line && self.problem.to_string() == other.problem.to_string()
    }
}

impl fmt::Display for FileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.mistakes.is_empty() {
            return write!(f, "{}: cannot be read", self.file);
        }
        let mut printed = Vec::new();
        for (i, Mistake { line, problem }) in self.mistakes.iter().enumerate() {
            let (end, file) = (if i > 0 { "\n" } else { "" }, &self.file);
            write!(f, "{end}{file}:{line}: {problem}")?;
            if let Some(names) = problem.allowed_names().filter(|names| !printed.contains(names)) {
                write!(f, "; allowed: {names}")?;
                printed.push(names);
            }
        }
        Ok(())
    }
}

impl std::error::Error for FileError {}

/// Kind of mistake in a file.
#[derive(Debug, Error, Serialize)]
#[serde(tag = "problem", rename_all = "snake_case")]
#[allow(missing_docs, reason = "the message says what each field is")]
pub enum FileProblem {
    /// Text that is not TOML.
    #[error("this is not valid TOML: {message}")]
    NotToml { message: String },
    /// A key or a table that occurs twice.
    #[error("duplicate key '{key}': each key and each table may occur only once")]
    DuplicateKey { key: String },
    /// A key both in a table of a list and outside the list.
    #[error("'{key}' is given here and outside [[{list}]], where it applies to each; remove one of the two")]
    InAndOutside { key: String, list: String },
    /// An unknown key.
    #[error("unknown key '{key}'{}", suggest(suggestion))]
    UnknownKey { key: String, suggestion: Option<String>, allowed: String },
    /// A missing key.
    #[error("missing key '{key}': {meaning}")]
    MissingKey { key: String, meaning: String },
    /// A value of the wrong type, a number out of range, a text that is not in the list.
    #[error("'{key}' is {found}; it must be {allowed}")]
    NotAllowed { key: String, found: String, allowed: String },
    /// An empty text.
    #[error("'{key}' must not be empty")]
    EmptyText { key: String },
    /// A character that XML does not allow in a model description.
    #[error("'{key}' contains the character U+{:04X}; it must contain printable characters only", u32::from(*found))]
    Character { key: String, found: char },
    /// An unexpected unit.
    #[error("the unit of '{key}' is \"{found}\"; it must be {expected}")]
    WrongUnit { key: String, found: String, expected: String },
    /// Mass and weight that do not agree.
    #[error(
        "'mass.weight' is {} N, but 'mass.mass' times {gravity} m/s2 is {} N; they must agree within {:.0} % (is the \
         weight in kg or pounds, or the mass in pounds?)",
        rounded(*weight), rounded(*expected), 100.0 * tolerance
    )]
    MassAndWeight { weight: f64, expected: f64, gravity: f64, tolerance: f64 },
    /// A moment of inertia that is physically impossible.
    #[error(
        "'mass.{key}', about the origin, is {} kg.m2; it must be above mass {arm} = {} kg.m2, the value for a point \
         mass (is {key} about the centre of gravity, or in another unit?)",
        rounded(*inertia), rounded(*of_a_point)
    )]
    Inertia { key: &'static str, arm: &'static str, inertia: f64, of_a_point: f64 },
    /// A mass matrix that is not positive definite.
    #[error(
        "the mass matrix ({numbers}, x_G, z_G and [added_mass]) is not positive definite: its least eigenvalue is {}; \
         it must be above zero",
        rounded(*least_eigenvalue)
    )]
    MassMatrixNotPositiveDefinite { numbers: &'static str, least_eigenvalue: f64 },
    /// A set of coefficients that is not allowed.
    #[error("{source}")]
    Coefficient {
        #[serde(serialize_with = "as_text")]
        source: CoefficientError,
    },
    /// Two actuators with the same name.
    #[error(
        "the actuator name \"{name}\" is already used in line {first_line}; each actuator needs a name of its own"
    )]
    DuplicateActuator { name: String, first_line: usize },
    /// Limits in the wrong order.
    #[error(
        "'{key}.min' is {} {unit} and '{key}.max' is {} {unit}; min must be below max",
        rounded(*min),
        rounded(*max)
    )]
    LimitsReversed { key: String, min: f64, max: f64, unit: &'static str },
    /// A list that is too long.
    #[error("'{key}' has {found} entries; it may have at most {most}")]
    TooLong { key: String, found: usize, most: usize },
    /// A decimal comma.
    #[error("{found} is not a number: the decimal separator is '.', not ','")]
    DecimalComma { found: String },
    /// A dotted name without quotes.
    #[error(
        "without quotes, {name} is read as a table {}; write \"{name}\" in quotes",
        name.split('.').next().unwrap_or_default()
    )]
    NoQuotes { name: String },
    /// A vehicle without actuators.
    #[error("no actuator: give at least one [[thruster]], [[thruster_group]] or [[control_surface]]")]
    NoActuator,
    /// A coefficient that the vehicle does not have.
    #[error("[{section}]: {source}")]
    UnknownCoefficient {
        section: &'static str,
        #[serde(serialize_with = "as_text")]
        source: UnknownParameter,
    },
}

impl FileProblem {
    /// Returns the names that are allowed instead of an unknown one without a similar name; a file's message has equal
    /// lists once.
    fn allowed_names(&self) -> Option<&str> {
        match self {
            Self::UnknownKey { suggestion: None, allowed, .. } => Some(allowed),
            Self::UnknownCoefficient { source, .. } if source.suggestion.is_none() => Some(&source.known),
            _ => None,
        }
    }

    /// Returns the key that it is about, if it is about one.
    pub fn key(&self) -> Option<&str> {
        match self {
            Self::DuplicateKey { key }
            | Self::InAndOutside { key, .. }
            | Self::UnknownKey { key, .. }
            | Self::MissingKey { key, .. }
            | Self::NotAllowed { key, .. }
            | Self::EmptyText { key }
            | Self::Character { key, .. }
            | Self::WrongUnit { key, .. }
            | Self::LimitsReversed { key, .. }
            | Self::TooLong { key, .. } => Some(key),
            Self::Inertia { key, .. } => Some(key),
            _ => None,
        }
    }
}

fn suggest(suggestion: &Option<String>) -> String {
    suggestion.as_ref().map(|s| format!(" (did you mean '{s}'?)")).unwrap_or_default()
}

fn as_text<S: Serializer>(source: &impl fmt::Display, to: S) -> Result<S::Ok, S::Error> {
    to.collect_str(source)
}
