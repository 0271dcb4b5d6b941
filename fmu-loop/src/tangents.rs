//! Exact derivatives of the loop between two ticks, while the commands are held, and at its start.

use squid_auv::longitudinal::{DEPTH, PITCH, SPEED};
use squid_auv::{REFERENCES, index};
use squid_fmi2::Moment;
use squid_fmu_plant::Quantity;
use squid_scheduled::Inputs;

use crate::{ClosedLoop, ClosedLoopError};

/// The quantities of the loop itself; they follow those of the plant.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Own {
    /// By its place.
    Reference(usize),
    ReferenceUsed(usize),
    TrackingError,
    SchedulingParameter,
    TrimPitch,
    Command(usize),
}

/// Own quantities that are not commands.
const FIXED: usize = 2 * REFERENCES + 3;

impl Own {
    /// Number of quantities of a loop with a number of actuators, including those of the plant.
    pub(crate) fn count(actuators: usize) -> usize {
        Self::Command(actuators).number(actuators)
    }

    /// The number of the quantity for a vehicle with a number of actuators.
    pub(crate) fn number(self, actuators: usize) -> usize {
        let position = match self {
            Self::Reference(index) => index,
            Self::ReferenceUsed(index) => REFERENCES + index,
            Self::TrackingError => 2 * REFERENCES,
            Self::SchedulingParameter => 2 * REFERENCES + 1,
            Self::TrimPitch => 2 * REFERENCES + 2,
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
        let references: [f64; REFERENCES] =
            std::array::from_fn(|reference| tangents[own(Own::Reference(reference))]);
        tangents[own(Own::ReferenceUsed(0))..].fill(0.0);
        if moment.initial && self.outside.manual {
            let axes = self.axes.iter().zip(&self.commanded).zip(&self.taken);
            for (index, ((axis, actuators), taken)) in axes.enumerate() {
                let design = axis.design();
                let wanted = taken.iter().map(|reference| references[*reference]);
                let direction =
                    Inputs { measured: vec![0.0; design.signals.len()], references: wanted.collect() };
                let moved = axis.tangents(moment.initial, false, &direction)?;
                for (reference, used) in taken.iter().zip(moved.references) {
                    // That of the speed is the first axis's.
                    if index == 0 || *reference != SPEED {
                        tangents[own(Own::ReferenceUsed(*reference))] = used;
                    }
                }
                if index == 0 {
                    tangents[own(Own::TrimPitch)] = moved.trim[PITCH];
                }
                for (actuator, command) in actuators.iter().zip(moved.commands) {
                    tangents[own(Own::Command(*actuator))] = command;
                    tangents[Quantity::command(*actuator)] = command;
                }
            }
            tangents[Quantity::GivenSpeed.number()] = references[SPEED];
            let slope = self.axes[0].autopilot().trim().speed_slope(self.outside.references[SPEED]);
            tangents[Quantity::OperatingSpeed.number()] = slope * references[SPEED];
        }
        self.plant.carry(moment.initial, tangents);
        let stepped = self.stepped();
        let measured = Quantity::State(if stepped == DEPTH { index::DEPTH } else { index::PITCH });
        tangents[own(Own::TrackingError)] =
            tangents[own(Own::ReferenceUsed(stepped))] - tangents[measured.number()];
        Ok(())
    }
}
