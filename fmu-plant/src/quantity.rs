//! Quantities with exact derivatives in the plant.

use squid_auv::index::STATES;

/// A quantity that does not belong to an actuator. Some are unused in the vertical plane.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// Velocity of the current: north or horizontal, east, down.
    Current(usize),
    /// Operating speed of the LPV model.
    OperatingSpeed,
    /// Prescribed forward speed.
    GivenSpeed,
    /// External load, X Y Z K M N.
    External(usize),
    /// Time, on which the waves depend.
    Time,
    /// State, numbered as in [`squid_auv::index`].
    State(usize),
    /// Time derivative of a state, numbered likewise.
    Rate(usize),
    /// Forward speed u through the water; then v, w and V.
    Speed,
    #[allow(missing_docs)]
    Sway,
    #[allow(missing_docs)]
    Heave,
    #[allow(missing_docs)]
    PathSpeed,
    /// Roll rate phi' in six degrees of freedom; then theta' and psi'. In the vertical plane theta' is the state q.
    RollRate,
    #[allow(missing_docs)]
    PitchRate,
    #[allow(missing_docs)]
    HeadingRate,
    /// Height above the seabed.
    Altitude,
}

const CURRENT: usize = 3;
const LOAD: usize = 6;
/// Number of quantities that do not belong to an actuator; every actuator adds three.
const FIXED: usize = CURRENT + LOAD + 2 * STATES + 11;

impl Quantity {
    /// Returns the number of quantities of a vehicle with `actuators` actuators.
    pub fn count(actuators: usize) -> usize {
        FIXED + 3 * actuators
    }

    /// Returns the number of the quantity.
    pub fn number(self) -> usize {
        let others = CURRENT + LOAD + 2 * STATES;
        match self {
            Self::Current(axis) => axis,
            Self::External(axis) => CURRENT + axis,
            Self::State(place) => CURRENT + LOAD + place,
            Self::Rate(place) => CURRENT + LOAD + STATES + place,
            Self::OperatingSpeed => others,
            Self::GivenSpeed => others + 1,
            Self::Time => others + 2,
            Self::Speed => others + 3,
            Self::Sway => others + 4,
            Self::Heave => others + 5,
            Self::PathSpeed => others + 6,
            Self::PitchRate => others + 7,
            Self::HeadingRate => others + 8,
            Self::Altitude => others + 9,
            Self::RollRate => others + 10,
        }
    }

    /// Returns the number of the command of an actuator.
    pub fn command(actuator: usize) -> usize {
        FIXED + 3 * actuator
    }

    /// Returns the number of the output of an actuator.
    pub fn output(actuator: usize) -> usize {
        FIXED + 3 * actuator + 1
    }

    /// Returns the number of the rate of an actuator's output.
    pub fn output_rate(actuator: usize) -> usize {
        FIXED + 3 * actuator + 2
    }
}
