//! Model of an underwater vehicle: from a file of coefficients to its motion.
//!
//! ```text
//! vehicle.toml -> Vehicle -> Dynamics -> trim -> linearise
//!                               |
//!                               +-> Plant (simulation, nonlinear or by an LPV model)
//! ```
//!
//! - [`Vehicle::parse`]: reads a vehicle file into [`Coefficients`] and [`Actuator`]s, or lists its mistakes;
//!   [`Vehicle::to_json`] and [`Vehicle::from_json`] exchange a vehicle with other programs;
//! - [`COEFFICIENTS`]: table of every coefficient, which drives reading, validation and documentation;
//! - [`Dynamics`]: nonlinear equations of motion over any [`Scalar`], in surge, heave and pitch and in sway, roll and
//!   yaw; a vehicle without the latter moves in the vertical plane only;
//! - [`trim()`]: level, steady motion at a speed and a depth; [`trims`]: over a range of speeds, on one branch, under a
//!   [`Pitch`] rule;
//! - [`linearise()`]: A and B about a trim, from exact derivatives;
//! - [`View`]: motion as seen by an axis of an autopilot; [`longitudinal`], [`lateral`], [`roll`] are its tables;
//! - [`Lateral`]: linear motion in sway, roll and yaw; [`Vehicle::in_plane`]: the vehicle without it;
//! - [`turn()`]: steady turns at constant depth; [`linearise_turn`]: A and B about them, in six degrees of freedom;
//! - [`Descriptor`]: linear motion before the mass matrix is inverted, and its derivatives with respect to any
//!   [`Parameter`] of vehicle and trim;
//! - [`Plant`]: simulation of the vehicle, by the nonlinear equations or an [`LpvModel`];
//! - [`Instant`] and [`Rates`]: motion at one instant as states and their rates, over any [`Scalar`];
//! - [`Water`]: interface to waves and layered currents of another crate, at the [`Pose`] of a vehicle;
//! - [`Slopes`]: inputs as ramps instead of held values; [`Snapshot`]: state of a plant, saved and restored.
//!
//! ```
//! use squid_auv::{Speed, Vehicle, linearise, trim};
//!
//! let file = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../vehicles/squid/vehicle.toml");
//! let vehicle = Vehicle::parse(&std::fs::read_to_string(file)?, "vehicle.toml")?;
//! let level = trim(&vehicle, Speed::Path(1.0), 50.0)?;
//! let linear = linearise(&vehicle, &level)?;
//! assert!(linear.eigenvalues().iter().all(|value| value.re < 0.0));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Units are SI, angles are radians. This crate contains no control design and no co-simulation.

mod bottom;
mod motion;
mod scalar;
mod simulation;
mod states;
mod text;
pub mod toml_file;
mod vehicle;
mod view;

pub use bottom::Bottom;
pub use motion::branch::trims;
pub use motion::descriptor::Descriptor;
pub use motion::dynamics::{Dynamics, LEAST_REYNOLDS_NUMBER, Motion, actuator_force, lateral_actuator_force};
pub use motion::lateral::Lateral;
pub use motion::level::{Branch, Pitch, Speed};
pub use motion::linearise::{Linearisation, linearise, linearise_with};
pub use motion::parameter::{Parameter, UnknownParameter};
pub use motion::trim::{Trim, climb, trim, trim_with};
pub use motion::trim_error::TrimError;
pub use motion::turn::{Turn, linearise_turn, turn};
/// Number with its derivative in one direction.
pub use num_dual::Dual64;
pub use scalar::Scalar;
pub use simulation::current::Current;
pub use simulation::error::SimulationError;
pub use simulation::integrator::IntegrationError;
pub use simulation::load::Load;
pub use simulation::lpv_model::{LPV_MODEL_FORMAT, LpvModel, LpvModelError, TrimPitch, TrimPoint};
pub use simulation::plant::{Fidelity, Plant, State};
pub use simulation::rates::{Instant, Rates, index};
pub use simulation::regular_waves::RegularWaves;
pub use simulation::slopes::Slopes;
pub use simulation::snapshot::{Snapshot, SnapshotError};
pub use simulation::surroundings::Surroundings;
pub use simulation::water::{Pose, Water, WaterMotion};
/// Curve of a thruster, and origin of the coefficients of a vehicle.
pub use squid_signals::{Curve, Status};
pub use text::{number, readable, rounded};
pub use toml_file::{FileError, FileProblem};
pub use vehicle::actuator::{Actuator, Effect};
pub use vehicle::allowed::Allowed;
pub use vehicle::ballast::Ballast;
pub use vehicle::coefficients::{
    COEFFICIENTS, CoefficientError, CoefficientSpec, Coefficients, DefaultValue, Subsystem,
};
pub use vehicle::geometry::Geometry;
pub use vehicle::hull::Hull;
pub use vehicle::json::{JsonProblem, VEHICLE_FORMAT, VehicleJsonError};
pub use vehicle::surge::Surge;
pub use vehicle::{PublishedLinearModel, VEHICLE_NAMES, Vehicle, is_vehicle_name};
pub use view::{
    LATERAL, LONGITUDINAL, MOST_SIGNALS, PerReference, PerSignal, REFERENCES, ROLL, Sensed, TRACKED, VIEWS,
    View, lateral, longitudinal, references, roll,
};

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
