//! Exact derivatives of the loop between two ticks, while the commands are held, and at its start.

use auv::longitudinal::{DEPTH, EachTracked, PITCH, SIGNALS, SPEED, TRACKED};
use fmi2::Moment;
use fmu_plant::Quantity;
use scheduled::Inputs;

use crate::{ClosedLoop, ClosedLoopError};

/// The quantities of the loop itself; they follow those of the plant.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Own {
    /// By the place in [`SIGNALS`].
    Reference(usize),
    ReferenceUsed(usize),
    TrackingError,
    SchedulingParameter,
    TrimPitch,
    Command(usize),
}

/// Own quantities that are not commands.
const FIXED: usize = 2 * TRACKED + 3;

impl Own {
    /// Number of quantities of a loop with a number of actuators, including those of the plant.
    pub(crate) fn count(actuators: usize) -> usize {
        Self::Command(actuators).number(actuators)
    }

    /// The number of the quantity for a vehicle with a number of actuators.
    pub(crate) fn number(self, actuators: usize) -> usize {
        let position = match self {
            Self::Reference(place) => place,
            Self::ReferenceUsed(place) => TRACKED + place,
            Self::TrackingError => 2 * TRACKED,
            Self::SchedulingParameter => 2 * TRACKED + 1,
            Self::TrimPitch => 2 * TRACKED + 2,
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
        let references: EachTracked<f64> = std::array::from_fn(|place| tangents[own(Own::Reference(place))]);
        tangents[own(Own::ReferenceUsed(0))..].fill(0.0);
        if moment.initial && self.outside.manual {
            let direction = Inputs { measured: vec![0.0; SIGNALS.len()], references: references.to_vec() };
            let autopilot = self.controller.autopilot();
            let moved = self.controller.tangents(moment.initial, &direction)?;
            tangents[own(Own::ReferenceUsed(0))..][..TRACKED].copy_from_slice(&moved.references);
            tangents[own(Own::TrimPitch)] = moved.trim[PITCH];
            for (index, command) in moved.commands.into_iter().enumerate() {
                tangents[own(Own::Command(index))] = command;
                tangents[Quantity::command(index)] = command;
            }
            tangents[Quantity::GivenSpeed.number()] = references[SPEED];
            let slope = autopilot.trim().speed_slope(self.outside.references[SPEED]);
            tangents[Quantity::OperatingSpeed.number()] = slope * references[SPEED];
        }
        self.plant.carry(moment.initial, tangents);
        let stepped = self.stepped();
        let measured = if stepped == DEPTH { Quantity::Depth } else { Quantity::Pitch };
        tangents[own(Own::TrackingError)] =
            tangents[own(Own::ReferenceUsed(stepped))] - tangents[measured.number()];
        Ok(())
    }
}
