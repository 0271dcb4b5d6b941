//! A gain-scheduled controller K(rho) at run time:
//!
//! ```text
//! frozen design (JSON) -> read and check -> discretise -> Autopilot: initialise, advance, advance, ...
//! ```
//!
//! The design is a linear fractional transformation (LFT) with the partition
//!
//! ```text
//! xk' = A xk + By y + Bt wk
//! u   = Cu xk + Duy y + Dut wk        wk = Theta zk,  Theta = blkdiag(theta_i I_ri)
//! zk  = Ct xk + Dty y + Dtt wk
//! ```
//!
//! with the scaled inputs `y` and the scaled actuator commands `u`; [`Autopilot`] defines the scaling. This
//! crate contains neither the vehicle's equations nor the synthesis.
//!
//! [`Autopilot::tangents`] gives the exact derivatives of a tick with respect to its inputs; [`Autopilot::snapshot`]
//! saves the state of an autopilot, which can be restored bit for bit.
//!
//! Commands are actuator outputs. [`Actuator::input_for`] converts the command of a thruster with a curve to its
//! input.
//!
//! Saturation: commands are clamped to the actuators' limits. If the design has an anti-windup gain,
//! [`ControllerDesign::anti_windup`], it feeds the excess back to the controller's states. While an actuator stays at
//! its limit, the references of the signals that it [steers](Actuator::steers) move towards the measured values.
//!
//! Sensors: a [`Supervisor`] checks them before each tick, and replaces those that are lost as the design's
//! [`Failsafe`] specifies.
//!
//! Engagement: [`Autopilot::follow`] tracks the commands of another source, so that the autopilot takes over from it
//! without a jump (bumpless transfer).

mod autopilot;
mod design;
mod error;
mod failsafe;
mod follow;
mod json;
mod lft;
mod manoeuvre;
mod ports;
mod snapshot;
mod source;
mod tangent;
mod trim;
mod validate;

pub use autopilot::{Autopilot, HELD, RETURNING, ROUNDING_OF_RHO, Saturation, Transition};
pub use design::{
    Actuator, CONTROLLER_FORMAT, ControllerDesign, ControllerInput, DEFAULT_DESIGN, Failsafe, Gain, Gamma,
    InputHashes, Kind, LftMatrices, MAX_DELAY_TICKS, OverSpeed, Port, Reference, ReferenceLimits, Rows,
    Scheduling, Sensor, Source, TrimTable, VehicleName, Without, ticks,
};
pub use error::{DesignError, TickError};
pub use failsafe::{
    Health, LONGEST, NEVER, RAMP, REGAINED_AFTER, RETURN, Reading, SLOWEST, STEPS, Supervised, Supervisor,
    returning,
};
pub use lft::controller::LftController;
pub use lft::matrix::Matrix;
pub use lft::{Lft, Sizes};
pub use manoeuvre::{MANOEUVRE_FORMAT, MANOEUVRE_RESOURCE, Manoeuvre, ManoeuvreError};
pub use ports::{Inputs, Outputs};
pub use snapshot::{Snapshot, SnapshotError};
/// Level of a signal, and status of the data of a vehicle.
pub use squid_signals::{Level, Status};
pub use tangent::OutputTangents;
pub use trim::{FARTHEST, Trim};

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
