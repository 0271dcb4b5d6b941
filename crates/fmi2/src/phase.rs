//! Which function may be called when (FMI 2.0.4, table in section 4.2.4).

use Phase::{Error, Fatal, Initialization, Instantiated, Step, Terminated};

/// State of a co-simulation instance.
///
/// `stepInProgress`, `stepFailed` and `stepCanceled` of the standard do not occur: a step is computed before
/// `fmi2DoStep` returns, and it is computed whole or not at all.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Phase {
    /// After `fmi2Instantiate` or `fmi2Reset`.
    Instantiated,
    /// Between `fmi2EnterInitializationMode` and `fmi2ExitInitializationMode`.
    Initialization,
    /// `stepComplete` of the standard: ready for `fmi2DoStep`.
    Step,
    /// After `fmi2Terminate`.
    Terminated,
    /// The model could not compute; reset, an earlier state, or free.
    Error,
    /// The FMU has a defect; only free.
    Fatal,
}

/// Functions that belong to an instance, by what the table says of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum Function {
    SetDebugLogging,
    FreeInstance,
    SetupExperiment,
    EnterInitializationMode,
    ExitInitializationMode,
    Terminate,
    Reset,
    Get,
    Set,
    GetFmuState,
    SetFmuState,
    FreeFmuState,
    SerializeFmuState,
    GetDirectionalDerivative,
    SetRealInputDerivatives,
    GetRealOutputDerivatives,
    DoStep,
    CancelStep,
    GetStatus,
}

const ALIVE: &[Phase] = &[Instantiated, Initialization, Step, Terminated, Error];
const READABLE: &[Phase] = &[Initialization, Step, Terminated, Error];

/// The table.
const LEGAL: [(Function, &str, &[Phase]); 19] = [
    (Function::SetDebugLogging, "fmi2SetDebugLogging", ALIVE),
    (
        Function::FreeInstance,
        "fmi2FreeInstance",
        &[Instantiated, Initialization, Step, Terminated, Error, Fatal],
    ),
    (Function::SetupExperiment, "fmi2SetupExperiment", &[Instantiated]),
    (Function::EnterInitializationMode, "fmi2EnterInitializationMode", &[Instantiated]),
    (Function::ExitInitializationMode, "fmi2ExitInitializationMode", &[Initialization]),
    (Function::Terminate, "fmi2Terminate", &[Step]),
    (Function::Reset, "fmi2Reset", ALIVE),
    (Function::Get, "fmi2GetXXX", READABLE),
    (Function::Set, "fmi2SetXXX", &[Instantiated, Initialization, Step]),
    (Function::GetFmuState, "fmi2GetFMUstate", ALIVE),
    (Function::SetFmuState, "fmi2SetFMUstate", ALIVE),
    (Function::FreeFmuState, "fmi2FreeFMUstate", ALIVE),
    (Function::SerializeFmuState, "serialization of the FMU state", ALIVE),
    (Function::GetDirectionalDerivative, "fmi2GetDirectionalDerivative", READABLE),
    (Function::SetRealInputDerivatives, "fmi2SetRealInputDerivatives", &[Instantiated, Initialization, Step]),
    (Function::GetRealOutputDerivatives, "fmi2GetRealOutputDerivatives", &[Step, Terminated, Error]),
    (Function::DoStep, "fmi2DoStep", &[Step]),
    (Function::CancelStep, "fmi2CancelStep", &[]),
    (Function::GetStatus, "fmi2GetXXXStatus", &[Step, Terminated]),
];

impl Function {
    /// All functions.
    pub fn all() -> impl Iterator<Item = Self> {
        LEGAL.iter().map(|row| row.0)
    }

    fn row(self) -> &'static (Function, &'static str, &'static [Phase]) {
        &LEGAL[self as usize]
    }

    /// Name in the standard.
    pub fn name(self) -> &'static str {
        self.row().1
    }

    /// Whether the function may be called in the given phase.
    pub fn is_legal_in(self, phase: Phase) -> bool {
        self.row().2.contains(&phase)
    }

    /// The phases in which the function may be called.
    pub fn legal_phases(self) -> &'static [Phase] {
        self.row().2
    }
}

impl Phase {
    /// All phases.
    pub const ALL: [Self; 6] = [Instantiated, Initialization, Step, Terminated, Error, Fatal];

    /// Name in the standard.
    pub fn name(self) -> &'static str {
        match self {
            Instantiated => "instantiated",
            Initialization => "initialization mode",
            Step => "step complete",
            Terminated => "terminated",
            Error => "error",
            Fatal => "fatal",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_stand_in_the_order_of_the_functions() {
        for (position, function) in Function::all().enumerate() {
            assert_eq!(function as usize, position, "{}", function.name());
        }
    }
}
