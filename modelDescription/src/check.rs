//! Checks a description against the rules of [`Problem`].

use std::collections::BTreeSet;

use crate::{Kind, ModelDescription, Problem, ScalarVariable, Unit};

/// All problems of a description, in the order of its variables.
pub(crate) fn problems(description: &ModelDescription) -> Vec<Problem> {
    let mut found = Vec::new();
    check_root(description, &mut found);
    let (mut names, mut references) = (BTreeSet::new(), BTreeSet::new());
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
    if !is_identifier(identifier) {
        found.push(Problem::BadIdentifier { identifier: identifier.clone() });
    }
    let experiment = description.default_experiment;
    let (start, stop, step) = (experiment.start_time, experiment.stop_time, experiment.step_size);
    let runs = start.is_finite() && stop.is_finite() && start < stop && step > 0.0 && step <= stop - start;
    let tolerance = experiment.tolerance.is_none_or(|tolerance| tolerance > 0.0 && tolerance.is_finite());
    if !runs || !tolerance {
        found.push(Problem::BadExperiment { start, stop, step });
    }
    let mut seen = BTreeSet::new();
    for enumeration in &description.enumerations {
        let names: BTreeSet<_> = enumeration.items.iter().map(|item| &item.name).collect();
        let bad = names.is_empty() || names.len() < enumeration.items.len();
        if bad || !seen.insert(&enumeration.name) {
            found.push(Problem::BadEnumeration { name: enumeration.name.clone() });
        }
    }
}

fn is_identifier(text: &str) -> bool {
    text.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
        && text.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
}

fn check_role(variable: &ScalarVariable, found: &mut Vec<Problem>) {
    let name = || variable.name.clone();
    if !variable.name.split('.').all(is_identifier) {
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
        let mut seen = BTreeSet::new();
        for dependency in list.iter().flatten() {
            let on = &dependency.on;
            if description.position(on).is_none() || !seen.insert(on) {
                found.push(Problem::BadDependency { name: variable.name.clone(), on: on.clone() });
            }
        }
    }
}
