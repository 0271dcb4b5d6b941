//! Stored states of an instance: `fmi2GetFMUstate` to `fmi2DeSerializeFMUstate` (section 2.1.8).

use crate::states::bytes::{Identity, StateReader, StateWriter};
use crate::{Interface, Model, Phase, SavedState, StateError};

/// Step to which the rates of the inputs belong.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Slopes {
    /// No step: all inputs are held.
    None,
    /// The next step.
    Ahead,
    /// The last step; the rates remain valid at its end.
    Flown,
}

impl Slopes {
    const ALL: [Self; 3] = [Self::None, Self::Ahead, Self::Flown];
}

/// Start, stop and tolerance of `fmi2SetupExperiment`, times in s.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Experiment {
    /// Start time.
    pub start: f64,
    /// Latest time at which a step may end.
    pub stop: Option<f64>,
    /// Relative tolerance; models with a fixed accuracy ignore it.
    pub tolerance: Option<f64>,
}

/// Complete state of an instance.
#[derive(Debug, Clone)]
#[repr(C)]
pub struct Snapshot<M> {
    /// Identity of the FMU. It is the first field, so that it can be checked before any other is read.
    pub(crate) identity: Identity,
    pub(crate) interface: Interface,
    pub(crate) phase: Phase,
    pub(crate) experiment: Experiment,
    pub(crate) time: f64,
    /// `true` if a variable was set after the outputs were computed.
    pub(crate) stale: bool,
    pub(crate) slopes: Slopes,
    pub(crate) model: M,
}

impl<M: Model> Snapshot<M> {
    /// Creates the state of a new instance.
    pub(crate) fn fresh(model: &M, identity: Identity, interface: Interface) -> Self {
        Self {
            identity,
            interface,
            phase: Phase::Instantiated,
            experiment: Experiment::default(),
            time: 0.0,
            stale: true,
            slopes: Slopes::None,
            model: model.clone(),
        }
    }

    pub(crate) fn save(&self) -> Result<Vec<u8>, StateError> {
        let mut state = StateWriter::default();
        self.clone().pass(&mut state)?;
        Ok(state.sealed(&self.identity))
    }

    pub(crate) fn restore(bytes: &[u8], fresh: &M, identity: &Identity) -> Result<Self, StateError> {
        let mut state = StateReader::unsealed(bytes, identity)?;
        let mut snapshot = Self::fresh(fresh, *identity, Interface::CoSimulation);
        snapshot.pass(&mut state)?;
        state.finish()?;
        Ok(snapshot)
    }

    /// Writes or reads all fields but the identity.
    fn pass(&mut self, state: &mut dyn SavedState) -> Result<(), StateError> {
        let mut steps_itself = self.interface == Interface::CoSimulation;
        state.boolean(&mut steps_itself)?;
        self.interface = if steps_itself { Interface::CoSimulation } else { Interface::ModelExchange };
        let mut number = self.phase as u64;
        state.integer(&mut number)?;
        let phase = Phase::ALL.into_iter().find(|phase| *phase as u64 == number);
        let possible = phase.filter(|phase| *phase != Phase::Fatal && phase.occurs_in(self.interface));
        self.phase = possible.ok_or_else(|| StateError::inconsistent(format_args!("the phase {number}")))?;
        let mut limit = |limit: Option<f64>| {
            let (mut given, mut value) = (limit.is_some(), limit.unwrap_or(0.0));
            state.boolean(&mut given)?;
            state.real(&mut value)?;
            Ok::<_, StateError>((given, value))
        };
        let Experiment { start, stop, tolerance } = self.experiment;
        let [start, stop, tolerance] = [limit(Some(start))?, limit(stop)?, limit(tolerance)?];
        let given = |(given, value): (bool, f64)| given.then_some(value);
        self.experiment = Experiment { start: start.1, stop: given(stop), tolerance: given(tolerance) };
        state.real(&mut self.time)?;
        state.boolean(&mut self.stale)?;
        let mut number = self.slopes as u64;
        state.integer(&mut number)?;
        let slopes = Slopes::ALL.into_iter().find(|slopes| *slopes as u64 == number);
        self.slopes = slopes.ok_or_else(|| StateError::inconsistent(format_args!("the slopes {number}")))?;
        self.model.pass_state(state)
    }
}
