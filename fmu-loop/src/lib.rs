//! Vehicle and autopilot in closed loop as an FMU for co-simulation and model exchange:
//!
//! ```text
//! resources/vehicle.json, plant.json -> squid_fmu_plant::PlantModel   -+
//! resources/controller.json          -> squid_fmu_controller::Axis    -+-> ClosedLoop -> table of variables -> FMU
//! resources/controller_2.json, ...   -> further axes, such as heading -+
//! resources/manoeuvre.json           -> squid_scheduled::Manoeuvre    -+
//! ```
//!
//! The loop gives the same result as a master that steps the controller FMU and then the plant FMU at every sample
//! time. A vehicle with sway, roll and yaw has several axes: one of pitch or depth, and those of other views. Without
//! connections it follows its manoeuvre; with the input `manual` it follows the external references.
//!
//! The crate contains no vehicle data and no manoeuvre. The C symbols are in `library`.

mod closed_loop;
mod error;
mod fmu;
mod tangents;
mod variables;

pub use closed_loop::{ClosedLoop, Override};
pub use error::ClosedLoopError;

use squid_fmi2::{DescribeError, Described, Resources};

/// Returns model description, GUID and XML of the loop in `resources`.
///
/// # Errors
/// Returns a [`DescribeError`] if a file is missing or damaged, or does not give a valid FMU.
pub fn describe(resources: &Resources) -> Result<Described<ClosedLoop>, DescribeError> {
    squid_fmi2::describe(resources)
}

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
