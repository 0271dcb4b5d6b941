//! What the design needs of a vehicle: one axis, scheduled on one parameter.

pub mod several;

use crate::error::ModelError;
use nalgebra::Complex;
use squid_auv::{Actuator, Status};
use squid_lpv::matrix::Mat;
use squid_scheduled::{ReferenceLimits, Sensor};
use squid_signals::{Interface, States};
use std::collections::BTreeMap;
use std::fmt::Debug;

/// A vehicle as one axis of its autopilot has it: states x, inputs u, outputs y, trims and linear models over the
/// scheduling parameter, the speed V along the path.
///
/// ```text
/// x' = A(V) (x - x0(V)) + B(V) (u - u0(V)),   y = C x
/// ```
///
/// A vehicle in level flight is [`LevelFlight`](crate::linearise::LevelFlight). SI units, angles in radians.
pub trait VehicleModel: Debug + Sync {
    /// The name of the vehicle.
    fn name(&self) -> &str;

    /// How well it is known.
    fn status(&self) -> Status;

    /// States and signals; the signal whose level is [`Level::Scheduled`](squid_signals::Level::Scheduled) gives V.
    fn interface(&self) -> &'static Interface;

    /// The states x of the linear models, some of those of the interface.
    fn states(&self) -> States;

    /// The inputs u.
    fn actuators(&self) -> &[Actuator];

    /// Whether the speed is imposed from outside: it has no reference here.
    fn speed_given(&self) -> bool;

    /// The trims at increasing speeds \[m/s\], on one branch.
    ///
    /// # Errors
    /// [`ModelError::Trim`]: no trim at a speed, or trims that do not lie on one branch.
    fn trims(&self, speeds: &[f64]) -> Result<Vec<OperatingPoint>, ModelError>;

    /// The slope of each of these trims, `[x0'; u0']` per m/s of the scheduled signal, (n + m) x 1.
    ///
    /// # Errors
    /// As [`trims`](Self::trims).
    fn trim_slopes(&self, speeds: &[f64]) -> Result<Vec<Mat>, ModelError>;

    /// What the references are limited to at these speeds, by the name of their signal; nothing, unless the model
    /// knows what it can hold.
    ///
    /// # Errors
    /// As [`trims`](Self::trims).
    fn envelope(&self, _speeds: &[f64]) -> Result<BTreeMap<String, ReferenceLimits>, ModelError> {
        Ok(BTreeMap::new())
    }

    /// How each measured signal moves at these speeds, by its name; nothing if that is not known.
    ///
    /// # Errors
    /// As [`trims`](Self::trims).
    fn sensors(&self, _speeds: &[f64]) -> Result<BTreeMap<String, Sensor>, ModelError> {
        Ok(BTreeMap::new())
    }

    /// The linear model about the trim at a speed \[m/s\].
    ///
    /// # Errors
    /// [`ModelError::Trim`] with the speed and the reason; [`ModelError::Waves`].
    fn linearise(&self, speed: f64) -> Result<Linearisation, ModelError>;
}

/// A trim.
#[derive(Debug, Clone, PartialEq)]
pub struct OperatingPoint {
    /// The speed V along the path, m/s.
    pub speed: f64,
    /// Each signal of the interface.
    pub signals: Vec<f64>,
    /// The output of each actuator.
    pub actuators: Vec<f64>,
}

/// The linear motion about a trim.
#[derive(Debug, Clone)]
pub struct Linearisation {
    /// A, n x n.
    pub a: Mat,
    /// B, n x m; inputs are outputs of the actuators, without their lags.
    pub b: Mat,
    /// x.
    pub states: States,
    /// The trim.
    pub trim: OperatingPoint,
    /// The slope of the trim, `[x0'; u0']` per m/s of the scheduled signal, (n + m) x 1.
    pub trim_slope: Mat,
    /// What waves add to x', n x 2; see [`squid_auv::Linearisation::by_waves`]. `None` in still water.
    pub by_waves: Option<Mat>,
}

impl Linearisation {
    /// The eigenvalues of A, 1/s.
    pub fn eigenvalues(&self) -> Vec<Complex<f64>> {
        self.a.complex_eigenvalues().iter().copied().collect()
    }
}
