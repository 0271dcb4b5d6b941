//! Tables of legal calls, copied from the standard by hand, against which the table of the crate is checked.

use squid_fmi2::{Function, Interface, Phase};

/// The table of section 4.2.4 of FMI 2.0.4, without states that do not occur here, and without functions that need no
/// instance.
pub const CO_SIMULATION: &str = "
                                   instantiated initialization step terminated error
    fmi2SetDebugLogging                 x            x          x       x        x
    fmi2SetupExperiment                 x            -          -       -        -
    fmi2EnterInitializationMode         x            -          -       -        -
    fmi2ExitInitializationMode          -            x          -       -        -
    fmi2Terminate                       -            -          x       -        -
    fmi2Reset                           x            x          x       x        x
    fmi2GetReal                         -            x          x       x        x
    fmi2GetInteger                      -            x          x       x        x
    fmi2GetBoolean                      -            x          x       x        x
    fmi2GetString                       -            x          x       x        x
    fmi2SetReal                         x            x          x       -        -
    fmi2SetInteger                      x            x          x       -        -
    fmi2SetBoolean                      x            x          x       -        -
    fmi2SetString                       x            x          x       -        -
    fmi2GetFMUstate                     x            x          x       x        x
    fmi2SetFMUstate                     x            x          x       x        x
    fmi2FreeFMUstate                    x            x          x       x        x
    fmi2SerializedFMUstateSize          x            x          x       x        x
    fmi2SerializeFMUstate               x            x          x       x        x
    fmi2DeSerializeFMUstate             x            x          x       x        x
    fmi2GetDirectionalDerivative        -            x          x       x        x
    fmi2SetRealInputDerivatives         x            x          x       -        -
    fmi2GetRealOutputDerivatives        -            -          x       x        x
    fmi2DoStep                          -            -          x       -        -
    fmi2CancelStep                      -            -          -       -        -
    fmi2GetStatus                       -            -          x       x        -
    fmi2GetRealStatus                   -            -          x       x        -
    fmi2GetIntegerStatus                -            -          x       x        -
    fmi2GetBooleanStatus                -            -          x       x        -
    fmi2GetStringStatus                 -            -          x       x        -
";

/// The table of section 3.2.3.
pub const MODEL_EXCHANGE: &str = "
                                   instantiated initialization event continuous terminated error
    fmi2SetDebugLogging                 x            x           x        x          x       x
    fmi2SetupExperiment                 x            -           -        -          -       -
    fmi2EnterInitializationMode         x            -           -        -          -       -
    fmi2ExitInitializationMode          -            x           -        -          -       -
    fmi2Terminate                       -            -           x        x          -       -
    fmi2Reset                           x            x           x        x          x       x
    fmi2GetReal                         -            x           x        x          x       x
    fmi2GetInteger                      -            x           x        x          x       x
    fmi2GetBoolean                      -            x           x        x          x       x
    fmi2GetString                       -            x           x        x          x       x
    fmi2SetReal                         x            x           x        x          -       -
    fmi2SetInteger                      x            x           x        -          -       -
    fmi2SetBoolean                      x            x           x        -          -       -
    fmi2SetString                       x            x           x        -          -       -
    fmi2GetFMUstate                     x            x           x        x          x       x
    fmi2SetFMUstate                     x            x           x        x          x       x
    fmi2FreeFMUstate                    x            x           x        x          x       x
    fmi2SerializedFMUstateSize          x            x           x        x          x       x
    fmi2SerializeFMUstate               x            x           x        x          x       x
    fmi2DeSerializeFMUstate             x            x           x        x          x       x
    fmi2GetDirectionalDerivative        -            x           x        x          x       x
    fmi2EnterEventMode                  -            -           x        x          -       -
    fmi2NewDiscreteStates               -            -           x        -          -       -
    fmi2EnterContinuousTimeMode         -            -           x        -          -       -
    fmi2CompletedIntegratorStep         -            -           -        x          -       -
    fmi2SetTime                         -            -           x        x          -       -
    fmi2SetContinuousStates             -            -           -        x          -       -
    fmi2GetDerivatives                  -            x           x        x          x       x
    fmi2GetEventIndicators              -            x           x        x          x       x
    fmi2GetContinuousStates             -            x           x        x          x       x
    fmi2GetNominalsOfContinuousStates   x            -           x        x          x       x
";

/// Returns `true` if the standard allows a function in a state; `None` if the interface does not have the function.
pub fn standard(function: Function, interface: Interface, phase: Phase) -> Option<bool> {
    let (table, phases): (_, &[Phase]) = match interface {
        Interface::CoSimulation => (
            CO_SIMULATION,
            &[Phase::Instantiated, Phase::Initialization, Phase::Step, Phase::Terminated, Phase::Error],
        ),
        Interface::ModelExchange => (
            MODEL_EXCHANGE,
            &[
                Phase::Instantiated,
                Phase::Initialization,
                Phase::Event,
                Phase::Continuous,
                Phase::Terminated,
                Phase::Error,
            ],
        ),
    };
    let mut rows = table.lines().map(|line| line.split_whitespace().collect::<Vec<_>>());
    let row = rows.find(|row| row.first() == Some(&function.name()))?;
    assert_eq!(row.len(), phases.len() + 1, "{row:?}");
    // No call is allowed after a fatal error.
    let column = phases.iter().position(|one| *one == phase);
    Some(column.is_some_and(|column| row[column + 1] == "x"))
}
