//! Forces on the hull: inertial, restoring, lift, damping, drag.
//!
//! Coefficients and motion may carry derivatives. In the vertical plane, where v, p, r and phi are 0, the coupling to
//! sway, roll and yaw vanishes.
//!
//! Sources: Lamb, Hydrodynamics (1932), ch. VI (Kirchhoff's equations); Fossen (2011), ch. 6 to 8; ITTC (1957).

use crate::motion::dynamics::{Attitude, LEAST_REYNOLDS_NUMBER, Motion, add};
use crate::scalar::Scalar;
use crate::vehicle::coefficients::Coefficients;
use std::f64::consts::LN_10;

impl<D: Scalar> Coefficients<D> {
    /// Returns `M nu' = actuators + coriolis + restoring + lift + damping + drag`: surge force, heave force, pitch
    /// moment. If the speed is given, the first entry is u' itself, taken from `actuators[0]`.
    pub(crate) fn force(
        &self,
        motion: &Motion<D>,
        attitude: &Attitude<D>,
        depth: D,
        actuators: [D; 3],
    ) -> [D; 3] {
        let parts = [
            self.coriolis(motion),
            self.restoring(attitude, depth),
            self.lift(motion),
            self.damping(motion),
            self.cross_flow(motion),
            [self.axial_drag(motion.u), D::from(0.0), D::from(0.0)],
        ];
        let [surge, heave, pitch] = parts.into_iter().fold(actuators, add);
        [if self.surge.is_given() { actuators[0] } else { surge }, heave, pitch]
    }

    /// Returns the same for sway force, roll moment and yaw moment.
    pub(crate) fn lateral_force(
        &self,
        motion: &Motion<D>,
        attitude: &Attitude<D>,
        depth: D,
        actuators: [D; 3],
    ) -> [D; 3] {
        let parts = [
            self.lateral_coriolis(motion),
            self.lateral_restoring(attitude, depth),
            self.lateral_lift(motion),
            self.lateral_damping(motion),
            self.lateral_cross_flow(motion),
        ];
        parts.into_iter().fold(actuators, add)
    }

    /// Returns the momentum P of vehicle and water in body axes.
    ///
    /// ```text
    /// P_x = (m - X_u') u + m z_G q
    /// P_y = (m - Y_v') v - (m z_G + Y_p') p + (m x_G - Y_r') r
    /// P_z = (m - Z_w') w - (m x_G + Z_q') q
    /// ```
    fn momentum(&self, motion: &Motion<D>) -> [D; 3] {
        let c = self;
        let Motion { u, v, w, p, q, r, .. } = *motion;
        [
            u * (c.mass - c.X_u_dot) + q * (c.mass * c.z_G),
            v * (c.mass - c.Y_v_dot) - p * (c.mass * c.z_G + c.Y_p_dot) + r * (c.mass * c.x_G - c.Y_r_dot),
            w * (c.mass - c.Z_w_dot) - q * (c.mass * c.x_G + c.Z_q_dot),
        ]
    }

    /// Returns the angular momentum L of vehicle and water about the origin.
    ///
    /// ```text
    /// L_x = (I_xx - K_p') p - K_r' r - (m z_G + Y_p') v
    /// L_y = (I_yy - M_q') q + m z_G u - (m x_G + M_w') w
    /// L_z = (I_zz - N_r') r - K_r' p + (m x_G - Y_r') v
    /// ```
    fn angular_momentum(&self, motion: &Motion<D>) -> [D; 3] {
        let c = self;
        let Motion { u, v, w, p, q, r, .. } = *motion;
        [
            p * (c.I_xx - c.K_p_dot) - r * c.K_r_dot - v * (c.mass * c.z_G + c.Y_p_dot),
            q * (c.I_yy - c.M_q_dot) + u * (c.mass * c.z_G) - w * (c.mass * c.x_G + c.M_w_dot),
            r * (c.I_zz - c.N_r_dot) - p * c.K_r_dot + v * (c.mass * c.x_G - c.Y_r_dot),
        ]
    }

    /// Returns Kirchhoff's inertial terms `-omega x P` and `-omega x L - v x P` along x and z and about y; they include
    /// the Munk moment.
    fn coriolis(&self, motion: &Motion<D>) -> [D; 3] {
        let Motion { u, w, p, q, r, .. } = *motion;
        let ([p_x, p_y, p_z], [l_x, _, l_z]) = (self.momentum(motion), self.angular_momentum(motion));
        [r * p_y - q * p_z, q * p_x - p * p_y, u * p_z - w * p_x + (p * l_z - r * l_x)]
    }

    /// Returns the same terms along y and about x and z.
    fn lateral_coriolis(&self, motion: &Motion<D>) -> [D; 3] {
        let Motion { u, v, w, p, q, r, .. } = *motion;
        let ([p_x, p_y, p_z], [l_x, l_y, l_z]) = (self.momentum(motion), self.angular_momentum(motion));
        [p * p_z - r * p_x, r * l_y - q * l_z + (w * p_y - v * p_z), q * l_x - p * l_y + (v * p_x - u * p_y)]
    }

    /// Returns `W - B`, `z_G W - z_B B` and `x_G W - x_B B` at a depth.
    fn weight_and_buoyancy(&self, depth: D) -> [D; 3] {
        let c = self;
        let buoyancy = (depth - c.reference_depth) * c.buoyancy_gradient + c.buoyancy;
        [
            -(buoyancy - c.weight),
            -(buoyancy * c.z_B - c.z_G * c.weight),
            -(buoyancy * c.x_B - c.x_G * c.weight),
        ]
    }

    /// Returns the restoring forces X, Z and M, with c_phi for cos(phi): `-(W - B) sin`, `(W - B) cos c_phi`, `-(z_G W
    /// - z_B B) sin - (x_G W - x_B B) cos c_phi`.
    fn restoring(&self, attitude: &Attitude<D>, depth: D) -> [D; 3] {
        let [excess, righting, trimming] = self.weight_and_buoyancy(depth);
        let Attitude { sin, cos, cos_phi, .. } = *attitude;
        [-(excess * sin), excess * cos * cos_phi, -(righting * sin) - trimming * cos * cos_phi]
    }

    /// Returns the restoring forces Y, K and N, with s_phi for sin(phi): `(W - B) cos s_phi`, `-(z_G W - z_B B) cos
    /// s_phi`, `(x_G W - x_B B) cos s_phi`.
    fn lateral_restoring(&self, attitude: &Attitude<D>, depth: D) -> [D; 3] {
        let [excess, righting, trimming] = self.weight_and_buoyancy(depth);
        let across = attitude.cos * attitude.sin_phi;
        [excess * across, -(righting * across), trimming * across]
    }

    /// Returns lift and its moment: `Z_uw |u| w + Z_uq |u| q` and `M_uw |u| w + M_uq |u| q + M_uu u|u|`. The sign is
    /// the same ahead and astern: a fin at incidence is pushed back by the flow, whichever edge leads.
    fn lift(&self, motion: &Motion<D>) -> [D; 3] {
        let c = self;
        let Motion { u, w, q, .. } = *motion;
        let flow = u.abs();
        let force = flow * w * c.Z_uw + flow * q * c.Z_uq;
        let moment = flow * w * c.M_uw + flow * q * c.M_uq + u * flow * c.M_uu;
        [D::from(0.0), force, moment]
    }

    /// Returns `Y_uv |u| v + Y_up |u| p + Y_ur |u| r`, and the same with K and N.
    fn lateral_lift(&self, motion: &Motion<D>) -> [D; 3] {
        let c = self;
        let Motion { u, v, p, r, .. } = *motion;
        let of = |by_v: D, by_p: D, by_r: D| u.abs() * (v * by_v + p * by_p + r * by_r);
        [of(c.Y_uv, c.Y_up, c.Y_ur), of(c.K_uv, c.K_up, c.K_ur), of(c.N_uv, c.N_up, c.N_ur)]
    }

    /// Returns linear damping, independent of the speed, and quadratic drag: `X_u u`, `Z_w w + Z_ww w|w| + Z_qq q|q| +
    /// Z_q q` and `M_q q + M_qq q|q| + M_ww w|w| + M_w w`.
    fn damping(&self, motion: &Motion<D>) -> [D; 3] {
        let c = self;
        let Motion { u, w, q, .. } = *motion;
        let (ww, qq) = (w * w.abs(), q * q.abs());
        let heave = w * c.Z_w + ww * c.Z_ww + qq * c.Z_qq + q * c.Z_q;
        let pitch = q * c.M_q + qq * c.M_qq + ww * c.M_ww + w * c.M_w;
        [u * c.X_u, heave, pitch]
    }

    /// Returns `Y_v v + Y_vv v|v| + Y_rr r|r| + Y_r r`, `K_p p + K_pp p|p|` and `N_r r + N_rr r|r| + N_vv v|v| + N_v
    /// v`.
    fn lateral_damping(&self, motion: &Motion<D>) -> [D; 3] {
        let c = self;
        let Motion { v, p, r, .. } = *motion;
        let (vv, rr) = (v * v.abs(), r * r.abs());
        let sway = v * c.Y_v + vv * c.Y_vv + rr * c.Y_rr + r * c.Y_r;
        let yaw = r * c.N_r + rr * c.N_rr + vv * c.N_vv + v * c.N_v;
        [sway, p * c.K_p + p * p.abs() * c.K_pp, yaw]
    }

    /// Returns the cross-flow drag of the hull sections: `-rho/2 C_d ∫ b v|v| dx` and `rho/2 C_d ∫ x b v|v| dx` with
    /// `v = w - x q`.
    ///
    /// Source: Healey and Lienard (1993); Fossen (2011), section 6.4.
    fn cross_flow(&self, motion: &Motion<D>) -> [D; 3] {
        let [force, moment] = self.hull.cross_flow(motion.w, motion.q);
        let factor = self.density * self.C_d * 0.5;
        [D::from(0.0), -(force * factor), moment * factor]
    }

    /// Returns the lateral cross-flow drag: `-rho/2 C_d ∫ b V|V| dx` and `-rho/2 C_d ∫ x b V|V| dx` with `V = v + x r`;
    /// the height of each section equals its breadth.
    fn lateral_cross_flow(&self, motion: &Motion<D>) -> [D; 3] {
        let [force, moment] = self.hull.cross_flow(motion.v, -motion.r);
        let factor = self.density * self.C_d * 0.5;
        [-(force * factor), D::from(0.0), -(moment * factor)]
    }

    /// Returns the surge force of drag: `X_uu u|u| - rho/2 (C_f k S_w + C_d A) u|u|`.
    ///
    /// `C_f = 0.075 / (log10 Re - 2)^2`, `Re = |u| L / nu`, at least [`LEAST_REYNOLDS_NUMBER`]. Source: ITTC (1957).
    pub(crate) fn axial_drag(&self, u: D) -> D {
        let c = self;
        let reynolds = u.abs() * (c.length / c.kinematic_viscosity);
        let reynolds =
            if reynolds > LEAST_REYNOLDS_NUMBER { reynolds } else { D::from(LEAST_REYNOLDS_NUMBER) };
        // The natural logarithm takes a third of the time of the decimal one.
        let line = (reynolds * 0.01).ln();
        let friction = (line * line).recip() * (c.form_factor * 0.075 * LN_10 * LN_10 * c.wetted_area);
        u * u.abs() * ((friction + c.drag_area) * (c.density * -0.5) + c.X_uu)
    }
}
