//! Vehicle and autopilot in one loop as an FMU for co-simulation and model exchange:
//!
//! ```text
//! resources/vehicle.json, plant.json -> squid_fmu_plant::PlantModel      -+
//! resources/controller.json          -> squid_fmu_controller::Axis -------+-> ClosedLoop -> table of variables -> FMU
//! resources/controller_2.json        -> the same, of heading; ... --+
//! resources/manoeuvre.json           -> squid_scheduled::Manoeuvre                  -+
//! ```
//!
//! The loop gives the same flight as a master that steps the controller's FMU and then the plant's at every sample
//! time. A vehicle with sway, roll and yaw has several axes: one of pitch or depth, and those of other views. Without
//! connections it flies its manoeuvre; with the input `manual` it follows the external references.
//!
//! The crate contains no vehicle and no manoeuvre. The C symbols are in `library`.

mod closed_loop;
mod error;
mod fmu;
mod tangents;
mod variables;

pub use closed_loop::{ClosedLoop, Override};
pub use error::ClosedLoopError;

use squid_fmi2::{DescribeError, Described, Resources};

/// Model description, GUID and XML of the loop in `resources`.
///
/// # Errors
/// [`DescribeError`] when a file is missing or damaged, or does not give a legal FMU.
pub fn describe(resources: &Resources) -> Result<Described<ClosedLoop>, DescribeError> {
    squid_fmi2::describe(resources)
}
