//! The interface of a model that becomes an FMU.

use squid_model_description::{DefaultExperiment, Enumeration};

use crate::{Log, ResourceError, Resources, SavedState, StateError, Variable};

/// A model that can be stepped in time; it is independent of FMI.
///
/// A clone is a complete snapshot, used by `fmi2GetFMUstate` and `fmi2Reset`. Heavy data that never changes
/// belongs in an `Arc`. [`Model::pass_state`] lists what is in a serialised state.
pub trait Model: Clone + Send + Sync + 'static {
    /// Error of the model; its text is logged as one sentence.
    type Error: std::error::Error + From<ResourceError> + Send + Sync + 'static;

    /// Reads the resources into a model whose variables have their start values.
    ///
    /// Whatever enters the model description must be identical on every platform, or the GUID will not match: take
    /// it from the files, or compute it with `+ - * /` and `sqrt` only.
    ///
    /// # Errors
    /// A resource is missing or damaged.
    fn load(resources: &Resources) -> Result<Self, Self::Error>;

    /// What the model description contains besides the variables.
    fn about(&self) -> About;

    /// The table of variables; position in the table is the value reference.
    fn variables(&self) -> Vec<Variable<Self>>;

    /// Computes initial state and all outputs from parameters and inputs, at the start time in s.
    ///
    /// It is called again whenever a variable was set in initialization mode, so it must not depend on its last result.
    ///
    /// # Errors
    /// Parameters or inputs allow no initial state.
    fn initialise(&mut self, start: f64, log: &mut dyn Log) -> Result<(), Self::Error>;

    /// Moves from one time to another, both in s, with the inputs held, and computes all outputs.
    ///
    /// # Errors
    /// The step cannot be computed; the instance then accepts only reset, an earlier state, or free.
    fn step(&mut self, from: f64, to: f64, log: &mut dyn Log) -> Result<(), Self::Error>;

    /// Passes every number that a saved state needs to `state`, always in the same order; data that follow from the
    /// resources are omitted. A state is read into a freshly loaded model of the same resources, which then continues
    /// from it.
    ///
    /// # Errors
    /// Of a state that is read: the bytes end early, or are not a state of this model.
    fn pass_state(&mut self, state: &mut dyn SavedState) -> Result<(), StateError>;

    /// The model's exact derivatives, if it has them.
    fn tangents() -> Option<Tangents<Self>> {
        None
    }

    /// How many quantities the [tangents](Model::tangents) have; some may belong to no variable.
    fn quantities(&self) -> usize {
        0
    }

    /// Whether an importer may integrate the continuous states `x' = f(x, u)` itself, with events at known times. The
    /// inputs then act at once in co-simulation too ([`Model::apply_inputs`]); otherwise the outputs change during a
    /// step only, and the functions below keep their defaults.
    ///
    /// States and derivatives are in the order of the variables that [`Variable::derivative_of`] marks.
    const MODEL_EXCHANGE: bool = false;

    /// Reads the states.
    fn states(&self, _states: &mut [f64]) {}

    /// Sets the states.
    fn set_states(&mut self, _states: &[f64]) {}

    /// Goes to a time in s, the states as they are; a model whose rates do not depend on time keeps this default.
    fn set_time(&mut self, _time: f64) {}

    /// Applies the present inputs to the values that outputs are read from; the states do not change.
    ///
    /// # Errors
    /// An input is not allowed.
    fn apply_inputs(&mut self) -> Result<(), Self::Error> {
        Ok(())
    }

    /// Applies tunable parameters that were set between two steps or in event mode; the states do not change. A model
    /// that reads them wherever it needs them, and takes any finite number, keeps this default.
    ///
    /// # Errors
    /// A value is not allowed; all tunable parameters then have the values before again.
    fn tune(&mut self) -> Result<(), Self::Error> {
        Ok(())
    }

    /// Computes `f(x, u)`; numbers that are not finite mean that f is undefined there.
    fn derivatives(&self, _rates: &mut [f64]) {}

    /// Fills in the tangents of the inputs that change at a rate, by their [quantities](Variable::quantity), and of
    /// time.
    ///
    /// Models whose inputs have no [slope](Variable::slope) and that do not depend on time keep this default.
    fn input_rates(&self, _tangents: &mut [f64]) {}

    /// The time in s of the next event, if one is known.
    fn next_event(&self) -> Option<f64> {
        None
    }

    /// Does what is due at an event at the given time in s.
    ///
    /// # Errors
    /// It cannot be computed.
    fn event(&mut self, _time: f64, _log: &mut dyn Log) -> Result<(), Self::Error> {
        Ok(())
    }

    /// Is called after a completed step of the importer's integrator.
    fn step_completed(&mut self, _log: &mut dyn Log) {}
}

/// Derivatives along one direction: `tangents[q]` is the derivative of quantity q, as [`Variable::quantity`] numbers
/// them.
///
/// On entry those of the knowns are set (inputs and, except in initialization, states); the function fills in those
/// of the unknowns.
pub type Tangents<M> = fn(&M, Moment, &mut [f64]) -> Result<(), <M as Model>::Error>;

/// The instant of the derivatives.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moment {
    /// Time in s.
    pub time: f64,
    /// In initialization mode, where states follow from inputs and parameters.
    pub initial: bool,
}

/// What a model description says besides the variables.
#[derive(Debug, Clone, PartialEq)]
pub struct About {
    /// C identifier, name of the binary and of the FMU.
    pub identifier: String,
    /// Name to display.
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
