//! The quantities with exact derivatives in the plant.

/// One quantity; those of actuators count from 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum Quantity {
    CurrentHorizontal,
    CurrentVertical,
    OperatingSpeed,
    /// Velocities over ground along the body.
    SurgeOverGround,
    HeaveOverGround,
    PitchRate,
    Pitch,
    Distance,
    Depth,
    /// Rates of the last six.
    SurgeAcceleration,
    HeaveAcceleration,
    PitchAcceleration,
    RateOfPitch,
    RateOfDistance,
    RateOfDepth,
    /// Through the water: u, w and V.
    Speed,
    Heave,
    PathSpeed,
    /// Of a vehicle that is given its speed; nothing belongs to it in others.
    GivenSpeed,
    /// By which waves change.
    Time,
    Command(usize),
    Output(usize),
    OutputRate(usize),
}

/// Quantities that do not belong to an actuator.
const FIXED: usize = 20;

impl Quantity {
    /// Number of quantities of a vehicle with a number of actuators.
    pub fn count(actuators: usize) -> usize {
        FIXED + 3 * actuators
    }

    /// The number of the quantity; every actuator adds three.
    pub fn number(self) -> usize {
        match self {
            Self::CurrentHorizontal => 0,
            Self::CurrentVertical => 1,
            Self::OperatingSpeed => 2,
            Self::SurgeOverGround => 3,
            Self::HeaveOverGround => 4,
            Self::PitchRate => 5,
            Self::Pitch => 6,
            Self::Distance => 7,
            Self::Depth => 8,
            Self::SurgeAcceleration => 9,
            Self::HeaveAcceleration => 10,
            Self::PitchAcceleration => 11,
            Self::RateOfPitch => 12,
            Self::RateOfDistance => 13,
            Self::RateOfDepth => 14,
            Self::Speed => 15,
            Self::Heave => 16,
            Self::PathSpeed => 17,
            Self::GivenSpeed => 18,
            Self::Time => 19,
            Self::Command(index) => FIXED + 3 * index,
            Self::Output(index) => FIXED + 3 * index + 1,
            Self::OutputRate(index) => FIXED + 3 * index + 2,
        }
    }
}
