//! The quantities with exact derivatives in the plant.

use squid_auv::index::STATES;

/// One quantity that does not belong to an actuator. In the vertical plane nothing belongs to some.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// The velocity of the current: north or horizontal, east, down.
    Current(usize),
    /// The operating speed of the LPV model.
    OperatingSpeed,
    /// Of a vehicle that is given its speed.
    GivenSpeed,
    /// The load from outside, X Y Z K M N.
    External(usize),
    /// By which waves change.
    Time,
    /// By [`squid_auv::place`].
    State(usize),
    /// Of these.
    Rate(usize),
    /// Through the water: u, v, w and V.
    Speed,
    #[allow(missing_docs)]
    Sway,
    #[allow(missing_docs)]
    Heave,
    #[allow(missing_docs)]
    PathSpeed,
    /// phi', theta' and psi' of a vehicle that leaves the vertical plane; in it theta' is the state q.
    RollRate,
    #[allow(missing_docs)]
    PitchRate,
    #[allow(missing_docs)]
    HeadingRate,
    /// Over the bottom.
    Altitude,
}

const CURRENT: usize = 3;
const LOAD: usize = 6;
/// Quantities that do not belong to an actuator; every actuator adds three.
const FIXED: usize = CURRENT + LOAD + 2 * STATES + 11;

impl Quantity {
    /// Number of quantities of a vehicle with a number of actuators.
    pub fn count(actuators: usize) -> usize {
        FIXED + 3 * actuators
    }

    /// The number of the quantity.
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

    /// The number of the command of an actuator.
    pub fn command(actuator: usize) -> usize {
        FIXED + 3 * actuator
    }

    /// The number of the output of an actuator.
    pub fn output(actuator: usize) -> usize {
        FIXED + 3 * actuator + 1
    }

    /// The number of the rate of the output of an actuator.
    pub fn output_rate(actuator: usize) -> usize {
        FIXED + 3 * actuator + 2
    }
}
