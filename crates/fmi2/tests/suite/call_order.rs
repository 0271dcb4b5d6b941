//! Call sequences of importers: rare but legal sequences, which must work without a message, and behaviour that
//! the standard leaves to the FMU.

use std::ffi::CString;
use std::ptr::{null, null_mut};

use crate::importer::*;
use squid_fmi2::Interface;
use squid_fmi2::abi::{EventInfo, Status};

fn quiet() {
    assert_eq!(messages(), Vec::<String>::new());
}

/// Follows the FMU Compliance Checker: all settings, all derivatives, the event loop, no indicator, `terminate` in
/// continuous-time mode.
#[test]
fn supports_the_calls_of_the_compliance_checker() {
    let fmu = unpack();
    let c = fmu.made_for(Interface::ModelExchange, false);
    let (mut info, mut state, mut rate) =
        (EventInfo { new_discrete_states_needed: 1, ..EventInfo::default() }, 0.0, 0.0);
    unsafe {
        assert_eq!(fmi2SetDebugLogging(c, 0, 0, null()), Status::Ok);
        assert_eq!(
            fmi2SetupExperiment(c, 1, 1e-4, 0.0, 0, f64::NAN),
            Status::Ok,
            "no stop time: its number is nothing"
        );
        assert_eq!(fmi2EnterInitializationMode(c), Status::Ok);
        assert_eq!(fmi2GetContinuousStates(c, &mut state, 1), Status::Ok);
        assert_eq!(fmi2GetDerivatives(c, &mut rate, 1), Status::Ok);
        assert_eq!(fmi2GetEventIndicators(c, null_mut(), 0), Status::Ok);
        assert_eq!(fmi2ExitInitializationMode(c), Status::Ok);
        let mut rounds = 0;
        while info.new_discrete_states_needed != 0 {
            assert_eq!(fmi2NewDiscreteStates(c, &mut info), Status::Ok);
            rounds += 1;
        }
        assert_eq!((rounds, info.terminate_simulation, info.values_of_continuous_states_changed), (1, 0, 0));
        assert_eq!(set(c, U, 3.0), Status::Ok, "a continuous input in event mode");
        assert_eq!(fmi2GetDerivatives(c, &mut rate, 1), Status::Ok);
        assert_eq!(rate, 12.0, "it acts at once");
        assert_eq!(fmi2EnterContinuousTimeMode(c), Status::Ok);
        assert_eq!(fmi2GetEventIndicators(c, null_mut(), 0), Status::Ok);
        let (mut event, mut end) = (1, 1);
        assert_eq!(fmi2SetTime(c, 0.5), Status::Ok);
        assert_eq!(fmi2SetContinuousStates(c, &1.0, 1), Status::Ok);
        assert_eq!(set(c, U, 1.0), Status::Ok, "a continuous input in continuous-time mode");
        for no_set_state_prior in [0, 1] {
            assert_eq!(fmi2CompletedIntegratorStep(c, no_set_state_prior, &mut event, &mut end), Status::Ok);
            assert_eq!((event, end), (0, 0));
        }
        assert_eq!(fmi2EnterEventMode(c), Status::Ok);
        assert_eq!(fmi2SetTime(c, 1.0), Status::Ok, "time in event mode");
        assert_eq!(fmi2NewDiscreteStates(c, &mut info), Status::Ok);
        assert_eq!((info.next_event_time_defined, info.next_event_time), (1, 2.0), "after the present time");
        assert_eq!(fmi2EnterContinuousTimeMode(c), Status::Ok);
        assert_eq!(real(c, Y), 1.0);
        assert_eq!(fmi2Terminate(c), Status::Ok);
        assert_eq!(real(c, Y), 1.0, "values can be read after the end");
        fmi2FreeInstance(c);
    }
    quiet();
}

/// A reset at any time allows a new simulation with other settings.
#[test]
fn reset_instance_equals_a_new_one() {
    let fmu = unpack();
    let c = fmu.instantiate(false);
    unsafe {
        for before_reset in 0..5 {
            if before_reset > 0 {
                assert_eq!(set(c, GAIN, 5.0), Status::Ok);
            }
            if before_reset > 1 {
                assert_eq!(fmi2SetupExperiment(c, 0, 0.0, 100.0, 1, 100.5), Status::Ok);
                assert_eq!(fmi2EnterInitializationMode(c), Status::Ok);
            }
            if before_reset > 2 {
                assert_eq!(fmi2ExitInitializationMode(c), Status::Ok);
                assert_eq!(fmi2DoStep(c, 100.0, 0.5, 0), Status::Ok);
            }
            if before_reset > 3 {
                assert_eq!(fmi2Terminate(c), Status::Ok);
            }
            assert_eq!(fmi2Reset(c), Status::Ok);
            assert_eq!(fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0), Status::Ok);
            assert_eq!(set(c, U, 1.0), Status::Ok);
            assert_eq!(fmi2EnterInitializationMode(c), Status::Ok);
            assert_eq!(fmi2ExitInitializationMode(c), Status::Ok);
            assert_eq!(real(c, GAIN), 2.0, "start values are back");
            assert_eq!(fmi2DoStep(c, 0.0, 2.0, 1), Status::Ok, "no stop time is left from before");
            assert_eq!(real(c, Y), 2.0);
            assert_eq!(fmi2Reset(c), Status::Ok);
        }
        fmi2FreeInstance(c);
    }
    quiet();
}

#[test]
fn setup_experiment_is_optional_and_the_last_call_applies() {
    let fmu = unpack();
    unsafe {
        let c = fmu.instantiate(false);
        assert_eq!(fmi2EnterInitializationMode(c), Status::Ok);
        assert_eq!(fmi2ExitInitializationMode(c), Status::Ok);
        assert_eq!(fmi2DoStep(c, 0.0, 0.1, 1), Status::Ok, "time begins at 0");
        fmi2FreeInstance(c);
        let c = fmu.instantiate(false);
        assert_eq!(fmi2SetupExperiment(c, 1, 0.0, 1.0, 1, 1.5), Status::Ok);
        assert_eq!(
            fmi2SetupExperiment(c, 0, 0.0, 5.0, 1, f64::INFINITY),
            Status::Ok,
            "an end that never comes"
        );
        assert_eq!(fmi2EnterInitializationMode(c), Status::Ok);
        assert_eq!(fmi2ExitInitializationMode(c), Status::Ok);
        assert_eq!(fmi2DoStep(c, 5.0, 1000.0, 1), Status::Ok);
        fmi2FreeInstance(c);
    }
    quiet();
}

/// A step of zero length, which some masters use for an event, is refused; the next step continues from the end of
/// the last one.
#[test]
fn refused_step_changes_nothing() {
    let fmu = unpack();
    let c = fmu.instantiate(false);
    unsafe {
        initialise(c);
        assert_eq!(set(c, U, 1.0), Status::Ok);
        assert_eq!(fmi2DoStep(c, 0.0, 0.5, 0), Status::Ok);
        let before = real(c, Y);
        let (mut last, mut status, mut end) = (f64::NAN, Status::Pending, 1);
        assert_eq!(fmi2DoStep(c, 0.5, 0.0, 0), Status::Error);
        assert_eq!(messages().len(), 1);
        assert_eq!(real(c, Y), before);
        assert_eq!(fmi2GetStatus(c, 0, &mut status), Status::Ok);
        assert_eq!(status, Status::Error, "of the last call");
        assert_eq!(fmi2GetRealStatus(c, 2, &mut last), Status::Ok);
        assert_eq!(last, 0.5, "the last successful time");
        assert_eq!(fmi2GetBooleanStatus(c, 3, &mut end), Status::Ok);
        assert_eq!(end, 0);
        assert_eq!(fmi2GetStringStatus(c, 1, &mut null()), Status::Discard, "nothing is pending");
        assert_eq!(fmi2GetIntegerStatus(c, 99, &mut 0), Status::Discard, "no such question");
        assert_eq!(fmi2DoStep(c, 0.5, 0.5, 1), Status::Ok);
        fmi2FreeInstance(c);
    }
    quiet();
}

/// `fmi2GetStatus` refers to steps, not to calls in phases without steps, nor to steps before a state was restored.
#[test]
fn status_is_that_of_the_last_step() {
    let fmu = unpack();
    let c = fmu.instantiate(false);
    let status = || unsafe {
        let mut status = Status::Pending;
        assert_eq!(fmi2GetStatus(c, 0, &mut status), Status::Ok);
        status
    };
    unsafe {
        assert_eq!(fmi2EnterInitializationMode(c), Status::Ok);
        assert_eq!(fmi2DoStep(c, 0.0, 0.5, 1), Status::Error, "there is no step yet");
        assert_eq!(fmi2ExitInitializationMode(c), Status::Ok);
        assert_eq!(status(), Status::Ok);
        let mut state = null_mut();
        assert_eq!(fmi2GetFMUstate(c, &mut state), Status::Ok);
        assert_eq!(fmi2DoStep(c, 0.0, -0.5, 1), Status::Error);
        assert_eq!(status(), Status::Error);
        assert_eq!(fmi2SetFMUstate(c, state), Status::Ok);
        assert_eq!(status(), Status::Ok);
        fmi2FreeFMUstate(c, &mut state);
        fmi2FreeInstance(c);
    }
    assert_eq!(messages().len(), 2);
}

#[test]
fn refuses_unknown_category_and_keeps_the_filter() {
    let fmu = unpack();
    let c = fmu.instantiate(false);
    let (known, unknown) = (c"logStatusWarning".as_ptr(), c"logAll the same".as_ptr());
    unsafe {
        initialise(c);
        assert_eq!(fmi2SetDebugLogging(c, 1, 2, [known, unknown].as_ptr()), Status::Error);
        insta::assert_snapshot!(messages()[0]);
        assert_eq!(fmi2SetDebugLogging(c, 1, 1, null()), Status::Error);
        assert!(messages()[0].contains("'categories' is NULL"));
        set(c, U, 11.0);
        assert_eq!(fmi2DoStep(c, 0.0, 0.1, 1), Status::Warning);
        assert_eq!(messages().len(), 1, "warnings are still shown");
        fmi2FreeInstance(c);
    }
}

/// Every variant of the resource location is accepted, with and without callbacks.
#[test]
fn accepts_every_variant_of_the_location() {
    let fmu = unpack();
    let path = fmu.uri.to_str().unwrap().strip_prefix("file://").unwrap().to_owned();
    for uri in [
        format!("file:{path}"),
        format!("file://{path}"),
        format!("file://{path}/"),
        format!("file:///{path}"),
        format!("file://localhost{path}"),
        format!("FILE://LOCALHOST{path}///"),
    ] {
        let uri = CString::new(uri).unwrap();
        let callbacks = callbacks();
        let made = |callbacks| unsafe {
            fmi2Instantiate(c"one".as_ptr(), 1, fmu.guid.as_ptr(), uri.as_ptr(), callbacks, 1, 1)
        };
        for c in [made(&callbacks), made(null())] {
            assert!(!c.is_null(), "{uri:?}: {:?}", messages());
            initialise(c);
            unsafe {
                fmi2FreeInstance(c);
            }
        }
    }
    quiet();
}
