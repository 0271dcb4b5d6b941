//! The exported C functions, called by an importer.

use std::ffi::CStr;
use std::ptr::{null, null_mut};

use crate::example::Lag;
use crate::importer::*;
use squid_fmi2::abi::{Component, Status};
use squid_fmi2::{INTERFACE_RESOURCE, Interface, Resources, describe};

/// Asserts that the last call was refused with one sentence that contains `text`.
#[track_caller]
fn assert_refused(status: Status, text: &str) {
    let messages = messages();
    assert_eq!(status, Status::Error, "{messages:?}");
    assert_eq!(messages.len(), 1, "{messages:?}");
    assert!(messages[0].contains(text), "{messages:?}");
    assert!(messages[0].starts_with("one Error logStatusError fmi2"), "{messages:?}");
}

#[test]
fn returns_version_and_platform() {
    unsafe {
        assert_eq!(CStr::from_ptr(fmi2GetVersion()), c"2.0");
        assert_eq!(CStr::from_ptr(fmi2GetTypesPlatform()), c"default");
    }
}

#[test]
fn steps_a_lag() {
    let fmu = unpack();
    let c = fmu.instantiate(false);
    unsafe {
        assert_eq!(fmi2SetupExperiment(c, 0, 0.0, 0.0, 1, 1.0), Status::Ok);
        assert_eq!(fmi2EnterInitializationMode(c), Status::Ok);
        assert_eq!(set(c, U, 3.0), Status::Ok);
        assert_eq!(real(c, Y), 6.0, "outputs follow inputs in initialization mode");
        assert_eq!(set(c, U, 1.0), Status::Ok);
        assert_eq!(real(c, Y), 2.0);
        assert_eq!(fmi2ExitInitializationMode(c), Status::Ok);
        assert_eq!(set(c, U, 0.0), Status::Ok);
        for k in 0..100 {
            assert_eq!(fmi2DoStep(c, f64::from(k) * 0.01, 0.010000000000000009, 1), Status::Ok);
        }
        let exact = 2.0 * (-2.0f64).exp();
        assert!((real(c, Y) - exact).abs() < 1e-12);
        assert_eq!(fmi2Terminate(c), Status::Ok);
        assert!((real(c, Y) - exact).abs() < 1e-12);
        fmi2FreeInstance(c);
        fmi2FreeInstance(null_mut());
    }
    assert_eq!(messages(), Vec::<String>::new());
}

#[test]
fn exchanges_every_type() {
    let fmu = unpack();
    let c = fmu.instantiate(false);
    unsafe {
        let (armed, label, method, text) = (4, 5, 6, c"Äther");
        assert_eq!(fmi2SetBoolean(c, &armed, 1, &7), Status::Ok);
        assert_eq!(fmi2SetString(c, &label, 1, &text.as_ptr()), Status::Ok);
        assert_eq!(fmi2SetInteger(c, &method, 1, &2), Status::Ok);
        assert_eq!(fmi2EnterInitializationMode(c), Status::Ok);
        let (mut truth, mut number, mut string) = (0, 0, null());
        assert_eq!(fmi2GetBoolean(c, &armed, 1, &mut truth), Status::Ok);
        assert_eq!(fmi2GetInteger(c, &method, 1, &mut number), Status::Ok);
        assert_eq!(fmi2GetString(c, &label, 1, &mut string), Status::Ok);
        assert_eq!((truth, number, CStr::from_ptr(string)), (1, 2, text));
        assert_refused(fmi2SetInteger(c, &method, 1, &3), "'method' cannot be set to 3, only to 1 .. 2");
        fmi2FreeInstance(c);
    }
}

#[test]
fn refuses_wrong_values_and_references() {
    let fmu = unpack();
    let c = fmu.instantiate(false);
    initialise(c);
    assert_refused(set(c, U, f64::NAN), "'u' cannot be set to NaN");
    assert_refused(set(c, U, f64::INFINITY), "'u' cannot be set to inf");
    assert_refused(set(c, 99, 0.0), "no variable with value reference 99, only 0 .. 8");
    assert_refused(set(c, Y, 0.0), "'y' may not be set in state 'step complete'");
    assert_refused(set(c, GAIN, 1.0), "'gain' may not be set in state 'step complete'");
    unsafe {
        assert_refused(fmi2SetBoolean(c, &U, 1, &1), "'u' is not of type Boolean");
        assert_refused(fmi2GetReal(c, null(), 1, null_mut()), "'vr' is NULL");
        assert_refused(fmi2SetReal(c, &U, 1, null()), "'value' is NULL");
        assert_refused(fmi2SetReal(c, &U, usize::MAX, &1.0), "'vr' cannot point to 18446744073709551615");
        let askew = [0u64; 2].as_ptr().cast::<u8>().add(1).cast::<f64>();
        assert_refused(fmi2SetReal(c, &U, 1, askew), "'value' cannot point to 1 elements");
        assert_eq!(fmi2GetReal(c, null(), 0, null_mut()), Status::Ok);
        let refused = fmi2SetReal(c, [U, U].as_ptr(), 2, [5.0, f64::NAN].as_ptr());
        assert_refused(refused, "NaN");
        assert_eq!(real(c, U), 0.0, "all values or none");
        fmi2FreeInstance(c);
        assert_eq!(set(null_mut(), U, 0.0), Status::Error);
        assert_eq!(fmi2DoStep(null_mut(), 0.0, 0.1, 1), Status::Error);
    }
}

#[test]
fn refuses_invalid_steps() {
    let fmu = unpack();
    let c = fmu.instantiate(false);
    unsafe {
        let sentence = "start time NaN s, stop time inf s and tolerance 0 make no experiment";
        assert_refused(fmi2SetupExperiment(c, 0, 0.0, f64::NAN, 0, 0.0), sentence);
        assert_refused(fmi2SetupExperiment(c, 1, -1.0, 0.0, 0, 0.0), "tolerance -1 make no experiment");
        assert_refused(fmi2SetupExperiment(c, 0, 0.0, 0.0, 1, f64::NAN), "stop time NaN s");
        assert_refused(fmi2SetupExperiment(c, 0, 0.0, 1.0, 1, 0.5), "no experiment");
        assert_eq!(fmi2SetupExperiment(c, 0, 0.0, 0.0, 1, 1.0), Status::Ok);
        assert_eq!(fmi2EnterInitializationMode(c), Status::Ok);
        assert_eq!(fmi2ExitInitializationMode(c), Status::Ok);
        for size in [0.0, -0.01, f64::NAN, f64::INFINITY, 1e300] {
            assert_refused(fmi2DoStep(c, 0.0, size, 1), "must be above 0 and at most 86400");
        }
        assert_refused(fmi2DoStep(c, 0.01, 0.01, 1), "starts at 0.01 s, but the last one ended at 0 s");
        assert_refused(fmi2DoStep(c, f64::NAN, 0.01, 1), "starts at NaN s");
        assert_refused(fmi2DoStep(c, 0.0, 1.5, 1), "after the stop time 1 s");
        assert_eq!(fmi2DoStep(c, 1e-13, 0.00999999999999934, 1), Status::Ok);
        assert_eq!(fmi2DoStep(c, 0.01, 0.99, 1), Status::Ok);
        fmi2FreeInstance(c);
    }
}

#[test]
fn refuses_to_instantiate_with_wrong_arguments() {
    let fmu = unpack();
    let make = |name, fmu_type, guid, location| unsafe {
        fmi2Instantiate(name, fmu_type, guid, location, &callbacks(), 0, 0)
    };
    let (name, guid, uri) = (c"one".as_ptr(), fmu.guid.as_ptr(), fmu.uri.as_ptr());
    let empty = tempfile::tempdir().unwrap();
    let nothing = std::ffi::CString::new(format!("file://{}", empty.path().display())).unwrap();
    for (name, fmu_type, guid, location, text) in [
        (name, 1, c"{1}".as_ptr(), uri, "the GUID is '{1}'"),
        (name, 1, null(), uri, "'fmuGUID' is NULL"),
        (name, 2, guid, uri, "the FMU type 2 is not supported, only 0 (model exchange) and 1"),
        (name, 1, guid, null(), "the resource location is NULL"),
        (name, 1, guid, c"http://x/y".as_ptr(), "is not a file URI"),
        (name, 1, guid, c"file:///no/such/folder".as_ptr(), "'/no/such/folder' cannot be read"),
        (name, 1, guid, c"file:///no/%23r1%23".as_ptr(), "'/no/##r1##' cannot be read"),
        (name, 1, guid, nothing.as_ptr(), "resources/gain.txt is missing"),
        (null(), 1, guid, uri, "'instanceName' is NULL"),
        (c"".as_ptr(), 1, guid, uri, "the instance name is empty"),
    ] {
        assert!(make(name, fmu_type, guid, location).is_null());
        let messages = messages();
        assert_eq!(messages.len(), 1, "{messages:?}");
        assert!(messages[0].contains(text), "{messages:?}");
    }
}

#[test]
fn detects_damaged_resources() {
    let fmu = unpack();
    let path = squid_fmi2::path_of(fmu.uri.to_str().unwrap()).unwrap().join("gain.txt");
    std::fs::write(&path, "2.5\n").unwrap();
    assert!(fmu.instantiate(false).is_null());
    assert!(messages()[0].contains("but binary and resources belong to"));
    std::fs::write(&path, "2\n").unwrap();
    std::fs::write(path.with_file_name("Thumbs.db"), "").unwrap();
    assert!(fmu.instantiate(false).is_null());
    assert!(messages()[0].contains("or a file in resources was changed or added"));
    std::fs::write(&path, "two\n").unwrap();
    assert!(fmu.instantiate(false).is_null());
    assert!(messages()[0].contains("holds 'two', which is no number"));
}

#[test]
fn works_without_callbacks() {
    let fmu = unpack();
    unsafe {
        let c = fmi2Instantiate(c"one".as_ptr(), 1, fmu.guid.as_ptr(), fmu.uri.as_ptr(), null(), 0, 1);
        assert!(!c.is_null());
        initialise(c);
        assert_eq!(set(c, 99, 0.0), Status::Error);
        fmi2FreeInstance(c);
    }
}

/// Asserts that the only message since the last check reports an undefined value.
fn assert_discarded(text: &str) {
    let messages = messages();
    assert_eq!(messages.len(), 1, "{messages:?}");
    assert!(
        messages[0].starts_with("one Discard logStatusDiscard") && messages[0].contains(text),
        "{messages:?}"
    );
}

#[test]
fn logs_enabled_categories() {
    let fmu = unpack();
    let c = fmu.instantiate(false);
    initialise(c);
    let step = |k: i32| unsafe { fmi2DoStep(c, f64::from(k), 1.0, 1) };
    unsafe {
        assert_eq!((step(0), messages().len()), (Status::Ok, 0));
        set(c, U, 11.0);
        let warning = "one Warning logStatusWarning input 100 % beyond its range".to_owned();
        assert_eq!((step(1), messages()), (Status::Warning, vec![warning.clone()]));
        assert_eq!(fmi2SetDebugLogging(c, 1, 1, &c"logStatusDiscard".as_ptr()), Status::Ok);
        assert_eq!((step(2), messages().len()), (Status::Warning, 0));
        assert_eq!(fmi2SetDebugLogging(c, 1, 1, &c"logStatusWarning".as_ptr()), Status::Ok);
        assert_eq!((step(3), messages()), (Status::Warning, vec![warning.clone()]));
        assert_eq!(fmi2SetDebugLogging(c, 0, 0, null()), Status::Ok, "debugging is off, warnings are not");
        assert_eq!((step(4), messages()), (Status::Warning, vec![warning]));
        assert_refused(fmi2SetDebugLogging(c, 1, 1, &c"noise".as_ptr()), "log category 'noise' is unknown");
        fmi2FreeInstance(c);
    }
}

#[test]
fn failed_model_stops_and_can_be_reset() {
    let fmu = unpack();
    let c = fmu.instantiate(false);
    unsafe {
        assert_eq!(set(c, GAIN, 0.0), Status::Ok);
        assert_eq!(fmi2EnterInitializationMode(c), Status::Ok);
        assert_refused(fmi2ExitInitializationMode(c), "gain 0 lets nothing through");
        assert_refused(fmi2DoStep(c, 0.0, 1.0, 1), "may not be called in state 'error'");
        assert_eq!(fmi2Reset(c), Status::Ok);
        initialise(c);
        assert_eq!(real(c, GAIN), 2.0);
        fmi2FreeInstance(c);
    }
}

#[test]
fn panic_becomes_fatal() {
    let fmu = unpack();
    let c = fmu.instantiate(false);
    unsafe {
        assert_eq!(fmi2SetInteger(c, &6, 1, &2), Status::Ok);
        initialise(c);
        assert_eq!(fmi2DoStep(c, 0.0, 1.0, 1), Status::Fatal);
        let messages = messages();
        assert!(messages[0].starts_with("one Fatal logStatusFatal fmi2DoStep"), "{messages:?}");
        assert!(messages[0].contains("method 2 is broken"), "{messages:?}");
        assert_refused(fmi2Reset(c), "may not be called in state 'fatal'");
        fmi2FreeInstance(c);
    }
}

#[test]
fn states_are_stored_and_restored() {
    let fmu = unpack();
    let c = fmu.instantiate(false);
    initialise(c);
    unsafe {
        set(c, U, 1.0);
        fmi2DoStep(c, 0.0, 0.3, 1);
        let mut state = null_mut();
        assert_eq!(fmi2GetFMUstate(c, &mut state), Status::Ok);
        fmi2DoStep(c, 0.3, 0.3, 1);
        let first = real(c, Y);
        assert_eq!(fmi2SetFMUstate(c, state), Status::Ok);
        assert_eq!(fmi2DoStep(c, 0.3, 0.3, 1), Status::Ok);
        assert_eq!(real(c, Y).to_bits(), first.to_bits());
        assert_eq!(fmi2GetFMUstate(c, &mut state), Status::Ok);
        let other = fmu.instantiate(false);
        assert_eq!(fmi2SetFMUstate(other, state), Status::Ok);
        assert_eq!(real(other, Y).to_bits(), first.to_bits());
        assert_refused(fmi2SetFMUstate(c, null_mut()), "'FMUstate' is NULL");
        assert_eq!(fmi2FreeFMUstate(c, &mut state), Status::Ok);
        assert!(state.is_null());
        assert_eq!(fmi2FreeFMUstate(c, &mut state), Status::Ok);
        fmi2FreeInstance(c);
        fmi2FreeInstance(other);
    }
}

#[test]
fn returns_the_status_of_synchronous_steps() {
    let fmu = unpack();
    let c = fmu.instantiate(false);
    initialise(c);
    unsafe {
        fmi2DoStep(c, 0.0, 0.25, 1);
        let (mut status, mut time, mut ended) = (Status::Pending, 0.0, 1);
        assert_eq!(fmi2GetStatus(c, 0, &mut status), Status::Ok);
        assert_eq!(fmi2GetRealStatus(c, 2, &mut time), Status::Ok);
        assert_eq!(fmi2GetBooleanStatus(c, 3, &mut ended), Status::Ok);
        assert_eq!((status, time, ended), (Status::Ok, 0.25, 0));
        assert_eq!(fmi2GetStringStatus(c, 1, &mut null()), Status::Discard);
        assert_eq!(fmi2GetIntegerStatus(c, 0, &mut 0), Status::Discard);
        assert_refused(fmi2CancelStep(c), "may not be called");
        assert_refused(fmi2SetRealInputDerivatives(c, &U, 1, &1, &0.0), "canInterpolateInputs = false");
        fmi2FreeInstance(c);
    }
}

#[test]
fn instances_are_independent() {
    let fmu = unpack();
    let all: Vec<_> = (0..20).map(|_| fmu.instantiate(false)).collect();
    for (k, &c) in all.iter().enumerate() {
        initialise(c);
        set(c, U, 0.5 * k as f64);
    }
    for &c in &all {
        assert_eq!(unsafe { fmi2DoStep(c, 0.0, 100.0, 1) }, Status::Ok);
    }
    for (k, &c) in all.iter().enumerate() {
        assert!((real(c, Y) - k as f64).abs() < 1e-12);
        unsafe { fmi2FreeInstance(c) };
    }
}

#[test]
fn serialised_states_round_trip_and_damaged_or_foreign_ones_are_refused() {
    let fmu = unpack();
    let c = fmu.instantiate(false);
    initialise(c);
    unsafe {
        set(c, U, 1.5);
        fmi2DoStep(c, 0.0, 0.3, 1);
        let (mut state, mut size) = (null_mut(), 0);
        assert_eq!(fmi2GetFMUstate(c, &mut state), Status::Ok);
        assert_eq!(fmi2SerializedFMUstateSize(c, state, &mut size), Status::Ok);
        let mut bytes = vec![0u8; size + 1];
        assert_refused(fmi2SerializeFMUstate(c, state, bytes.as_mut_ptr(), size - 1), "but the state needs");
        assert_eq!(fmi2SerializeFMUstate(c, state, bytes.as_mut_ptr(), size), Status::Ok);
        fmi2DoStep(c, 0.3, 0.3, 1);
        let other = fmu.instantiate(false);
        let mut again = null_mut();
        assert_eq!(fmi2DeSerializeFMUstate(other, bytes.as_ptr(), size, &mut again), Status::Ok);
        assert_eq!(fmi2SetFMUstate(other, again), Status::Ok);
        assert_eq!(fmi2DoStep(other, 0.3, 0.3, 1), Status::Ok);
        assert_eq!(real(other, Y).to_bits(), real(c, Y).to_bits());
        let read = |bytes: &[u8]| fmi2DeSerializeFMUstate(c, bytes.as_ptr(), bytes.len(), &mut null_mut());
        assert_refused(read(&bytes[..10]), "the state has 10 bytes, but should have");
        assert_refused(read(&bytes[..size - 1]), "but should have");
        assert_refused(read(&bytes), "but should have");
        bytes.truncate(size);
        let changed = |position: usize| {
            let mut changed = bytes.clone();
            changed[position] ^= 0x10;
            changed
        };
        assert_refused(read(&changed(0)), "no state that this tool has written");
        assert_refused(read(&changed(8)), "has version 18, but only version 2 can be read");
        assert_refused(read(&changed(size / 2)), "its checksum does not fit");
        assert_refused(fmi2DeSerializeFMUstate(c, null(), 9, &mut null_mut()), "'serializedState' is NULL");
        let exchange = fmu.made_for(squid_fmi2::Interface::ModelExchange, false);
        assert_refused(
            fmi2DeSerializeFMUstate(exchange, bytes.as_ptr(), size, &mut null_mut()),
            "made for co-simulation, and this one was made for model exchange",
        );
        assert_refused(fmi2SetFMUstate(exchange, state), "this one was made for model exchange");
        let stranger = unpack_with("3.0\n");
        let foreign = stranger.instantiate(false);
        assert_refused(fmi2SetFMUstate(foreign, state), "belongs to an FMU with another GUID");
        assert_refused(fmi2FreeFMUstate(foreign, &mut state.clone()), "another GUID");
        let refused = fmi2DeSerializeFMUstate(foreign, bytes.as_ptr(), size, &mut null_mut());
        assert_refused(refused, "belongs to an FMU with another GUID");
        assert_eq!(fmi2FreeFMUstate(c, &mut state), Status::Ok);
        assert_eq!(fmi2FreeFMUstate(c, &mut again), Status::Ok);
        [c, other, exchange, foreign].into_iter().for_each(|one| fmi2FreeInstance(one));
    }
}

#[test]
fn derivatives_are_exact_and_refused_for_invalid_variables() {
    let fmu = unpack();
    let c = fmu.instantiate(false);
    let slope = |unknown: u32, known: u32, derivative: &mut f64| unsafe {
        fmi2GetDirectionalDerivative(c, &unknown, 1, &known, 1, &0.5, derivative)
    };
    let (mut derivative, rate, tau) = (0.0, 8, 7);
    unsafe { fmi2EnterInitializationMode(c) };
    assert_eq!((slope(Y, U, &mut derivative), derivative), (Status::Ok, 1.0));
    let sentence = "by variable 'y' can be asked for in state 'initialization mode', only by inputs, for";
    assert_refused(slope(rate, Y, &mut derivative), sentence);
    // The standard lists parameters among the knowns here.
    assert_refused(slope(Y, GAIN, &mut derivative), "by parameters, such as 'gain', are not computed");
    unsafe { fmi2ExitInitializationMode(c) };
    set(c, U, 1.0);
    assert_eq!((slope(Y, U, &mut derivative), derivative), (Status::Ok, 0.0));
    assert_eq!((slope(rate, U, &mut derivative), derivative), (Status::Ok, 2.0));
    assert_eq!((slope(rate, Y, &mut derivative), derivative), (Status::Ok, -1.0));
    assert_eq!((slope(Y, Y, &mut derivative), derivative), (Status::Ok, 0.5));
    assert_refused(slope(Y, GAIN, &mut derivative), "by parameters, such as 'gain', are not computed");
    assert_refused(slope(tau, U, &mut derivative), "no derivative of variable 'tau'");
    assert_refused(slope(99, U, &mut derivative), "value reference 99");
    unsafe {
        assert_eq!(fmi2GetRealOutputDerivatives(c, &Y, 1, &1, &mut derivative), Status::Ok);
        assert_eq!(derivative, 4.0);
        assert_refused(fmi2GetRealOutputDerivatives(c, &Y, 1, &2, &mut derivative), "order 2");
        assert_refused(fmi2GetRealOutputDerivatives(c, &U, 1, &1, &mut derivative), "'u' is no output");
        fmi2FreeInstance(c);
    }
}

#[test]
fn importer_integrates_the_lag() {
    let fmu = unpack();
    let c = fmu.made_for(squid_fmi2::Interface::ModelExchange, false);
    let (steps, mut state, mut rate) = (2000, 0.0, 0.0);
    unsafe {
        initialise(c);
        assert_eq!(set(c, U, 3.0), Status::Ok);
        let mut info = squid_fmi2::abi::EventInfo::default();
        assert_eq!(fmi2NewDiscreteStates(c, &mut info), Status::Ok);
        assert_eq!((info.next_event_time_defined, info.next_event_time), (1, 1.0));
        assert_eq!(fmi2EnterContinuousTimeMode(c), Status::Ok);
        assert_eq!(fmi2GetNominalsOfContinuousStates(c, &mut state, 1), Status::Ok);
        assert_eq!(state, 4.0);
        assert_eq!(fmi2GetContinuousStates(c, &mut state, 1), Status::Ok);
        for k in 0..steps {
            let (time, h) = (f64::from(k) / f64::from(steps), 1.0 / f64::from(steps));
            let mut rate_at = |time, state: f64| {
                assert_eq!(fmi2SetTime(c, time), Status::Ok);
                assert_eq!(fmi2SetContinuousStates(c, &state, 1), Status::Ok);
                assert_eq!(fmi2GetDerivatives(c, &mut rate, 1), Status::Ok);
                rate
            };
            let middle = state + 0.5 * h * rate_at(time, state);
            state += h * rate_at(time + 0.5 * h, middle);
            let (mut event, mut end) = (1, 1);
            assert_eq!(fmi2CompletedIntegratorStep(c, 1, &mut event, &mut end), Status::Ok);
            assert_eq!((event, end), (0, 0));
        }
        assert_eq!(fmi2SetContinuousStates(c, &state, 1), Status::Ok);
        assert!((real(c, Y) - 6.0 * (1.0 - (-2.0f64).exp())).abs() < 1e-6);
        assert_refused(fmi2SetContinuousStates(c, &f64::NAN, 1), "'y' cannot be set to NaN");
        assert_refused(fmi2SetContinuousStates(c, &0.0, 2), "2 numbers are given, but there are 1");
        assert_refused(fmi2SetTime(c, f64::INFINITY), "the time is inf s");
        fmi2SetContinuousStates(c, &1e7, 1);
        assert_eq!(fmi2GetDerivatives(c, &mut rate, 1), Status::Discard, "the solver shall step back");
        assert_discarded("fmi2GetDerivatives: the derivative of state 'y' is NaN here.");
        let (unknowns, mut values) = ([8, Y], [7.0; 2]);
        assert_eq!(fmi2GetReal(c, unknowns.as_ptr(), 2, values.as_mut_ptr()), Status::Discard);
        assert_discarded("fmi2GetReal: variable 'der(y)' is NaN here.");
        assert!(values[0].is_nan() && values[1] == 1e7, "all are written: {values:?}");
        let (by, values) = (&mut 1.0, &mut [7.0; 2]);
        let status = fmi2GetDirectionalDerivative(c, unknowns.as_ptr(), 2, &Y, 1, by, values.as_mut_ptr());
        assert_eq!(status, Status::Discard);
        assert_discarded("the directional derivative of variable 'der(y)' is NaN here.");
        assert!(values[0].is_nan() && values[1] == 1.0, "all are written: {values:?}");
        fmi2SetContinuousStates(c, &1.0, 1);
        assert_eq!(fmi2GetDerivatives(c, &mut rate, 1), Status::Ok);
        assert_eq!(fmi2EnterEventMode(c), Status::Ok);
        assert_eq!(fmi2Terminate(c), Status::Ok);
        fmi2FreeInstance(c);
    }
    assert_eq!(messages(), Vec::<String>::new());
}

#[test]
fn fmu_with_one_interface_refuses_the_other() {
    for (word, offered, other) in [
        ("CoSimulation", Interface::CoSimulation, Interface::ModelExchange),
        ("ModelExchange", Interface::ModelExchange, Interface::CoSimulation),
    ] {
        let fmu = unpack_files(&[("gain.txt", "2.0"), (INTERFACE_RESOURCE, word)]);
        let both = unpack();
        assert_ne!(fmu.guid, both.guid);
        assert!(fmu.made_for(other, false).is_null());
        let refused = messages();
        assert_eq!(refused.len(), 1);
        let expected = format!("fmi2Instantiate: the FMU was packed without {};", other.name());
        assert!(refused[0].contains(&expected), "{refused:?}");
        let c = fmu.made_for(offered, false);
        assert!(!c.is_null());
        initialise(c);
        unsafe { fmi2FreeInstance(c) };
        assert_eq!(messages(), Vec::<String>::new());
    }
}

#[test]
fn description_offers_the_interface_of_the_resource() {
    let of = |word: Option<&str>| {
        let gain = [("gain.txt", "2.0")];
        let files: Resources = gain.into_iter().chain(word.map(|word| (INTERFACE_RESOURCE, word))).collect();
        describe::<Lag>(&files).map(|described| described.xml).map_err(|error| error.to_string())
    };
    let offered = |word| {
        let xml = of(word).unwrap();
        ["<ModelExchange ", "<CoSimulation "].map(|element| xml.contains(element))
    };
    assert_eq!(offered(None), [true, true]);
    assert_eq!(offered(Some("CoSimulation")), [false, true]);
    assert_eq!(offered(Some("ModelExchange")), [true, false]);
    let refused = of(Some("ScheduledExecution")).unwrap_err();
    let expected =
        "resources/interface.txt is 'ScheduledExecution'; it must be CoSimulation or ModelExchange";
    assert!(refused.ends_with(expected), "{refused}");
}

/// CasADi sets states and inputs in one call.
#[test]
fn set_real_sets_states_in_model_exchange() {
    let fmu = unpack();
    for continuous in [false, true] {
        let c = fmu.made_for(Interface::ModelExchange, false);
        initialise(c);
        if continuous {
            assert_eq!(unsafe { fmi2EnterContinuousTimeMode(c) }, Status::Ok);
        }
        sets_the_state(c);
    }
    // The FMU integrates in co-simulation.
    let c = fmu.instantiate(false);
    initialise(c);
    unsafe {
        assert_refused(fmi2SetReal(c, &Y, 1, &3.0), "'y' may not be set in state 'step complete'");
        fmi2FreeInstance(c);
    }
}

/// Sets state and input of the lag in one call, then with a value that is refused, and frees the instance.
fn sets_the_state(c: Component) {
    let (mut rate, mut state) = (0.0, 0.0);
    unsafe {
        assert_eq!(fmi2SetReal(c, [Y, U].as_ptr(), 2, [3.0, 1.0].as_ptr()), Status::Ok);
        assert_eq!(fmi2GetDerivatives(c, &mut rate, 1), Status::Ok);
        assert_eq!(fmi2GetContinuousStates(c, &mut state, 1), Status::Ok);
        assert_eq!((rate, state, real(c, U)), ((2.0 * 1.0 - 3.0) / 0.5, 3.0, 1.0));
        assert_refused(
            fmi2SetReal(c, [U, Y].as_ptr(), 2, [5.0, f64::NAN].as_ptr()),
            "'y' cannot be set to NaN",
        );
        assert_refused(fmi2SetReal(c, [Y, GAIN].as_ptr(), 2, [7.0, 1.0].as_ptr()), "'gain' may not be set");
        assert_eq!((real(c, Y), real(c, U)), (3.0, 1.0), "a refused call sets nothing");
        fmi2FreeInstance(c);
    }
}
