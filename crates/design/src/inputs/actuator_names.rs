//! The names of actuators, which must differ from those of the FMUs' other variables.

use crate::error::InputError;
use auv::{COEFFICIENTS, Vehicle};
use std::collections::BTreeSet;

/// Variables that the three FMUs may have for any vehicle, besides its coefficients, and the first column of every
/// record.
const RESERVED: [&str; 51] = [
    "applied_given",
    "current_horizontal",
    "current_vertical",
    "depth",
    "distance",
    "engaged",
    "external_force_x",
    "external_force_z",
    "external_moment",
    "fidelity",
    "gamma",
    "gamma_certified",
    "heave",
    "heave_over_ground",
    "initial_depth",
    "initial_speed",
    "manual",
    "operating_speed",
    "path_speed",
    "pitch",
    "pitch_rate",
    "pitch_rate_valid",
    "pitch_reference",
    "pitch_reference_used",
    "pitch_step",
    "pitch_valid",
    "ramp_duration",
    "ramp_start",
    "reference_limited",
    "sample_time",
    "scheduling_parameter",
    "speed",
    "speed_from",
    "speed_out_of_range",
    "speed_reference",
    "speed_reference_used",
    "speed_to",
    "speed_valid",
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

/// A variable of plants of vehicles with a given speed.
const GIVEN: &str = "given_speed";

/// Variables of the FMUs of designs that track or measure depth or heave.
const OF_OTHERS: [&str; 5] =
    ["depth_reference", "depth_reference_used", "depth_step", "depth_valid", "heave_valid"];

/// The variables of an actuator.
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
        RESERVED.into_iter().chain(OF_OTHERS).chain(given).chain(COEFFICIENTS.iter().map(|spec| spec.key));
    let mut taken: BTreeSet<String> = reserved.map(str::to_owned).collect();
    for actuator in &vehicle.actuators {
        for name in variables_of(&actuator.name) {
            if !taken.insert(name.clone()) {
                return Err(InputError::ActuatorName {
                    file: file.into(),
                    actuator: actuator.name.clone(),
                    name,
                });
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn squid(root: &Path) -> Vehicle {
        let text = std::fs::read_to_string(root.join("vehicles/squid/vehicle.toml")).unwrap();
        Vehicle::parse(&text, "vehicle.toml").unwrap()
    }

    /// The list is exactly that of the committed model descriptions.
    #[test]
    fn the_list_is_that_of_the_fmus() {
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
        assert_eq!(found, RESERVED.map(str::to_owned).into());
    }

    #[test]
    fn names_that_are_taken_are_refused() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        let mut vehicle = squid(&folder);
        check(&vehicle, "v.toml").unwrap();
        for (name, taken) in [
            ("pitch", "pitch"),
            ("time", "time"),
            ("depth_step", "depth_step"),
            ("mass", "mass"),
            ("upper_port_output", "upper_port_output"),
            ("trim_upper_port", "trim_upper_port"),
        ] {
            vehicle.actuators[2].name = name.to_owned();
            let message = check(&vehicle, "v.toml").unwrap_err().to_string();
            assert!(
                message.starts_with(&format!("v.toml: an actuator cannot be called '{name}'")),
                "{message}"
            );
            assert!(message.contains(&format!("'{taken}'")), "{message}");
        }
    }
}
