//! The sea around an underwater vehicle: waves and their loads on a submerged hull, currents, and sensor errors.
//!
//! ```text
//! Spectrum -> Waves -> Spheroid::in_waves: the water's motion, and the load on the hull
//! ```
//!
//! - [`Spectrum`]: JONSWAP or Pierson-Moskowitz;
//! - [`Waves`]: a long-crested sea of that spectrum, the same for the same seed; elevation and orbital motion by linear
//!   theory in deep water;
//! - [`Spheroid`]: a prolate spheroid under waves: Froude-Krylov load, exact, and diffraction by its added mass;
//! - [`ShapingFilter`]: that spectrum as encountered by a vehicle, as noise through a filter of two states;
//! - [`Layers`] of a current over depth, and [`GaussMarkov`], a random part of it;
//! - [`Sensor`]: noise, bias, quantisation, rate and delay of a measured signal.
//!
//! All that is random is the same for the same seed; waves, current and each sensor have numbers of their own.
//!
//! Axes: north, east, and depth down from the still water, where in the vertical plane of a vehicle north is the way
//! that it faces; body axes as SNAME (1950), x forward, y to starboard, z down. Units are SI, angles are radians.
//! Linear theory ends at the surface: waves of small slope, a hull that is submerged.
//!
//! ```
//! use squid_sea::{Place, Spectrum, Waves};
//!
//! let sea = Waves::new(&Spectrum::jonswap(1.0, 6.0, 3.3)?, std::f64::consts::PI, 100, 7)?;
//! let place = Place { time: 12.0, north: 0.0, east: 0.0, depth: 5.0 };
//! assert!(sea.motion(place).velocity.iter().all(|one| one.abs() < 1.0));
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
pub use waves::{Component, Place, WaterMotion, Waves, encounter_frequency};

/// The acceleration of gravity \[m/s2\].
pub const GRAVITY: f64 = 9.81;
