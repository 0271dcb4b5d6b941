//! Names of actuators, which must differ from those of the FMUs' other variables.

use crate::error::InputError;
use squid_auv::{Actuator, COEFFICIENTS, VIEWS, Vehicle};
use std::collections::BTreeMap;

/// Variables that the three FMUs may have for any vehicle, besides its signals and coefficients, and the first column
/// of every record.
const RESERVED: [&str; 40] = [
    "applied_given",
    "bottom_depth",
    "bottom_slope_north",
    "current_horizontal",
    "current_vertical",
    "distance",
    "engaged",
    "external_force_x",
    "external_force_z",
    "external_moment",
    "fidelity",
    "gamma",
    "gamma_certified",
    "heave_over_ground",
    "initial_depth",
    "initial_speed",
    "manual",
    "operating_speed",
    "path_speed",
    "ramp_duration",
    "ramp_start",
    "reference_limited",
    "sample_time",
    "scheduling_parameter",
    "speed_from",
    "speed_out_of_range",
    "speed_to",
    "stale_after",
    "status",
    "step_end",
    "step_time",
    "surge_over_ground",
    "time",
    "tracking_error",
    "trim_pitch",
    "wave_gamma",
    "wave_heading",
    "wave_height",
    "wave_period",
    "wave_seed",
];

/// Variable of plants of vehicles with a given speed.
const GIVEN: &str = "given_speed";

/// Variables of plants in six degrees of freedom.
const OF_TURNING: [&str; 14] = [
    "angular_velocity_x",
    "angular_velocity_y",
    "angular_velocity_z",
    "bottom_slope_east",
    "current_east",
    "current_north",
    "east",
    "external_force_y",
    "external_moment_x",
    "external_moment_y",
    "external_moment_z",
    "initial_heading",
    "north",
    "sway_over_ground",
];

/// Variables of the FMUs for each signal.
fn of_signals() -> impl Iterator<Item = String> {
    let names = VIEWS.iter().flat_map(|view| view.interface.signals).map(|signal| signal.name);
    let of =
        |name| ["", "_valid", "_reference", "_reference_used", "_step"].map(|end| format!("{name}{end}"));
    names.flat_map(of)
}

/// Variables of an actuator.
fn variables_of(name: &str) -> [String; 5] {
    let with = |end: &str| format!("{name}_{end}");
    [name.to_owned(), with("output"), with("applied"), with("saturated"), format!("trim_{name}")]
}

/// Checks that no two variables of the FMUs have the same name; `file` is for the message.
///
/// # Errors
/// [`InputError::ActuatorName`].
pub fn check(vehicle: &Vehicle, file: &str) -> Result<(), InputError> {
    let given = vehicle.coefficients.surge.is_given().then_some(GIVEN);
    let reserved =
        RESERVED.into_iter().chain(OF_TURNING).chain(given).chain(COEFFICIENTS.iter().map(|spec| spec.key));
    let reserved = reserved.map(str::to_owned).chain(of_signals());
    // Owner of each variable: an actuator, or `None`.
    let mut owners: BTreeMap<String, Option<&str>> = reserved.map(|name| (name, None)).collect();
    for Actuator { name: actuator, .. } in &vehicle.actuators {
        for name in variables_of(actuator) {
            if let Some(owner) = owners.insert(name.clone(), Some(actuator)) {
                let (actuator, other) = (actuator.clone(), owner.map(str::to_owned));
                return Err(InputError::ActuatorName { file: file.into(), actuator, name, other });
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;
    use std::path::Path;

    fn squid(root: &Path) -> Vehicle {
        let text = std::fs::read_to_string(root.join("vehicles/squid/vehicle.toml")).unwrap();
        Vehicle::parse(&text, "vehicle.toml").unwrap()
    }

    /// The list equals that of the committed model descriptions.
    #[test]
    fn reserved_names_are_those_of_fmus() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        let vehicle = squid(&folder);
        let mut found: BTreeSet<String> = BTreeSet::from(["time".to_owned()]);
        for name in ["squid", "squid_plant", "squid_controller"] {
            let xml = std::fs::read_to_string(folder.join(format!("modelDescription/{name}.xml"))).unwrap();
            let names =
                xml.split("<ScalarVariable name=\"").skip(1).filter_map(|rest| rest.split('"').next());
            found.extend(names.filter(|name| !name.starts_with("der(")).map(str::to_owned));
        }
        for name in vehicle.in_plane().actuators.iter().flat_map(|one| variables_of(&one.name)) {
            assert!(found.remove(&name), "{name}");
        }
        for spec in COEFFICIENTS.iter().filter(|spec| !spec.acts_out_of_plane()) {
            assert!(found.remove(spec.key), "{}", spec.key);
        }
        let signals: BTreeSet<String> = of_signals().collect();
        found.retain(|name| !signals.contains(name));
        assert_eq!(found, RESERVED.map(str::to_owned).into());
    }

    #[test]
    fn rejects_names_of_other_variables() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        let mut vehicle = squid(&folder);
        check(&vehicle, "v.toml").unwrap();
        let mut messages = Vec::new();
        for (name, owner) in [
            ("pitch", None),
            ("time", None),
            ("heading_rate", None),
            ("north", None),
            ("depth_step", None),
            ("mass", None),
            ("upper_port_output", Some("upper_port")),
            ("trim_upper_port", Some("upper_port")),
        ] {
            vehicle.actuators[2].name = name.to_owned();
            let error = check(&vehicle, "v.toml").unwrap_err();
            let InputError::ActuatorName { actuator, name: found, other, .. } = &error else {
                panic!("{error}")
            };
            assert_eq!((actuator.as_str(), found.as_str(), other.as_deref()), (name, name, owner));
            messages.push(error.to_string());
        }
        insta::assert_snapshot!(messages[6..].join("\n"));
    }
}
