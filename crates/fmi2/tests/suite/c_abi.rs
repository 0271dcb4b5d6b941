//! The exported C functions, called by an importer.

use std::ffi::CStr;
use std::ptr::{null, null_mut};

use crate::example::Lag;
use crate::importer::*;
use squid_fmi2::abi::{Component, Status};
use squid_fmi2::{INTERFACE_RESOURCE, Interface, Resources, describe};

/// Messages of the refused calls of a test, for its snapshot.
#[derive(Default)]
struct Refused(Vec<String>);

impl Refused {
    /// Checks that the last call was refused with one message.
    #[track_caller]
    fn add(&mut self, status: Status) {
        assert_eq!(status, Status::Error);
        self.0.push(the_message("one Error logStatusError "));
    }
}

/// Returns the one message since the last look without its beginning, which is checked.
#[track_caller]
fn the_message(begin: &str) -> String {
    let message = only_message();
    message.strip_prefix(begin).unwrap_or_else(|| panic!("{message}")).to_owned()
}

/// Returns the one message since the last look.
#[track_caller]
fn only_message() -> String {
    let mut messages = messages();
    assert_eq!(messages.len(), 1, "{messages:?}");
    messages.remove(0)
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
    let mut refused = Refused::default();
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
        refused.add(fmi2SetInteger(c, &method, 1, &3));
        fmi2FreeInstance(c);
    }
    insta::assert_snapshot!(refused.0.join("\n"));
}

#[test]
fn refuses_wrong_values_and_references() {
    let mut refused = Refused::default();
    let fmu = unpack();
    let c = fmu.instantiate(false);
    initialise(c);
    refused.add(set(c, U, f64::NAN));
    refused.add(set(c, U, f64::INFINITY));
    refused.add(set(c, 99, 0.0));
    refused.add(set(c, Y, 0.0));
    refused.add(set(c, GAIN, 1.0));
    unsafe {
        refused.add(fmi2SetBoolean(c, &U, 1, &1));
        refused.add(fmi2GetReal(c, null(), 1, null_mut()));
        refused.add(fmi2SetReal(c, &U, 1, null()));
        refused.add(fmi2SetReal(c, &U, usize::MAX, &1.0));
        let askew = [0u64; 2].as_ptr().cast::<u8>().add(1).cast::<f64>();
        refused.add(fmi2SetReal(c, &U, 1, askew));
        assert_eq!(fmi2GetReal(c, null(), 0, null_mut()), Status::Ok);
        refused.add(fmi2SetReal(c, [U, U].as_ptr(), 2, [5.0, f64::NAN].as_ptr()));
        assert_eq!(real(c, U), 0.0, "all values or none");
        fmi2FreeInstance(c);
        assert_eq!(set(null_mut(), U, 0.0), Status::Error);
        assert_eq!(fmi2DoStep(null_mut(), 0.0, 0.1, 1), Status::Error);
    }
    insta::assert_snapshot!(refused.0.join("\n"));
}

#[test]
fn refuses_invalid_steps() {
    let mut refused = Refused::default();
    let fmu = unpack();
    let c = fmu.instantiate(false);
    unsafe {
        refused.add(fmi2SetupExperiment(c, 0, 0.0, f64::NAN, 0, 0.0));
        refused.add(fmi2SetupExperiment(c, 1, -1.0, 0.0, 0, 0.0));
        refused.add(fmi2SetupExperiment(c, 0, 0.0, 0.0, 1, f64::NAN));
        refused.add(fmi2SetupExperiment(c, 0, 0.0, 1.0, 1, 0.5));
        assert_eq!(fmi2SetupExperiment(c, 0, 0.0, 0.0, 1, 1.0), Status::Ok);
        assert_eq!(fmi2EnterInitializationMode(c), Status::Ok);
        assert_eq!(fmi2ExitInitializationMode(c), Status::Ok);
        for size in [0.0, -0.01, f64::NAN, f64::INFINITY, 1e300] {
            refused.add(fmi2DoStep(c, 0.0, size, 1));
        }
        refused.add(fmi2DoStep(c, 0.01, 0.01, 1));
        refused.add(fmi2DoStep(c, f64::NAN, 0.01, 1));
        refused.add(fmi2DoStep(c, 0.0, 1.5, 1));
        assert_eq!(fmi2DoStep(c, 1e-13, 0.00999999999999934, 1), Status::Ok);
        assert_eq!(fmi2DoStep(c, 0.01, 0.99, 1), Status::Ok);
        fmi2FreeInstance(c);
    }
    insta::assert_snapshot!(refused.0.join("\n"));
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
    let mut messages = vec![];
    for (name, fmu_type, guid, location) in [
        (name, 1, c"{1}".as_ptr(), uri),
        (name, 1, null(), uri),
        (name, 2, guid, uri),
        (name, 1, guid, null()),
        (name, 1, guid, c"http://x/y".as_ptr()),
        (name, 1, guid, c"file:///no/such/folder".as_ptr()),
        (name, 1, guid, c"file:///no/%23r1%23".as_ptr()),
        (name, 1, guid, nothing.as_ptr()),
        (null(), 1, guid, uri),
        (c"".as_ptr(), 1, guid, uri),
    ] {
        assert!(make(name, fmu_type, guid, location).is_null());
        messages.push(only_message());
    }
    insta::assert_snapshot!(messages.join("\n").replace(fmu.guid.to_str().unwrap(), "{GUID}"));
}

#[test]
fn detects_damaged_resources() {
    let fmu = unpack();
    let path = squid_fmi2::path_of(fmu.uri.to_str().unwrap()).unwrap().join("gain.txt");
    let error = "one Error logStatusError ";
    let names_the_guid = || the_message(error).contains(fmu.guid.to_str().unwrap());
    std::fs::write(&path, "2.5\n").unwrap();
    assert!(fmu.instantiate(false).is_null());
    assert!(names_the_guid());
    std::fs::write(&path, "2\n").unwrap();
    std::fs::write(path.with_file_name("Thumbs.db"), "").unwrap();
    assert!(fmu.instantiate(false).is_null());
    assert!(names_the_guid());
    std::fs::write(&path, "two\n").unwrap();
    assert!(fmu.instantiate(false).is_null());
    insta::assert_snapshot!(the_message(error));
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

#[test]
fn logs_enabled_categories() {
    let mut refused = Refused::default();
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
        refused.add(fmi2SetDebugLogging(c, 1, 1, &c"noise".as_ptr()));
        fmi2FreeInstance(c);
    }
    insta::assert_snapshot!(refused.0.join("\n"));
}

#[test]
fn failed_model_stops_and_can_be_reset() {
    let mut refused = Refused::default();
    let fmu = unpack();
    let c = fmu.instantiate(false);
    unsafe {
        assert_eq!(set(c, GAIN, 0.0), Status::Ok);
        assert_eq!(fmi2EnterInitializationMode(c), Status::Ok);
        refused.add(fmi2ExitInitializationMode(c));
        refused.add(fmi2DoStep(c, 0.0, 1.0, 1));
        assert_eq!(fmi2Reset(c), Status::Ok);
        initialise(c);
        assert_eq!(real(c, GAIN), 2.0);
        fmi2FreeInstance(c);
    }
    insta::assert_snapshot!(refused.0.join("\n"));
}

#[test]
fn panic_becomes_fatal() {
    let mut refused = Refused::default();
    let fmu = unpack();
    let c = fmu.instantiate(false);
    unsafe {
        assert_eq!(fmi2SetInteger(c, &6, 1, &2), Status::Ok);
        initialise(c);
        assert_eq!(fmi2DoStep(c, 0.0, 1.0, 1), Status::Fatal);
        refused.0.push(the_message("one Fatal logStatusFatal "));
        refused.add(fmi2Reset(c));
        fmi2FreeInstance(c);
    }
    insta::assert_snapshot!(refused.0.join("\n"));
}

#[test]
fn states_are_stored_and_restored() {
    let mut refused = Refused::default();
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
        refused.add(fmi2SetFMUstate(c, null_mut()));
        assert_eq!(fmi2FreeFMUstate(c, &mut state), Status::Ok);
        assert!(state.is_null());
        assert_eq!(fmi2FreeFMUstate(c, &mut state), Status::Ok);
        fmi2FreeInstance(c);
        fmi2FreeInstance(other);
    }
    insta::assert_snapshot!(refused.0.join("\n"));
}

#[test]
fn returns_the_status_of_synchronous_steps() {
    let mut refused = Refused::default();
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
        refused.add(fmi2CancelStep(c));
        refused.add(fmi2SetRealInputDerivatives(c, &U, 1, &1, &0.0));
        fmi2FreeInstance(c);
    }
    insta::assert_snapshot!(refused.0.join("\n"));
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
    let mut refused = Refused::default();
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
        refused.add(fmi2SerializeFMUstate(c, state, bytes.as_mut_ptr(), size - 1));
        assert_eq!(fmi2SerializeFMUstate(c, state, bytes.as_mut_ptr(), size), Status::Ok);
        fmi2DoStep(c, 0.3, 0.3, 1);
        let other = fmu.instantiate(false);
        let mut again = null_mut();
        assert_eq!(fmi2DeSerializeFMUstate(other, bytes.as_ptr(), size, &mut again), Status::Ok);
        assert_eq!(fmi2SetFMUstate(other, again), Status::Ok);
        assert_eq!(fmi2DoStep(other, 0.3, 0.3, 1), Status::Ok);
        assert_eq!(real(other, Y).to_bits(), real(c, Y).to_bits());
        let read = |bytes: &[u8]| fmi2DeSerializeFMUstate(c, bytes.as_ptr(), bytes.len(), &mut null_mut());
        refused.add(read(&bytes[..10]));
        refused.add(read(&bytes[..size - 1]));
        refused.add(read(&bytes));
        bytes.truncate(size);
        let changed = |position: usize| {
            let mut changed = bytes.clone();
            changed[position] ^= 0x10;
            changed
        };
        refused.add(read(&changed(0)));
        refused.add(read(&changed(8)));
        refused.add(read(&changed(size / 2)));
        refused.add(fmi2DeSerializeFMUstate(c, null(), 9, &mut null_mut()));
        let exchange = fmu.made_for(squid_fmi2::Interface::ModelExchange, false);
        refused.add(fmi2DeSerializeFMUstate(exchange, bytes.as_ptr(), size, &mut null_mut()));
        refused.add(fmi2SetFMUstate(exchange, state));
        let stranger = unpack_with("3.0\n");
        let foreign = stranger.instantiate(false);
        refused.add(fmi2SetFMUstate(foreign, state));
        refused.add(fmi2FreeFMUstate(foreign, &mut state.clone()));
        refused.add(fmi2DeSerializeFMUstate(foreign, bytes.as_ptr(), size, &mut null_mut()));
        assert_eq!(fmi2FreeFMUstate(c, &mut state), Status::Ok);
        assert_eq!(fmi2FreeFMUstate(c, &mut again), Status::Ok);
        [c, other, exchange, foreign].into_iter().for_each(|one| fmi2FreeInstance(one));
    }
    insta::assert_snapshot!(refused.0.join("\n"));
}

#[test]
fn derivatives_are_exact_and_refused_for_invalid_variables() {
    let mut refused = Refused::default();
    let fmu = unpack();
    let c = fmu.instantiate(false);
    let slope = |unknown: u32, known: u32, derivative: &mut f64| unsafe {
        fmi2GetDirectionalDerivative(c, &unknown, 1, &known, 1, &0.5, derivative)
    };
    let (mut derivative, rate, tau) = (0.0, 8, 7);
    unsafe { fmi2EnterInitializationMode(c) };
    assert_eq!((slope(Y, U, &mut derivative), derivative), (Status::Ok, 1.0));
    refused.add(slope(rate, Y, &mut derivative));
    // FMI lists parameters among the knowns here.
    refused.add(slope(Y, GAIN, &mut derivative));
    unsafe { fmi2ExitInitializationMode(c) };
    set(c, U, 1.0);
    assert_eq!((slope(Y, U, &mut derivative), derivative), (Status::Ok, 0.0));
    assert_eq!((slope(rate, U, &mut derivative), derivative), (Status::Ok, 2.0));
    assert_eq!((slope(rate, Y, &mut derivative), derivative), (Status::Ok, -1.0));
    assert_eq!((slope(Y, Y, &mut derivative), derivative), (Status::Ok, 0.5));
    refused.add(slope(Y, GAIN, &mut derivative));
    refused.add(slope(tau, U, &mut derivative));
    refused.add(slope(99, U, &mut derivative));
    unsafe {
        assert_eq!(fmi2GetRealOutputDerivatives(c, &Y, 1, &1, &mut derivative), Status::Ok);
        assert_eq!(derivative, 4.0);
        refused.add(fmi2GetRealOutputDerivatives(c, &Y, 1, &2, &mut derivative));
        refused.add(fmi2GetRealOutputDerivatives(c, &U, 1, &1, &mut derivative));
        fmi2FreeInstance(c);
    }
    insta::assert_snapshot!(refused.0.join("\n"));
}

#[test]
fn importer_integrates_the_lag() {
    let mut refused = Refused::default();
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
        refused.add(fmi2SetContinuousStates(c, &f64::NAN, 1));
        refused.add(fmi2SetContinuousStates(c, &0.0, 2));
        refused.add(fmi2SetTime(c, f64::INFINITY));
        fmi2SetContinuousStates(c, &1e7, 1);
        assert_eq!(fmi2GetDerivatives(c, &mut rate, 1), Status::Discard, "the solver shall step back");
        refused.0.push(the_message("one Discard logStatusDiscard "));
        let (unknowns, mut values) = ([8, Y], [7.0; 2]);
        assert_eq!(fmi2GetReal(c, unknowns.as_ptr(), 2, values.as_mut_ptr()), Status::Discard);
        refused.0.push(the_message("one Discard logStatusDiscard "));
        assert!(values[0].is_nan() && values[1] == 1e7, "all are written: {values:?}");
        let (by, values) = (&mut 1.0, &mut [7.0; 2]);
        let status = fmi2GetDirectionalDerivative(c, unknowns.as_ptr(), 2, &Y, 1, by, values.as_mut_ptr());
        assert_eq!(status, Status::Discard);
        refused.0.push(the_message("one Discard logStatusDiscard "));
        assert!(values[0].is_nan() && values[1] == 1.0, "all are written: {values:?}");
        fmi2SetContinuousStates(c, &1.0, 1);
        assert_eq!(fmi2GetDerivatives(c, &mut rate, 1), Status::Ok);
        assert_eq!(fmi2EnterEventMode(c), Status::Ok);
        assert_eq!(fmi2Terminate(c), Status::Ok);
        fmi2FreeInstance(c);
    }
    assert_eq!(messages(), Vec::<String>::new());
    insta::assert_snapshot!(refused.0.join("\n"));
}

#[test]
fn fmu_with_one_interface_refuses_the_other() {
    let mut said = vec![];
    for (word, offered, other) in [
        ("CoSimulation", Interface::CoSimulation, Interface::ModelExchange),
        ("ModelExchange", Interface::ModelExchange, Interface::CoSimulation),
    ] {
        let fmu = unpack_files(&[("gain.txt", "2.0"), (INTERFACE_RESOURCE, word)]);
        let both = unpack();
        assert_ne!(fmu.guid, both.guid);
        assert!(fmu.made_for(other, false).is_null());
        said.push(the_message("one Error logStatusError "));
        let c = fmu.made_for(offered, false);
        assert!(!c.is_null());
        initialise(c);
        unsafe { fmi2FreeInstance(c) };
        assert_eq!(messages(), Vec::<String>::new());
    }
    insta::assert_snapshot!(said.join("\n"));
}

#[test]
fn description_offers_the_interface_of_the_resource() {
    let of = |word: Option<&str>| {
        let gain = [("gain.txt", "2.0")];
        let files: Resources = gain.into_iter().chain(word.map(|word| (INTERFACE_RESOURCE, word))).collect();
        describe::<Lag>(&files).map(|described| described.xml)
    };
    let offered = |word| {
        let xml = of(word).unwrap();
        ["<ModelExchange ", "<CoSimulation "].map(|element| xml.contains(element))
    };
    assert_eq!(offered(None), [true, true]);
    assert_eq!(offered(Some("CoSimulation")), [false, true]);
    assert_eq!(offered(Some("ModelExchange")), [true, false]);
    insta::assert_snapshot!(of(Some("ScheduledExecution")).unwrap_err());
}

/// CasADi sets states and inputs in one call.
#[test]
fn set_real_sets_states_in_model_exchange() {
    let mut refused = Refused::default();
    let fmu = unpack();
    for continuous in [false, true] {
        let c = fmu.made_for(Interface::ModelExchange, false);
        initialise(c);
        if continuous {
            assert_eq!(unsafe { fmi2EnterContinuousTimeMode(c) }, Status::Ok);
        }
        sets_the_state(c, &mut refused);
    }
    // The FMU integrates in co-simulation.
    let c = fmu.instantiate(false);
    initialise(c);
    unsafe {
        refused.add(fmi2SetReal(c, &Y, 1, &3.0));
        fmi2FreeInstance(c);
    }
    insta::assert_snapshot!(refused.0.join("\n"));
}

/// Sets state and input of the lag at once, then with a value that is refused, and frees it.
fn sets_the_state(c: Component, refused: &mut Refused) {
    let (mut rate, mut state) = (0.0, 0.0);
    unsafe {
        assert_eq!(fmi2SetReal(c, [Y, U].as_ptr(), 2, [3.0, 1.0].as_ptr()), Status::Ok);
        assert_eq!(fmi2GetDerivatives(c, &mut rate, 1), Status::Ok);
        assert_eq!(fmi2GetContinuousStates(c, &mut state, 1), Status::Ok);
        assert_eq!((rate, state, real(c, U)), ((2.0 * 1.0 - 3.0) / 0.5, 3.0, 1.0));
        refused.add(fmi2SetReal(c, [U, Y].as_ptr(), 2, [5.0, f64::NAN].as_ptr()));
        refused.add(fmi2SetReal(c, [Y, GAIN].as_ptr(), 2, [7.0, 1.0].as_ptr()));
        assert_eq!((real(c, Y), real(c, U)), (3.0, 1.0), "a refused call sets nothing");
        fmi2FreeInstance(c);
    }
}
