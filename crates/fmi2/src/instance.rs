//! One instance of a model, from instantiation to the end, without any C.

use std::sync::Arc;

use crate::refusal::Failure;
use crate::values::Value;
use crate::{Described, Function, Log, Model, Phase, Refusal, Table};

/// Start, stop and tolerance of `fmi2SetupExperiment`, times in s.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Experiment {
    /// Start time.
    pub start: f64,
    /// Time after which no step may end.
    pub stop: Option<f64>,
    /// Relative tolerance; models with a fixed accuracy ignore it.
    pub tolerance: Option<f64>,
}

/// A running model: life cycle, time and access to variables.
#[derive(Debug)]
pub struct Instance<M: Model> {
    table: Arc<Table<M>>,
    fresh: M,
    now: Snapshot<M>,
}

/// Everything of an instance that changes.
#[derive(Debug, Clone)]
pub struct Snapshot<M> {
    model: M,
    phase: Phase,
    experiment: Experiment,
    time: f64,
    /// A variable was set since the outputs were computed.
    stale: bool,
}

impl<M: Clone> Snapshot<M> {
    fn start(model: &M) -> Self {
        let experiment = Experiment::default();
        Self { model: model.clone(), phase: Phase::Instantiated, experiment, time: 0.0, stale: true }
    }
}

type Outcome<M> = Result<(), Failure<<M as Model>::Error>>;

impl<M: Model> Instance<M> {
    /// An instance of a described model.
    pub fn new(described: Described<M>) -> Self {
        let now = Snapshot::start(&described.model);
        Self { table: Arc::new(described.table), fresh: described.model, now }
    }

    /// Where the instance stands in its life.
    pub fn phase(&self) -> Phase {
        self.now.phase
    }

    /// End of the last step in s.
    pub fn time(&self) -> f64 {
        self.now.time
    }

    /// The table of variables.
    pub fn table(&self) -> &Table<M> {
        &self.table
    }

    /// The model itself.
    pub fn model(&self) -> &M {
        &self.now.model
    }

    /// Whether the state table allows a function now.
    ///
    /// # Errors
    /// [`Refusal::IllegalCall`].
    pub fn allows(&self, function: Function) -> Result<(), Refusal> {
        if function.is_legal_in(self.now.phase) {
            return Ok(());
        }
        Err(Refusal::IllegalCall { phase: self.now.phase.name() })
    }

    /// `fmi2SetupExperiment`.
    ///
    /// # Errors
    /// [`Refusal::IllegalCall`], [`Refusal::BadExperiment`].
    pub fn set_up(&mut self, experiment: Experiment) -> Result<(), Refusal> {
        self.allows(Function::SetupExperiment)?;
        let (start, stop) = (experiment.start, experiment.stop.unwrap_or(f64::MAX));
        let tolerance = experiment.tolerance.unwrap_or(0.0);
        let possible = start.is_finite() && stop.is_finite() && stop >= start;
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
    /// [`Refusal::IllegalCall`], or that the model finds no initial state.
    pub fn exit_initialization(&mut self, log: &mut dyn Log) -> Outcome<M> {
        self.allows(Function::ExitInitializationMode)?;
        self.update(log)?;
        self.now.phase = Phase::Step;
        Ok(())
    }

    /// `fmi2DoStep` from `at` over `size`, both in s.
    ///
    /// Importers reckon time in several ways, so `at` may differ from the end of the last step by rounding:
    /// `|at - time| <= 1e-9 max(1 s, |time|)`.
    ///
    /// # Errors
    /// A refused call, or that the model could not compute the step.
    pub fn step(&mut self, at: f64, size: f64, log: &mut dyn Log) -> Outcome<M> {
        self.allows(Function::DoStep)?;
        let time = self.now.time;
        let end = at + size;
        let rounding = 1e-9 * time.abs().max(1.0);
        if !at.is_finite() || (at - time).abs() > rounding {
            return Err(Refusal::WrongCommunicationPoint { given: at, expected: time }.into());
        }
        if !end.is_finite() || size <= 0.0 || end <= time {
            return Err(Refusal::BadStepSize { size }.into());
        }
        if let Some(stop) = self.now.experiment.stop.filter(|stop| end > stop + rounding) {
            return Err(Refusal::BeyondStopTime { end, stop }.into());
        }
        let outcome = self.now.model.step(time, end, log);
        self.settle(outcome)?;
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
        self.now = Snapshot::start(&self.fresh);
        Ok(())
    }

    /// `fmi2GetXXX`: hands each value to `take` with its position in `references`.
    ///
    /// # Errors
    /// A refused call, or that the model could not compute its outputs.
    pub fn get<T: Value>(
        &mut self,
        references: &[u32],
        log: &mut dyn Log,
        mut take: impl FnMut(usize, T),
    ) -> Outcome<M> {
        self.allows(Function::Get)?;
        self.update(log)?;
        for (position, &reference) in references.iter().enumerate() {
            take(position, self.table.get(&self.now.model, reference)?);
        }
        Ok(())
    }

    /// `fmi2SetXXX`: sets all of the values, or none if one is refused.
    ///
    /// # Errors
    /// A refused call.
    pub fn set<T: Value>(&mut self, references: &[u32], value: impl Fn(usize) -> T) -> Result<(), Refusal> {
        self.allows(Function::Set)?;
        for (position, &reference) in references.iter().enumerate() {
            self.table.check(reference, &value(position), self.now.phase)?;
        }
        for (position, &reference) in references.iter().enumerate() {
            self.table.set(&mut self.now.model, reference, value(position))?;
        }
        self.now.stale = true;
        Ok(())
    }

    /// `fmi2GetDirectionalDerivative`.
    ///
    /// # Errors
    /// A refused call, [`Refusal::Unsupported`], or that the model could not compute it.
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
        let derivative = M::directional_derivative().ok_or(Refusal::Unsupported { flag })?;
        self.update(log)?;
        for &reference in unknowns.iter().chain(knowns) {
            self.table.get::<f64>(&self.now.model, reference)?;
        }
        derivative(&self.now.model, unknowns, knowns, seed, sensitivity).map_err(Failure::Model)
    }

    /// `fmi2GetFMUstate`.
    ///
    /// # Errors
    /// [`Refusal::IllegalCall`].
    pub fn snapshot(&self) -> Result<Snapshot<M>, Refusal> {
        self.allows(Function::GetFmuState)?;
        Ok(self.now.clone())
    }

    /// `fmi2SetFMUstate`.
    ///
    /// # Errors
    /// [`Refusal::IllegalCall`].
    pub fn restore(&mut self, snapshot: &Snapshot<M>) -> Result<(), Refusal> {
        self.allows(Function::SetFmuState)?;
        self.now = snapshot.clone();
        Ok(())
    }

    /// Gives the instance up after a panic.
    pub(crate) fn abandon(&mut self) {
        self.now.phase = Phase::Fatal;
    }

    /// Brings the outputs up to date with what was set.
    fn update(&mut self, log: &mut dyn Log) -> Outcome<M> {
        if !self.now.stale {
            return Ok(());
        }
        let outcome = match self.now.phase {
            Phase::Initialization => self.now.model.initialise(self.now.experiment.start, log),
            Phase::Step => self.now.model.refresh(),
            _ => Ok(()),
        };
        self.settle(outcome)?;
        self.now.stale = false;
        Ok(())
    }

    fn settle(&mut self, outcome: Result<(), M::Error>) -> Outcome<M> {
        outcome.map_err(|error| {
            self.now.phase = Phase::Error;
            Failure::Model(error)
        })
    }
}
