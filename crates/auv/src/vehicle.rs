//! A vehicle: its name and status, its coefficients, its actuators.

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

/// A vehicle as read from a vehicle file.
#[derive(Clone, Debug, PartialEq)]
pub struct Vehicle {
    /// Name, for instance `squid`.
    pub name: String,
    /// How well its coefficients are known.
    pub status: Status,
    /// What it is, in a sentence or two.
    pub description: String,
    /// Its coefficients.
    pub coefficients: Coefficients,
    /// Its actuators, thrusters first, each kind in the order of the file.
    pub actuators: Vec<Actuator>,
    /// Those that another autopilot has, which keeps level flight beside an axis; see
    /// [`View::vehicle`](crate::View::vehicle).
    pub others: Vec<Actuator>,
    /// The size of its hull, if the file says it.
    pub geometry: Option<Geometry>,
    /// Where each number comes from, by the name of the coefficient or `actuator.key`.
    pub sources: BTreeMap<String, String>,
    /// What the source prints as its linear model, if the file says so. Only the TOML file contains it, not the
    /// JSON of a vehicle.
    pub published_linear_model: Option<Arc<PublishedLinearModel>>,
}

/// The poles of the linear model that the source of the coefficients prints, to be compared with those computed
/// from the coefficients.
#[derive(Clone, Debug, PartialEq)]
pub struct PublishedLinearModel {
    /// Speed \[m/s\].
    pub speed: f64,
    /// Poles \[rad/s\].
    pub poles: Vec<Complex<f64>>,
    /// Where they are printed.
    pub source: String,
    /// A note on them.
    pub note: String,
}

/// Longer names make names of files that some systems refuse.
const LONGEST_NAME: usize = 64;

/// Whether a name may be part of the names of files and models.
pub(crate) fn is_vehicle_name(name: &str) -> bool {
    name.len() <= LONGEST_NAME
        && name.starts_with(|c: char| c.is_ascii_alphabetic())
        && name.chars().all(|c| c.is_ascii_alphanumeric() || "_- ".contains(c))
}
