//! Model description of the plant, and the files that it refuses.

use crate::common::{prepare, remus100, squid, vehicle};
use squid_auv::{LpvModel, LpvModelError};
use squid_fmi2::model_description::{Causality, Kind, ScalarVariable, Variability};
use squid_fmi2::{DescribeError, ResourceError, Resources};
use squid_fmu_plant::{LPV_RESOURCE, PlantError, VEHICLE_RESOURCE, describe};

#[test]
fn description_follows_from_the_files() {
    let described = describe(&squid()).unwrap();
    assert_eq!(described.description.model_identifier, "squid_plant");
    assert_eq!(described.description.model_name, "squid plant");
    for part in [
        "(surrogate coefficients)",
        r#"name="lower" valueReference="0""#,
        r#"<Real declaredType="SI.Force" unit="N" min="-60.0" max="100.0" nominal="100.0" start="#,
        r#"<Real declaredType="SI.AngularVelocity" unit="rad/s" displayUnit="deg/s" nominal="0.1"/>"#,
        r#"<Item name="nonlinear" value="1""#,
        r#"<Item name="lpv" value="2""#,
        r#"<Enumeration declaredType="Fidelity" start="1"/>"#,
        "heave force per |u| w: lift of hull and fixed fins; source: derived from geometry",
        &described.guid,
    ] {
        assert!(described.xml.contains(part), "{part} is not in\n{}", described.xml);
    }
    assert_eq!(describe(&squid()).unwrap().xml, described.xml, "the same bytes every time");
    let remus = describe(&remus100()).unwrap();
    assert_eq!(remus.description.model_identifier, "remus100_plant");
    assert!(remus.xml.contains("(published coefficients)") && !remus.xml.contains("surrogate"));
    let planes = variable(&remus.description.variables, "stern_planes");
    let Kind::Real { unit, display_unit, .. } = &planes.kind else { panic!("{planes:?}") };
    assert_eq!((unit.as_deref(), display_unit.as_deref()), (Some("rad"), Some("deg")));
}

fn variable<'a>(variables: &'a [ScalarVariable], name: &str) -> &'a ScalarVariable {
    variables.iter().find(|one| one.name == name).unwrap_or_else(|| panic!("no variable {name}"))
}

fn start_of(variables: &[ScalarVariable], name: &str) -> f64 {
    match variable(variables, name).kind {
        Kind::Real { start: Some(start), .. } => start,
        ref other => panic!("{name} has no start: {other:?}"),
    }
}

#[test]
fn starts_with_numbers_of_the_files_to_the_last_bit() {
    let resources = squid();
    let variables = describe(&resources).unwrap().description.variables;
    let model = LpvModel::from_json(resources.text(LPV_RESOURCE).unwrap(), LPV_RESOURCE).unwrap();
    let row = &model.trim[1];
    assert_eq!(row.speed, model.speed_centre);
    assert_eq!(start_of(&variables, "initial_speed"), row.speed);
    assert_eq!(start_of(&variables, "operating_speed"), row.speed);
    assert_eq!(start_of(&variables, "initial_depth"), model.depth);
    for (name, value) in ["lower", "upper_port", "upper_starboard"].iter().zip(&row.actuators) {
        assert_eq!(start_of(&variables, name), *value);
    }
}

#[test]
fn tie_between_trim_rows_selects_slower() {
    let mut resources = squid();
    let mut model = LpvModel::from_json(resources.text(LPV_RESOURCE).unwrap(), LPV_RESOURCE).unwrap();
    model.trim.remove(1);
    resources.insert(LPV_RESOURCE, model.to_json().unwrap());
    assert_eq!(start_of(&describe(&resources).unwrap().description.variables, "initial_speed"), 0.5);
}

#[test]
fn coefficients_are_parameters_and_ballast_is_tunable() {
    for (name, resources) in [("squid", squid()), ("remus100", remus100())] {
        let vehicle = vehicle(name);
        let variables = describe(&resources).unwrap().description.variables;
        let mut flight = prepare(&resources, &[]);
        for (position, spec) in vehicle.coefficients.acting().enumerate() {
            let entry = variable(&variables, spec.key);
            let in_flight = ["weight", "buoyancy", "x_G", "z_G"].contains(&spec.key);
            let variability = if in_flight { Variability::Tunable } else { Variability::Fixed };
            assert_eq!((entry.causality, entry.variability), (Causality::Parameter, variability));
            assert_eq!(entry.unit(), Some(spec.unit));
            let value = (spec.get)(&vehicle.coefficients);
            assert_eq!(start_of(&variables, spec.key), value, "{}", spec.key);
            flight.set(spec.key, value + 1e-3 * (position as f64 + 1.0));
        }
        for (position, spec) in vehicle.coefficients.acting().enumerate() {
            let expected = (spec.get)(&vehicle.coefficients) + 1e-3 * (position as f64 + 1.0);
            let found = (spec.get)(&flight.instance.model().settings.coefficients);
            assert_eq!(found, expected, "{} sets itself and nothing else", spec.key);
        }
    }
}

#[test]
fn outputs_depend_on_states_and_current_only() {
    let description = describe(&squid()).unwrap().description;
    let structure = description.structure();
    let name = |index: usize| description.variables[index - 1].name.as_str();
    for unknown in &structure.outputs {
        let on = unknown.dependencies.as_ref().unwrap().iter();
        let on: Vec<_> = on.map(|&(index, _)| name(index)).collect();
        let current = ["current_horizontal", "current_vertical"];
        match name(unknown.index) {
            "speed" => {
                assert_eq!(on, [&current[..], &["pitch", "depth", "distance", "surge_over_ground"]].concat());
            }
            "heave" | "path_speed" => assert_eq!(on[..2], current),
            "altitude" => assert_eq!(on, ["depth", "distance"]),
            constant if constant.starts_with("trim_") => assert!(on.is_empty()),
            state => assert_eq!(on, [state]),
        }
    }
    let of_states = |unknown: usize| !name(unknown).starts_with("der(");
    for unknown in structure.initial_unknowns.iter().filter(|one| of_states(one.index)) {
        let on: Vec<_> =
            unknown.dependencies.as_ref().unwrap().iter().map(|&(index, _)| name(index)).collect();
        match name(unknown.index) {
            "depth" => assert_eq!(on, ["initial_depth"]),
            "altitude" => assert_eq!(on, ["initial_depth", "bottom_depth"]),
            "distance" | "pitch_rate" => assert!(on.is_empty()),
            "surge_over_ground" => {
                assert!(
                    ["initial_speed", "current_vertical", "wave_seed"].iter().all(|one| on.contains(one))
                );
            }
            _ => assert!(on.contains(&"initial_speed") && on.contains(&"Z_uw") && !on.contains(&"lower")),
        }
    }
    assert_eq!(structure.outputs.len(), 8 + 3 + 3 + 1);
    assert_eq!(structure.derivatives.len(), 6 + 3);
    assert_eq!(structure.initial_unknowns.len(), structure.outputs.len() + 2 + structure.derivatives.len());
}

/// Returns the cause of an error, if the model found it.
fn cause(error: &DescribeError) -> Option<&PlantError> {
    std::error::Error::source(error)?.downcast_ref()
}

#[test]
fn rejects_invalid_files() {
    let good = squid();
    let json = good.text(LPV_RESOURCE).unwrap();
    let vehicle = good.text(VEHICLE_RESOURCE).unwrap();
    let stranger = remus100().text(VEHICLE_RESOURCE).unwrap().replace("\"remus100\"", "\"squid\"");
    let errors = [
        (LPV_RESOURCE, "{"),
        (LPV_RESOURCE, &json.replace("auv-lpv-model/1", "auv-lpv-model/9")),
        (LPV_RESOURCE, &json.replace("\"squid\"", "\"whale\"")),
        (VEHICLE_RESOURCE, &vehicle.replace("I_yy", "I_yyy")),
        (VEHICLE_RESOURCE, &vehicle.replace("\"lower\"", "\"pitch\"")),
        (VEHICLE_RESOURCE, &stranger),
    ]
    .map(|(name, text)| {
        let mut damaged = good.clone();
        damaged.insert(name, text);
        describe(&damaged).unwrap_err()
    });
    let alone: Resources = [(VEHICLE_RESOURCE, vehicle)].into_iter().collect();
    let missing = [Resources::default(), alone].map(|files| describe(&files).unwrap_err());
    let [text, format, whale, unknown, twice, other] = errors.each_ref().map(cause);
    assert!(matches!(text, Some(PlantError::Lpv(LpvModelError::NotJson { .. }))), "{text:?}");
    assert!(matches!(format, Some(PlantError::Lpv(LpvModelError::Format { .. }))), "{format:?}");
    assert!(matches!(whale, Some(PlantError::OtherVehicle { .. })), "{whale:?}");
    assert!(matches!(unknown, Some(PlantError::Vehicle(_))), "{unknown:?}");
    assert!(twice.is_none() && matches!(errors[4], DescribeError::Write(_)), "{twice:?}");
    let wrong = LpvModelError::Actuators { key: "trim", found: 3, expected: 2 };
    assert!(matches!(other, Some(PlantError::Lpv(reason)) if *reason == wrong), "{other:?}");
    for (error, file) in missing.iter().zip([VEHICLE_RESOURCE, LPV_RESOURCE]) {
        let Some(PlantError::Resource(ResourceError::Missing { name })) = cause(error) else {
            panic!("{error}")
        };
        assert_eq!(name, file);
    }
    let messages: Vec<_> = errors.iter().chain(&missing).map(ToString::to_string).collect();
    insta::assert_snapshot!(messages.join("\n\n"));
}
