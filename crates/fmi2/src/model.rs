//! The interface of a model that becomes an FMU.

use squid_model_description::{DefaultExperiment, Enumeration};

use crate::{Log, ResourceError, Resources, SavedState, StateError, Variable};

/// A model that can be advanced in time, independent of FMI.
///
/// A clone is a complete snapshot, used by `fmi2GetFMUstate` and `fmi2Reset`. Large constant data belongs in an
/// `Arc`. [`Model::pass_state`] defines the content of a serialised state.
pub trait Model: Clone + Send + Sync + 'static {
    /// Error of the model; its text is logged as one sentence.
    type Error: std::error::Error + From<ResourceError> + Send + Sync + 'static;

    /// Loads a model from the resources, with start values of all variables.
    ///
    /// All data of the model description must be identical on every platform, or the GUID does not match: take
    /// them from the files, or compute them with `+ - * /` and `sqrt` only.
    ///
    /// # Errors
    /// Returns an error if a resource is missing or damaged.
    fn load(resources: &Resources) -> Result<Self, Self::Error>;

    /// Returns the content of the model description besides the variables.
    fn about(&self) -> About;

    /// Returns the table of variables; the index in the table is the value reference.
    fn variables(&self) -> Vec<Variable<Self>>;

    /// Computes the initial state and all outputs from parameters and inputs, at the start time in s.
    ///
    /// It is called again after a variable is set in initialization mode, so it must not depend on its last result.
    ///
    /// # Errors
    /// Returns an error if parameters or inputs allow no initial state.
    fn initialise(&mut self, start: f64, log: &mut dyn Log) -> Result<(), Self::Error>;

    /// Advances from one time to another, both in s, with constant inputs, and computes all outputs.
    ///
    /// # Errors
    /// Returns an error if the step cannot be computed; the instance can then only be reset, restored or freed.
    fn step(&mut self, from: f64, to: f64, log: &mut dyn Log) -> Result<(), Self::Error>;

    /// Passes all numbers of a saved state to `state`, always in the same order, except data that follow from the
    /// resources. A state is read into a newly loaded model with the same resources, which then continues from it.
    ///
    /// # Errors
    /// Returns an error if a state that is read is too short or not a state of this model.
    fn pass_state(&mut self, state: &mut dyn SavedState) -> Result<(), StateError>;

    /// Returns the function for exact derivatives, if the model has one.
    fn tangents() -> Option<Tangents<Self>> {
        None
    }

    /// Returns the number of quantities of the [tangents](Model::tangents); some may belong to no variable.
    fn quantities(&self) -> usize {
        0
    }

    /// `true` if an importer may integrate the continuous states `x' = f(x, u)` itself, with events at known times. The
    /// inputs then act immediately in co-simulation, too ([`Model::apply_inputs`]); otherwise the outputs change only
    /// during a step, and the functions below keep their defaults.
    ///
    /// States and derivatives are in the order of the variables that [`Variable::derivative_of`] marks.
    const MODEL_EXCHANGE: bool = false;

    /// Reads the states.
    fn states(&self, _states: &mut [f64]) {}

    /// Sets the states.
    fn set_states(&mut self, _states: &[f64]) {}

    /// Sets the time in s without changing the states; a model whose rates do not depend on time keeps this default.
    fn set_time(&mut self, _time: f64) {}

    /// Updates the values of outputs with the present inputs, without changing the states.
    ///
    /// # Errors
    /// Returns an error if an input is not allowed.
    fn apply_inputs(&mut self) -> Result<(), Self::Error> {
        Ok(())
    }

    /// Applies tunable parameters set between two steps or in event mode, without changing the states. A model that
    /// always reads the current parameters, and allows any finite number, keeps this default.
    ///
    /// # Errors
    /// Returns an error if a value is not allowed; all tunable parameters then keep their previous values.
    fn tune(&mut self) -> Result<(), Self::Error> {
        Ok(())
    }

    /// Computes `f(x, u)`; values that are not finite mean that f is undefined there.
    fn derivatives(&self, _rates: &mut [f64]) {}

    /// Writes the tangents of the inputs that change at a rate, by their [quantities](Variable::quantity), and of
    /// time.
    ///
    /// Models whose inputs have no [slope](Variable::slope) and that do not depend on time keep this default.
    fn input_rates(&self, _tangents: &mut [f64]) {}

    /// Returns the time in s of the next event, if known.
    fn next_event(&self) -> Option<f64> {
        None
    }

    /// Processes the event at the given time in s.
    ///
    /// # Errors
    /// Returns an error if the event cannot be computed.
    fn event(&mut self, _time: f64, _log: &mut dyn Log) -> Result<(), Self::Error> {
        Ok(())
    }

    /// Notifies the model of a completed step of the importer's integrator.
    fn step_completed(&mut self, _log: &mut dyn Log) {}
}

/// Function for derivatives along one direction: `tangents[q]` is the derivative of quantity q, numbered by
/// [`Variable::quantity`].
///
/// The tangents of the knowns are set on entry (inputs and, except in initialization, states); the function computes
/// those of the unknowns.
pub type Tangents<M> = fn(&M, Moment, &mut [f64]) -> Result<(), <M as Model>::Error>;

/// Instant at which derivatives are evaluated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moment {
    /// Time in s.
    pub time: f64,
    /// `true` in initialization mode, where states follow from inputs and parameters.
    pub initial: bool,
}

/// Content of a model description besides the variables.
#[derive(Debug, Clone, PartialEq)]
pub struct About {
    /// C identifier, which is the name of the binary and of the FMU.
    pub identifier: String,
    /// Display name.
    pub name: String,
    /// Description of one sentence.
    pub description: String,
    /// Version of the model.
    pub version: String,
    /// Enumerated types that the variables use.
    pub enumerations: Vec<Enumeration>,
    /// Default start, stop and step.
    pub default_experiment: DefaultExperiment,
}
