//! Model description of the loop, and the files that it refuses.

use crate::example::{Flight, design, manoeuvre, resources, turning, with};
use squid_auv::VIEWS;
use squid_auv::longitudinal::SIGNALS;
use squid_fmi2::model_description::{Causality, Kind};
use squid_fmi2::{Described, Experiment, Instance, Model, Resources, Silent};
use squid_fmu_loop::describe;
use squid_scheduled::MANOEUVRE_RESOURCE;
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

fn refusal(resources: &Resources) -> String {
    describe(resources).unwrap_err().to_string()
}

#[test]
fn rejects_missing_and_damaged_files() {
    for name in ["vehicle.json", "plant.json", "controller.json", "manoeuvre.json"] {
        let complete = resources();
        let others = complete.iter().filter(|(other, _)| *other != name);
        let message = refusal(&others.collect());
        assert!(message.contains(&format!("resources/{name} is missing")), "{message}");
        for damage in [&b"{\"format\": "[..], &b"\xff"[..]] {
            let mut damaged = resources();
            damaged.insert(name, damage);
            let message = refusal(&damaged);
            let named = message.contains(name);
            assert!(named, "{name}: {message}");
        }
    }
}

#[test]
fn rejects_infeasible_manoeuvre() {
    let mut damaged = resources();
    let text = manoeuvre().to_json().unwrap().replace("\"ramp_duration\": 10.0", "\"ramp_duration\": -10.0");
    damaged.insert(MANOEUVRE_RESOURCE, text);
    let message = refusal(&damaged);
    let expected = "resources/manoeuvre.json: ramp_duration is -10, but must be finite and above 0";
    assert!(message.contains(expected), "{message}");
}

#[test]
fn rejects_controller_of_another_vehicle() {
    let mut other = design();
    other.vehicle.name = "whale".to_owned();
    let message = refusal(&with(&other, &manoeuvre()));
    assert!(message.contains("is the design for 'whale', and the vehicle is 'squid'"), "{message}");
    let mut other = design();
    other.actuators.swap(0, 1);
    let message = refusal(&with(&other, &manoeuvre()));
    let expected = "commands upper_port, lower, upper_starboard, and the actuators of the vehicle are lower,";
    assert!(message.contains(expected), "{message}");
    let mut other = design();
    other.actuators[0].curve = Some(Curve::through(vec![[-1.0, -60.0], [1.0, 100.0]], "%").unwrap());
    let message = refusal(&with(&other, &manoeuvre()));
    let expected =
        "commands lower [%], upper_port, upper_starboard, and the actuators of the vehicle are lower,";
    assert!(message.contains(expected), "{message}");
}

#[test]
fn rejects_infeasible_parameters() {
    for (name, value, expected) in [
        ("ramp_duration", 0.0, "the manoeuvre cannot be flown: ramp_duration is 0, but must be"),
        ("step_end", 1.0, "the manoeuvre cannot be flown: step_end is 1 s, before step_time at 2 s"),
        ("speed_from", 80.0, "the vehicle cannot start"),
        ("initial_depth", -1.0, "initial_depth is -1 m, and must be zero"),
    ] {
        let mut flight = Flight::prepare(describe(&resources()).unwrap(), 0.0);
        flight.set(name, value);
        let message = flight.begin().unwrap_err().to_string();
        assert!(message.contains(expected), "{message}");
    }
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
                let words = ["above zero", "excluded"];
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
