//! Angle controlled by a PID.

use squid_auv::Actuator;
use std::fmt::{Display, Formatter, Result};

/// An attitude angle of the vehicle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Angle {
    /// theta, positive bow up.
    Pitch,
    /// psi, positive to starboard.
    Heading,
    /// phi, positive starboard down.
    Roll,
}

impl Angle {
    /// All angles, pitch first.
    pub const ALL: [Self; 3] = [Self::Pitch, Self::Heading, Self::Roll];

    /// Returns the name of the angle's signal, which also names its table in `[controller]`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Pitch => "pitch",
            Self::Heading => "heading",
            Self::Roll => "roll",
        }
    }

    /// Returns the symbols of the angle and of its rate.
    pub(crate) const fn symbols(self) -> [&'static str; 2] {
        match self {
            Self::Pitch => ["theta", "q"],
            Self::Heading => ["psi", "psi'"],
            Self::Roll => ["phi", "phi'"],
        }
    }

    /// Returns the moment of an actuator about the axis of the angle, N m per unit of its output, ahead at `speed` m/s.
    pub fn moment(self, actuator: &Actuator, speed: f64) -> f64 {
        match self {
            Self::Pitch => actuator.force(speed, 1.0)[2],
            Self::Heading => actuator.lateral_force(speed, 1.0)[2],
            Self::Roll => actuator.lateral_force(speed, 1.0)[1],
        }
    }
}

impl Display for Angle {
    fn fmt(&self, formatter: &mut Formatter<'_>) -> Result {
        formatter.write_str(self.name())
    }
}
