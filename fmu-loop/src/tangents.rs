//! Exact derivatives of the loop between two ticks, while the commands are held, and at its start.

use squid_auv::longitudinal::{DEPTH, PITCH, SPEED};
use squid_auv::{REFERENCES, index};
use squid_fmi2::Moment;
use squid_fmu_plant::Quantity;
use squid_scheduled::Inputs;

use crate::{ClosedLoop, ClosedLoopError};

/// Quantities of the loop itself, numbered after those of the plant.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Own {
    /// External reference, by its index.
    Reference(usize),
    ReferenceUsed(usize),
    TrackingError,
    SchedulingParameter,
    TrimPitch,
    Command(usize),
}

/// Number of quantities of the loop that are not commands.
const FIXED: usize = 2 * REFERENCES + 3;

impl Own {
    /// Returns the number of quantities of a loop with `actuators` actuators, including those of the plant.
    pub(crate) fn count(actuators: usize) -> usize {
        Self::Command(actuators).number(actuators)
    }

    /// Returns the number of the quantity for a vehicle with `actuators` actuators.
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
    /// Computes the tangents of outputs and derivatives from those of inputs and states.
    ///
    /// References act at ticks; at the start the external ones, if used, affect the first commands.
    pub(crate) fn carry(&self, moment: Moment, tangents: &mut [f64]) -> Result<(), ClosedLoopError> {
        let actuators = self.plant.vehicle().actuators.len();
        let own = |quantity: Own| quantity.number(actuators);
        let references: [f64; REFERENCES] =
            std::array::from_fn(|reference| tangents[own(Own::Reference(reference))]);
        tangents[own(Own::ReferenceUsed(0))..].fill(0.0);
        if moment.initial && self.outside.manual {
            let axes = self.axes.iter().zip(&self.commanded).zip(&self.reference_indices);
            for (index, ((axis, actuators), indices)) in axes.enumerate() {
                let design = axis.design();
                let seeded = indices.iter().map(|reference| references[*reference]);
                let direction =
                    Inputs { measured: vec![0.0; design.signals.len()], references: seeded.collect() };
                let moved = axis.tangents(moment.initial, false, &direction)?;
                for (reference, used) in indices.iter().zip(moved.references) {
                    // The speed reference is that of the first axis.
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
        let tracked = self.tracked();
        let measured = Quantity::State(if tracked == DEPTH { index::DEPTH } else { index::PITCH });
        tangents[own(Own::TrackingError)] =
            tangents[own(Own::ReferenceUsed(tracked))] - tangents[measured.number()];
        Ok(())
    }
}
