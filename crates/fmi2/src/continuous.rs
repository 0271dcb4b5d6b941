//! What a model must offer so that an importer integrates it (model exchange, section 3), or sees its inputs act
//! without a step.

use crate::{Log, Model};

/// A model with continuous states `x' = f(x, u)`, whose inputs act at once, and with events at known times.
///
/// States and derivatives stand in the order of the variables that
/// [`Variable::derivative_of`](crate::Variable::derivative_of) marks.
pub trait ContinuousModel: Model {
    /// Reads the states.
    fn states(&self, states: &mut [f64]);

    /// Sets the states.
    fn set_states(&mut self, states: &[f64]);

    /// Lets the inputs act, as they stand, on what the outputs are read from; the states do not move.
    ///
    /// # Errors
    /// An input makes no sense.
    fn obey(&mut self) -> Result<(), Self::Error>;

    /// Computes `f(x, u)`; numbers that are not finite mean that there is none.
    fn derivatives(&self, rates: &mut [f64]);

    /// Fills in the tangents of the inputs that change at a rate, by their [quantities](crate::Variable::quantity).
    ///
    /// Models whose inputs have no [slope](crate::Variable::slope) keep this default.
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

    /// Looks at a completed step of the importer's integrator.
    fn step_completed(&mut self, _log: &mut dyn Log) {}
}

type EventOf<M> = fn(&mut M, f64, &mut dyn Log) -> Result<(), <M as Model>::Error>;

/// The functions of a [`ContinuousModel`], for code that knows a [`Model`] alone.
pub struct Continuous<M: Model> {
    pub(crate) states: fn(&M, &mut [f64]),
    pub(crate) set_states: fn(&mut M, &[f64]),
    pub(crate) obey: fn(&mut M) -> Result<(), M::Error>,
    pub(crate) derivatives: fn(&M, &mut [f64]),
    pub(crate) input_rates: fn(&M, &mut [f64]),
    pub(crate) next_event: fn(&M) -> Option<f64>,
    pub(crate) event: EventOf<M>,
    pub(crate) step_completed: fn(&mut M, &mut dyn Log),
}

impl<M: ContinuousModel> Continuous<M> {
    /// Those of `M`.
    pub fn of() -> Self {
        Self {
            states: M::states,
            set_states: M::set_states,
            obey: M::obey,
            derivatives: M::derivatives,
            input_rates: M::input_rates,
            next_event: M::next_event,
            event: M::event,
            step_completed: M::step_completed,
        }
    }
}
