//! Early end of a flight at the surface.

use crate::sea::Conditions;
use squid_auv::State;

/// Height above the surface \[m\] beyond which a vehicle has left the water; less is rounding in a flight that starts
/// at the surface.
const OUT_OF_WATER: f64 = 1e-3;

/// Returns `true` if a vehicle at a depth \[m\] is out of the water, where the equations of motion do not hold.
pub fn out_of_water(depth: f64) -> bool {
    depth < -OUT_OF_WATER
}

/// Returns the end of a flight in this state, if the hull is out of the water.
pub(crate) fn surfacing(sea: Option<&Conditions>, time: f64, state: &State) -> Option<Surfacing> {
    let clearance = sea.map_or(state.depth, |sea| sea.surroundings().clearance(time, &state.pose()));
    out_of_water(clearance).then_some(Surfacing { time, speed: state.motion.u })
}

/// Early end of a flight at the surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Surfacing {
    /// Time, s.
    pub time: f64,
    /// Forward speed through the water, m/s.
    pub speed: f64,
}

impl std::fmt::Display for Surfacing {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "the vehicle reaches the surface at {:.2} s, with {:.2} m/s", self.time, self.speed)
    }
}
