//! Directional derivatives of the model at one instant, and time derivatives of outputs (sections 2.1.9 and 4.2.1).
//!
//! Co-simulation evaluates them at the communication point, with the present inputs, before any event at the start of
//! the next step.

use crate::instance::Outcome;
use crate::states::snapshot::Slopes;
use crate::{Function, Instance, Log, Model, Moment, Phase, Refusal, Tangents};

impl<M: Model> Instance<M> {
    /// `fmi2GetDirectionalDerivative`: `sensitivity = (d unknowns / d knowns) seed`, exact.
    ///
    /// # Errors
    /// A refused call, an invalid known or unknown, or a failure of the model.
    /// [`Refusal::Undefined`] if a derivative does not exist; all others are written.
    pub fn directional_derivative(
        &mut self,
        unknowns: &[u32],
        knowns: &[u32],
        seed: &[f64],
        sensitivity: &mut [f64],
        log: &mut dyn Log,
    ) -> Outcome<M> {
        self.allows(Function::GetDirectionalDerivative)?;
        let flag = "providesDirectionalDerivative = false";
        let tangents = M::tangents().ok_or(Refusal::Unsupported { flag })?;
        self.update(log)?;
        self.tangents.fill(0.0);
        for (&known, &seed) in knowns.iter().zip(seed) {
            let quantity = self.table.known(known, self.now.phase)?;
            if !seed.is_finite() {
                return Err(Refusal::NotFinite { name: self.name(known), value: seed }.into());
            }
            self.tangents[quantity] += seed;
        }
        for &unknown in unknowns {
            self.table.unknown(unknown)?;
        }
        self.carry(tangents)?;
        for (&unknown, result) in unknowns.iter().zip(&mut *sensitivity) {
            *result = self.table.unknown(unknown)?.map_or(0.0, |quantity| self.tangents[quantity]);
        }
        self.defined("the directional derivative of variable", unknowns, sensitivity)
    }

    /// `fmi2SetRealInputDerivatives`: the rates of inputs during the next step, of order 1.
    ///
    /// # Errors
    /// A refused call, another order, a variable that is not a continuous input, or a rate that is not finite. No rate
    /// is then set.
    pub fn set_input_derivatives(
        &mut self,
        references: &[u32],
        orders: &[i32],
        values: &[f64],
    ) -> Result<(), Refusal> {
        self.allows(Function::SetRealInputDerivatives)?;
        if !references.is_empty() && !self.table.interpolates() {
            return Err(Refusal::Unsupported { flag: "canInterpolateInputs = false" });
        }
        for ((&reference, &order), &value) in references.iter().zip(orders).zip(values) {
            self.table.slope(reference)?;
            if order != 1 {
                return Err(Refusal::BadOrder { name: self.name(reference), order });
            }
            if !value.is_finite() {
                return Err(Refusal::NotFinite { name: self.name(reference), value });
            }
        }
        self.forget_flown_slopes();
        for (&reference, &value) in references.iter().zip(values) {
            (self.table.slope(reference)?)(&mut self.now.model, value);
            self.now.slopes = Slopes::Ahead;
        }
        Ok(())
    }

    /// `fmi2GetRealOutputDerivatives`: the time derivatives of outputs, of order 1, with the present
    /// inputs, which change at the rates set for the next step, or else at those of the last step.
    ///
    /// # Errors
    /// A refused call, another order, a variable that is not an output, or a failure of the model.
    /// [`Refusal::Undefined`] if a derivative does not exist; all others are written.
    pub fn output_derivatives(
        &mut self,
        references: &[u32],
        orders: &[i32],
        values: &mut [f64],
        log: &mut dyn Log,
    ) -> Outcome<M> {
        self.allows(Function::GetRealOutputDerivatives)?;
        if references.is_empty() {
            return Ok(());
        }
        let flag = "maxOutputDerivativeOrder = 0";
        let tangents = M::tangents().filter(|_| M::MODEL_EXCHANGE).ok_or(Refusal::Unsupported { flag })?;
        for (&reference, &order) in references.iter().zip(orders) {
            self.table.output(reference)?;
            if order != 1 {
                return Err(Refusal::BadOrder { name: self.name(reference), order }.into());
            }
        }
        self.update(log)?;
        self.now.model.derivatives(&mut self.rates);
        self.tangents.fill(0.0);
        for (&state, &rate) in self.table.states().iter().zip(&self.rates) {
            let quantity = self.table.known(state, Phase::Step)?;
            self.tangents[quantity] = rate;
        }
        self.now.model.input_rates(&mut self.tangents);
        self.carry(tangents)?;
        for (&reference, value) in references.iter().zip(&mut *values) {
            *value = self.table.output(reference)?.map_or(0.0, |quantity| self.tangents[quantity]);
        }
        self.defined("the time derivative of output", references, values)
    }

    fn carry(&mut self, tangents: Tangents<M>) -> Outcome<M> {
        let moment = Moment { time: self.now.time, initial: self.now.phase == Phase::Initialization };
        tangents(&self.now.model, moment, &mut self.tangents).map_err(crate::Failure::Model)
    }

    /// Checks that the returned values are finite.
    pub(crate) fn defined(&self, what: &'static str, references: &[u32], values: &[f64]) -> Outcome<M> {
        match references.iter().zip(values).find(|(_, value)| !value.is_finite()) {
            Some((&reference, &value)) => {
                Err(Refusal::Undefined { what, name: self.name(reference), value }.into())
            }
            None => Ok(()),
        }
    }

    /// Returns the name of an existing variable.
    pub(crate) fn name(&self, reference: u32) -> String {
        self.table.variables()[reference as usize].name().to_owned()
    }
}
