//! JSON of a vehicle, for exchange between programs: SI units, every number finite and allowed. People write TOML; see
//! [`Vehicle::parse`].

#![allow(non_snake_case, reason = "the field's symbols keep their capitals: Z is a force, z a length")]

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use serde_with::rust::maps_duplicate_key_is_error;
use squid_signals::Curve;
use thiserror::Error;

use crate::vehicle::actuator::{Actuator, Effect, LAG_WITH_RATE, allowed, is_actuator_name};
use crate::vehicle::allowed::Allowed;
use crate::vehicle::coefficients::{COEFFICIENTS, CoefficientError, Coefficients};
use crate::vehicle::geometry::Geometry;
use crate::vehicle::hull::Hull;
use crate::vehicle::surge::Surge;
use crate::vehicle::{Status, Vehicle, is_vehicle_name};

/// Value of `format` in the files that this version reads and writes.
pub const VEHICLE_FORMAT: &str = "auv-vehicle/1";

const LIMITS: [&str; 3] = ["min", "max", "lag"];
/// Key of the rate limit, omitted if there is none.
const RATE: &str = "rate";

type Numbers = BTreeMap<String, f64>;

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    format: String,
    name: String,
    status: String,
    description: String,
    /// Values by the keys of [`COEFFICIENTS`]; an omitted one has its default, as in a vehicle file. Those of sway,
    /// roll and yaw are omitted for a vehicle in the vertical plane.
    #[serde(deserialize_with = "maps_duplicate_key_is_error::deserialize")]
    coefficients: Numbers,
    /// Stations of the [`Hull`]; omitted if there are none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    stations: Vec<[f64; 2]>,
    /// Time constant of a given speed, s; omitted if surge has an equation of motion.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    given_speed_lag: Option<f64>,
    /// Length and diameter of the hull, m; omitted if absent in the vehicle file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    geometry: Option<[f64; 2]>,
    actuators: Vec<Row>,
    #[serde(deserialize_with = "maps_duplicate_key_is_error::deserialize")]
    sources: BTreeMap<String, String>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Row {
    name: String,
    kind: String,
    /// Values of [`LIMITS`], [`RATE`], and the numbers of the [`Effect`] by their keys in a vehicle file; those of
    /// sway, roll and yaw are omitted if they are 0.
    #[serde(deserialize_with = "maps_duplicate_key_is_error::deserialize")]
    numbers: Numbers,
    /// Curve of a thruster; omitted if there is none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    curve: Option<Curve>,
}

/// Error in the JSON of a vehicle.
#[derive(Debug, Error, PartialEq)]
#[error("{file}: {problem}")]
pub struct VehicleJsonError {
    /// File, as named by the caller.
    pub file: String,
    /// Description of the error.
    pub problem: JsonProblem,
}

/// Error in the JSON of a vehicle, without the name of the file.
#[derive(Debug, Error, PartialEq)]
#[allow(missing_docs, reason = "the message says what each field is")]
pub enum JsonProblem {
    /// Text that is not the JSON of a vehicle.
    #[error("this is not a vehicle: {0}")]
    NotJson(String),
    /// A text or number that is not allowed.
    #[error("`{key}` is {found}; it must be {allowed}")]
    NotAllowed { key: String, found: String, allowed: &'static str },
    /// A missing number.
    #[error("`{0}` is missing")]
    Missing(String),
    /// An unknown number.
    #[error("`{0}` is unknown")]
    Unknown(String),
    /// Coefficients that are not allowed.
    #[error(transparent)]
    Coefficients(#[from] CoefficientError),
}

impl Vehicle {
    /// Reads a vehicle from JSON, as returned by [`Vehicle::to_json`], and checks it like a vehicle file; `file` is its
    /// name in messages.
    ///
    /// # Errors
    /// [`VehicleJsonError`]: not JSON, another format, a number that is missing, unknown or not allowed.
    #[inline]
    pub fn from_json(text: &str, file: &str) -> Result<Self, VehicleJsonError> {
        let read = serde_json::from_str(text).map_err(|error| JsonProblem::NotJson(error.to_string()));
        read.and_then(vehicle).map_err(|problem| VehicleJsonError { file: file.to_owned(), problem })
    }

    /// Returns the vehicle as JSON, with numbers that read back to the same `f64`.
    ///
    /// # Errors
    /// [`VehicleJsonError`]: JSON cannot represent a number that is not finite.
    pub fn to_json(&self) -> Result<String, VehicleJsonError> {
        let file = File {
            format: VEHICLE_FORMAT.to_owned(),
            name: self.name.clone(),
            status: self.status.word().to_owned(),
            description: self.description.clone(),
            coefficients: COEFFICIENTS
                .iter()
                .filter(|spec| self.coefficients.leaves_plane() || !spec.acts_out_of_plane())
                .map(|spec| (spec.key.to_owned(), (spec.get)(&self.coefficients)))
                .collect(),
            stations: self.coefficients.hull.stations().to_vec(),
            given_speed_lag: match self.coefficients.surge {
                Surge::Free => None,
                Surge::Given { lag } => Some(lag),
            },
            geometry: self.geometry.map(|Geometry { length, diameter }| [length, diameter]),
            actuators: self.actuators.iter().map(row).collect(),
            sources: self.sources.clone(),
        };
        serde_json::to_string_pretty(&file).map(|text| text + "\n").map_err(|error| VehicleJsonError {
            file: self.name.clone(),
            problem: JsonProblem::NotJson(error.to_string()),
        })
    }
}

fn row(actuator: &Actuator) -> Row {
    let Actuator { name, min, max, lag, rate, curve, effect } = actuator;
    let mut numbers: Numbers = LIMITS.iter().map(|&key| key.to_owned()).zip([*min, *max, *lag]).collect();
    numbers.extend(rate.map(|rate| (RATE.to_owned(), rate)));
    let of_effect =
        effect.numbers().into_iter().filter(|(key, value)| !Effect::acts_out_of_plane(key) || *value != 0.0);
    numbers.extend(of_effect.map(|(key, value)| (key.to_owned(), value)));
    Row { name: name.clone(), kind: effect.kind().to_owned(), numbers, curve: curve.clone() }
}

#[inline]
fn vehicle(file: File) -> Result<Vehicle, JsonProblem> {
    let File { format, name, status, description, coefficients, stations, .. } = file;
    let File { given_speed_lag, geometry, actuators, sources, .. } = file;
    if format != VEHICLE_FORMAT {
        return Err(not_allowed("format", format, VEHICLE_FORMAT));
    }
    if !is_vehicle_name(&name) {
        return Err(not_allowed("name", name, "a valid vehicle name"));
    }
    let Some(status) = Status::ALL.into_iter().find(|known| known.word() == status) else {
        return Err(not_allowed("status", status, "surrogate, published or measured"));
    };
    let mut coefficients = read_coefficients(&coefficients)?;
    if !stations.is_empty() {
        let invalid = || not_allowed("stations", "not in order".to_owned(), Hull::ALLOWED);
        coefficients.hull = Hull::new(&stations).ok_or_else(invalid)?;
    }
    let actuators = read_actuators(actuators)?;
    if let Some(lag) = given_speed_lag {
        if !Allowed::Positive.contains(lag) {
            return Err(not_allowed("given_speed_lag", lag.to_string(), Allowed::Positive.describe()));
        }
        if let Some(one) = actuators.iter().find(|one| one.effect.acts_along()) {
            let allowed = "a control_surface without drag, because the speed is given";
            return Err(not_allowed(&one.name, one.effect.kind().to_owned(), allowed));
        }
        coefficients.surge = Surge::Given { lag };
    }
    let checked = |[length, diameter]: [f64; 2]| {
        let found = || not_allowed("geometry", format!("[{length}, {diameter}]"), Geometry::ALLOWED);
        Geometry::new(length, diameter).ok_or_else(found)
    };
    let geometry = geometry.map(checked).transpose()?;
    let published_linear_model = None;
    Ok(Vehicle {
        name,
        status,
        description,
        coefficients,
        others: vec![],
        actuators,
        geometry,
        sources,
        published_linear_model,
    })
}

#[inline]
fn read_coefficients(numbers: &Numbers) -> Result<Coefficients, JsonProblem> {
    let required = COEFFICIENTS.iter().filter(|spec| spec.is_required()).map(|spec| spec.key);
    let optional = COEFFICIENTS.iter().filter(|spec| !spec.is_required()).map(|spec| spec.key);
    check_keys("coefficients", numbers, &required.collect::<Vec<_>>(), &optional.collect::<Vec<_>>())?;
    let mut coefficients = Coefficients::default();
    for spec in COEFFICIENTS {
        numbers.get(spec.key).into_iter().for_each(|number| (spec.set)(&mut coefficients, *number));
    }
    coefficients.complete(|key| numbers.contains_key(key));
    coefficients.check()?;
    Ok(coefficients)
}

#[inline]
fn read_actuators(rows: Vec<Row>) -> Result<Vec<Actuator>, JsonProblem> {
    let mut actuators: Vec<Actuator> = Vec::new();
    for row in rows {
        if !is_actuator_name(&row.name) || actuators.iter().any(|other| other.name == row.name) {
            let allowed = "a unique name of letters, digits and `_`";
            return Err(not_allowed("actuators.name", row.name, allowed));
        }
        actuators.push(actuator(row)?);
    }
    if actuators.is_empty() {
        Err(not_allowed("actuators", "empty".to_owned(), "a list of at least one actuator"))
    } else {
        Ok(actuators)
    }
}

#[inline]
fn actuator(row: Row) -> Result<Actuator, JsonProblem> {
    let Row { name, kind, numbers, curve } = row;
    let Some(effect) = Effect::ALL.into_iter().find(|known| known.kind() == kind) else {
        return Err(not_allowed(
            &format!("{name}.kind"),
            kind,
            "thruster, thruster_group or control_surface",
        ));
    };
    let of_effect = effect.numbers().map(|(key, _)| key);
    let (optional, required): (Vec<&str>, Vec<&str>) =
        of_effect.into_iter().partition(|key| Effect::acts_out_of_plane(key));
    let required: Vec<&str> = LIMITS.into_iter().chain(required).collect();
    let optional: Vec<&str> = optional.into_iter().chain([RATE]).collect();
    check_keys(&name, &numbers, &required, &optional)?;
    for (key, value) in &numbers {
        let allowed = allowed(key);
        if !allowed.contains(*value) {
            return Err(not_allowed(&format!("{name}.{key}"), value.to_string(), allowed.describe()));
        }
    }
    let [min, max, lag] = LIMITS.map(|key| numbers[key]);
    if min >= max {
        return Err(not_allowed(&format!("{name}.min"), min.to_string(), "below max"));
    }
    let rate = numbers.get(RATE).copied();
    if rate.is_some() && lag <= 0.0 {
        return Err(not_allowed(&format!("{name}.lag"), lag.to_string(), LAG_WITH_RATE));
    }
    if curve.as_ref().is_some_and(|curve| !fits(curve, min, max, &effect)) {
        let found = format!("a curve that does not cover {min} to {max}");
        return Err(not_allowed(
            &format!("{name}.curve"),
            found,
            "the curve of a thruster and cover its limits",
        ));
    }
    let effect = effect.map(|key, _| numbers.get(key).copied().unwrap_or(0.0));
    Ok(Actuator { name, min, max, lag, rate, curve, effect })
}

/// Returns `true` if a curve is that of a thruster and covers these limits.
fn fits(curve: &Curve, min: f64, max: f64, effect: &Effect) -> bool {
    let [least, most] = curve.ends();
    least <= min && max <= most && effect.works_at_rest()
}

fn not_allowed(key: &str, found: String, allowed: &'static str) -> JsonProblem {
    JsonProblem::NotAllowed { key: key.to_owned(), found, allowed }
}

/// Checks that all required numbers are present, and no others except optional ones.
#[inline]
fn check_keys(
    path: &str,
    numbers: &Numbers,
    required: &[&str],
    optional: &[&str],
) -> Result<(), JsonProblem> {
    let known = |key: &str| required.contains(&key) || optional.contains(&key);
    let unknown = numbers.keys().find(|key| !known(key));
    let missing = required.iter().find(|&&key| !numbers.contains_key(key));
    match (unknown, missing) {
        (Some(key), _) => Err(JsonProblem::Unknown(format!("{path}.{key}"))),
        (None, Some(key)) => Err(JsonProblem::Missing(format!("{path}.{key}"))),
        (None, None) => Ok(()),
    }
}
