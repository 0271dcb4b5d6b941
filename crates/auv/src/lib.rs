//! An underwater vehicle in the vertical plane: from a file of coefficients to its motion.
//!
//! ```text
//! vehicle.toml -> Vehicle -> Dynamics -> trim -> linearise
//!                               |
//!                               +-> Plant (simulation, nonlinear or by an LPV model)
//! ```
//!
//! - [`Vehicle::read`]: a vehicle file becomes [`Coefficients`] and [`Actuator`]s, or one clear message; [`Vehicle::to_json`] passes the
//!   vehicle on to machines, and [`Vehicle::from_json`] takes it up;
//! - [`COEFFICIENTS`]: the table of every coefficient, which drives reading, validation and documentation;
//! - [`Dynamics`]: the nonlinear longitudinal equations of motion, over any [`Scalar`];
//! - [`trim()`]: level, steady motion at a speed and a depth;
//! - [`linearise()`]: A and B about a trim, by exact derivatives;
//! - [`Descriptor`]: the same before the mass matrix is inverted, and its derivatives by any [`Parameter`] of vehicle and trim;
//! - [`Plant`]: the vehicle in motion, by the nonlinear equations or by an [`LpvModel`];
//! - [`Instant`] and [`Rates`]: the motion at one instant as states and their rates, over any [`Scalar`];
//! - [`Slopes`]: inputs that are ramps instead of being held; [`Memory`]: a plant put away to be taken up again.
//!
//! ```
//! use auv::{Speed, Vehicle, linearise, trim};
//!
//! let file = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../vehicles/squid/vehicle.toml");
//! let vehicle = Vehicle::read(&file)?;
//! let level = trim(&vehicle, Speed::Path(1.0), 50.0)?;
//! let linear = linearise(&vehicle, &level)?;
//! assert!(linear.eigenvalues().iter().all(|value| value.re < 0.0));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Units are SI, angles are radians. This crate knows no control theory and no co-simulation.

mod actuator;
mod coefficients;
mod descriptor;
mod dynamics;
mod flow;
mod forces;
mod frozen;
mod integrator;
mod linearise;
mod lpv_model;
mod memory;
mod parameter;
mod plant;
mod rates;
mod simulation_error;
mod slopes;
pub mod toml_file;
mod trim;
mod vehicle;
mod vehicle_file;
mod vehicle_json;

pub use actuator::{Actuator, Effect};
pub use coefficients::{Allowed, COEFFICIENTS, CoefficientError, CoefficientSpec, Coefficients};
pub use descriptor::Descriptor;
pub use dynamics::{Dynamics, LEAST_REYNOLDS_NUMBER, Motion, Scalar, actuator_force};
pub use flow::Current;
pub use integrator::IntegrationError;
pub use linearise::{Linearisation, linearise};
pub use lpv_model::{LPV_MODEL_FORMAT, LpvModel, LpvModelError, TrimPoint};
pub use memory::{Memory, MemoryError};
/// A number with its derivative in one direction.
pub use num_dual::Dual64;
pub use parameter::{Parameter, UnknownParameter};
pub use plant::{Fidelity, Plant, State};
pub use rates::{Instant, Rates};
pub use simulation_error::SimulationError;
pub use slopes::Slopes;
pub use toml_file::{FileError, FileProblem, number, read_text, rounded};
pub use trim::{Speed, Trim, TrimError, trim};
pub use vehicle::{PublishedLinearModel, Status, Vehicle};
pub use vehicle_json::{JsonProblem, VEHICLE_FORMAT, VehicleJsonError};
