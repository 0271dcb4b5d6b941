//! `ModelStructure`, derived from the variables (section 2.2.8).

use crate::{Causality, Dependency, DependencyKind, Initial, ModelDescription, ScalarVariable};

/// Unknowns at a communication point and at initialisation.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ModelStructure {
    /// All outputs, each once, in the order of the variables.
    pub outputs: Vec<Unknown>,
    /// All unknowns of the initialisation, in the order of the variables.
    pub initial_unknowns: Vec<Unknown>,
}

/// One unknown; indices count from 1 as in the XML.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Unknown {
    /// Index of the unknown.
    pub index: usize,
    /// Indices of what it depends on; `None` means all knowns.
    pub dependencies: Option<Vec<(usize, DependencyKind)>>,
}

impl ModelDescription {
    /// The structure that follows from causality, initial and dependencies of the variables.
    pub fn structure(&self) -> ModelStructure {
        let unknowns = |chosen: fn(&ScalarVariable) -> bool,
                        of: fn(&ScalarVariable) -> &Option<Vec<Dependency>>| {
            let numbered = self.variables.iter().enumerate();
            let chosen = numbered.filter(|(_, variable)| chosen(variable));
            chosen
                .map(|(position, variable)| Unknown {
                    index: position + 1,
                    dependencies: of(variable).as_deref().map(|list| self.indices(list)),
                })
                .collect()
        };
        ModelStructure {
            outputs: unknowns(is_output, |variable| &variable.depends_on),
            initial_unknowns: unknowns(is_initial_unknown, |variable| &variable.initially_depends_on),
        }
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

fn is_output(variable: &ScalarVariable) -> bool {
    variable.causality == Causality::Output
}

/// An output or calculated parameter that is not given by its start value.
fn is_initial_unknown(variable: &ScalarVariable) -> bool {
    matches!(variable.causality, Causality::Output | Causality::CalculatedParameter)
        && matches!(variable.initial(), Some(Initial::Approx | Initial::Calculated))
}
