//! Vehicle and autopilot in one loop as an FMU for co-simulation and model exchange:
//!
//! ```text
//! resources/vehicle.json, plant.json -> fmu_plant::PlantModel      -+
//! resources/controller.json          -> fmu_controller::Controller -+-> ClosedLoop -> table of variables -> FMU
//! resources/manoeuvre.json           -> scheduled::Manoeuvre                  -+
//! ```
//!
//! The loop does what a master does that steps the controller's FMU and then the plant's at every sample time, so
//! that both ways give the same flight. Without anything connected it flies its manoeuvre; the input `manual` hands
//! the references over.
//!
//! The crate holds no vehicle and no manoeuvre. The C symbols exist with the feature `export` only:
//!
//! ```text
//! cargo rustc -p fmu-squid --lib --crate-type cdylib --features export --profile fmu
//! ```

mod closed_loop;
mod error;
mod exchange;
mod fmu;
mod state;
mod tangents;
mod variables;

pub use closed_loop::{ClosedLoop, Override};
pub use error::ClosedLoopError;

use fmi2::{DescribeError, Described, Resources};

/// Model description, GUID and XML of the loop in `resources`.
///
/// # Errors
/// [`DescribeError`] when a file is missing or damaged, or makes no legal FMU.
pub fn describe(resources: &Resources) -> Result<Described<ClosedLoop>, DescribeError> {
    fmi2::describe(resources)
}

#[cfg(feature = "export")]
fmi2::export!(ClosedLoop);
