//! The sea around an underwater vehicle: waves and their loads on a submerged hull, currents, and sensor errors.
//!
//! ```text
//! Spectrum -> Waves -> Spheroid::in_waves: motion of the water, and wave load on the hull
//! ```
//!
//! - [`Spectrum`]: JONSWAP or Pierson-Moskowitz;
//! - [`Waves`]: a realisation of a long-crested sea of that spectrum, reproducible by its seed; elevation and orbital
//!   motion from linear theory in deep water;
//! - [`Spheroid`]: wave loads on a prolate spheroid: Froude-Krylov load, exact, and diffraction from its added mass;
//! - [`ShapingFilter`]: that spectrum as encountered by a vehicle, as white noise through a second-order filter;
//! - [`Layers`] of a current over depth, and [`GaussMarkov`], its random component;
//! - [`Sensor`]: noise, bias, quantisation, rate and delay of a measured signal.
//!
//! All random numbers are reproducible by the seed; waves, current and each sensor use separate streams.
//!
//! Axes: north, east, and depth below the still water level; in the vertical plane of a vehicle, north is along its
//! heading. Body axes follow SNAME (1950): x forward, y to starboard, z down. Units are SI, angles are in radians.
//! Linear theory holds for waves of small slope and a fully submerged hull.
//!
//! ```
//! use squid_sea::{Position, Spectrum, Waves};
//!
//! let sea = Waves::new(&Spectrum::jonswap(1.0, 6.0, 3.3)?, std::f64::consts::PI, 100, 7)?;
//! let position = Position { time: 12.0, north: 0.0, east: 0.0, depth: 5.0 };
//! assert!(sea.motion(position).velocity.iter().all(|one| one.abs() < 1.0));
//! # Ok::<(), squid_sea::SeaError>(())
//! ```

mod current;
mod error;
mod random;
mod sensor;
mod shaping;
mod spectrum;
mod spheroid;
mod waves;

pub use current::{GaussMarkov, Layers, Wandering};
pub use error::SeaError;
pub use sensor::{Sensor, SensorErrors};
pub use shaping::ShapingFilter;
pub use spectrum::Spectrum;
pub use spheroid::{Axes, Spheroid};
pub use waves::{Component, Position, WaterMotion, Waves, encounter_frequency};

/// Acceleration of gravity \[m/s2\].
pub const GRAVITY: f64 = 9.81;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
