//! Nonlinear dynamics in six degrees of freedom: Kirchhoff's equations with the forces on the hull.
//!
//! Axes follow SNAME (1950): x forward, y to starboard, z down; roll positive starboard down, pitch bow up, yaw bow to
//! starboard; the origin is fixed in the body, in its plane of symmetry. All velocities are relative to the water,
//! which a steady, uniform current moves together with the vehicle.
//!
//! For a hull with port-starboard symmetry, the mass matrix and the equations have two blocks: surge, heave and pitch,
//! and sway, roll and yaw. The forces couple the two.
//!
//! Sources: Lamb, Hydrodynamics (1932), ch. VI (Kirchhoff's equations); Fossen (2011), ch. 6 to 8; ITTC (1957).

use crate::scalar::Scalar;
use crate::vehicle::actuator::Actuator;
use crate::vehicle::ballast::Ballast;
use crate::vehicle::coefficients::{CoefficientError, Coefficients};
use nalgebra::Matrix3;

/// Least Reynolds number for the ITTC-57 line; below it the friction coefficient is constant.
pub const LEAST_REYNOLDS_NUMBER: f64 = 1e4;

/// Motion of the vehicle through the water.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion<D = f64> {
    /// Surge velocity \[m/s\].
    pub u: D,
    /// Sway velocity \[m/s\], positive to starboard.
    pub v: D,
    /// Heave velocity \[m/s\], positive down.
    pub w: D,
    /// Angular velocity about the body's x axis \[rad/s\].
    pub p: D,
    /// Angular velocity about the body's y axis \[rad/s\].
    pub q: D,
    /// Angular velocity about the body's z axis \[rad/s\].
    pub r: D,
    /// Roll \[rad\], positive starboard down.
    pub phi: D,
    /// Pitch \[rad\], positive bow up.
    pub theta: D,
}

/// Sines and cosines of roll and pitch, computed once.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Attitude<D> {
    pub(crate) sin: D,
    pub(crate) cos: D,
    pub(crate) sin_phi: D,
    pub(crate) cos_phi: D,
}

impl<D: Scalar> Motion<D> {
    pub(crate) fn attitude(&self) -> Attitude<D> {
        let ((sin, cos), (sin_phi, cos_phi)) = (self.theta.sin_cos(), self.phi.sin_cos());
        Attitude { sin, cos, sin_phi, cos_phi }
    }

    /// Returns motion in the vertical plane: v = p = r = phi = 0.
    pub fn in_plane(u: D, w: D, q: D, theta: D) -> Self {
        let zero = D::from(0.0);
        Self { u, v: zero, w, p: zero, q, r: zero, phi: zero, theta }
    }

    /// Returns the depth rate in still water \[m/s\]: `z' = (v sin(phi) + w cos(phi)) cos(theta) - u sin(theta)`.
    pub fn depth_rate(&self) -> D {
        self.sinking_at(&self.attitude())
    }

    fn sinking_at(&self, &Attitude { sin, cos, sin_phi, cos_phi }: &Attitude<D>) -> D {
        (self.w * cos_phi + self.v * sin_phi) * cos - self.u * sin
    }

    /// Returns the rates \[phi' theta' psi'\] of the Euler angles, psi the heading:
    ///
    /// ```text
    /// phi'   = p + tan(theta) (q sin(phi) + r cos(phi))
    /// theta' = q cos(phi) - r sin(phi)
    /// psi'   = (q sin(phi) + r cos(phi))/cos(theta)
    /// ```
    ///
    /// Source: Fossen (2011), eq. 2.28. Singular at a pitch of 90 degrees.
    pub fn turning(&self) -> [D; 3] {
        self.turning_at(&self.attitude())
    }

    pub(crate) fn turning_at(&self, &Attitude { sin, cos, sin_phi, cos_phi }: &Attitude<D>) -> [D; 3] {
        let heading = (self.q * sin_phi + self.r * cos_phi) / cos;
        [self.p + heading * sin, self.q * cos_phi - self.r * sin_phi, heading]
    }

    /// Returns the velocity north, east and down at a heading psi.
    pub fn velocity(&self, heading: D) -> [D; 3] {
        self.velocity_at(&self.attitude(), heading)
    }

    pub(crate) fn velocity_at(&self, attitude: &Attitude<D>, heading: D) -> [D; 3] {
        let &Attitude { sin, cos, sin_phi, cos_phi } = attitude;
        let across = self.v * cos_phi - self.w * sin_phi;
        let ahead = self.u * cos + (self.v * sin_phi + self.w * cos_phi) * sin;
        let (sin_psi, cos_psi) = heading.sin_cos();
        [ahead * cos_psi - across * sin_psi, ahead * sin_psi + across * cos_psi, self.sinking_at(attitude)]
    }

    /// Returns the components in body axes of a velocity north, east and down at a heading psi: the inverse of
    /// [`Motion::velocity`].
    pub fn along_body(&self, heading: D, [north, east, down]: [D; 3]) -> [D; 3] {
        let ((sin, cos), (sin_phi, cos_phi)) = (self.theta.sin_cos(), self.phi.sin_cos());
        let (sin_psi, cos_psi) = heading.sin_cos();
        let (ahead, across) = (north * cos_psi + east * sin_psi, east * cos_psi - north * sin_psi);
        let level = ahead * sin + down * cos;
        [ahead * cos - down * sin, across * cos_phi + level * sin_phi, level * cos_phi - across * sin_phi]
    }
}

/// Equations of motion of one vehicle, with its mass matrix inverted once.
#[derive(Clone, Debug)]
pub struct Dynamics<D = f64> {
    coefficients: Coefficients<D>,
    inverse_mass: Matrix3<f64>,
    /// Inverse mass matrix of sway, roll and yaw, for a vehicle that moves in these.
    inverse_lateral: Option<Matrix3<f64>>,
}

impl Dynamics {
    /// Checks the coefficients and inverts the mass matrix.
    ///
    /// # Errors
    /// [`CoefficientError`] if a coefficient is not allowed or the mass matrix is not positive definite.
    pub fn new(coefficients: &Coefficients) -> Result<Self, CoefficientError> {
        let (inverse_mass, inverse_lateral) = inverse_masses(coefficients)?;
        Ok(Self { coefficients: coefficients.clone(), inverse_mass, inverse_lateral })
    }

    /// Returns the dynamics over scalars that carry derivatives, with constant coefficients.
    pub fn lifted<D: Scalar>(&self) -> Dynamics<D> {
        let coefficients = self.coefficients.map(|_, value| D::from(value));
        let Self { inverse_mass, inverse_lateral, .. } = *self;
        Dynamics { coefficients, inverse_mass, inverse_lateral }
    }

    /// Returns the coefficients.
    pub fn coefficients(&self) -> &Coefficients {
        &self.coefficients
    }

    /// Returns the speed at which the Reynolds number is [`LEAST_REYNOLDS_NUMBER`] \[m/s\].
    pub fn least_friction_speed(&self) -> f64 {
        LEAST_REYNOLDS_NUMBER * self.coefficients.kinematic_viscosity / self.coefficients.length
    }

    /// Sets weight, buoyancy and centre of gravity, and the mass with them, without allocating.
    ///
    /// # Errors
    /// [`CoefficientError`] as for [`Dynamics::new`]; the dynamics are unchanged then.
    pub(crate) fn set_ballast(&mut self, ballast: &Ballast) -> Result<(), CoefficientError> {
        let before = self.coefficients.ballast();
        self.coefficients.set_ballast(ballast);
        match inverse_masses(&self.coefficients) {
            Ok(inverses) => (self.inverse_mass, self.inverse_lateral) = inverses,
            Err(error) => {
                self.coefficients.set_ballast(&before);
                return Err(error);
            }
        }
        Ok(())
    }
}

/// Checks the coefficients and inverts the two blocks of the mass matrix.
fn inverse_masses(c: &Coefficients) -> Result<(Matrix3<f64>, Option<Matrix3<f64>>), CoefficientError> {
    c.check()?;
    let inverse = |numbers, matrix: Matrix3<f64>| {
        let singular = CoefficientError::MassMatrixNotPositiveDefinite { numbers, least_eigenvalue: 0.0 };
        matrix.try_inverse().ok_or(singular)
    };
    let lateral =
        c.leaves_plane().then(|| inverse("mass, I_xx, I_zz", c.lateral_mass_matrix())).transpose()?;
    Ok((inverse("mass, I_yy", c.mass_matrix())?, lateral))
}

impl<D: Scalar> Dynamics<D> {
    /// Returns \[u' w' q'\] under the force \[X Z M\] of the actuators: `M nu' = coriolis + restoring + lift +
    /// damping + drag + actuators`.
    pub fn acceleration(&self, motion: &Motion<D>, depth: D, actuators: [D; 3]) -> [D; 3] {
        product(&self.inverse_mass, self.coefficients.force(motion, &motion.attitude(), depth, actuators))
    }

    /// Returns \[v' p' r'\] under the force \[Y K N\] of the actuators; zero for a vehicle that stays in the vertical
    /// plane.
    pub fn lateral_acceleration(&self, motion: &Motion<D>, depth: D, actuators: [D; 3]) -> [D; 3] {
        self.lateral_acceleration_at(&motion.attitude(), motion, depth, actuators)
    }

    pub(crate) fn lateral_acceleration_at(
        &self,
        attitude: &Attitude<D>,
        motion: &Motion<D>,
        depth: D,
        actuators: [D; 3],
    ) -> [D; 3] {
        let Some(inverse) = &self.inverse_lateral else { return [D::from(0.0); 3] };
        product(inverse, self.coefficients.lateral_force(motion, attitude, depth, actuators))
    }

    /// Returns the contribution of an external load \[Y K N\] to \[v' p' r'\].
    pub(crate) fn lateral_load_acceleration(&self, load: [D; 3]) -> [D; 3] {
        self.inverse_lateral.as_ref().map_or([D::from(0.0); 3], |inverse| product(inverse, load))
    }

    /// Returns the contribution of an external load \[X Z M\] to \[u' w' q'\]; the surge force has no effect if the
    /// speed is given.
    pub(crate) fn load_acceleration(&self, load: [D; 3]) -> [D; 3] {
        let [surge, heave, pitch] = load;
        let surge = if self.coefficients.surge.is_given() { D::from(0.0) } else { surge };
        product(&self.inverse_mass, [surge, heave, pitch])
    }

    /// Returns \[u' w' q' theta'\] under the force \[X Z M\] of the actuators and at a `given` speed \[m/s\], which a
    /// vehicle with free surge ignores. See [`Dynamics::acceleration`].
    pub fn rate(&self, motion: &Motion<D>, depth: D, given: D, force: [D; 3]) -> [D; 4] {
        self.rate_at(&motion.attitude(), motion, depth, given, force)
    }

    pub(crate) fn rate_at(
        &self,
        attitude: &Attitude<D>,
        motion: &Motion<D>,
        depth: D,
        given: D,
        mut force: [D; 3],
    ) -> [D; 4] {
        if let Some(rate) = self.coefficients.surge.rate(motion.u, given) {
            force[0] = rate;
        }
        let force = self.coefficients.force(motion, attitude, depth, force);
        let [u, w, q] = product(&self.inverse_mass, force);
        [u, w, q, motion.q]
    }

    /// Returns the surge force of drag: `X_uu u|u| - rho/2 (C_f k S_w + C_d A) u|u|`.
    ///
    /// `C_f = 0.075 / (log10 Re - 2)^2`, `Re = |u| L / nu`, at least [`LEAST_REYNOLDS_NUMBER`]. Source: ITTC (1957).
    pub fn axial_drag(&self, u: D) -> D {
        self.coefficients.axial_drag(u)
    }
}

fn product<D: Scalar>(matrix: &Matrix3<f64>, force: [D; 3]) -> [D; 3] {
    let row = |i: usize| force[0] * matrix[(i, 0)] + force[1] * matrix[(i, 1)] + force[2] * matrix[(i, 2)];
    [row(0), row(1), row(2)]
}

/// Returns the total force \[Y K N\] of all actuators at surge speed `u`.
pub fn lateral_actuator_force<D: Scalar>(
    actuators: &[Actuator],
    u: D,
    outputs: impl IntoIterator<Item = D>,
) -> [D; 3] {
    let pairs = actuators.iter().zip(outputs);
    pairs.fold([D::from(0.0); 3], |sum, (actuator, output)| add(sum, actuator.lateral_force(u, output)))
}

/// Returns the total force \[X Z M\] of all actuators at surge speed `u`.
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
