//! Checks a description against the rules of [`Problem`].

use std::collections::BTreeSet;

use crate::{Causality, Initial, Kind, ModelDescription, Problem, ScalarVariable, Unit, Variability};

impl ModelDescription {
    /// Returns every violation of the standard, in the order of the variables; the description is valid if the list is
    /// empty.
    pub fn check(&self) -> Vec<Problem> {
        let mut problems = Vec::new();
        check_root(self, &mut problems);
        for text in [&self.model_name, &self.description, &self.version] {
            check_text(&self.model_identifier, text, &mut problems);
        }
        let (mut names, mut references) = (BTreeSet::new(), BTreeSet::new());
        for variable in &self.variables {
            let name = || variable.name.clone();
            if !names.insert(&variable.name) {
                problems.push(Problem::DuplicateName { name: name() });
            }
            if !references.insert(variable.value_reference) {
                let value_reference = variable.value_reference;
                problems.push(Problem::DuplicateValueReference { name: name(), value_reference });
            }
            check_text(&variable.name, &variable.description, &mut problems);
            check_role(variable, &mut problems);
            check_kind(self, variable, &mut problems);
            check_dependencies(self, variable, &mut problems);
            check_derivative(self, variable, &mut problems);
        }
        check_structure(self, &mut problems);
        problems
    }
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
        let taken = description.variables.iter().any(|variable| variable.name == enumeration.name);
        let bad = taken || names.is_empty() || names.len() < enumeration.items.len();
        if bad || !seen.insert(&enumeration.name) {
            found.push(Problem::BadEnumeration { name: enumeration.name.clone() });
        }
    }
}

/// Checks the characters of a free text.
fn check_text(place: &str, text: &str, found: &mut Vec<Problem>) {
    let bad = |c: &char| matches!(c, '\0'..='\u{8}' | '\u{b}' | '\u{c}' | '\u{e}'..='\u{1f}' | '\u{fffe}' | '\u{ffff}');
    if let Some(character) = text.chars().find(bad) {
        found.push(Problem::BadCharacter { place: place.to_owned(), character });
    }
}

fn is_identifier(text: &str) -> bool {
    text.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
        && text.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
}

/// Returns `true` for a structured name of section 2.2.9: identifiers separated by dots, or `der(...)` of such a name.
fn is_structured(name: &str) -> bool {
    let inner = name.strip_prefix("der(").and_then(|rest| rest.strip_suffix(')'));
    inner.unwrap_or(name).split('.').all(is_identifier)
}

fn check_role(variable: &ScalarVariable, found: &mut Vec<Problem>) {
    let name = || variable.name.clone();
    if !is_structured(&variable.name) {
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

/// Checks that a derivative and its state are continuous Reals, and that no state has two derivatives.
fn check_derivative(description: &ModelDescription, variable: &ScalarVariable, found: &mut Vec<Problem>) {
    let Some(state) = &variable.derivative_of else { return };
    let continuous = |one: &ScalarVariable| {
        one.variability == Variability::Continuous && matches!(one.kind, Kind::Real { .. })
    };
    let of_state = description.variables.iter().find(|one| one.name == *state);
    let legal = of_state.is_some_and(|one| continuous(one) && one.causality != Causality::Input);
    let claims = description.variables.iter().filter(|one| one.derivative_of.as_ref() == Some(state));
    let twice = claims.count() > 1;
    if !legal || !continuous(variable) || twice || !description.model_exchange {
        found.push(Problem::BadDerivative { name: variable.name.clone(), state: state.clone() });
    }
}

/// Checks that every dependency is on a known of its list in `ModelStructure`.
fn check_structure(description: &ModelDescription, found: &mut Vec<Problem>) {
    let structure = description.structure();
    let states: BTreeSet<&String> =
        description.variables.iter().filter_map(|one| one.derivative_of.as_ref()).collect();
    for (list, unknowns, initial) in [
        ("Outputs", &structure.outputs, false),
        ("Derivatives", &structure.derivatives, false),
        ("InitialUnknowns", &structure.initial_unknowns, true),
    ] {
        for unknown in unknowns {
            let name = || description.variables[unknown.index - 1].name.clone();
            for &(index, _) in unknown.dependencies.iter().flatten() {
                let on = &description.variables[index - 1];
                // Knowns are inputs and states (section 2.2.8); at initialisation, inputs and variables with an exact
                // start value.
                let known =
                    if initial { on.initial() == Some(Initial::Exact) } else { states.contains(&on.name) };
                if !known && on.causality != Causality::Input {
                    found.push(Problem::NoKnown { name: name(), on: on.name.clone(), list });
                }
            }
        }
    }
}
