//! The controller as an FMU, without the C interface.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

mod example;
#[path = "../../crates/fmi2/tests/flight/mod.rs"]
mod flight;

use example::{design, with_pitch_rate};
use flight::{Flight, Remember, masked};
use serde_json::{Value, json};
use squid_fmi2::model_description::Causality;
use squid_fmi2::{DescribeError, ResourceError, Resources, Silent};
use squid_fmu_controller::{Controller, ControllerError, RESOURCE, describe};
use squid_scheduled::DesignError;

fn resources(design: &Value) -> Resources {
    [(RESOURCE, design.to_string())].into_iter().collect()
}

fn start() -> Flight<Controller> {
    start_of(&design())
}

fn start_of(design: &Value) -> Flight<Controller> {
    Flight::started(describe(&resources(design)).unwrap())
}

#[test]
fn description_follows_from_the_design() {
    let described = describe(&resources(&design())).unwrap();
    assert_eq!(described.description.model_identifier, "test_controller");
    for part in [
        r#"name="thruster" valueReference="8""#,
        r#"<Real declaredType="SI.Force" unit="N" min="-60.0" max="100.0" nominal="100.0"/>"#,
        r#"<Real declaredType="SI.Angle" unit="rad" displayUnit="deg" min="-0.25" max="0.25" nominal="0.2"/>"#,
        r#"<Unknown index="9" dependencies="" dependenciesKind=""/>"#,
        r#"<Unknown index="11" dependencies="2" dependenciesKind="dependent"/>"#,
        &described.guid,
    ] {
        assert!(described.xml.contains(part), "{part} is not in\n{}", described.xml);
    }
    assert_eq!(describe(&resources(&design())).unwrap().xml, described.xml, "the same bytes every time");
}

/// The sign follows from the force, which designs of earlier versions lack.
#[test]
fn describes_the_sign_of_a_command() {
    let described = |design: &Value| {
        let description = describe(&resources(design)).unwrap().description;
        description.variables[description.position("thruster").unwrap()].description.clone()
    };
    let mut design = design();
    assert!(!described(&design).contains("positive"));
    let descriptions = [json!([1.0, 0.0, -0.2]), json!([0.0, -1.0, 0.5])].map(|force| {
        design["actuators"][0]["force"] = force;
        described(&design)
    });
    insta::assert_snapshot!(descriptions.join("\n"));
}

/// Every design has the speed and its reference as inputs; the others follow from the inputs of the controller.
#[test]
fn inputs_are_measured_signals_and_references() {
    let inputs = |design: &Value| {
        let variables = describe(&resources(design)).unwrap().description.variables;
        let inputs = variables.into_iter().filter(|one| one.causality == Causality::Input);
        inputs.map(|one| one.name).collect::<Vec<_>>()
    };
    let mut design = with_pitch_rate();
    let engagement = ["thruster_applied", "fin_applied", "engaged", "applied_given"];
    let with_engagement = |others: &[&'static str]| [others, &engagement].concat();
    let others = ["pitch", "speed", "pitch_rate", "pitch_reference", "speed_reference"];
    assert_eq!(inputs(&design), with_engagement(&others));
    let xml = describe(&resources(&design)).unwrap().xml;
    for part in [
        r#"<ScalarVariable name="pitch_rate" valueReference="2" description="rate of pitch" causality="input""#,
        r#"unit="rad/s" displayUnit="deg/s" nominal="0.1" start="0.0"/>"#,
        r#"<Unknown index="10" dependencies="1 2 3 4 5 6 7 8 9""#,
    ] {
        assert!(xml.contains(part), "{part} is not in\n{xml}");
    }
    design["controller_inputs"] = json!([design["controller_inputs"][2]]);
    for matrix in ["By", "Duy", "Dty"] {
        let rows = design["lft"][matrix].as_array_mut().unwrap();
        rows.iter_mut().for_each(|row| row.as_array_mut().unwrap().truncate(1));
    }
    assert_eq!(inputs(&design), with_engagement(&["speed", "pitch_rate", "speed_reference"]));
}

/// The fin opposes the pitch rate immediately, and moves to a new trim with the filtered reference.
#[test]
fn uses_pitch_rate_and_filtered_reference() {
    let mut flight = start_of(&with_pitch_rate());
    let fin = flight.get("fin");
    flight.set("pitch_rate", 0.1);
    flight.instance.step(0.0, 0.02, &mut Silent).unwrap();
    assert!((flight.get("fin") - fin + 0.2 * 0.2).abs() < 1e-9);
    flight.set("pitch_rate", 0.0);
    let (pitch, speed) = (flight.get("trim_pitch"), flight.get("speed_reference"));
    flight.set("speed_reference", 3.0);
    flight.instance.step(0.02, 2.0 + 0.02, &mut Silent).unwrap();
    let part = 1.0 - (-0.5 * 2.0f64).exp();
    let expected = pitch + part * (3.0 - speed) * 0.09 / 2.51;
    assert!((flight.get("trim_pitch") - expected).abs() < 1e-12);
}

#[test]
fn guid_depends_on_the_design() {
    let mut other = design();
    other["lft"]["A"][0][0] = json!(-1.0000000000000002);
    assert_ne!(describe(&resources(&other)).unwrap().guid, describe(&resources(&design())).unwrap().guid);
}

#[test]
fn logs_nothing_by_default() {
    let mut flight = start();
    let (thrust, fin) = (flight.get("thruster"), flight.get("fin"));
    for k in 0..100 {
        flight.instance.step(f64::from(k) * 0.1, 0.1, &mut Silent).unwrap();
    }
    assert_eq!((flight.get("thruster"), flight.get("fin")), (thrust, fin));
    assert!(thrust > 2.0 && thrust < 70.0);
    assert!(flight.get("scheduling_parameter").abs() < 1e-15);
}

#[test]
fn outputs_hold_until_the_next_step() {
    let mut flight = start();
    let fin = flight.get("fin");
    flight.set("pitch_reference", 0.1);
    assert_eq!(flight.get("fin"), fin, "no output follows an input without a step");
    flight.instance.step(0.0, 0.02, &mut Silent).unwrap();
    assert!(flight.get("fin") > fin);
}

#[test]
fn warns_once_per_excursion() {
    let mut flight = start();
    let mut log = Remember::default();
    for (k, speed) in [1.0, 3.5, 3.6, 2.0, 0.1, 0.1].into_iter().enumerate() {
        flight.set("speed", speed);
        flight.instance.step(k as f64, 1.0, &mut log).unwrap();
    }
    assert_eq!(log.0.len(), 2, "{:?}", log.0);
    for number in [" 3.5 m/s", " 3.49", " 0.5 to 3 m/s"] {
        assert!(log.0[0].contains(number), "{}", log.0[0]);
    }
    insta::assert_snapshot!(masked(&log.0.join("\n")));
}

/// Returns the cause of an error, if the model found it.
fn cause(error: &DescribeError) -> Option<&ControllerError> {
    std::error::Error::source(error)?.downcast_ref()
}

#[test]
fn rejects_invalid_designs() {
    let mut errors = vec![describe(&Resources::default()).unwrap_err()];
    let actuators = |name: &str, unit: &str| {
        json!([{"name": name, "unit": unit, "scale": 1.0, "minimum": -60.0, "maximum": 100.0},
            {"name": "fin", "unit": "rad", "scale": 1.0, "minimum": -1.0, "maximum": 1.0}])
    };
    for (key, value) in [
        ("sample_time", json!(-1.0)),
        ("actuators", actuators("pitch", "N")),
        ("actuators", actuators("a", "lbf")),
    ] {
        let mut damaged = design();
        damaged[key] = value;
        errors.push(describe(&resources(&damaged)).unwrap_err());
    }
    let [missing, number, ..] = &errors[..] else { panic!() };
    let missing = cause(missing);
    assert!(matches!(missing, Some(ControllerError::Resource(ResourceError::Missing { .. }))), "{missing:?}");
    let Some(ControllerError::Design { reason: DesignError::BadNumber { key, value, .. }, .. }) =
        cause(number)
    else {
        panic!("{number}")
    };
    assert_eq!((key.as_str(), *value), ("sample_time", -1.0));
    assert!(errors[2..].iter().all(|error| matches!(error, DescribeError::Write(_))), "{errors:?}");
    insta::assert_snapshot!(errors.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"));
}

/// A finite but absurd speed is not mistaken for a singular loop: the scheduling parameter is held at its limit.
#[test]
fn absurd_speed_is_reported_as_out_of_range() {
    for (speed, rho) in [(1e308, 1.0), (-1e308, -1.0)] {
        let mut flight = start();
        flight.set("speed", speed);
        flight.instance.step(0.0, 0.1, &mut Silent).unwrap();
        assert_eq!(flight.get("scheduling_parameter"), rho);
    }
}
