//! Implausible contents of a vehicle file: signs and sizes of coefficients.

#![allow(non_snake_case, reason = "the field's symbols keep their capitals: Z is a force, z a length")]

mod lift;
mod size;

use crate::text::rounded;
use crate::vehicle::Vehicle;
use crate::vehicle::actuator::{Actuator, Effect};
use squid_finding::Finding;
use std::f64::consts::PI;

/// Ratio of added mass to the vehicle's own above which it is unusual; the vehicles of this repository have 0.6 to 1.4.
const ADDED: f64 = 5.0;

/// Lag above which it is unusual (s): servos have a tenth, thrusters less than a second, and a given speed some
/// seconds.
const LAG: f64 = 5.0;

/// Deflection above which it is unusual (deg): a fin stalls at half of it.
const DEFLECTION: f64 = 45.0;

impl Vehicle {
    /// Returns findings on coefficients that are allowed but improbable: a centre of gravity above the centre of
    /// buoyancy, lift and damping that act with the motion or feed energy to it, a moment of inertia inconsistent with
    /// the mass, too large added mass, lags and deflections, control surfaces ahead of the origin, thrust and lengths
    /// inconsistent with drag and displacement.
    pub fn findings(&self) -> Vec<Finding> {
        let mut all: Vec<Finding> = self.gravity().into_iter().chain(self.acting_with_motion()).collect();
        all.extend(self.inertia());
        all.extend(self.added_mass());
        all.extend(self.lift());
        all.extend(self.size());
        all.extend(self.actuators.iter().chain(&self.others).flat_map(actuator));
        all
    }

    fn gravity(&self) -> Option<Finding> {
        let above = self.coefficients.z_B - self.coefficients.z_G;
        let why = format!(
            "the centre of gravity is {} m above the centre of buoyancy, so the vehicle is unstable at rest (z points \
             down)",
            rounded(above)
        );
        (above > 0.0).then(|| Finding::new("gravity_above_buoyancy", "z_G", why).value(above, "m").limit(0.0))
    }

    /// Coefficients of lift and damping with the wrong sign.
    fn acting_with_motion(&self) -> impl Iterator<Item = Finding> {
        let c = &self.coefficients;
        let (lift, fins) = ("the lift of a hull", "the damping by fins");
        let all = [
            ("Z_uw", c.Z_uw, "kg/m", "heave force Z_uw |u| w", "w", lift),
            ("M_uq", c.M_uq, "kg.m", "pitch moment M_uq |u| q", "q", fins),
            ("Y_uv", c.Y_uv, "kg/m", "sway force Y_uv |u| v", "v", lift),
            ("N_ur", c.N_ur, "kg.m", "yaw moment N_ur |u| r", "r", fins),
            ("K_up", c.K_up, "kg.m", "roll moment K_up |u| p", "p", fins),
        ];
        // In the vertical plane the terms of added mass alone can give the wrong sign.
        let counts = |key: &str| matches!(key, "Z_uw" | "M_uq") || self.sources.contains_key(key);
        let wrong = all.into_iter().filter(move |(key, value, ..)| *value > 0.0 && counts(key));
        wrong.map(|(key, value, unit, what, motion, usual)| {
            let why = format!(
                "the {what} acts in the direction of {motion}: without the terms of added mass {key} is {} {unit}, \
                 where {usual} is negative",
                rounded(value)
            );
            Finding::new("acts_with_motion", key, why).value(value, unit).limit(0.0)
        })
    }

    fn added_mass(&self) -> impl Iterator<Item = Finding> {
        let c = &self.coefficients;
        let all = [("Z_w_dot", -c.Z_w_dot, "mass", c.mass), ("M_q_dot", -c.M_q_dot, "I_yy", c.I_yy)];
        all.into_iter().filter(|(_, added, _, own)| *added > ADDED * own).map(|(key, added, of, own)| {
            let why = format!(
                "'{key}' is {} times '{of}'; more than {ADDED} times is unusual: check its unit",
                rounded(added / own)
            );
            Finding::new("large_added_mass", key, why).value(added / own, "").limit(ADDED)
        })
    }

    /// Moments of inertia: of roll above those of pitch and yaw; of pitch about the centre of gravity below that of a
    /// ball of the vehicle's mass and the density of water, or above that of all the mass at the ends of the hull.
    fn inertia(&self) -> impl Iterator<Item = Finding> {
        let c = &self.coefficients;
        let mass = c.mass;
        let own = c.I_yy - mass * (c.x_G * c.x_G + c.z_G * c.z_G);
        let radius = (3.0 * mass / (4.0 * PI * c.density)).cbrt();
        let ball = 0.4 * mass * radius * radius;
        let ends = self.geometry.map(|hull| 0.25 * mass * hull.length * hull.length);
        let comparison = match ends {
            _ if own < ball => {
                Some((ball, format!("below {} kg.m2, that of a ball of its mass", rounded(ball))))
            }
            Some(ends) if own > ends => Some((
                ends,
                format!("above {} kg.m2, that of all its mass at the two ends of the hull", rounded(ends)),
            )),
            _ => None,
        };
        let pitch = comparison.map(|(limit, comparison)| {
            let why = format!(
                "'I_yy' is {} kg.m2, and {} kg.m2 about the centre of gravity, {comparison}: check its unit",
                rounded(c.I_yy),
                rounded(own)
            );
            Finding::new("inertia_against_mass", "I_yy", why).value(own, "kg.m2").limit(limit)
        });
        let limit = c.I_yy.max(c.I_zz);
        let roll = (c.I_xx > limit).then(|| {
            let why = format!(
                "'I_xx' is {} kg.m2, more than 'I_yy' and 'I_zz', although a hull is longer than broad: check its axis",
                rounded(c.I_xx)
            );
            Finding::new("large_roll_inertia", "I_xx", why).value(c.I_xx, "kg.m2").limit(limit)
        });
        pitch.into_iter().chain(roll)
    }
}

/// Findings on an actuator: a long lag, a large deflection, a fin ahead of the origin.
fn actuator(one: &Actuator) -> Vec<Finding> {
    let name = &one.name;
    let mut found = vec![];
    if one.lag > LAG {
        let why = format!(
            "the lag of '{name}' is {} s; more than {LAG} s is unusual: check its unit",
            rounded(one.lag)
        );
        found.push(Finding::new("long_lag", name, why).value(one.lag, "s").limit(LAG));
    }
    let Effect::ControlSurface { Z_uu_delta, M_uu_delta, Y_uu_delta, N_uu_delta, .. } = one.effect else {
        return found;
    };
    let largest = one.min.abs().max(one.max.abs()).to_degrees();
    if largest > DEFLECTION + 1e-9 {
        let why = format!(
            "'{name}' is deflected by up to {} deg; more than {DEFLECTION} deg is unusual, because its force is taken \
             as proportional: check its unit",
            rounded(largest)
        );
        found.push(Finding::new("large_deflection", name, why).value(largest, "deg").limit(DEFLECTION));
    }
    let planes = ("pitches", "Z_uu_delta", Z_uu_delta, "M_uu_delta", M_uu_delta, -1.0, "planes", "equal");
    let rudder = ("yaws", "Y_uu_delta", Y_uu_delta, "N_uu_delta", N_uu_delta, 1.0, "a rudder", "opposite");
    for (turns, force, of_force, moment, of_moment, sign, what, signs) in [planes, rudder] {
        if sign * of_force * of_moment <= 0.0 {
            continue;
        }
        let arm = (of_moment / of_force).abs();
        let why = format!(
            "'{name}' {turns} as a fin {} m ahead of the origin: '{force}' is {} and '{moment}' {}; those of {what} at \
             the stern have {signs} signs",
            rounded(arm),
            rounded(of_force),
            rounded(of_moment)
        );
        found.push(Finding::new("fin_ahead_of_origin", name, why).value(arm, "m").limit(0.0));
    }
    found
}
