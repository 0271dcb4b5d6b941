//! Parameters of a vehicle and of its trim that a model may treat as uncertain.

use thiserror::Error;

use crate::motion::trim::Trim;
use crate::text::nearest;
use crate::vehicle::Vehicle;
use crate::vehicle::actuator::Effect;
use crate::vehicle::coefficients::COEFFICIENTS;

/// Parameter of the linear motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Parameter {
    /// Coefficient, by its key in [`COEFFICIENTS`].
    Coefficient(&'static str),
    /// Coefficient of an actuator, by its key in the vehicle file.
    Effect {
        /// Index of the actuator in the vehicle.
        actuator: usize,
        /// Key, for instance `Z_uu_delta`.
        key: &'static str,
    },
    /// Incidence at trim \[rad\].
    Incidence,
    /// Output of an actuator at trim \[N or rad\], by its index in the vehicle.
    Output(usize),
}

/// Name that matches no parameter of the vehicle.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error(
    "the vehicle has no coefficient '{name}' of {motion}{}",
    suggestion.as_ref().map(|s| format!(" (did you mean '{s}'?)")).unwrap_or_default()
)]
pub struct UnknownParameter {
    /// Requested name.
    pub name: String,
    /// Requested motion.
    pub motion: &'static str,
    /// Most similar name.
    pub suggestion: Option<String>,
    /// All names.
    pub known: String,
}

impl Parameter {
    /// Returns every coefficient of the vehicle and of its actuators, in the order of the vehicle file: for a vehicle
    /// in the vertical plane those of surge, heave and pitch, for one that leaves it those of sway, roll and yaw, on
    /// which its level trim does not depend.
    pub fn all(vehicle: &Vehicle) -> Vec<Self> {
        let lateral = vehicle.coefficients.leaves_plane();
        let acts =
            |key: &str, out_of_plane: bool| lateral == out_of_plane && vehicle.coefficients.surge.uses(key);
        let coefficients = COEFFICIENTS.iter().filter(|spec| acts(spec.key, spec.acts_out_of_plane()));
        let coefficients = coefficients.map(|spec| Self::Coefficient(spec.key));
        let effects = vehicle.actuators.iter().enumerate().flat_map(|(actuator, a)| {
            let keys = a.effect.numbers().into_iter().map(|(key, _)| key);
            keys.filter(|key| acts(key, Effect::acts_out_of_plane(key)))
                .map(move |key| Self::Effect { actuator, key })
        });
        coefficients.chain(effects).collect()
    }

    /// Returns the coefficient with a name: `Z_uw`, or `stern_planes.M_uu_delta`.
    ///
    /// # Errors
    /// [`UnknownParameter`] with the nearest name.
    pub fn named(vehicle: &Vehicle, name: &str) -> Result<Self, UnknownParameter> {
        let all = Self::all(vehicle);
        let names: Vec<String> = all.iter().map(|parameter| parameter.name(vehicle)).collect();
        if let Some(index) = names.iter().position(|known| known == name) {
            return Ok(all[index]);
        }
        let known: Vec<&str> = names.iter().map(String::as_str).collect();
        let leaves_plane = vehicle.coefficients.leaves_plane();
        Err(UnknownParameter {
            name: name.to_string(),
            motion: if leaves_plane { "sway, roll and yaw" } else { "surge, heave and pitch" },
            suggestion: nearest(name, &known),
            known: known.join(", "),
        })
    }

    /// Returns the name, as read by [`Parameter::named`]. A parameter of the trim is `incidence` or, for instance,
    /// `stern_planes at trim`.
    pub fn name(self, vehicle: &Vehicle) -> String {
        match self {
            Self::Coefficient(key) => key.to_string(),
            Self::Effect { actuator, key } => format!("{}.{key}", vehicle.actuators[actuator].name),
            Self::Incidence => "incidence".to_string(),
            Self::Output(actuator) => format!("{} at trim", vehicle.actuators[actuator].name),
        }
    }

    /// Returns the SI unit.
    pub fn unit(self, vehicle: &Vehicle) -> &'static str {
        match self {
            Self::Coefficient(key) => COEFFICIENTS.iter().find(|s| s.key == key).map_or("", |s| s.unit),
            Self::Effect { key, .. } => Effect::unit_of(key),
            Self::Incidence => "rad",
            Self::Output(actuator) => vehicle.actuators[actuator].unit(),
        }
    }

    /// Returns the value \[SI\].
    pub fn value(self, vehicle: &Vehicle, trim: &Trim) -> f64 {
        match self {
            Self::Incidence => trim.incidence,
            Self::Output(actuator) => trim.actuators[actuator],
            of_vehicle => of_vehicle.coefficient(vehicle).unwrap_or(0.0),
        }
    }

    /// Returns the value of a coefficient \[SI\]; `None` for a parameter of the trim.
    pub fn coefficient(self, vehicle: &Vehicle) -> Option<f64> {
        match self {
            Self::Coefficient(key) => {
                COEFFICIENTS.iter().find(|s| s.key == key).map(|s| (s.get)(&vehicle.coefficients))
            }
            Self::Effect { actuator, key } => {
                let number = std::cell::Cell::new(None);
                vehicle.actuators[actuator].effect.map(|k, value| {
                    if k == key {
                        number.set(Some(value));
                    }
                });
                number.get()
            }
            Self::Incidence | Self::Output(_) => None,
        }
    }

    /// Returns the vehicle with another value of a coefficient, unchecked; unchanged for a parameter of the trim.
    #[must_use]
    pub fn with_value(self, vehicle: &Vehicle, value: f64) -> Vehicle {
        let mut changed = vehicle.clone();
        match self {
            Self::Coefficient(key) => {
                changed.coefficients = vehicle.coefficients.map(|k, v| if k == key { value } else { v });
            }
            Self::Effect { actuator, key } => {
                let effect = vehicle.actuators[actuator].effect.map(|k, v| if k == key { value } else { v });
                changed.actuators[actuator].effect = effect;
            }
            Self::Incidence | Self::Output(_) => {}
        }
        changed
    }
}
