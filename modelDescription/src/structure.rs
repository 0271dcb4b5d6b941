//! Derivation of `ModelStructure` from the variables (section 2.2.8).

use std::collections::BTreeSet;

use crate::{Causality, Dependency, DependencyKind, Initial, ModelDescription, ScalarVariable};

/// Unknowns at a communication point and at initialisation.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ModelStructure {
    /// All outputs, each once, in the order of the variables.
    pub outputs: Vec<Unknown>,
    /// All derivatives of states, each once, in the order of the variables, which is that of the states.
    pub derivatives: Vec<Unknown>,
    /// All unknowns of the initialisation, in the order of the variables.
    pub initial_unknowns: Vec<Unknown>,
}

/// Unknown of the model; indices count from 1 as in the XML.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Unknown {
    /// Index of the unknown.
    pub index: usize,
    /// Indices of the knowns on which it depends; `None` means all knowns.
    pub dependencies: Option<Vec<(usize, DependencyKind)>>,
}

impl ModelDescription {
    /// Returns the structure that follows from causality, initial and dependencies of the variables.
    pub fn structure(&self) -> ModelStructure {
        let states: BTreeSet<&str> =
            self.variables.iter().filter_map(|one| one.derivative_of.as_deref()).collect();
        let is_state = |variable: &ScalarVariable| states.contains(variable.name.as_str());
        ModelStructure {
            outputs: self.unknowns(
                |variable| variable.causality == Causality::Output,
                |variable| &variable.depends_on,
            ),
            derivatives: self
                .unknowns(|variable| variable.derivative_of.is_some(), |variable| &variable.depends_on),
            initial_unknowns: self.unknowns(
                |variable| is_initial_unknown(variable, is_state(variable)),
                |variable| &variable.initially_depends_on,
            ),
        }
    }

    fn unknowns(
        &self,
        is_unknown: impl Fn(&ScalarVariable) -> bool,
        dependencies_of: impl Fn(&ScalarVariable) -> &Option<Vec<Dependency>>,
    ) -> Vec<Unknown> {
        let numbered = self.variables.iter().enumerate().filter(|(_, variable)| is_unknown(variable));
        let unknown = |(position, variable)| Unknown {
            index: position + 1,
            dependencies: dependencies_of(variable).as_deref().map(|list| self.indices(list)),
        };
        numbered.map(unknown).collect()
    }

    fn indices(&self, dependencies: &[Dependency]) -> Vec<(usize, DependencyKind)> {
        let index = |dependency: &Dependency| {
            self.position(&dependency.on).map(|position| (position + 1, dependency.kind))
        };
        let mut indices: Vec<_> = dependencies.iter().filter_map(index).collect();
        indices.sort_unstable_by_key(|&(index, _)| index);
        indices
    }
}

/// Returns `true` for an output, calculated parameter, state or derivative that is not set by its start value.
fn is_initial_unknown(variable: &ScalarVariable, is_state: bool) -> bool {
    let is_unknown = matches!(variable.causality, Causality::Output | Causality::CalculatedParameter)
        || is_state
        || variable.derivative_of.is_some();
    is_unknown && matches!(variable.initial(), Some(Initial::Approx | Initial::Calculated))
}
