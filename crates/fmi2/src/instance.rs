//! Life cycle of one instance of a model, without the C interface.

use crate::refusal::Failure;
use crate::states::bytes::identity;
use crate::states::snapshot::Slopes;
use crate::variables::values::Value;
use crate::{Described, Experiment, Function, Interface, Log, Model, Phase, Refusal, Snapshot, Table};

/// Longest step allowed \[s\], a day: a longer one is probably a mistake, and its computation would take long.
const LONGEST_STEP: f64 = 86_400.0;

/// Returns the largest rounding difference between two computations of a time \[s\]: a nanosecond plus some units in
/// the last place.
pub fn rounding_of_time(time: f64) -> f64 {
    1e-9 + 16.0 * f64::EPSILON * time.abs()
}

/// A running model: life cycle, time and access to variables.
#[derive(Debug)]
pub struct Instance<M: Model> {
    pub(crate) table: Table<M>,
    pub(crate) fresh: M,
    pub(crate) now: Snapshot<M>,
    /// Workspace for derivatives.
    pub(crate) tangents: Vec<f64>,
    pub(crate) rates: Vec<f64>,
}

pub(crate) type Outcome<M> = Result<(), Failure<<M as Model>::Error>>;

impl<M: Model> Instance<M> {
    /// Creates an instance of a described model for co-simulation.
    pub fn new(described: Described<M>) -> Self {
        Self::made_for(Interface::CoSimulation, described)
    }

    /// Creates an instance of a described model for an interface.
    pub fn made_for(interface: Interface, described: Described<M>) -> Self {
        Self::of(interface, described.model, described.table, &described.guid)
    }

    /// Creates an instance of a loaded model.
    pub(crate) fn of(interface: Interface, fresh: M, table: Table<M>, guid: &str) -> Self {
        let now = Snapshot::fresh(&fresh, identity(guid), interface);
        let (tangents, rates) = (vec![0.0; fresh.quantities()], vec![0.0; table.states().len()]);
        Self { table, fresh, now, tangents, rates }
    }

    /// Returns the phase of the instance.
    pub fn phase(&self) -> Phase {
        self.now.phase
    }

    /// Returns the end of the last step in s.
    pub fn time(&self) -> f64 {
        self.now.time
    }

    /// Returns the table of variables.
    pub fn table(&self) -> &Table<M> {
        &self.table
    }

    /// Returns the model.
    pub fn model(&self) -> &M {
        &self.now.model
    }

    /// Checks that the state table allows a function in the current phase.
    ///
    /// # Errors
    /// [`Refusal::IllegalCall`], [`Refusal::OtherInterface`].
    pub fn allows(&self, function: Function) -> Result<(), Refusal> {
        let Snapshot { phase, interface, .. } = self.now;
        if function.is_legal_in(phase, interface) {
            return Ok(());
        }
        match function.interface().filter(|needed| *needed != interface) {
            Some(needed) => {
                Err(Refusal::OtherInterface { needed: needed.name(), interface: interface.name() })
            }
            None => Err(Refusal::IllegalCall { phase: phase.name() }),
        }
    }

    /// `fmi2SetupExperiment`.
    ///
    /// # Errors
    /// [`Refusal::IllegalCall`], [`Refusal::BadExperiment`].
    pub fn set_up(&mut self, experiment: Experiment) -> Result<(), Refusal> {
        self.allows(Function::SetupExperiment)?;
        let (start, stop) = (experiment.start, experiment.stop.unwrap_or(f64::INFINITY));
        let tolerance = experiment.tolerance.unwrap_or(0.0);
        let possible = start.is_finite() && stop >= start && experiment.stop.is_none_or(f64::is_finite);
        if !possible || !tolerance.is_finite() || tolerance < 0.0 {
            return Err(Refusal::BadExperiment { start, stop, tolerance });
        }
        self.now.experiment = experiment;
        self.now.time = start;
        Ok(())
    }

    /// `fmi2EnterInitializationMode`.
    ///
    /// # Errors
    /// [`Refusal::IllegalCall`].
    pub fn enter_initialization(&mut self) -> Result<(), Refusal> {
        self.allows(Function::EnterInitializationMode)?;
        self.now.phase = Phase::Initialization;
        self.now.stale = true;
        Ok(())
    }

    /// `fmi2ExitInitializationMode`.
    ///
    /// # Errors
    /// [`Refusal::IllegalCall`], or a failure of the model to find an initial state.
    pub fn exit_initialization(&mut self, log: &mut dyn Log) -> Outcome<M> {
        self.allows(Function::ExitInitializationMode)?;
        self.update(log)?;
        self.now.phase = self.now.interface.first_phase();
        Ok(())
    }

    /// `fmi2DoStep` from `at` over `size`, both in s.
    ///
    /// The time `at` may differ from the end of the last step by [`rounding_of_time`], because importers compute it
    /// differently.
    ///
    /// # Errors
    /// A refused call, or a failure of the model to compute the step.
    pub fn step(&mut self, at: f64, size: f64, log: &mut dyn Log) -> Outcome<M> {
        self.allows(Function::DoStep)?;
        let time = self.now.time;
        let end = at + size;
        let rounding = rounding_of_time(time);
        if !at.is_finite() || (at - time).abs() > rounding {
            return Err(Refusal::WrongCommunicationPoint { given: at, expected: time }.into());
        }
        if size.is_nan() || size <= 0.0 || size > LONGEST_STEP {
            return Err(Refusal::BadStepSize { size, longest: LONGEST_STEP }.into());
        }
        if end <= time {
            return Err(Refusal::StepTooShort { size, time }.into());
        }
        if let Some(stop) = self.now.experiment.stop.filter(|stop| end > stop + rounding) {
            return Err(Refusal::BeyondStopTime { end, stop }.into());
        }
        self.forget_flown_slopes();
        let outcome = self.now.model.step(time, end, log);
        self.settle(outcome)?;
        if self.now.slopes == Slopes::Ahead {
            self.now.slopes = Slopes::Flown;
        }
        self.now.time = end;
        self.now.stale = false;
        Ok(())
    }

    /// `fmi2Terminate`.
    ///
    /// # Errors
    /// [`Refusal::IllegalCall`].
    pub fn terminate(&mut self) -> Result<(), Refusal> {
        self.allows(Function::Terminate)?;
        self.now.phase = Phase::Terminated;
        Ok(())
    }

    /// `fmi2Reset`.
    ///
    /// # Errors
    /// [`Refusal::IllegalCall`].
    pub fn reset(&mut self) -> Result<(), Refusal> {
        self.allows(Function::Reset)?;
        self.now = Snapshot::fresh(&self.fresh, self.now.identity, self.now.interface);
        Ok(())
    }

    /// `fmi2GetXXX`: passes each value to `take` with its position in `references`.
    ///
    /// # Errors
    /// A refused call, or a failure of the model to compute its outputs. [`Refusal::Undefined`] if a value is not
    /// finite; all values are passed to `take` nevertheless.
    pub fn get<T: Value>(
        &mut self,
        references: &[u32],
        log: &mut dyn Log,
        mut take: impl FnMut(usize, T),
    ) -> Outcome<M> {
        self.allows(T::GET)?;
        self.update(log)?;
        let mut undefined = None;
        for (position, &reference) in references.iter().enumerate() {
            let value: T = self.table.get(&self.now.model, reference)?;
            if value.undefined().is_some() {
                undefined = undefined.or(Some(reference));
            }
            take(position, value);
        }
        undefined.map_or(Ok(()), |reference| self.refuse_undefined::<T>(reference))
    }

    #[cold]
    fn refuse_undefined<T: Value>(&self, reference: u32) -> Outcome<M> {
        let value: T = self.table.get(&self.now.model, reference)?;
        let (name, value) = (self.name(reference), value.undefined().unwrap_or(f64::NAN));
        Err(Refusal::Undefined { what: "variable", name, value }.into())
    }

    /// `fmi2SetXXX`: sets all values, or none if one is refused.
    ///
    /// # Errors
    /// A refused call.
    pub fn set<T: Value>(&mut self, references: &[u32], value: impl Fn(usize) -> T) -> Result<(), Refusal> {
        self.allows(T::SET)?;
        for (position, &reference) in references.iter().enumerate() {
            self.table.check(reference, &value(position), self.now.phase)?;
        }
        self.tune(references, &value)?;
        for (position, &reference) in references.iter().enumerate() {
            self.table.set(&mut self.now.model, reference, value(position))?;
        }
        self.now.stale = true;
        Ok(())
    }

    /// Sets the tunable parameters of a running model, before all other variables: if the model refuses a value, it
    /// restores the parameters, and no other variable has been set.
    pub(crate) fn tune<T: Value>(
        &mut self,
        references: &[u32],
        value: impl Fn(usize) -> T,
    ) -> Result<(), Refusal> {
        if !matches!(self.now.phase, Phase::Step | Phase::Event) {
            return Ok(());
        }
        let mut any = false;
        for (position, &reference) in references.iter().enumerate() {
            if self.table.is_tunable(reference) {
                self.table.set(&mut self.now.model, reference, value(position))?;
                any = true;
            }
        }
        let outcome = if any { self.now.model.tune() } else { Ok(()) };
        outcome.map_err(|error| Refusal::NotTuned { reason: error.to_string() })
    }

    /// Sets the phase to fatal after a panic.
    pub(crate) fn abandon(&mut self) {
        self.now.phase = Phase::Fatal;
    }

    /// Updates the outputs if a variable was set.
    pub(crate) fn update(&mut self, log: &mut dyn Log) -> Outcome<M> {
        if !self.now.stale {
            return Ok(());
        }
        let outcome = match self.now.phase {
            Phase::Initialization => self.now.model.initialise(self.now.experiment.start, log),
            Phase::Step | Phase::Event | Phase::Continuous | Phase::Terminated => {
                self.now.model.apply_inputs()
            }
            _ => Ok(()),
        };
        self.settle(outcome)?;
        self.now.stale = false;
        Ok(())
    }

    /// Holds the inputs whose rates belong to a completed step.
    pub(crate) fn forget_flown_slopes(&mut self) {
        if self.now.slopes == Slopes::Flown {
            self.table.hold(&mut self.now.model);
            self.now.slopes = Slopes::None;
        }
    }

    pub(crate) fn settle(&mut self, outcome: Result<(), M::Error>) -> Outcome<M> {
        outcome.map_err(|error| {
            self.now.phase = Phase::Error;
            Failure::Model(error)
        })
    }
}
