//! Coefficients that change in operation, by a dropped weight or pumped volume.

#![allow(non_snake_case, reason = "the field's symbols keep their capitals")]

use crate::vehicle::coefficients::Coefficients;

/// Coefficients that dropped weights and buoyancy engines change. All others are constant, including I_yy about the
/// origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ballast {
    /// Mass \[kg\].
    pub mass: f64,
    /// Weight W \[N\].
    pub weight: f64,
    /// Buoyancy B at the reference depth \[N\].
    pub buoyancy: f64,
    /// Centre of gravity forward of the origin \[m\].
    pub x_G: f64,
    /// Centre of gravity below the origin \[m\].
    pub z_G: f64,
}

impl Coefficients {
    /// Returns the coefficients that change in operation.
    pub fn ballast(&self) -> Ballast {
        let Self { mass, weight, buoyancy, x_G, z_G, .. } = *self;
        Ballast { mass, weight, buoyancy, x_G, z_G }
    }

    /// Sets these coefficients, unchecked: call [`Coefficients::check`] afterwards.
    pub fn set_ballast(&mut self, ballast: &Ballast) {
        let Ballast { mass, weight, buoyancy, x_G, z_G } = *ballast;
        (self.mass, self.weight, self.buoyancy) = (mass, weight, buoyancy);
        (self.x_G, self.z_G) = (x_G, z_G);
    }
}
