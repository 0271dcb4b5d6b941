//! Nonlinear longitudinal dynamics: surge, heave and pitch by Kirchhoff's equations with the forces on the hull.
//!
//! Axes are those of SNAME (1950): x forward, z down, pitch positive bow up, origin fixed in the body. All velocities
//! are through the water; a steady, uniform current moves the water and the vehicle in it alike.
//!
//! Sources: Lamb, Hydrodynamics (1932), ch. VI (Kirchhoff's equations); Fossen (2011), ch. 6 to 8; ITTC (1957).

use crate::scalar::Scalar;
use crate::vehicle::actuator::Actuator;
use crate::vehicle::ballast::Ballast;
use crate::vehicle::coefficients::{CoefficientError, Coefficients};
use nalgebra::Matrix3;

/// The least Reynolds number at which the ITTC-57 line is evaluated; below it the friction coefficient is constant.
pub const LEAST_REYNOLDS_NUMBER: f64 = 1e4;

/// The motion of the vehicle through the water, x = \[u w q theta\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion<D = f64> {
    /// Surge velocity \[m/s\].
    pub u: D,
    /// Heave velocity \[m/s\], positive down.
    pub w: D,
    /// Pitch rate \[rad/s\].
    pub q: D,
    /// Pitch \[rad\], positive bow up.
    pub theta: D,
}

impl<D: Scalar> Motion<D> {
    /// Returns how fast the depth grows in still water \[m/s\]: `z' = w cos(theta) - u sin(theta)`.
    pub fn sinking(&self) -> D {
        let (sin, cos) = self.theta.sin_cos();
        self.w * cos - self.u * sin
    }
}

/// The equations of motion of one vehicle, its mass matrix inverted once.
#[derive(Clone, Debug)]
pub struct Dynamics<D = f64> {
    coefficients: Coefficients<D>,
    inverse_mass: Matrix3<f64>,
}

impl Dynamics {
    /// Checks the coefficients and inverts the mass matrix.
    ///
    /// # Errors
    /// [`CoefficientError`] if a coefficient is not allowed or the mass matrix is not positive definite.
    pub fn new(coefficients: &Coefficients) -> Result<Self, CoefficientError> {
        Ok(Self { coefficients: coefficients.clone(), inverse_mass: inverse_mass(coefficients)? })
    }

    /// The same over scalars that carry derivatives, with the coefficients as constants among them.
    pub fn lifted<D: Scalar>(&self) -> Dynamics<D> {
        let coefficients = self.coefficients.map(|_, value| D::from(value));
        Dynamics { coefficients, inverse_mass: self.inverse_mass }
    }

    /// The coefficients.
    pub fn coefficients(&self) -> &Coefficients {
        &self.coefficients
    }

    /// Returns the speed at which the Reynolds number is [`LEAST_REYNOLDS_NUMBER`] \[m/s\].
    pub fn least_friction_speed(&self) -> f64 {
        LEAST_REYNOLDS_NUMBER * self.coefficients.kinematic_viscosity / self.coefficients.length
    }

    /// Changes weight, buoyancy and centre of gravity, and the mass with them, without allocating.
    ///
    /// # Errors
    /// [`CoefficientError`] as for [`Dynamics::new`]; the dynamics are then as they were.
    pub(crate) fn set_ballast(&mut self, ballast: &Ballast) -> Result<(), CoefficientError> {
        let before = self.coefficients.ballast();
        self.coefficients.set_ballast(ballast);
        match inverse_mass(&self.coefficients) {
            Ok(inverse) => self.inverse_mass = inverse,
            Err(error) => {
                self.coefficients.set_ballast(&before);
                return Err(error);
            }
        }
        Ok(())
    }
}

/// Checks the coefficients and inverts the mass matrix.
fn inverse_mass(coefficients: &Coefficients) -> Result<Matrix3<f64>, CoefficientError> {
    coefficients.check()?;
    let singular = CoefficientError::MassMatrixNotPositiveDefinite { least_eigenvalue: 0.0 };
    coefficients.mass_matrix().try_inverse().ok_or(singular)
}

impl<D: Scalar> Dynamics<D> {
    /// Returns \[u' w' q'\] under the force \[X Z M\] of the actuators: `M nu' = coriolis + restoring + lift +
    /// damping + drag + actuators`.
    pub fn acceleration(&self, motion: &Motion<D>, depth: D, actuators: [D; 3]) -> [D; 3] {
        self.response(self.coefficients.force(motion, depth, actuators))
    }

    /// Returns the part of \[u' w' q'\] that a load \[X Z M\] beside the other forces makes; along the hull it makes
    /// none where the speed is given.
    pub(crate) fn pushed(&self, load: [D; 3]) -> [D; 3] {
        let [surge, heave, pitch] = load;
        let surge = if self.coefficients.surge.is_given() { D::from(0.0) } else { surge };
        self.response([surge, heave, pitch])
    }

    fn response(&self, force: [D; 3]) -> [D; 3] {
        let row = |i: usize| {
            force[0] * self.inverse_mass[(i, 0)]
                + force[1] * self.inverse_mass[(i, 1)]
                + force[2] * self.inverse_mass[(i, 2)]
        };
        [row(0), row(1), row(2)]
    }

    /// Returns \[u' w' q' theta'\] under the outputs of the actuators \[N or rad\], and a speed `given` \[m/s\] for a
    /// vehicle that takes one; see [`Dynamics::acceleration`].
    pub fn rate(
        &self,
        actuators: &[Actuator],
        motion: &Motion<D>,
        depth: D,
        given: D,
        outputs: impl Iterator<Item = D>,
    ) -> [D; 4] {
        let mut force = actuator_force(actuators, motion.u, outputs);
        if let Some(rate) = self.coefficients.surge.rate(motion.u, given) {
            force[0] = rate;
        }
        let [u, w, q] = self.acceleration(motion, depth, force);
        [u, w, q, motion.q]
    }

    /// Returns the surge force of drag: `X_uu u|u| - rho/2 (C_f k S_w + C_d A) u|u|`.
    ///
    /// `C_f = 0.075 / (log10 Re - 2)^2`, `Re = |u| L / nu`, at least [`LEAST_REYNOLDS_NUMBER`]. Source: ITTC (1957).
    pub fn axial_drag(&self, u: D) -> D {
        self.coefficients.axial_drag(u)
    }
}

/// Adds up the forces of all actuators at surge speed `u`.
pub fn actuator_force<D: Scalar>(
    actuators: &[Actuator],
    u: D,
    outputs: impl IntoIterator<Item = D>,
) -> [D; 3] {
    let zero = [D::from(0.0); 3];
    actuators.iter().zip(outputs).fold(zero, |sum, (actuator, output)| add(sum, actuator.force(u, output)))
}

pub(crate) fn add<D: Scalar>(a: [D; 3], b: [D; 3]) -> [D; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}
