//! The role of a variable, with its setter.

use std::fmt;

use squid_model_description::{Causality, Variability};

/// Function that reads a value from a model.
pub type Get<M, T> = Box<dyn Fn(&M) -> T + Send + Sync>;
/// Function that writes a value to a model.
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

    /// Creates the role of an input, set by another model at every communication point.
    pub fn input(set: impl Fn(&mut M, T) + Send + Sync + 'static) -> Self {
        Self::settable(Causality::Input, None, set)
    }

    /// Creates the role of a fixed parameter, set by the user before the simulation.
    pub fn parameter(set: impl Fn(&mut M, T) + Send + Sync + 'static) -> Self {
        Self::settable(Causality::Parameter, Some(Variability::Fixed), set)
    }

    /// Creates the role of a tunable parameter, which the user may also set between steps.
    pub fn tunable(set: impl Fn(&mut M, T) + Send + Sync + 'static) -> Self {
        Self::settable(Causality::Parameter, Some(Variability::Tunable), set)
    }

    /// Creates the role of an output, computed for other models.
    pub fn output() -> Self {
        Self::readable(Causality::Output, None)
    }

    /// Creates the role of a local variable, computed for display.
    pub fn local() -> Self {
        Self::readable(Causality::Local, None)
    }

    /// Creates the role of a constant from the resources, for display.
    pub fn constant() -> Self {
        Self::readable(Causality::Local, Some(Variability::Constant))
    }
}

impl<M, T> fmt::Debug for Role<M, T> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{:?} {:?}", self.causality, self.variability)
    }
}
