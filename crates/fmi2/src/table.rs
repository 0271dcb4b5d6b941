//! The table of variables at run time: value reference to entry.

use model_description::{Causality, Initial, Variability};

use crate::values::Value;
use crate::{Model, Phase, Refusal, Variable};

/// A model's variables; the value reference of a variable is its position.
#[derive(Debug)]
pub struct Table<M> {
    variables: Vec<Variable<M>>,
}

impl<M: Model> Table<M> {
    /// The table of a loaded model.
    pub fn of(model: &M) -> Self {
        Self { variables: model.variables() }
    }

    /// The entries in the order of their value references.
    pub fn variables(&self) -> &[Variable<M>] {
        &self.variables
    }

    /// Value reference of a name.
    pub fn reference(&self, name: &str) -> Option<u32> {
        let position = self.variables.iter().position(|variable| variable.meta.name == name)?;
        u32::try_from(position).ok()
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
    /// [`Refusal::UnknownReference`], [`Refusal::WrongType`], [`Refusal::NotSettable`], or that the variable cannot
    /// take the value.
    pub fn check<T: Value>(&self, reference: u32, value: &T, phase: Phase) -> Result<(), Refusal> {
        let entry = self.entry(reference)?;
        let (_, set) = T::reach(&entry.access).ok_or_else(|| wrong_type::<M, T>(entry))?;
        if set.is_none() || !may_be_set(entry, phase) {
            return Err(Refusal::NotSettable { name: entry.meta.name.clone(), phase: phase.name() });
        }
        value.check(&entry.meta.name, &entry.access)
    }

    /// Sets a value without looking at the phase.
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
        entry.ok_or(Refusal::UnknownReference { reference, count: self.variables.len() })
    }
}

fn wrong_type<M, T: Value>(entry: &Variable<M>) -> Refusal {
    Refusal::WrongType { name: entry.meta.name.clone(), wanted: T::NAME }
}

/// Footnotes of the table in section 4.2.4.
fn may_be_set<M>(entry: &Variable<M>, phase: Phase) -> bool {
    let meta = &entry.meta;
    let is_input = meta.causality == Causality::Input;
    let varies = meta.variability != Variability::Constant;
    match phase {
        Phase::Instantiated => varies && meta.needs_start(),
        Phase::Initialization => is_input || (varies && meta.initial() == Some(Initial::Exact)),
        _ => is_input || (meta.causality == Causality::Parameter && meta.variability == Variability::Tunable),
    }
}
