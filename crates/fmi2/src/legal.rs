//! The legal function calls in each phase: the tables of sections 3.2.3 and 4.2.4 of FMI 2.0.4, combined.

use Phase::{Continuous, Error, Event, Initialization, Instantiated, Step, Terminated};

use crate::{Interface, Phase};

/// One row of the table.
struct Row {
    function: Function,
    name: &'static str,
    /// Interface that alone has the function; `None` means both.
    interface: Option<Interface>,
    phases: &'static [Phase],
}

const BOTH: Option<Interface> = None;
const ME: Option<Interface> = Some(Interface::ModelExchange);
const CS: Option<Interface> = Some(Interface::CoSimulation);

/// All phases. The standard allows no calls of a fatal instance; freeing is allowed here, to prevent leaks.
const EVERYWHERE: &[Phase] = &Phase::ALL;
const ALIVE: &[Phase] = &[Instantiated, Initialization, Step, Event, Continuous, Terminated, Error];
const READABLE: &[Phase] = &[Initialization, Step, Event, Continuous, Terminated, Error];
/// Phases with settable Reals; variables that change at events only cannot be set in continuous-time mode.
const SET_REAL: &[Phase] = &[Instantiated, Initialization, Step, Event, Continuous];
const SET_OTHER: &[Phase] = &[Instantiated, Initialization, Step, Event];
const RUNNING: &[Phase] = &[Step, Event, Continuous];
const MOVING: &[Phase] = &[Event, Continuous];
const COMPUTABLE: &[Phase] = &[Initialization, Event, Continuous, Terminated, Error];
const NOMINAL: &[Phase] = &[Instantiated, Event, Continuous, Terminated, Error];
const INPUT: &[Phase] = &[Instantiated, Initialization, Step];
const STEPPED: &[Phase] = &[Step, Terminated, Error];
const STATUS: &[Phase] = &[Step, Terminated];
const NOWHERE: &[Phase] = &[];

macro_rules! functions {
    ($($function:ident $name:literal $interface:ident $phases:expr;)*) => {
        /// The functions of FMI 2.0, one for each C symbol.
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        #[allow(missing_docs)]
        pub enum Function { $($function),* }

        /// The table, in the order of the functions.
        const LEGAL: &[Row] = &[
            $(Row { function: Function::$function, name: $name, interface: $interface, phases: $phases }),*
        ];
    };
}

// The comment of each row is the section of FMI 2.0.4 that describes the function.
functions! {
    GetTypesPlatform              "fmi2GetTypesPlatform"              BOTH EVERYWHERE; // 2.1.4
    GetVersion                    "fmi2GetVersion"                    BOTH EVERYWHERE; // 2.1.4
    Instantiate                   "fmi2Instantiate"                   BOTH EVERYWHERE; // 2.1.5
    FreeInstance                  "fmi2FreeInstance"                  BOTH EVERYWHERE; // 2.1.5
    SetDebugLogging               "fmi2SetDebugLogging"               BOTH ALIVE; // 2.1.5
    SetupExperiment               "fmi2SetupExperiment"               BOTH &[Instantiated]; // 2.1.6
    EnterInitializationMode       "fmi2EnterInitializationMode"       BOTH &[Instantiated]; // 2.1.6
    ExitInitializationMode        "fmi2ExitInitializationMode"        BOTH &[Initialization]; // 2.1.6
    Terminate                     "fmi2Terminate"                     BOTH RUNNING; // 2.1.6
    Reset                         "fmi2Reset"                         BOTH ALIVE; // 2.1.6
    GetReal                       "fmi2GetReal"                       BOTH READABLE; // 2.1.7
    GetInteger                    "fmi2GetInteger"                    BOTH READABLE; // 2.1.7
    GetBoolean                    "fmi2GetBoolean"                    BOTH READABLE; // 2.1.7
    GetString                     "fmi2GetString"                     BOTH READABLE; // 2.1.7
    SetReal                       "fmi2SetReal"                       BOTH SET_REAL; // 2.1.7
    SetInteger                    "fmi2SetInteger"                    BOTH SET_OTHER; // 2.1.7
    SetBoolean                    "fmi2SetBoolean"                    BOTH SET_OTHER; // 2.1.7
    SetString                     "fmi2SetString"                     BOTH SET_OTHER; // 2.1.7
    GetFmuState                   "fmi2GetFMUstate"                   BOTH ALIVE; // 2.1.8
    SetFmuState                   "fmi2SetFMUstate"                   BOTH ALIVE; // 2.1.8
    FreeFmuState                  "fmi2FreeFMUstate"                  BOTH ALIVE; // 2.1.8
    SerializedFmuStateSize        "fmi2SerializedFMUstateSize"        BOTH ALIVE; // 2.1.8
    SerializeFmuState             "fmi2SerializeFMUstate"             BOTH ALIVE; // 2.1.8
    DeserializeFmuState           "fmi2DeSerializeFMUstate"           BOTH ALIVE; // 2.1.8
    GetDirectionalDerivative      "fmi2GetDirectionalDerivative"      BOTH READABLE; // 2.1.9
    EnterEventMode                "fmi2EnterEventMode"                ME   MOVING; // 3.2.2
    NewDiscreteStates             "fmi2NewDiscreteStates"             ME   &[Event]; // 3.2.2
    EnterContinuousTimeMode       "fmi2EnterContinuousTimeMode"       ME   &[Event]; // 3.2.2
    CompletedIntegratorStep       "fmi2CompletedIntegratorStep"       ME   &[Continuous]; // 3.2.2
    SetTime                       "fmi2SetTime"                       ME   MOVING; // 3.2.1
    SetContinuousStates           "fmi2SetContinuousStates"           ME   &[Continuous]; // 3.2.1
    GetDerivatives                "fmi2GetDerivatives"                ME   COMPUTABLE; // 3.2.2
    GetEventIndicators            "fmi2GetEventIndicators"            ME   COMPUTABLE; // 3.2.2
    GetContinuousStates           "fmi2GetContinuousStates"           ME   COMPUTABLE; // 3.2.2
    GetNominalsOfContinuousStates "fmi2GetNominalsOfContinuousStates" ME   NOMINAL; // 3.2.2
    SetRealInputDerivatives       "fmi2SetRealInputDerivatives"       CS   INPUT; // 4.2.1
    GetRealOutputDerivatives      "fmi2GetRealOutputDerivatives"      CS   STEPPED; // 4.2.1
    DoStep                        "fmi2DoStep"                        CS   &[Step]; // 4.2.2
    CancelStep                    "fmi2CancelStep"                    CS   NOWHERE; // 4.2.2
    GetStatus                     "fmi2GetStatus"                     CS   STATUS; // 4.2.3
    GetRealStatus                 "fmi2GetRealStatus"                 CS   STATUS; // 4.2.3
    GetIntegerStatus              "fmi2GetIntegerStatus"              CS   STATUS; // 4.2.3
    GetBooleanStatus              "fmi2GetBooleanStatus"              CS   STATUS; // 4.2.3
    GetStringStatus               "fmi2GetStringStatus"               CS   STATUS; // 4.2.3
}

impl Function {
    /// Iterates over all functions.
    pub fn all() -> impl Iterator<Item = Self> {
        LEGAL.iter().map(|row| row.function)
    }

    fn row(self) -> &'static Row {
        &LEGAL[self as usize]
    }

    /// Returns the name in the standard.
    pub fn name(self) -> &'static str {
        self.row().name
    }

    /// Interface that alone has the function; `None` means both.
    pub fn interface(self) -> Option<Interface> {
        self.row().interface
    }

    /// Returns `true` if instances for the given interface have the function.
    pub fn belongs_to(self, interface: Interface) -> bool {
        self.row().interface.is_none_or(|own| own == interface)
    }

    /// Returns `true` if the function may be called in the given phase of an instance for the given interface.
    pub fn is_legal_in(self, phase: Phase, interface: Interface) -> bool {
        self.belongs_to(interface) && self.row().phases.contains(&phase)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_44_names_are_distinct_and_start_with_fmi2() {
        let names: std::collections::BTreeSet<_> = Function::all().map(Function::name).collect();
        assert_eq!(names.len(), 44);
        assert!(names.iter().all(|name| name.starts_with("fmi2")));
        let of_co_simulation =
            Function::all().filter(|function| function.belongs_to(Interface::CoSimulation));
        assert_eq!(of_co_simulation.count(), 34);
    }

    #[test]
    fn every_phase_of_a_function_occurs_in_its_interface() {
        for function in Function::all() {
            for &phase in function.row().phases {
                let some = [Interface::ModelExchange, Interface::CoSimulation]
                    .into_iter()
                    .any(|interface| phase.occurs_in(interface) && function.is_legal_in(phase, interface));
                assert!(some, "{} in {}", function.name(), phase.name());
            }
        }
    }
}
