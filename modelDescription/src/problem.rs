//! Violations of the standard that the schema cannot express and validators do not detect.

use crate::UnitError;

/// Violated rule of the standard.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[allow(missing_docs, reason = "the message says what each field is")]
pub enum Problem {
    /// Text with a character that XML 1.0 (section 2.2) cannot represent.
    #[error("the text of '{place}' contains the character U+{:04X}, which XML does not allow", u32::from(*character))]
    BadCharacter { place: String, character: char },
    /// Two variables with the same name.
    #[error("two variables are called '{name}'")]
    DuplicateName { name: String },
    /// Two variables with the same handle.
    #[error("variable '{name}' has value reference {value_reference}, which another variable already has")]
    DuplicateValueReference { name: String, value_reference: u32 },
    /// Name that does not consist of identifiers separated by dots.
    #[error("variable name {name:?} does not consist of identifiers separated by dots")]
    BadName { name: String },
    /// Model identifier that is not a C identifier.
    #[error("model identifier '{identifier}' is not a C identifier")]
    BadIdentifier { identifier: String },
    /// Combination of causality, variability, initial and type that is not allowed.
    #[error("variable '{name}': this combination of causality, variability, initial and type is not allowed")]
    IllegalCombination { name: String },
    /// Missing start value that the standard requires.
    #[error("variable '{name}' requires a start value")]
    MissingStart { name: String },
    /// Start value of a calculated variable.
    #[error("variable '{name}' is calculated and must not have a start value")]
    UnexpectedStart { name: String },
    /// Empty range.
    #[error("variable '{name}' has min {min} above max {max}")]
    MinAboveMax { name: String, min: f64, max: f64 },
    /// Start value outside its range.
    #[error("variable '{name}' has the start value {start}, outside {min} to {max}")]
    StartOutOfRange { name: String, start: f64, min: f64, max: f64 },
    /// Attribute that is infinite or not a number.
    #[error("variable '{name}' has {attribute} = {value}; it must be finite")]
    NotFinite { name: String, attribute: &'static str, value: f64 },
    /// Nominal value that is not positive.
    #[error("variable '{name}' has nominal {nominal}; it must be above 0")]
    NominalNotPositive { name: String, nominal: f64 },
    /// Unit that cannot be read.
    #[error("variable '{name}': {reason}")]
    UnknownUnit { name: String, reason: UnitError },
    /// Display unit that is not defined for the unit.
    #[error("variable '{name}' has display unit '{display_unit}', which its unit does not define")]
    UnknownDisplayUnit { name: String, display_unit: String },
    /// Enumerated type that is not defined.
    #[error("variable '{name}' is of type '{declared_type}', which is not defined")]
    UnknownType { name: String, declared_type: String },
    /// Enumeration without items, with two items of the same name, defined twice, or with the name of a variable.
    #[error(
        "enumeration '{name}' has no items, has duplicate items, is defined twice, or has the name of a variable"
    )]
    BadEnumeration { name: String },
    /// Dependency on a variable that does not exist, or duplicate dependency.
    #[error("variable '{name}' depends on '{on}', which is unknown or listed twice")]
    BadDependency { name: String, on: String },
    /// Derivative of a variable that is not a continuous state, second derivative entry of a state, or derivative
    /// without model exchange.
    #[error("variable '{name}' cannot be the derivative of '{state}'")]
    BadDerivative { name: String, state: String },
    /// Dependency on a variable that is not a known of the list.
    #[error("variable '{name}' cannot have this kind of dependency on '{on}' in {list}")]
    NoKnown { name: String, on: String, list: &'static str },
    /// Default experiment that cannot be run.
    #[error("the default experiment from {start} s to {stop} s with step {step} s is invalid")]
    BadExperiment { start: f64, stop: f64, step: f64 },
}
