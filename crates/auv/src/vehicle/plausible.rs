//! Implausible contents of a vehicle file: signs and sizes of coefficients.

#![allow(non_snake_case, reason = "the field's symbols keep their capitals: Z is a force, z a length")]

mod lift;
mod size;

use crate::vehicle::Vehicle;
use crate::vehicle::actuator::Effect;
use crate::words::rounded;
use std::f64::consts::PI;

/// Ratio of added mass to the vehicle's own above which it is unusual; the vehicles of this repository have 0.6 to 1.4.
const ADDED: f64 = 5.0;

/// Lag above which it is unusual (s): servos have a tenth, thrusters less than a second, and a given speed some
/// seconds.
const LAG: f64 = 5.0;

/// Deflection above which it is unusual (deg): a fin stalls at half of it.
const DEFLECTION: f64 = 45.0;

impl Vehicle {
    /// Returns remarks on coefficients that are allowed but improbable, a sentence each: a centre of gravity above the
    /// centre of buoyancy, lift and damping that act with the motion or feed energy to it, a moment of inertia
    /// inconsistent with the mass, too large added mass, lags and deflections, control surfaces ahead of the origin,
    /// thrust and lengths inconsistent with drag and displacement.
    pub fn remarks(&self) -> Vec<String> {
        let c = &self.coefficients;
        let above = c.z_B - c.z_G;
        let gravity = (above > 0.0).then(|| {
            format!(
                "the centre of gravity is {} m above the centre of buoyancy: it is unstable at rest (z points \
                 down)",
                rounded(above)
            )
        });
        let lift = (c.Z_uw > 0.0).then(|| {
            format!(
                "the heave force Z_uw |u| w acts in the direction of w: without the terms of added mass Z_uw is {} \
                 kg/m, where the lift of a hull is negative",
                rounded(c.Z_uw)
            )
        });
        let damping = (c.M_uq > 0.0).then(|| {
            format!(
                "the pitch moment M_uq |u| q acts in the direction of q: without the terms of added mass M_uq is {} \
                 kg.m, where the damping by fins is negative",
                rounded(c.M_uq)
            )
        });
        let with_motion = [
            ("Y_uv", c.Y_uv, "sway force Y_uv |u| v", "v", "the lift of a hull"),
            ("N_ur", c.N_ur, "yaw moment N_ur |u| r", "r", "the damping by fins"),
            ("K_up", c.K_up, "roll moment K_up |u| p", "p", "the damping by fins"),
        ];
        let given = |key: &str| self.sources.contains_key(key);
        let lateral = with_motion.into_iter().filter(|(key, value, ..)| *value > 0.0 && given(key)).map(
            |(key, value, what, motion, usual)| {
                format!(
                    "the {what} acts in the direction of {motion}: without the terms of added mass {key} is {}, where \
                     {usual} is negative",
                    rounded(value)
                )
            },
        );
        let roll_inertia = (c.I_xx > c.I_yy.max(c.I_zz)).then(|| {
            format!(
                "'I_xx' is {} kg.m2, more than 'I_yy' and 'I_zz': a hull is longer than broad; check its axis",
                rounded(c.I_xx)
            )
        });
        let added = [("Z_w_dot", -c.Z_w_dot, "mass", c.mass), ("M_q_dot", -c.M_q_dot, "I_yy", c.I_yy)];
        let added = added.into_iter().filter(|(_, added, _, own)| *added > ADDED * own).map(
            |(key, added, of, own)| {
                format!(
                    "'{key}' is {} times '{of}'; more than {ADDED} times is unusual: check its unit",
                    rounded(added / own)
                )
            },
        );
        let all = || self.actuators.iter().chain(&self.others);
        let lags = all().filter(|a| a.lag > LAG).map(|a| {
            format!(
                "the lag of '{}' is {} s; more than {LAG} s is unusual: check its unit",
                a.name,
                rounded(a.lag)
            )
        });
        let surfaces =
            all().filter(|a| matches!(a.effect, Effect::ControlSurface { .. })).map(|a| {
                let largest = a.min.abs().max(a.max.abs()).to_degrees();
                (largest > DEFLECTION + 1e-9).then(|| {
                    format!(
                        "'{}' is deflected by up to {} deg; more than {DEFLECTION} deg is unusual, where its force \
                         is taken as proportional: check its unit",
                        a.name,
                        rounded(largest)
                    )
                })
            });
        let ahead = all().flat_map(|one| {
            let Effect::ControlSurface { Z_uu_delta, M_uu_delta, Y_uu_delta, N_uu_delta, .. } = one.effect else {
                return [None, None];
            };
            let planes = ("pitches", "Z_uu_delta", Z_uu_delta, "M_uu_delta", M_uu_delta, -1.0, "planes", "equal");
            let rudder = ("yaws", "Y_uu_delta", Y_uu_delta, "N_uu_delta", N_uu_delta, 1.0, "a rudder", "opposite");
            [planes, rudder].map(|(turns, force, of_force, moment, of_moment, sign, what, signs)| {
                (sign * of_force * of_moment > 0.0).then(|| {
                    format!(
                        "'{}' {turns} as a fin {} m ahead of the origin: '{force}' is {} and '{moment}' {}; those of \
                         {what} at the stern have {signs} signs",
                        one.name,
                        rounded((of_moment / of_force).abs()),
                        rounded(of_force),
                        rounded(of_moment)
                    )
                })
            })
        });
        let inertia = self.inertia();
        let remarks = gravity.into_iter().chain(lift).chain(damping).chain(inertia).chain(added);
        let remarks = remarks.chain(lateral).chain(roll_inertia);
        let remarks = remarks.chain(self.remarks_on_lift()).chain(self.remarks_on_size());
        remarks.chain(ahead.flatten()).chain(lags).chain(surfaces.flatten()).collect()
    }

    /// Returns a remark on a moment of inertia about the centre of gravity below that of a ball of the vehicle's mass
    /// and the density of water, or above that of all the mass at the ends of the hull.
    fn inertia(&self) -> Option<String> {
        let c = &self.coefficients;
        let mass = c.mass;
        let own = c.I_yy - mass * (c.x_G * c.x_G + c.z_G * c.z_G);
        let radius = (3.0 * mass / (4.0 * PI * c.density)).cbrt();
        let ball = 0.4 * mass * radius * radius;
        let ends = self.geometry.map(|hull| 0.25 * mass * hull.length * hull.length);
        let comparison = match ends {
            _ if own < ball => format!("below {} kg.m2, that of a ball of its mass", rounded(ball)),
            Some(ends) if own > ends => {
                format!("above {} kg.m2, that of all its mass at the two ends of the hull", rounded(ends))
            }
            _ => return None,
        };
        Some(format!(
            "'I_yy' is {} kg.m2, and {} kg.m2 about the centre of gravity, {comparison}: check its unit",
            rounded(c.I_yy),
            rounded(own)
        ))
    }
}
