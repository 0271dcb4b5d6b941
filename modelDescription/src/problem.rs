//! Violations of the standard that the schema cannot express and validators miss.

use crate::UnitError;

/// One violated rule of the standard.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Problem {
    /// A text contains a character that XML 1.0 (section 2.2) cannot represent.
    #[error("the text of '{place}' holds the character U+{:04X}, which XML cannot", u32::from(*character))]
    BadCharacter {
        /// The variable, or the model.
        place: String,
        /// The character.
        character: char,
    },
    /// Two variables of the same name.
    #[error("two variables are called '{name}'")]
    DuplicateName {
        /// The name.
        name: String,
    },
    /// Two variables with the same handle.
    #[error("variable '{name}' has value reference {value_reference}, which another variable has already")]
    DuplicateValueReference {
        /// The second variable.
        name: String,
        /// The handle.
        value_reference: u32,
    },
    /// A name that is not made of identifiers with dots between them.
    #[error("variable name {name:?} is not made of identifiers with dots between them")]
    BadName {
        /// The name.
        name: String,
    },
    /// A model identifier that is not a C identifier.
    #[error("model identifier '{identifier}' is not a C identifier")]
    BadIdentifier {
        /// The identifier.
        identifier: String,
    },
    /// A combination of causality, variability, initial and type that is not allowed.
    #[error("variable '{name}': causality, variability, initial and type may not stand together")]
    IllegalCombination {
        /// The variable.
        name: String,
    },
    /// No start value where the standard requires one.
    #[error("variable '{name}' needs a start value")]
    MissingStart {
        /// The variable.
        name: String,
    },
    /// A start value on a calculated variable.
    #[error("variable '{name}' is calculated and may have no start value")]
    UnexpectedStart {
        /// The variable.
        name: String,
    },
    /// An empty range.
    #[error("variable '{name}' has min {min} above max {max}")]
    MinAboveMax {
        /// The variable.
        name: String,
        /// Its min.
        min: f64,
        /// Its max.
        max: f64,
    },
    /// A start value outside its range.
    #[error("variable '{name}' starts at {start}, outside {min} .. {max}")]
    StartOutOfRange {
        /// The variable.
        name: String,
        /// Its start value.
        start: f64,
        /// Its min.
        min: f64,
        /// Its max.
        max: f64,
    },
    /// An attribute that is infinite or not a number.
    #[error("variable '{name}' has the attribute {attribute} = {value}, which is not finite")]
    NotFinite {
        /// The variable.
        name: String,
        /// The attribute.
        attribute: &'static str,
        /// Its value.
        value: f64,
    },
    /// A nominal value that is not positive.
    #[error("variable '{name}' has nominal {nominal}, which is not above 0")]
    NominalNotPositive {
        /// The variable.
        name: String,
        /// Its nominal value.
        nominal: f64,
    },
    /// A unit that cannot be read.
    #[error("variable '{name}': {reason}")]
    UnknownUnit {
        /// The variable.
        name: String,
        /// What is wrong with the unit.
        reason: UnitError,
    },
    /// A display unit that the unit does not have.
    #[error("variable '{name}' has display unit '{display_unit}', which its unit does not define")]
    UnknownDisplayUnit {
        /// The variable.
        name: String,
        /// The display unit.
        display_unit: String,
    },
    /// An enumerated type that is not defined.
    #[error("variable '{name}' is of type '{declared_type}', which is not defined")]
    UnknownType {
        /// The variable.
        name: String,
        /// The type.
        declared_type: String,
    },
    /// An enumeration without items, or with two of the same name, or defined twice, or called like a variable.
    #[error("enumeration '{name}' has no items, repeats one, is defined twice, or is called like a variable")]
    BadEnumeration {
        /// The enumeration.
        name: String,
    },
    /// A dependency on a variable that does not exist, or the same one twice.
    #[error("variable '{name}' depends on '{on}', which is unknown or named twice")]
    BadDependency {
        /// The variable.
        name: String,
        /// What it depends on.
        on: String,
    },
    /// A derivative of a variable that is not a continuous state, a second one of a state, or one without model
    /// exchange.
    #[error("variable '{name}' cannot be the derivative of '{state}'")]
    BadDerivative {
        /// The derivative.
        name: String,
        /// The state.
        state: String,
    },
    /// A dependency on a variable that is not a known, or of a kind that the list does not allow.
    #[error("variable '{name}' cannot depend on '{on}' in this way in {list}")]
    NoKnown {
        /// The unknown.
        name: String,
        /// What it depends on.
        on: String,
        /// The list.
        list: &'static str,
    },
    /// A default experiment that cannot be run.
    #[error("default experiment from {start} s to {stop} s with steps of {step} s cannot be run")]
    BadExperiment {
        /// Start time in s.
        start: f64,
        /// Stop time in s.
        stop: f64,
        /// Step in s.
        step: f64,
    },
}
