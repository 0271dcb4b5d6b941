//! What moves the vehicle forward: thrust and drag, or a speed that is given from outside.

use crate::scalar::Scalar;
use crate::states::longitudinal;
use squid_signals::States;

/// Where the surge velocity comes from.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Surge {
    /// Its equation of motion: thrust, drag, inertia.
    #[default]
    Free,
    /// It follows a speed that is given from outside, `u' = (given - u)/lag`, whatever acts on the hull. Heave and
    /// pitch move at that speed, with \[w q theta\] as the states of their linear model.
    Given {
        /// Time constant \[s\], above zero.
        lag: f64,
    },
}

/// The numbers that enter the surge force alone.
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
    /// Returns whether the speed is given.
    pub fn is_given(self) -> bool {
        matches!(self, Self::Given { .. })
    }

    /// Returns `u' = (given - u)/lag` where the speed is given.
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

    /// Returns whether a number of a vehicle acts on its motion, by its key in the vehicle file: forces along the hull
    /// have no part in a speed that is given.
    pub fn uses(self, key: &str) -> bool {
        !(self.is_given() && ALONG_THE_HULL.contains(&key))
    }

    /// The first of the equations of surge, heave and pitch that belongs to the linear model.
    pub(crate) fn first(self) -> usize {
        usize::from(self.is_given())
    }
}
