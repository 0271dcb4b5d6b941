//! The phases of an instance (FMI 2.0.4, state machines in sections 3.2.3 and 4.2.4).

use Phase::{Continuous, Error, Event, Fatal, Initialization, Instantiated, Step, Terminated};

/// Interface of an instance (`fmi2Type`).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Interface {
    /// Model exchange: the importer integrates (section 3).
    ModelExchange,
    /// Co-simulation: the FMU integrates (section 4).
    CoSimulation,
}

impl Interface {
    /// Returns the name for messages.
    pub fn name(self) -> &'static str {
        match self {
            Self::ModelExchange => "model exchange",
            Self::CoSimulation => "co-simulation",
        }
    }

    /// Returns the phase after `fmi2ExitInitializationMode`.
    pub(crate) fn first_phase(self) -> Phase {
        match self {
            Self::ModelExchange => Event,
            Self::CoSimulation => Step,
        }
    }
}

/// Phase of an instance in the state machine.
///
/// `stepInProgress`, `stepFailed` and `stepCanceled` of the standard do not occur: a step is computed before
/// `fmi2DoStep` returns, and it is computed completely or not at all.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Phase {
    /// Phase after `fmi2Instantiate` or `fmi2Reset`.
    Instantiated,
    /// Initialization mode, from `fmi2EnterInitializationMode` to `fmi2ExitInitializationMode`.
    Initialization,
    /// `stepComplete` of the standard: ready for `fmi2DoStep`; co-simulation only.
    Step,
    /// Event mode; model exchange only.
    Event,
    /// Continuous-time mode; model exchange only.
    Continuous,
    /// Phase after `fmi2Terminate`.
    Terminated,
    /// Failure of the model; the instance can only be reset, restored or freed.
    Error,
    /// Internal error of the FMU; the instance can only be freed.
    Fatal,
}

impl Phase {
    /// All phases.
    pub const ALL: [Self; 8] =
        [Instantiated, Initialization, Step, Event, Continuous, Terminated, Error, Fatal];

    /// Returns the name in the standard.
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

    /// Returns `true` if instances for the given interface can be in the phase.
    pub fn occurs_in(self, interface: Interface) -> bool {
        match self {
            Step => interface == Interface::CoSimulation,
            Event | Continuous => interface == Interface::ModelExchange,
            _ => true,
        }
    }
}
