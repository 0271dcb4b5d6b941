//! One axis of a vehicle, scheduled on one parameter: the model from which the design starts.

pub mod several;

use crate::error::ModelError;
use nalgebra::Complex;
use squid_auv::{Actuator, Status};
use squid_lpv::matrix::Mat;
use squid_scheduled::{ReferenceLimits, Sensor};
use squid_signals::{Interface, States};
use std::collections::BTreeMap;
use std::fmt::Debug;

/// One axis of a vehicle and its autopilot: states x, inputs u, outputs y, trims and linear models over the scheduling
/// parameter, the speed V along the path.
///
/// ```text
/// x' = A(V) (x - x0(V)) + B(V) (u - u0(V)),   y = C x
/// ```
///
/// A vehicle in level flight is [`LevelFlight`](crate::linearise::LevelFlight). SI units, angles in radians.
pub trait VehicleModel: Debug + Sync {
    /// Name of the vehicle.
    fn name(&self) -> &str;

    /// Status of the vehicle's data.
    fn status(&self) -> Status;

    /// Returns states and signals; the signal of level [`Level::Scheduled`](squid_signals::Level::Scheduled) gives V.
    fn interface(&self) -> &'static Interface;

    /// Returns the states x of the linear models, some of those of the interface.
    fn states(&self) -> States;

    /// Returns the actuators, whose outputs are the inputs u.
    fn actuators(&self) -> &[Actuator];

    /// Returns `true` if the speed is imposed from outside, so that it has no reference here.
    fn is_speed_given(&self) -> bool;

    /// Returns the trims at increasing speeds \[m/s\], on one branch.
    ///
    /// # Errors
    /// [`ModelError::Trim`]: no trim at a speed, or trims that do not lie on one branch.
    fn trims(&self, speeds: &[f64]) -> Result<Vec<OperatingPoint>, ModelError>;

    /// Returns the slope of each of these trims, `[x0'; u0']` per m/s of the scheduled signal, (n + m) x 1.
    ///
    /// # Errors
    /// The errors of [`trims`](Self::trims).
    fn trim_slopes(&self, speeds: &[f64]) -> Result<Vec<Mat>, ModelError>;

    /// Returns the limits of the references at these speeds, by the name of their signal; empty if the model knows no
    /// limits.
    ///
    /// # Errors
    /// The errors of [`trims`](Self::trims).
    fn envelope(&self, _speeds: &[f64]) -> Result<BTreeMap<String, ReferenceLimits>, ModelError> {
        Ok(BTreeMap::new())
    }

    /// Returns the motion of each measured signal at these speeds, by its name; empty if it is not known.
    ///
    /// # Errors
    /// The errors of [`trims`](Self::trims).
    fn sensors(&self, _speeds: &[f64]) -> Result<BTreeMap<String, Sensor>, ModelError> {
        Ok(BTreeMap::new())
    }

    /// Linearises about the trim at a speed \[m/s\].
    ///
    /// # Errors
    /// [`ModelError::Trim`] with the speed and the reason; [`ModelError::Waves`].
    fn linearise(&self, speed: f64) -> Result<Linearisation, ModelError>;
}

/// Trim at one speed.
#[derive(Debug, Clone, PartialEq)]
pub struct OperatingPoint {
    /// Speed V along the path, m/s.
    pub speed: f64,
    /// Value of each signal of the interface.
    pub signals: Vec<f64>,
    /// Output of each actuator.
    pub actuators: Vec<f64>,
}

/// Linear motion about a trim.
#[derive(Debug, Clone)]
pub struct Linearisation {
    /// Matrix A, n x n.
    pub a: Mat,
    /// Matrix B, n x m; the inputs are actuator outputs, without lags.
    pub b: Mat,
    /// States x.
    pub states: States,
    /// Trim about which the motion is linear.
    pub trim: OperatingPoint,
    /// Slope of the trim, `[x0'; u0']` per m/s of the scheduled signal, (n + m) x 1.
    pub trim_slope: Mat,
    /// Effect of waves on x', n x 2; see [`squid_auv::Linearisation::by_waves`]. `None` in still water.
    pub by_waves: Option<Mat>,
}

impl Linearisation {
    /// Returns the eigenvalues of A, 1/s.
    pub fn eigenvalues(&self) -> Vec<Complex<f64>> {
        self.a.complex_eigenvalues().iter().copied().collect()
    }
}
