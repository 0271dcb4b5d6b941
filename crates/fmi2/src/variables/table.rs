//! The table of variables at run time, indexed by value reference.

use squid_model_description::{Causality, Initial, Kind, ScalarVariable, Variability};

use crate::variables::role::Set;
use crate::variables::values::Value;
use crate::{Model, Phase, Refusal, Variable};

/// The variables of a model; the value reference of a variable is its index.
#[derive(Debug)]
pub struct Table<M> {
    variables: Vec<Variable<M>>,
    /// Value references of the states, in the order of their derivatives.
    states: Vec<u32>,
}

impl<M: Model> Table<M> {
    /// Creates the table of a loaded model.
    pub fn of(model: &M) -> Self {
        let mut table = Self { variables: model.variables(), states: Vec::new() };
        let states = table.variables.iter().filter_map(|variable| variable.meta.derivative_of.as_deref());
        table.states = states.filter_map(|name| table.reference(name)).collect();
        table
    }

    /// Returns the value references of the continuous states, in order.
    pub fn states(&self) -> &[u32] {
        &self.states
    }

    /// Returns the nominal value of a Real variable, 1 by default.
    pub(crate) fn nominal(&self, reference: u32) -> f64 {
        match self.variables.get(reference as usize).map(|variable| &variable.meta.kind) {
            Some(Kind::Real { nominal: Some(nominal), .. }) => *nominal,
            _ => 1.0,
        }
    }

    /// Returns the quantity of a variable that can be a known of derivatives: an input, or a state, except in
    /// initialization mode, where states follow from other variables.
    pub(crate) fn known(&self, reference: u32, phase: Phase) -> Result<usize, Refusal> {
        let entry = self.real(reference)?;
        let is_state = phase != Phase::Initialization && self.states.contains(&reference);
        let is_known = is_state || entry.meta.causality == Causality::Input;
        let name = || entry.meta.name.clone();
        // The standard allows parameters as knowns in initialization mode (section 2.1.9); they are not supported.
        if entry.meta.causality == Causality::Parameter {
            return Err(Refusal::ByParameter { name: name() });
        }
        let initial = phase == Phase::Initialization;
        let refused = || Refusal::NotKnown { name: name(), phase: phase.name(), initial };
        entry.quantity.filter(|_| is_known).ok_or_else(refused)
    }

    /// Returns the quantity of a variable that can be an unknown of derivatives: an output, a state or a derivative. A
    /// variable that changes at events only has no quantity, and its derivatives are zero.
    pub(crate) fn unknown(&self, reference: u32) -> Result<Option<usize>, Refusal> {
        let entry = self.real(reference)?;
        let is_unknown = entry.meta.causality == Causality::Output
            || entry.meta.derivative_of.is_some()
            || self.states.contains(&reference);
        if is_unknown {
            Ok(entry.quantity)
        } else {
            Err(Refusal::NotUnknown { name: entry.meta.name.clone() })
        }
    }

    /// Returns `true` if there are continuous inputs and all of them can change during a step.
    pub(crate) fn interpolates(&self) -> bool {
        let continuous = |one: &&Variable<M>| {
            one.meta.causality == Causality::Input && one.meta.variability == Variability::Continuous
        };
        let mut inputs = self.variables.iter().filter(continuous).peekable();
        inputs.peek().is_some() && inputs.all(|variable| variable.slope.is_some())
    }

    /// Returns the function that sets the rate of an input.
    pub(crate) fn slope(&self, reference: u32) -> Result<&Set<M, f64>, Refusal> {
        let entry = self.real(reference)?;
        entry.slope.as_ref().ok_or_else(|| Refusal::NotInterpolated { name: entry.meta.name.clone() })
    }

    /// Sets the rate of every input to zero.
    pub(crate) fn hold(&self, model: &mut M) {
        self.variables.iter().filter_map(|variable| variable.slope.as_ref()).for_each(|set| set(model, 0.0));
    }

    /// Returns the quantity of an output.
    pub(crate) fn output(&self, reference: u32) -> Result<Option<usize>, Refusal> {
        let entry = self.real(reference)?;
        match entry.meta.causality {
            Causality::Output => Ok(entry.quantity),
            _ => Err(Refusal::NotOutput { name: entry.meta.name.clone() }),
        }
    }

    fn real(&self, reference: u32) -> Result<&Variable<M>, Refusal> {
        let entry = self.entry(reference)?;
        f64::reach(&entry.access).map(|_| entry).ok_or_else(|| wrong_type::<M, f64>(entry))
    }

    /// Returns the entries in the order of their value references.
    pub fn variables(&self) -> &[Variable<M>] {
        &self.variables
    }

    /// Returns the value reference of a name.
    pub fn reference(&self, name: &str) -> Option<u32> {
        let position = self.variables.iter().position(|variable| variable.meta.name == name)?;
        u32::try_from(position).ok()
    }

    /// Returns `true` if a variable is a tunable parameter.
    pub(crate) fn is_tunable(&self, reference: u32) -> bool {
        self.variables.get(reference as usize).is_some_and(|one| is_tunable(&one.meta))
    }

    /// Reads a value.
    ///
    /// # Errors
    /// [`Refusal::UnknownReference`], [`Refusal::WrongType`].
    pub fn get<T: Value>(&self, model: &M, reference: u32) -> Result<T, Refusal> {
        let entry = self.entry(reference)?;
        let (get, _) = T::reach(&entry.access).ok_or_else(|| wrong_type::<M, T>(entry))?;
        Ok(get(model))
    }

    /// Checks that a variable may be set to `value` in the given phase.
    ///
    /// # Errors
    /// [`Refusal::UnknownReference`], [`Refusal::WrongType`], [`Refusal::NotSettable`], or the refusal of an invalid
    /// value.
    pub fn check<T: Value>(&self, reference: u32, value: &T, phase: Phase) -> Result<(), Refusal> {
        let entry = self.entry(reference)?;
        let (_, set) = T::reach(&entry.access).ok_or_else(|| wrong_type::<M, T>(entry))?;
        if set.is_none() || !may_be_set(entry, phase) {
            return Err(Refusal::NotSettable { name: entry.meta.name.clone(), phase: phase.name() });
        }
        value.check(&entry.meta.name, &entry.access)
    }

    /// Sets a value in any phase.
    ///
    /// # Errors
    /// [`Refusal::UnknownReference`], [`Refusal::WrongType`].
    pub fn set<T: Value>(&self, model: &mut M, reference: u32, value: T) -> Result<(), Refusal> {
        let entry = self.entry(reference)?;
        match T::reach(&entry.access) {
            Some((_, Some(set))) => {
                set(model, value);
                Ok(())
            }
            _ => Err(wrong_type::<M, T>(entry)),
        }
    }

    fn entry(&self, reference: u32) -> Result<&Variable<M>, Refusal> {
        let entry = self.variables.get(reference as usize);
        entry.ok_or_else(|| Refusal::UnknownReference { reference, count: self.variables.len() })
    }
}

fn wrong_type<M, T: Value>(entry: &Variable<M>) -> Refusal {
    Refusal::WrongType { name: entry.meta.name.clone(), expected: T::NAME }
}

fn is_tunable(meta: &ScalarVariable) -> bool {
    meta.causality == Causality::Parameter && meta.variability == Variability::Tunable
}

/// Returns `true` if a variable may be set in a phase (footnotes of the tables in sections 3.2.3 and 4.2.4).
fn may_be_set<M>(entry: &Variable<M>, phase: Phase) -> bool {
    let meta = &entry.meta;
    let is_input = meta.causality == Causality::Input;
    let varies = meta.variability != Variability::Constant;
    match phase {
        Phase::Instantiated => varies && meta.needs_start(),
        Phase::Initialization => is_input || (varies && meta.initial() == Some(Initial::Exact)),
        Phase::Continuous => is_input && meta.variability == Variability::Continuous,
        _ => is_input || is_tunable(meta),
    }
}
