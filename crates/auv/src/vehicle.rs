//! Vehicle: its name and status, its coefficients, its actuators.

pub(crate) mod actuator;
pub(crate) mod allowed;
pub(crate) mod ballast;
pub(crate) mod coefficients;
mod file;
pub(crate) mod geometry;
pub(crate) mod hull;
pub(crate) mod json;
mod plane;
mod plausible;
pub(crate) mod surge;

use std::collections::BTreeMap;
use std::sync::Arc;

use nalgebra::Complex;
use squid_signals::Status;

use crate::vehicle::actuator::Actuator;
use crate::vehicle::coefficients::Coefficients;
use crate::vehicle::geometry::Geometry;

/// Vehicle as read from a vehicle file.
#[derive(Clone, Debug, PartialEq)]
pub struct Vehicle {
    /// Name, for instance `squid`.
    pub name: String,
    /// Origin of the coefficients.
    pub status: Status,
    /// Description in a sentence or two.
    pub description: String,
    /// Coefficients.
    pub coefficients: Coefficients,
    /// Actuators, thrusters first, each kind in the order of the file.
    pub actuators: Vec<Actuator>,
    /// Actuators of another autopilot, which keeps level flight beside an axis; see
    /// [`View::vehicle`](crate::View::vehicle).
    pub others: Vec<Actuator>,
    /// Size of the hull, if given in the file.
    pub geometry: Option<Geometry>,
    /// Source of each number, by the name of the coefficient or `actuator.key`.
    pub sources: BTreeMap<String, String>,
    /// Linear model printed in the source, if given in the file. The JSON of a vehicle does not contain it.
    pub published_linear_model: Option<Arc<PublishedLinearModel>>,
}

/// Poles of the linear model printed in the source of the coefficients, for comparison with those computed from the
/// coefficients.
#[derive(Clone, Debug, PartialEq)]
pub struct PublishedLinearModel {
    /// Speed \[m/s\].
    pub speed: f64,
    /// Poles \[rad/s\].
    pub poles: Vec<Complex<f64>>,
    /// Source of the poles.
    pub source: String,
    /// Note on the poles.
    pub note: String,
}

/// Length limit of a name: some systems refuse longer file names.
const LONGEST_NAME: usize = 64;

/// Allowed names of a vehicle, for messages.
pub const VEHICLE_NAMES: &str = "at most 64 letters, digits, '_', '-' and spaces, starting with a letter";

/// Returns `true` if a name may be part of the names of files and models.
pub fn is_vehicle_name(name: &str) -> bool {
    name.len() <= LONGEST_NAME
        && name.starts_with(|c: char| c.is_ascii_alphabetic())
        && name.chars().all(|c| c.is_ascii_alphanumeric() || "_- ".contains(c))
}
