//! The quantities with exact derivatives in the plant.

/// One quantity that does not belong to an actuator.
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
    /// The load from outside.
    ExternalForceX,
    ExternalForceZ,
    ExternalMoment,
    /// By which waves change.
    Time,
}

/// Quantities that do not belong to an actuator; every actuator adds three.
const FIXED: usize = Quantity::Time as usize + 1;

impl Quantity {
    /// The load from outside, X Z M.
    pub const EXTERNAL: [Self; 3] = [Self::ExternalForceX, Self::ExternalForceZ, Self::ExternalMoment];

    /// Number of quantities of a vehicle with a number of actuators.
    pub fn count(actuators: usize) -> usize {
        FIXED + 3 * actuators
    }

    /// The number of the quantity.
    pub fn number(self) -> usize {
        self as usize
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
