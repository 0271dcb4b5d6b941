//! The role of a variable, and how it is set.

use std::fmt;

use squid_model_description::{Causality, Variability};

/// Reads a value from a model.
pub type Get<M, T> = Box<dyn Fn(&M) -> T + Send + Sync>;
/// Writes a value into a model.
pub type Set<M, T> = Box<dyn Fn(&mut M, T) + Send + Sync>;

/// Causality and variability of a variable, with its setter if it has one.
pub struct Role<M, T> {
    pub(crate) causality: Causality,
    pub(crate) variability: Option<Variability>,
    pub(crate) set: Option<Set<M, T>>,
}

impl<M, T> Role<M, T> {
    fn settable(
        causality: Causality,
        variability: Option<Variability>,
        set: impl Fn(&mut M, T) + Send + Sync + 'static,
    ) -> Self {
        Self { causality, variability, set: Some(Box::new(set)) }
    }

    fn readable(causality: Causality, variability: Option<Variability>) -> Self {
        Self { causality, variability, set: None }
    }

    /// Set by another model at every communication point.
    pub fn input(set: impl Fn(&mut M, T) + Send + Sync + 'static) -> Self {
        Self::settable(Causality::Input, None, set)
    }

    /// Set by the user before the simulation.
    pub fn parameter(set: impl Fn(&mut M, T) + Send + Sync + 'static) -> Self {
        Self::settable(Causality::Parameter, Some(Variability::Fixed), set)
    }

    /// Set by the user, also between steps.
    pub fn tunable(set: impl Fn(&mut M, T) + Send + Sync + 'static) -> Self {
        Self::settable(Causality::Parameter, Some(Variability::Tunable), set)
    }

    /// Computed, for other models.
    pub fn output() -> Self {
        Self::readable(Causality::Output, None)
    }

    /// Computed, to be displayed.
    pub fn local() -> Self {
        Self::readable(Causality::Local, None)
    }

    /// Known from the resources, to be displayed.
    pub fn constant() -> Self {
        Self::readable(Causality::Local, Some(Variability::Constant))
    }
}

impl<M, T> fmt::Debug for Role<M, T> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{:?} {:?}", self.causality, self.variability)
    }
}
