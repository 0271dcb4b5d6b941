//! Every function in every state, through the C ABI: legal calls work; illegal calls are refused with one sentence and
//! change nothing.

use std::ffi::c_int;
use std::ptr::{null, null_mut};

use crate::importer::*;
use crate::standard::{CO_SIMULATION, MODEL_EXCHANGE, standard};
use squid_fmi2::abi::{Component, EventInfo, FmuState, Status};
use squid_fmi2::{Function, Interface, Phase};

const BOTH: [Interface; 2] = [Interface::ModelExchange, Interface::CoSimulation];
const COUNT: u32 = 3;
const ARMED: u32 = 4;
const LABEL: u32 = 5;
const METHOD: u32 = 6;
const RATE: u32 = 8;

/// Returns a new instance in the given phase.
fn in_phase(fmu: &Unpacked, interface: Interface, phase: Phase) -> Component {
    let c = fmu.made_for(interface, false);
    unsafe {
        match phase {
            Phase::Instantiated => {}
            Phase::Initialization => {
                fmi2EnterInitializationMode(c);
            }
            Phase::Step | Phase::Event => initialise(c),
            Phase::Continuous => {
                initialise(c);
                fmi2EnterContinuousTimeMode(c);
            }
            Phase::Terminated => {
                initialise(c);
                fmi2Terminate(c);
            }
            Phase::Error => {
                fmi2SetReal(c, &GAIN, 1, &0.0);
                fmi2EnterInitializationMode(c);
                fmi2ExitInitializationMode(c);
            }
            Phase::Fatal => {
                fmi2SetInteger(c, &METHOD, 1, &2);
                initialise(c);
                match interface {
                    Interface::CoSimulation => fmi2DoStep(c, 0.0, 1.0, 1),
                    Interface::ModelExchange => fmi2NewDiscreteStates(c, &mut EventInfo::default()),
                };
            }
        }
    }
    messages();
    c
}

/// A state of another instance, for the functions on states.
struct Stored {
    owner: Component,
    state: FmuState,
    bytes: Vec<u8>,
}

impl Stored {
    fn new(fmu: &Unpacked, interface: Interface) -> Self {
        let owner = fmu.made_for(interface, false);
        initialise(owner);
        let (mut state, mut size) = (null_mut(), 0);
        unsafe {
            assert_eq!(fmi2GetFMUstate(owner, &mut state), Status::Ok);
            assert_eq!(fmi2SerializedFMUstateSize(owner, state, &mut size), Status::Ok);
            let mut bytes = vec![0; size];
            assert_eq!(fmi2SerializeFMUstate(owner, state, bytes.as_mut_ptr(), size), Status::Ok);
            Self { owner, state, bytes }
        }
    }
}

impl Drop for Stored {
    fn drop(&mut self) {
        unsafe {
            fmi2FreeFMUstate(self.owner, &mut self.state);
            fmi2FreeInstance(self.owner);
        }
    }
}

/// Calls a function with arguments that are valid in a phase that allows it.
fn call(c: Component, function: Function, stored: &Stored) -> Status {
    let (mut real, mut integer, mut text, mut state) = (0.0, 0, null(), null_mut());
    let mut bytes = stored.bytes.clone();
    let size = bytes.len();
    unsafe {
        match function {
            Function::GetTypesPlatform | Function::GetVersion | Function::Instantiate => {
                unreachable!("has no instance")
            }
            Function::FreeInstance => unreachable!("has no status"),
            Function::SetDebugLogging => fmi2SetDebugLogging(c, 0, 0, null()),
            Function::SetupExperiment => fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0),
            Function::EnterInitializationMode => fmi2EnterInitializationMode(c),
            Function::ExitInitializationMode => fmi2ExitInitializationMode(c),
            Function::Terminate => fmi2Terminate(c),
            Function::Reset => fmi2Reset(c),
            Function::GetReal => fmi2GetReal(c, &Y, 1, &mut real),
            Function::GetInteger => fmi2GetInteger(c, &COUNT, 1, &mut integer),
            Function::GetBoolean => fmi2GetBoolean(c, &ARMED, 1, &mut integer),
            Function::GetString => fmi2GetString(c, &LABEL, 1, &mut text),
            Function::SetReal => fmi2SetReal(c, &U, 1, &1.0),
            Function::SetBoolean => fmi2SetBoolean(c, &ARMED, 1, &1),
            Function::SetInteger => fmi2SetInteger(c, null(), 0, null()),
            Function::SetString => fmi2SetString(c, null(), 0, null()),
            Function::GetFmuState => {
                let status = fmi2GetFMUstate(c, &mut state);
                fmi2FreeFMUstate(stored.owner, &mut state);
                status
            }
            Function::SetFmuState => fmi2SetFMUstate(c, stored.state),
            Function::FreeFmuState => fmi2FreeFMUstate(c, &mut state),
            Function::SerializedFmuStateSize => fmi2SerializedFMUstateSize(c, stored.state, &mut bytes.len()),
            Function::SerializeFmuState => fmi2SerializeFMUstate(c, stored.state, bytes.as_mut_ptr(), size),
            Function::DeserializeFmuState => {
                let status = fmi2DeSerializeFMUstate(c, bytes.as_ptr(), size, &mut state);
                fmi2FreeFMUstate(stored.owner, &mut state);
                status
            }
            Function::GetDirectionalDerivative => {
                fmi2GetDirectionalDerivative(c, &Y, 1, &U, 1, &1.0, &mut real)
            }
            Function::EnterEventMode => fmi2EnterEventMode(c),
            Function::NewDiscreteStates => fmi2NewDiscreteStates(c, &mut EventInfo::default()),
            Function::EnterContinuousTimeMode => fmi2EnterContinuousTimeMode(c),
            Function::CompletedIntegratorStep => fmi2CompletedIntegratorStep(c, 1, &mut integer, &mut 0),
            Function::SetTime => fmi2SetTime(c, 0.5),
            Function::SetContinuousStates => fmi2SetContinuousStates(c, &0.5, 1),
            Function::GetDerivatives => fmi2GetDerivatives(c, &mut real, 1),
            Function::GetEventIndicators => fmi2GetEventIndicators(c, null_mut(), 0),
            Function::GetContinuousStates => fmi2GetContinuousStates(c, &mut real, 1),
            Function::GetNominalsOfContinuousStates => fmi2GetNominalsOfContinuousStates(c, &mut real, 1),
            Function::SetRealInputDerivatives => fmi2SetRealInputDerivatives(c, null(), 0, null(), null()),
            Function::GetRealOutputDerivatives => fmi2GetRealOutputDerivatives(c, &Y, 1, &1, &mut real),
            Function::DoStep => fmi2DoStep(c, 0.0, 1.0, 1),
            Function::CancelStep => fmi2CancelStep(c),
            Function::GetStatus => fmi2GetStatus(c, 0, &mut Status::Ok),
            Function::GetRealStatus => fmi2GetRealStatus(c, 2, &mut real),
            Function::GetIntegerStatus => fmi2GetIntegerStatus(c, 0, &mut integer),
            Function::GetBooleanStatus => fmi2GetBooleanStatus(c, 3, &mut integer),
            Function::GetStringStatus => fmi2GetStringStatus(c, 1, &mut text),
        }
    }
}

/// Returns the phase after a legal call.
fn phase_after(function: Function, interface: Interface, before: Phase) -> Phase {
    let running = match interface {
        Interface::CoSimulation => Phase::Step,
        Interface::ModelExchange => Phase::Event,
    };
    match function {
        Function::EnterInitializationMode => Phase::Initialization,
        Function::ExitInitializationMode | Function::SetFmuState => running,
        Function::Terminate => Phase::Terminated,
        Function::Reset => Phase::Instantiated,
        Function::EnterEventMode => Phase::Event,
        Function::EnterContinuousTimeMode => Phase::Continuous,
        _ => before,
    }
}

/// Returns the expected status of a legal call.
fn status_of(function: Function) -> Status {
    match function {
        // No kind of status is an integer, and strings describe pending steps only (section 4.2.3).
        Function::GetIntegerStatus | Function::GetStringStatus => Status::Discard,
        _ => Status::Ok,
    }
}

/// Returns the phase, as reported by a function that is legal in initialization mode only.
fn phase_of(c: Component) -> Phase {
    if unsafe { fmi2ExitInitializationMode(c) } == Status::Ok {
        return Phase::Initialization;
    }
    let logged = messages().join("");
    let named = |phase: &Phase| logged.contains(&format!("in state '{}'", phase.name()));
    Phase::ALL.into_iter().find(named).unwrap_or_else(|| panic!("{logged}"))
}

/// Returns the serialised state of an instance; `None` if serialisation is illegal.
fn bytes_of(c: Component, owner: Component) -> Option<Vec<u8>> {
    let (mut state, mut size) = (null_mut(), 0);
    unsafe {
        if fmi2GetFMUstate(c, &mut state) != Status::Ok {
            messages();
            return None;
        }
        assert_eq!(fmi2SerializedFMUstateSize(owner, state, &mut size), Status::Ok);
        let mut bytes = vec![0; size];
        assert_eq!(fmi2SerializeFMUstate(owner, state, bytes.as_mut_ptr(), size), Status::Ok);
        assert_eq!(fmi2FreeFMUstate(owner, &mut state), Status::Ok);
        Some(bytes)
    }
}

/// Returns the functions that take an instance and return a status.
fn of_an_instance() -> impl Iterator<Item = Function> {
    let others =
        [Function::GetTypesPlatform, Function::GetVersion, Function::Instantiate, Function::FreeInstance];
    Function::all().filter(move |function| !others.contains(function))
}

fn every_state() -> impl Iterator<Item = (Interface, Phase)> {
    let all = BOTH.into_iter().flat_map(|one| Phase::ALL.map(|phase| (one, phase)));
    all.filter(|(interface, phase)| phase.occurs_in(*interface))
}

#[test]
fn legal_calls_succeed_and_lead_to_the_phase_of_the_standard() {
    let fmu = unpack();
    let mut calls = 0;
    for (interface, phase) in every_state() {
        let stored = Stored::new(&fmu, interface);
        for function in of_an_instance().filter(|one| standard(*one, interface, phase) == Some(true)) {
            let c = in_phase(&fmu, interface, phase);
            let context = format!("{} in {} of {}", function.name(), phase.name(), interface.name());
            let status = call(c, function, &stored);
            let logged = messages();
            assert_eq!((status, logged.len()), (status_of(function), 0), "{context}: {logged:?}");
            assert_eq!(phase_of(c), phase_after(function, interface, phase), "{context}");
            unsafe { fmi2FreeInstance(c) };
            calls += 1;
        }
    }
    let allowed =
        [CO_SIMULATION, MODEL_EXCHANGE].join("").split_whitespace().filter(|one| *one == "x").count();
    assert_eq!(calls, allowed, "every call that the standard allows");
}

#[test]
fn illegal_calls_are_refused_and_change_nothing() {
    let fmu = unpack();
    let mut calls = 0;
    for (interface, phase) in every_state() {
        let stored = Stored::new(&fmu, interface);
        for function in of_an_instance().filter(|one| standard(*one, interface, phase) != Some(true)) {
            let c = in_phase(&fmu, interface, phase);
            let context = format!("{} in {} of {}", function.name(), phase.name(), interface.name());
            let before = bytes_of(c, stored.owner);
            let status = call(c, function, &stored);
            let logged = messages();
            assert_eq!((status, logged.len()), (Status::Error, 1), "{context}: {logged:?}");
            let reason = match standard(function, interface, phase) {
                Some(_) => format!("may not be called in state '{}'.", phase.name()),
                None => "may not be called: it belongs to ".to_owned(),
            };
            let start = format!("one Error logStatusError {}: ", function.name());
            assert!(logged[0].starts_with(&start) && logged[0].contains(&reason), "{context}: {logged:?}");
            assert_eq!(bytes_of(c, stored.owner), before, "{context}");
            assert_eq!(phase_of(c), phase, "{context}");
            unsafe { fmi2FreeInstance(c) };
            calls += 1;
        }
    }
    assert!(calls > 250, "{calls} illegal calls");
    assert_eq!(of_an_instance().count(), 40);
}

#[test]
fn functions_without_instance_and_free_work_in_every_state() {
    let fmu = unpack();
    for (interface, phase) in every_state() {
        let c = in_phase(&fmu, interface, phase);
        unsafe {
            assert!(!fmi2GetVersion().is_null() && !fmi2GetTypesPlatform().is_null());
            let other = fmu.made_for(interface, false);
            assert!(!other.is_null());
            fmi2FreeInstance(c);
            initialise(other);
            fmi2FreeInstance(other);
        }
        assert_eq!(messages(), Vec::<String>::new());
    }
}

#[test]
fn every_function_returns_an_error_without_instance() {
    let fmu = unpack();
    let stored = Stored::new(&fmu, Interface::CoSimulation);
    for function in of_an_instance() {
        assert_eq!(call(null_mut(), function, &stored), Status::Error, "{}", function.name());
    }
    unsafe { fmi2FreeInstance(null_mut()) };
}

#[test]
fn reset_or_restored_state_recovers_from_an_error() {
    let fmu = unpack();
    for interface in BOTH {
        let stored = Stored::new(&fmu, interface);
        let c = in_phase(&fmu, interface, Phase::Error);
        unsafe {
            assert_eq!(fmi2SetFMUstate(c, stored.state), Status::Ok);
            let mut value: f64 = 0.0;
            assert_eq!(fmi2GetReal(c, &GAIN, 1, &mut value), Status::Ok);
            assert_eq!(value, 2.0);
            fmi2FreeInstance(c);
            let c = in_phase(&fmu, interface, Phase::Error);
            assert_eq!(fmi2Reset(c), Status::Ok);
            initialise(c);
            fmi2FreeInstance(c);
        }
    }
}

/// Variables that change at events only are refused (footnote of the table in section 3.2.3).
#[test]
fn continuous_time_mode_sets_continuous_inputs_only() {
    let fmu = unpack();
    let c = in_phase(&fmu, Interface::ModelExchange, Phase::Continuous);
    let refused: [c_int; 3] = unsafe {
        [
            fmi2SetBoolean(c, &ARMED, 1, &0) as c_int,
            fmi2SetReal(c, &GAIN, 1, &1.0) as c_int,
            fmi2SetReal(c, &RATE, 1, &1.0) as c_int,
        ]
    };
    assert_eq!((refused, messages().len()), ([Status::Error as c_int; 3], 3));
    assert_eq!(unsafe { fmi2SetReal(c, &U, 1, &1.0) }, Status::Ok);
    unsafe { fmi2FreeInstance(c) };
}
