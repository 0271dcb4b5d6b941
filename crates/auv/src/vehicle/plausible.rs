//! What a vehicle file may say, but hardly means: signs and sizes of coefficients.

use crate::vehicle::Vehicle;
use crate::words::rounded;

/// Added mass of more than this multiple of the vehicle's own is unusual: it is 0.6 to 1.4 times as much for the
/// vehicles that are shipped.
const ADDED: f64 = 5.0;

/// A lag of more than this is unusual (s): servos take a tenth, thrusters less than a second, and a speed that is given
/// some seconds.
const LAG: f64 = 5.0;

impl Vehicle {
    /// Remarks on coefficients that are allowed but improbable, a sentence each: a centre of gravity above that of
    /// buoyancy, lift that acts with the heave velocity, added mass and lags that are too large.
    pub fn doubts(&self) -> Vec<String> {
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
                "the heave force Z_uw u w acts in the direction of w: without the terms of added mass Z_uw is {} kg/m, \
                 where the lift of a hull is negative",
                rounded(c.Z_uw)
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
        let lags = self.actuators.iter().filter(|a| a.lag > LAG).map(|a| {
            format!(
                "the lag of '{}' is {} s; more than {LAG} s is unusual: check its unit",
                a.name,
                rounded(a.lag)
            )
        });
        gravity.into_iter().chain(lift).chain(added).chain(lags).collect()
    }
}
