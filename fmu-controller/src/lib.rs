//! The gain-scheduled controller as a co-simulation FMU:
//!
//! ```text
//! resources/controller.json, controller_2.json ... -> one axis each -> table of variables -> FMU
//! ```
//!
//! The crate contains no vehicle data: names and limits of the actuators, trim, sample time and matrices come from the
//! frozen design. The C symbols are in `library`.

mod axis;
mod controller;
mod tangents;
mod variables;

pub use axis::{Axis, ControllerError, RESOURCE};
pub use controller::{Controller, of_axis, prefix};
pub use variables::{healths, outputs, used_name};

use squid_fmi2::{DescribeError, Described, Resources};

/// Returns model description, GUID and XML of the controller in `resources`.
///
/// # Errors
/// Returns a [`DescribeError`] if the design is missing, damaged or does not give a valid FMU.
pub fn describe(resources: &Resources) -> Result<Described<Controller>, DescribeError> {
    squid_fmi2::describe(resources)
}

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
