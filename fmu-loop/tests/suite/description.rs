//! Model description of the loop, and the files that it refuses.

use crate::example::{Flight, design, manoeuvre, resources, turning, with};
use squid_auv::VIEWS;
use squid_auv::longitudinal::SIGNALS;
use squid_fmi2::model_description::{Causality, Kind};
use squid_fmi2::{DescribeError, Described, Experiment, Failure, Instance, Model, Silent};
use squid_fmu_loop::{ClosedLoopError, describe};
use squid_fmu_plant::PlantError;
use squid_scheduled::{MANOEUVRE_RESOURCE, ManoeuvreError};
use squid_signals::Curve;

/// Every signal measured by a controller of any view is an output of the plant with the same name and unit.
#[test]
fn every_signal_is_an_output_of_the_plant() {
    let [plane, whole] =
        [resources(), turning()].map(|files| squid_fmu_plant::describe(&files).unwrap().description);
    let all = VIEWS.iter().flat_map(|view| view.interface.signals).map(|signal| (signal, &whole));
    for (signal, plant) in SIGNALS.iter().map(|signal| (signal, &plane)).chain(all) {
        let output = plant.variables.iter().find(|one| one.name == signal.name).unwrap();
        assert_eq!(
            (output.causality, output.unit()),
            (Causality::Output, Some(signal.unit)),
            "{}",
            signal.name
        );
    }
}

#[test]
fn description_follows_from_the_files() {
    let described = describe(&resources()).unwrap();
    let description = &described.description;
    assert_eq!((description.model_identifier.as_str(), description.model_name.as_str()), ("squid", "squid"));
    let experiment = description.default_experiment;
    assert_eq!((experiment.start_time, experiment.stop_time, experiment.step_size), (0.0, 30.0, 0.02));
    assert_eq!(experiment.tolerance, Some(1e-6));
    let of = |causality| {
        let ours = description.variables.iter().filter(move |one| one.causality == causality);
        ours.map(|one| one.name.as_str()).collect::<Vec<_>>()
    };
    assert_eq!(
        of(Causality::Input),
        [
            "manual",
            "pitch_reference",
            "speed_reference",
            "current_horizontal",
            "current_vertical",
            "external_force_x",
            "external_force_z",
            "external_moment"
        ]
    );
    let outputs = [
        "pitch",
        "speed",
        "pitch_rate",
        "heave",
        "path_speed",
        "depth",
        "altitude",
        "distance",
        "lower_output",
        "upper_port_output",
        "upper_starboard_output",
        "lower",
        "upper_port",
        "upper_starboard",
        "scheduling_parameter",
        "speed_out_of_range",
        "reference_limited",
        "status",
        "lower_saturated",
        "upper_port_saturated",
        "upper_starboard_saturated",
        "trim_pitch",
        "pitch_reference_used",
        "speed_reference_used",
        "tracking_error",
    ];
    assert_eq!(of(Causality::Output), outputs);
    let parameters = of(Causality::Parameter);
    for name in ["pitch_step", "step_end", "speed_from", "ramp_duration", "initial_depth", "fidelity", "z_G"]
    {
        assert!(parameters.contains(&name), "{name}");
    }
    assert!(!parameters.contains(&"initial_speed"), "the manoeuvre says where the flight starts");
    assert!(
        described
            .xml
            .contains(r#"<Real declaredType="SI.Speed" unit="m/s" min="0.0" nominal="1.0" start="0.8"/>"#)
    );
    assert_eq!(describe(&resources()).unwrap().xml, described.xml, "the same bytes every time");
}

#[test]
fn guid_depends_on_the_manoeuvre() {
    let mut longer = manoeuvre();
    longer.duration = 31.0;
    assert_ne!(describe(&with(&design(), &longer)).unwrap().guid, describe(&resources()).unwrap().guid);
}

/// Returns the error in a set of resources as an error of the loop.
fn cause(error: &DescribeError) -> Option<&ClosedLoopError> {
    std::error::Error::source(error)?.downcast_ref()
}

#[test]
fn rejects_missing_and_damaged_files() {
    for name in ["vehicle.json", "plant.json", "controller.json", "manoeuvre.json"] {
        let complete = resources();
        let others = complete.iter().filter(|(other, _)| *other != name);
        let message = describe(&others.collect()).unwrap_err().to_string();
        assert!(message.contains(name), "{message}");
        for damage in [&b"{\"format\": "[..], &b"\xff"[..]] {
            let mut damaged = resources();
            damaged.insert(name, damage);
            let message = describe(&damaged).unwrap_err().to_string();
            assert!(message.contains(name), "{name}: {message}");
        }
    }
}

#[test]
fn rejects_infeasible_manoeuvre() {
    let mut damaged = resources();
    let text = manoeuvre().to_json().unwrap().replace("\"ramp_duration\": 10.0", "\"ramp_duration\": -10.0");
    damaged.insert(MANOEUVRE_RESOURCE, text);
    let error = describe(&damaged).unwrap_err();
    let Some(ClosedLoopError::ManoeuvreFile(ManoeuvreError::BadNumber { key, value, .. })) = cause(&error)
    else {
        panic!("{error}")
    };
    assert_eq!((key.as_str(), *value), ("ramp_duration", -10.0));
    insta::assert_snapshot!(error);
}

#[test]
fn rejects_controller_of_another_vehicle() {
    let mut whale = design();
    whale.vehicle.name = "whale".to_owned();
    let mut order = design();
    order.actuators.swap(0, 1);
    let mut unit = design();
    unit.actuators[0].curve = Some(Curve::through(vec![[-1.0, -60.0], [1.0, 100.0]], "%").unwrap());
    let errors = [whale, order, unit].map(|other| describe(&with(&other, &manoeuvre())).unwrap_err());
    let [whale, order, unit] = errors.each_ref().map(|error| cause(error).unwrap());
    assert!(matches!(whale, ClosedLoopError::OtherVehicle { found, .. } if found == "whale"), "{whale}");
    for (error, found) in [
        (order, ["upper_port", "lower", "upper_starboard"]),
        (unit, ["lower [%]", "upper_port", "upper_starboard"]),
    ] {
        assert!(
            matches!(error, ClosedLoopError::OtherActuators { found: of, .. } if *of == found),
            "{error}"
        );
    }
    insta::assert_snapshot!(errors.map(|error| error.to_string()).join("\n"));
}

#[test]
fn rejects_infeasible_parameters() {
    let rejected = |name: &str, value: f64| {
        let mut flight = Flight::prepare(describe(&resources()).unwrap(), 0.0);
        flight.set(name, value);
        match flight.begin().unwrap_err() {
            Failure::Model(error) => error,
            Failure::Refused(refusal) => panic!("{refusal}"),
        }
    };
    let (ramp, step) = (rejected("ramp_duration", 0.0), rejected("step_end", 1.0));
    assert!(
        matches!(&ramp, ClosedLoopError::Manoeuvre(ManoeuvreError::BadNumber { key, .. }) if key == "ramp_duration"),
        "{ramp}"
    );
    let ClosedLoopError::Manoeuvre(ManoeuvreError::StepEndsBeforeItStarts { step_time, step_end }) = step
    else {
        panic!("{step}")
    };
    assert_eq!((step_time, step_end), (2.0, 1.0));
    insta::assert_snapshot!(format!("{ramp}\n{step}"));
    let fast = rejected("speed_from", 80.0);
    assert!(matches!(fast, ClosedLoopError::Plant(PlantError::Trim(_))), "{fast}");
    let above = rejected("initial_depth", -1.0);
    assert!(matches!(above, ClosedLoopError::Plant(PlantError::AboveSurface { depth: -1.0 })), "{above}");
}

/// Minimum and maximum of FMI include the ends; the description states it if the model refuses an end.
fn ends_are_accepted_or_excluded<M: Model>(describe: fn() -> Described<M>) -> usize {
    let description = describe().description;
    let mut excluded = 0;
    for parameter in description.variables.iter().filter(|one| one.causality == Causality::Parameter) {
        let Kind::Real { min, max, .. } = parameter.kind else { continue };
        for end in [min, max].into_iter().flatten() {
            let mut instance = Instance::new(describe());
            instance.set(&[parameter.value_reference], |_| end).unwrap();
            instance.set_up(Experiment::default()).unwrap();
            instance.enter_initialization().unwrap();
            let Err(refused) = instance.exit_initialization(&mut Silent) else { continue };
            let sentence = refused.to_string();
            let own = sentence.contains(&format!("{} is {end}", parameter.name));
            if own {
                let words = ["above zero", "strictly"];
                let explained = words.iter().any(|word| parameter.description.contains(word));
                assert!(explained, "'{}' at {end}: {sentence}", parameter.description);
                excluded += 1;
            }
        }
    }
    excluded
}

#[test]
fn description_excludes_rejected_ends_of_ranges() {
    assert!(ends_are_accepted_or_excluded(|| squid_fmu_plant::describe(&resources()).unwrap()) >= 3);
    assert!(ends_are_accepted_or_excluded(|| describe(&resources()).unwrap()) >= 6);
}
