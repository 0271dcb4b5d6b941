//! The vehicle as an FMU for co-simulation and model exchange, in the vertical plane, or in six degrees of freedom if
//! it has coefficients of sway, roll and yaw:
//!
//! ```text
//! resources/vehicle.json, plant.json -> squid_auv::Plant -> table of variables -> FMU
//! ```
//!
//! The crate contains no vehicle data: coefficients, actuators and limits come from the vehicle file, start values from
//! the trim table of its LPV model. The C symbols are in `library`.
//!
//! A larger model can contain a [`PlantModel`] and reuse parts of its table with [`squid_fmi2::Variable::embedded`]:
//!
//! ```
//! use squid_fmu_plant::{PlantModel, parameters};
//! struct Loop { plant: PlantModel }
//!
//! fn table(model: &Loop) -> Vec<squid_fmi2::Variable<Loop>> {
//!     let of_plant = parameters(&model.plant).into_iter();
//!     of_plant.map(|variable| variable.embedded(|m: &Loop| &m.plant, |m| &mut m.plant)).collect()
//! }
//! ```

mod error;
mod exchange;
mod fmu;
mod model;
mod quantity;
mod resources;
mod state;
mod states;
mod tangents;
mod variables;
mod waves;

pub use error::PlantError;
pub use fmu::TOLERANCE;
pub use model::{Inputs, PlantModel, Settings};
pub use quantity::Quantity;
pub use resources::{LPV_RESOURCE, VEHICLE_RESOURCE};
pub use states::states;
pub use variables::{GIVEN_SPEED, inputs, of_current, outputs, parameters};
pub use waves::{WAVES, WaveParameters};

use squid_fmi2::{DescribeError, Described, Resources};

/// Returns model description, GUID and XML of the plant in `resources`.
///
/// # Errors
/// Returns a [`DescribeError`] if a file is missing or damaged, or does not give a valid FMU.
pub fn describe(resources: &Resources) -> Result<Described<PlantModel>, DescribeError> {
    squid_fmi2::describe(resources)
}

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
