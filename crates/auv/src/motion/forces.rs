//! The forces on the hull: inertial, restoring, lift, damping, drag.
//!
//! They are written over coefficients that may carry derivatives, as the motion may.
//!
//! Sources: Lamb, Hydrodynamics (1932), ch. VI (Kirchhoff's equations); Fossen (2011), ch. 6 to 8; ITTC (1957).

use crate::motion::dynamics::{LEAST_REYNOLDS_NUMBER, Motion, add};
use crate::scalar::Scalar;
use crate::vehicle::coefficients::Coefficients;

impl<D: Scalar> Coefficients<D> {
    /// Returns `M nu' = actuators + coriolis + restoring + lift + damping + drag`: surge force, heave force, pitch
    /// moment. Where the speed is given, the first is u' itself, and `actuators[0]` gives it.
    pub(crate) fn force(&self, motion: &Motion<D>, depth: D, actuators: [D; 3]) -> [D; 3] {
        let parts = [
            self.coriolis(motion),
            self.restoring(motion.theta, depth),
            self.lift(motion),
            self.damping(motion),
            self.cross_flow(motion),
            [self.axial_drag(motion.u), D::from(0.0), D::from(0.0)],
        ];
        let [surge, heave, pitch] = parts.into_iter().fold(actuators, add);
        [if self.surge.is_given() { actuators[0] } else { surge }, heave, pitch]
    }

    /// Kirchhoff's inertial terms: `-q p_z`, `q p_x`, `u p_z - w p_x`, with the momenta `p_x = (m - X_u') u + m z_G
    /// q` and `p_z = (m - Z_w') w - (m x_G + Z_q') q`; the Munk moment is among them.
    fn coriolis(&self, motion: &Motion<D>) -> [D; 3] {
        let c = self;
        let Motion { u, w, q, .. } = *motion;
        let p_x = u * (c.mass - c.X_u_dot) + q * (c.mass * c.z_G);
        let p_z = w * (c.mass - c.Z_w_dot) - q * (c.mass * c.x_G + c.Z_q_dot);
        [-(q * p_z), q * p_x, u * p_z - w * p_x]
    }

    /// Weight and buoyancy: `-(W - B) sin`, `(W - B) cos`, `-(z_G W - z_B B) sin - (x_G W - x_B B) cos`.
    fn restoring(&self, theta: D, depth: D) -> [D; 3] {
        let c = self;
        let (sin, cos) = theta.sin_cos();
        let buoyancy = (depth - c.reference_depth) * c.buoyancy_gradient + c.buoyancy;
        let excess = -(buoyancy - c.weight);
        let righting = -(buoyancy * c.z_B - c.z_G * c.weight);
        let trimming = -(buoyancy * c.x_B - c.x_G * c.weight);
        [-(excess * sin), excess * cos, -(righting * sin) - trimming * cos]
    }

    /// Lift and its moment: `Z_uw u w + Z_uq u q` and `M_uw u w + M_uq u q + M_uu u|u|`.
    fn lift(&self, motion: &Motion<D>) -> [D; 3] {
        let c = self;
        let Motion { u, w, q, .. } = *motion;
        let force = u * w * c.Z_uw + u * q * c.Z_uq;
        let moment = u * w * c.M_uw + u * q * c.M_uq + u * u.abs() * c.M_uu;
        [D::from(0.0), force, moment]
    }

    /// Linear damping, whatever the speed, and cross-flow drag: `X_u u`, `Z_w w + Z_ww w|w| + Z_qq q|q| + Z_q q` and
    /// `M_q q + M_qq q|q| + M_ww w|w| + M_w w`.
    fn damping(&self, motion: &Motion<D>) -> [D; 3] {
        let c = self;
        let Motion { u, w, q, .. } = *motion;
        let (ww, qq) = (w * w.abs(), q * q.abs());
        let heave = w * c.Z_w + ww * c.Z_ww + qq * c.Z_qq + q * c.Z_q;
        let pitch = q * c.M_q + qq * c.M_qq + ww * c.M_ww + w * c.M_w;
        [u * c.X_u, heave, pitch]
    }

    /// Cross-flow drag of the sections of the hull: `-rho/2 C_d ∫ b v|v| dx` and `rho/2 C_d ∫ x b v|v| dx` with
    /// `v = w - x q`.
    ///
    /// Source: Healey and Lienard (1993); Fossen (2011), section 6.4.
    fn cross_flow(&self, motion: &Motion<D>) -> [D; 3] {
        let [force, moment] = self.hull.cross_flow(motion.w, motion.q);
        let factor = self.density * self.C_d * 0.5;
        [D::from(0.0), -(force * factor), moment * factor]
    }

    /// Returns the surge force of drag: `X_uu u|u| - rho/2 (C_f k S_w + C_d A) u|u|`.
    ///
    /// `C_f = 0.075 / (log10 Re - 2)^2`, `Re = |u| L / nu`, at least [`LEAST_REYNOLDS_NUMBER`]. Source: ITTC (1957).
    pub(crate) fn axial_drag(&self, u: D) -> D {
        let c = self;
        let reynolds = u.abs() * (c.length / c.kinematic_viscosity);
        let reynolds =
            if reynolds > LEAST_REYNOLDS_NUMBER { reynolds } else { D::from(LEAST_REYNOLDS_NUMBER) };
        let line = reynolds.log10() - 2.0;
        let friction = (line * line).recip() * (c.form_factor * 0.075 * c.wetted_area);
        u * u.abs() * ((friction + c.drag_area) * (c.density * -0.5) + c.X_uu)
    }
}
