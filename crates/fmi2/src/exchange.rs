//! Model exchange: the importer integrates (section 3).

use crate::instance::Outcome;
use crate::{Failure, Function, Instance, Log, Model, Phase, Refusal};

/// Result of `fmi2NewDiscreteStates`; the states are continuous at events, and one call is always sufficient.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Events {
    /// Time in s of the next event, if one is known.
    pub next: Option<f64>,
}

impl<M: Model> Instance<M> {
    /// `fmi2EnterEventMode`.
    ///
    /// # Errors
    /// [`Refusal::IllegalCall`].
    pub fn enter_event_mode(&mut self) -> Result<(), Refusal> {
        self.allows(Function::EnterEventMode)?;
        self.now.phase = Phase::Event;
        Ok(())
    }

    /// `fmi2NewDiscreteStates`: processes the pending event.
    ///
    /// # Errors
    /// A refused call, or a failure of the model.
    pub fn new_discrete_states(&mut self, log: &mut dyn Log) -> Result<Events, Failure<M::Error>> {
        self.allows(Function::NewDiscreteStates)?;
        self.update(log)?;
        let outcome = self.now.model.event(self.now.time, log);
        self.settle(outcome)?;
        self.now.stale = true;
        Ok(Events { next: self.now.model.next_event() })
    }

    /// `fmi2EnterContinuousTimeMode`.
    ///
    /// # Errors
    /// [`Refusal::IllegalCall`].
    pub fn enter_continuous_time_mode(&mut self) -> Result<(), Refusal> {
        self.allows(Function::EnterContinuousTimeMode)?;
        self.now.phase = Phase::Continuous;
        Ok(())
    }

    /// `fmi2CompletedIntegratorStep`; it never requests an event.
    ///
    /// # Errors
    /// A refused call, or a failure of the model.
    pub fn integrator_step_completed(&mut self, log: &mut dyn Log) -> Outcome<M> {
        self.allows(Function::CompletedIntegratorStep)?;
        self.update(log)?;
        self.now.model.step_completed(log);
        Ok(())
    }

    /// `fmi2SetTime`, in s.
    ///
    /// # Errors
    /// [`Refusal::IllegalCall`], [`Refusal::BadTime`].
    pub fn set_time(&mut self, time: f64) -> Result<(), Refusal> {
        self.allows(Function::SetTime)?;
        if !time.is_finite() {
            return Err(Refusal::BadTime { time });
        }
        self.now.time = time;
        self.now.model.set_time(time);
        self.now.stale = true;
        Ok(())
    }

    /// `fmi2SetContinuousStates`.
    ///
    /// # Errors
    /// A refused call; [`Refusal::WrongCount`], [`Refusal::NotFinite`].
    pub fn set_continuous_states(&mut self, states: &[f64]) -> Result<(), Refusal> {
        self.allows(Function::SetContinuousStates)?;
        self.counts("continuous states", states.len(), self.table.states().len())?;
        if let Some(index) = states.iter().position(|state| !state.is_finite()) {
            let name = self.name(self.table.states()[index]);
            return Err(Refusal::NotFinite { name, value: states[index] });
        }
        self.now.model.set_states(states);
        self.now.stale = true;
        Ok(())
    }

    /// `fmi2SetReal`: does the same as [`set`](Self::set), and in event and continuous-time mode also sets states.
    ///
    /// States have `fmi2SetContinuousStates` in the standard; CasADi sets them by `fmi2SetReal`, together with inputs.
    ///
    /// # Errors
    /// A refused call; no value is then set.
    pub fn set_real(&mut self, references: &[u32], values: &[f64]) -> Result<(), Refusal> {
        let states = self.table.states();
        let moves = matches!(self.now.phase, Phase::Event | Phase::Continuous);
        if !moves || !references.iter().any(|reference| states.contains(reference)) {
            return self.set(references, |position| values[position]);
        }
        self.allows(Function::SetReal)?;
        self.now.model.states(&mut self.rates);
        for (&reference, &value) in references.iter().zip(values) {
            match states.iter().position(|&state| state == reference) {
                None => self.table.check(reference, &value, self.now.phase)?,
                Some(_) if !value.is_finite() => {
                    return Err(Refusal::NotFinite { name: self.name(reference), value });
                }
                Some(index) => self.rates[index] = value,
            }
        }
        self.tune(references, |position| values[position])?;
        let states = self.table.states();
        self.now.model.set_states(&self.rates);
        for (&reference, &value) in references.iter().zip(values).filter(|(one, _)| !states.contains(one)) {
            self.table.set(&mut self.now.model, reference, value)?;
        }
        self.now.stale = true;
        Ok(())
    }

    /// `fmi2GetContinuousStates`.
    ///
    /// # Errors
    /// A refused call, or a failure of the model.
    pub fn continuous_states(&mut self, states: &mut [f64], log: &mut dyn Log) -> Outcome<M> {
        self.allows(Function::GetContinuousStates)?;
        self.counts("continuous states", states.len(), self.table.states().len())?;
        self.update(log)?;
        self.now.model.states(states);
        Ok(())
    }

    /// `fmi2GetDerivatives`.
    ///
    /// # Errors
    /// A refused call, or a failure of the model; [`Refusal::Undefined`] if the states are not admissible.
    pub fn derivatives(&mut self, rates: &mut [f64], log: &mut dyn Log) -> Outcome<M> {
        self.allows(Function::GetDerivatives)?;
        self.counts("continuous states", rates.len(), self.table.states().len())?;
        self.update(log)?;
        self.now.model.derivatives(rates);
        self.defined("the derivative of state", self.table.states(), rates)
    }

    /// `fmi2GetEventIndicators`: models have no event indicators.
    ///
    /// # Errors
    /// A refused call; [`Refusal::WrongCount`].
    pub fn event_indicators(&self, indicators: &mut [f64]) -> Result<(), Refusal> {
        self.allows(Function::GetEventIndicators)?;
        self.counts("event indicators", indicators.len(), 0)
    }

    /// `fmi2GetNominalsOfContinuousStates`.
    ///
    /// # Errors
    /// A refused call; [`Refusal::WrongCount`].
    pub fn nominals(&self, nominals: &mut [f64]) -> Result<(), Refusal> {
        self.allows(Function::GetNominalsOfContinuousStates)?;
        self.counts("continuous states", nominals.len(), self.table.states().len())?;
        for (nominal, &state) in nominals.iter_mut().zip(self.table.states()) {
            *nominal = self.table.nominal(state);
        }
        Ok(())
    }

    fn counts(&self, what: &'static str, found: usize, expected: usize) -> Result<(), Refusal> {
        if found == expected { Ok(()) } else { Err(Refusal::WrongCount { what, found, expected }) }
    }
}
