//! What a model must offer to become an FMU.

use model_description::{DefaultExperiment, Enumeration};

use crate::{Log, ResourceError, Resources, Variable};

/// A model that can be stepped in time; it knows no protocol.
///
/// A clone is a complete snapshot: it serves `fmi2GetFMUstate` and `fmi2Reset`. Heavy data that never changes
/// belongs into an `Arc`.
pub trait Model: Clone + Send + 'static {
    /// What can go wrong; its text is logged as one sentence.
    type Error: std::error::Error + From<ResourceError> + Send + Sync + 'static;

    /// Reads the resources into a model whose variables hold their start values.
    ///
    /// Whatever reaches the model description from here must come out alike on every platform, or the GUID will
    /// not match: take it from the files, or compute it with `+ - * /` and `sqrt` only.
    ///
    /// # Errors
    /// A resource is missing or damaged.
    fn load(resources: &Resources) -> Result<Self, Self::Error>;

    /// What the model description says besides the variables.
    fn about(&self) -> About;

    /// The table of variables; position in the table is the value reference.
    fn variables(&self) -> Vec<Variable<Self>>;

    /// Computes initial state and all outputs from parameters and inputs, at the start time in s.
    ///
    /// It is called again whenever a variable was set in initialization mode, so it must not build on itself.
    ///
    /// # Errors
    /// Parameters or inputs allow no initial state.
    fn initialise(&mut self, start: f64, log: &mut dyn Log) -> Result<(), Self::Error>;

    /// Moves from one time to another, both in s, with the inputs held, and computes all outputs.
    ///
    /// # Errors
    /// The step cannot be computed; the instance then only takes reset, an earlier state, or free.
    fn step(&mut self, from: f64, to: f64, log: &mut dyn Log) -> Result<(), Self::Error>;

    /// Recomputes the outputs that follow an input without a step.
    ///
    /// Models whose outputs only move with a step keep this default.
    ///
    /// # Errors
    /// The outputs cannot be computed.
    fn refresh(&mut self) -> Result<(), Self::Error> {
        Ok(())
    }

    /// The model's own directional derivative, if it has one.
    fn directional_derivative() -> Option<DirectionalDerivative<Self>> {
        None
    }
}

/// `dz = (d unknowns / d knowns) dv`: model, value references of unknowns and knowns, `dv`, and room for `dz`.
pub type DirectionalDerivative<M> =
    fn(&M, &[u32], &[u32], &[f64], &mut [f64]) -> Result<(), <M as Model>::Error>;

/// What a model description says besides the variables.
#[derive(Debug, Clone, PartialEq)]
pub struct About {
    /// C identifier, name of the binary and of the FMU.
    pub identifier: String,
    /// Name for people.
    pub name: String,
    /// One sentence.
    pub description: String,
    /// Version of the model.
    pub version: String,
    /// Enumerated types that the variables use.
    pub enumerations: Vec<Enumeration>,
    /// Default start, stop and step.
    pub default_experiment: DefaultExperiment,
}
