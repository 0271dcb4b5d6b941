//! The phases of an instance (FMI 2.0.4, state machines in sections 3.2.3 and 4.2.4).

use Phase::{Continuous, Error, Event, Fatal, Initialization, Instantiated, Step, Terminated};

/// What an instance was made for (`fmi2Type`).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Interface {
    /// The importer integrates (section 3).
    ModelExchange,
    /// The FMU steps itself (section 4).
    CoSimulation,
}

impl Interface {
    /// Name in prose.
    pub fn name(self) -> &'static str {
        match self {
            Self::ModelExchange => "model exchange",
            Self::CoSimulation => "co-simulation",
        }
    }

    /// The phase after `fmi2ExitInitializationMode`.
    pub(crate) fn first_phase(self) -> Phase {
        match self {
            Self::ModelExchange => Event,
            Self::CoSimulation => Step,
        }
    }
}

/// State of an instance.
///
/// `stepInProgress`, `stepFailed` and `stepCanceled` of the standard do not occur: a step is computed before
/// `fmi2DoStep` returns, and it is computed completely or not at all.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Phase {
    /// After `fmi2Instantiate` or `fmi2Reset`.
    Instantiated,
    /// Between `fmi2EnterInitializationMode` and `fmi2ExitInitializationMode`.
    Initialization,
    /// `stepComplete` of the standard: ready for `fmi2DoStep`; co-simulation only.
    Step,
    /// Event mode; model exchange only.
    Event,
    /// Continuous-time mode; model exchange only.
    Continuous,
    /// After `fmi2Terminate`.
    Terminated,
    /// The model could not compute; only reset, an earlier state, or free.
    Error,
    /// The FMU has a defect; only free.
    Fatal,
}

impl Phase {
    /// All phases.
    pub const ALL: [Self; 8] =
        [Instantiated, Initialization, Step, Event, Continuous, Terminated, Error, Fatal];

    /// Name in the standard.
    pub fn name(self) -> &'static str {
        match self {
            Instantiated => "instantiated",
            Initialization => "initialization mode",
            Step => "step complete",
            Event => "event mode",
            Continuous => "continuous-time mode",
            Terminated => "terminated",
            Error => "error",
            Fatal => "fatal",
        }
    }

    /// Whether an instance of this kind can ever be in the phase.
    pub fn occurs_in(self, interface: Interface) -> bool {
        match self {
            Step => interface == Interface::CoSimulation,
            Event | Continuous => interface == Interface::ModelExchange,
            _ => true,
        }
    }
}
