//! Surge of a vehicle: from thrust and drag, or at a given speed.

use crate::scalar::Scalar;
use crate::states::longitudinal;
use squid_signals::States;

/// Source of the surge velocity.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Surge {
    /// Equation of motion: thrust, drag, inertia.
    #[default]
    Free,
    /// Given speed, followed as `u' = (given - u)/lag` regardless of the forces on the hull. Heave and pitch move at
    /// that speed, and the linear model has the states \[w q theta\].
    Given {
        /// Time constant \[s\], above zero.
        lag: f64,
    },
}

/// Coefficients that affect the surge force only.
const ALONG_THE_HULL: [&str; 8] = [
    "kinematic_viscosity",
    "X_u",
    "X_uu",
    "length",
    "wetted_area",
    "form_factor",
    "drag_area",
    "X_uu_delta2",
];

impl Surge {
    /// Returns `true` if the speed is given.
    pub fn is_given(self) -> bool {
        matches!(self, Self::Given { .. })
    }

    /// Returns `u' = (given - u)/lag` if the speed is given.
    pub fn rate<D: Scalar>(self, u: D, given: D) -> Option<D> {
        match self {
            Self::Free => None,
            Self::Given { lag } => Some((given - u) / lag),
        }
    }

    /// Returns the states of the linear model, without or with the depth.
    pub fn states(self, depth: bool) -> States {
        longitudinal(self.is_given(), depth)
    }

    /// Returns `true` if a coefficient affects the motion, by its key in the vehicle file: forces along the hull do not
    /// affect a given speed.
    pub fn uses(self, key: &str) -> bool {
        !(self.is_given() && ALONG_THE_HULL.contains(&key))
    }

    /// Returns the index of the first equation of surge, heave and pitch that belongs to the linear model.
    pub(crate) fn first(self) -> usize {
        usize::from(self.is_given())
    }
}
