//! Exact derivatives of the loop between two ticks, while the commands are held, and at its start.

use fmi2::Moment;
use fmu_plant::Quantity;
use scheduled::Inputs;
use signals::{DEPTH, PITCH, SIGNALS, SPEED, TRACKED};

use crate::{ClosedLoop, ClosedLoopError};

/// The quantities of the loop itself; they follow those of the plant.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Own {
    PitchReference,
    DepthReference,
    SpeedReference,
    PitchReferenceUsed,
    DepthReferenceUsed,
    SpeedReferenceUsed,
    TrackingError,
    SchedulingParameter,
    TrimPitch,
    Command(usize),
}

/// Own quantities that are not commands.
const FIXED: usize = 9;

impl Own {
    /// Number of quantities of a loop with a number of actuators, including those of the plant.
    pub(crate) fn count(actuators: usize) -> usize {
        Self::Command(actuators).number(actuators)
    }

    /// The number of the quantity for a vehicle with a number of actuators.
    pub(crate) fn number(self, actuators: usize) -> usize {
        let position = match self {
            Self::PitchReference => 0,
            Self::DepthReference => 1,
            Self::SpeedReference => 2,
            Self::PitchReferenceUsed => 3,
            Self::DepthReferenceUsed => 4,
            Self::SpeedReferenceUsed => 5,
            Self::TrackingError => 6,
            Self::SchedulingParameter => 7,
            Self::TrimPitch => 8,
            Self::Command(index) => FIXED + index,
        };
        Quantity::count(actuators) + position
    }
}

impl ClosedLoop {
    /// Fills in the tangents of outputs and rates from those of inputs and states.
    ///
    /// References act at ticks; at the start the external ones, if used, change the first commands.
    pub(crate) fn carry(&self, moment: Moment, tangents: &mut [f64]) -> Result<(), ClosedLoopError> {
        let actuators = self.plant.vehicle().actuators.len();
        let own = |quantity: Own| quantity.number(actuators);
        let [pitch, depth, speed] = [Own::PitchReference, Own::DepthReference, Own::SpeedReference]
            .map(|reference| tangents[own(reference)]);
        tangents[own(Own::PitchReferenceUsed)..].fill(0.0);
        if moment.initial && self.outside.manual {
            let mut direction = Inputs { measured: [0.0; SIGNALS.len()], references: [0.0; TRACKED] };
            (direction.references[PITCH], direction.references[DEPTH]) = (pitch, depth);
            direction.references[SPEED] = speed;
            let autopilot = self.controller.autopilot();
            let moved = self.controller.tangents(moment.initial, &direction)?;
            tangents[own(Own::PitchReferenceUsed)] = pitch;
            tangents[own(Own::DepthReferenceUsed)] = depth;
            tangents[own(Own::SpeedReferenceUsed)] = speed;
            tangents[own(Own::TrimPitch)] = moved.trim_pitch;
            for (index, command) in moved.commands.into_iter().enumerate() {
                tangents[own(Own::Command(index))] = command;
                tangents[Quantity::Command(index).number()] = command;
            }
            tangents[Quantity::GivenSpeed.number()] = speed;
            let trim = autopilot.trim();
            tangents[Quantity::OperatingSpeed.number()] =
                trim.speed_slope(self.outside.speed_reference) * speed;
        }
        self.plant.carry(moment.initial, tangents);
        let (wanted, measured) = match self.stepped() {
            DEPTH => (Own::DepthReferenceUsed, Quantity::Depth),
            _ => (Own::PitchReferenceUsed, Quantity::Pitch),
        };
        tangents[own(Own::TrackingError)] = tangents[own(wanted)] - tangents[measured.number()];
        Ok(())
    }
}
