//! PID cascade of pitch and speed, or of heading or roll, with gains scheduled on speed, as a controller K(rho) whose
//! matrices are affine in the gains.
//!
//! ```text
//! [controller] of a file -> Pid -> Structure::new(pid, vehicle and signals) -> base + sum g_i K_i -> lpv Controller
//! ```
//!
//! ```text
//! pitch:  v = kp (b r - theta) + ki I - kd q,                                I' = r - theta
//!         v = ka theta_m'' + kp (theta_m - theta) + ki I + kd (theta_m' - q),   I' = theta_m - theta
//!         likewise for heading or roll, with its rate in place of q
//! depth:  r = -kz (z_r - z) - kzi I_z,                                       I_z' = z_r - z
//! speed:  v = kp (b a - u) + ki I,                                           I' = -u
//! commands = allocation v
//! ```
//!
//! Signals are deviations from trim at the filtered speed reference, and a is the speed reference minus its filtered
//! value. A gain is a polynomial in the scheduling parameter rho of degree 2 at most, and acts after the integrator.
//! Source of setpoint weight, back-calculation and derivative filter: K. J. Astrom, T. Hagglund, Advanced PID Control,
//! 2006, sections 3.3 to 3.5; of gains scheduled after the integrator: D. J. Leith, W. E. Leithead, Int. J. Control
//! 73(11), 2000.
//!
//! [`autopilots`] reads the gains of other autopilots' files as `[controller]`, and writes them back.

mod allocation;
mod angle;
pub mod autopilots;
mod file;
mod gain;
mod refusal;
mod structure;

pub use allocation::{Allocation, Drive};
pub use angle::Angle;
pub use file::{DepthLoop, Pid, Shares, SpeedLoop, TurnLoop, read, read_file};
pub use gain::{Given, Law, Misfit};
pub use structure::{Affine, Direction, Gain, Layout, Port, Structure, Vehicle};

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
