//! What the schema cannot say, and validators miss.

use std::collections::HashSet;

use crate::{Kind, ModelDescription, ScalarVariable, Unit, UnitError};

/// One violated rule of the standard.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Problem {
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
    /// A name that is empty or holds a line break, tab or control character.
    #[error("variable name {name:?} is empty or holds a control character")]
    BadName {
        /// The name.
        name: String,
    },
    /// Not a C identifier.
    #[error("model identifier '{identifier}' is not a C identifier")]
    BadIdentifier {
        /// The identifier.
        identifier: String,
    },
    /// Causality, variability, initial and type that may not stand together.
    #[error("variable '{name}': causality, variability, initial and type may not stand together")]
    IllegalCombination {
        /// The variable.
        name: String,
    },
    /// No start value where the standard demands one.
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
    /// A range that holds no value.
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
    /// An enumeration without items, or with two of the same name, or defined twice.
    #[error("enumeration '{name}' has no items, repeats one, or is defined twice")]
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

/// All problems of a description, in the order of its variables.
pub(crate) fn problems(description: &ModelDescription) -> Vec<Problem> {
    let mut found = Vec::new();
    check_root(description, &mut found);
    let (mut names, mut references) = (HashSet::new(), HashSet::new());
    for variable in &description.variables {
        let name = || variable.name.clone();
        if !names.insert(&variable.name) {
            found.push(Problem::DuplicateName { name: name() });
        }
        if !references.insert(variable.value_reference) {
            let value_reference = variable.value_reference;
            found.push(Problem::DuplicateValueReference { name: name(), value_reference });
        }
        check_role(variable, &mut found);
        check_kind(description, variable, &mut found);
        check_dependencies(description, variable, &mut found);
    }
    found
}

fn check_root(description: &ModelDescription, found: &mut Vec<Problem>) {
    let identifier = &description.model_identifier;
    let starts_well = identifier.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_');
    if !starts_well || identifier.contains(|c: char| !c.is_ascii_alphanumeric() && c != '_') {
        found.push(Problem::BadIdentifier { identifier: identifier.clone() });
    }
    let experiment = description.default_experiment;
    let (start, stop, step) = (experiment.start_time, experiment.stop_time, experiment.step_size);
    let runs = start.is_finite() && stop.is_finite() && start < stop && step > 0.0 && step <= stop - start;
    let tolerance = experiment.tolerance.is_none_or(|tolerance| tolerance > 0.0 && tolerance.is_finite());
    if !runs || !tolerance {
        found.push(Problem::BadExperiment { start, stop, step });
    }
    let mut seen = HashSet::new();
    for enumeration in &description.enumerations {
        let names: HashSet<_> = enumeration.items.iter().map(|item| &item.name).collect();
        let bad = names.is_empty() || names.len() < enumeration.items.len();
        if bad || !seen.insert(&enumeration.name) {
            found.push(Problem::BadEnumeration { name: enumeration.name.clone() });
        }
    }
}

fn check_role(variable: &ScalarVariable, found: &mut Vec<Problem>) {
    let name = || variable.name.clone();
    if variable.name.is_empty() || variable.name.contains(char::is_control) {
        found.push(Problem::BadName { name: name() });
    }
    if !variable.is_legal_combination() {
        found.push(Problem::IllegalCombination { name: name() });
    }
    match (variable.needs_start(), variable.has_start()) {
        (true, false) => found.push(Problem::MissingStart { name: name() }),
        (false, true) => found.push(Problem::UnexpectedStart { name: name() }),
        _ => {}
    }
}

fn check_kind(description: &ModelDescription, variable: &ScalarVariable, found: &mut Vec<Problem>) {
    let name = || variable.name.clone();
    match &variable.kind {
        Kind::Real { unit, display_unit, min, max, nominal, start } => {
            for (attribute, value) in [("min", min), ("max", max), ("nominal", nominal), ("start", start)] {
                if let Some(value) = value.filter(|value| !value.is_finite()) {
                    found.push(Problem::NotFinite { name: name(), attribute, value });
                }
            }
            if let Some(nominal) = nominal.filter(|nominal| *nominal <= 0.0) {
                found.push(Problem::NominalNotPositive { name: name(), nominal });
            }
            check_range(variable, [*min, *start, *max], found);
            check_unit(variable, unit.as_deref(), display_unit.as_deref(), found);
        }
        Kind::Integer { min, max, start } => {
            check_range(variable, [min.map(f64::from), start.map(f64::from), max.map(f64::from)], found);
        }
        Kind::Enumeration { declared_type, start } => {
            let Some(defined) = description.enumerations.iter().find(|one| one.name == *declared_type) else {
                found.push(Problem::UnknownType { name: name(), declared_type: declared_type.clone() });
                return;
            };
            let count = defined.items.len() as f64;
            check_range(variable, [Some(1.0), start.map(f64::from), Some(count)], found);
        }
        Kind::Boolean { .. } | Kind::String { .. } => {}
    }
}

fn check_range(variable: &ScalarVariable, [min, start, max]: [Option<f64>; 3], found: &mut Vec<Problem>) {
    let name = || variable.name.clone();
    let (min, max) = (min.unwrap_or(f64::NEG_INFINITY), max.unwrap_or(f64::INFINITY));
    if min > max {
        found.push(Problem::MinAboveMax { name: name(), min, max });
    } else if let Some(start) = start.filter(|start| *start < min || *start > max) {
        found.push(Problem::StartOutOfRange { name: name(), start, min, max });
    }
}

fn check_unit(
    variable: &ScalarVariable,
    unit: Option<&str>,
    display: Option<&str>,
    found: &mut Vec<Problem>,
) {
    let name = || variable.name.clone();
    let unit = match unit.map(Unit::parse).transpose() {
        Ok(unit) => unit,
        Err(reason) => {
            found.push(Problem::UnknownUnit { name: name(), reason });
            return;
        }
    };
    if let Some(display) = display {
        let defined = unit.is_some_and(|unit| unit.display_units.iter().any(|one| one.name == display));
        if !defined {
            found.push(Problem::UnknownDisplayUnit { name: name(), display_unit: display.to_owned() });
        }
    }
}

fn check_dependencies(description: &ModelDescription, variable: &ScalarVariable, found: &mut Vec<Problem>) {
    for list in [&variable.depends_on, &variable.initially_depends_on] {
        let mut seen = HashSet::new();
        for dependency in list.iter().flatten() {
            let on = &dependency.on;
            if description.position(on).is_none() || !seen.insert(on) {
                found.push(Problem::BadDependency { name: variable.name.clone(), on: on.clone() });
            }
        }
    }
}
