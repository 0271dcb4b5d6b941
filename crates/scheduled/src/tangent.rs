//! Exact derivatives of a tick by its inputs.

use crate::{Autopilot, Inputs, TickError};
use signals::SPEED;

/// The derivatives of the outputs of a tick in one direction of its inputs.
#[derive(Debug, Clone, PartialEq)]
pub struct OutputTangents {
    /// Of the commands, in the order of the design's actuators.
    pub commands: Vec<f64>,
    /// Of the scheduling parameter.
    pub scheduling_parameter: f64,
    /// Of the trim pitch.
    pub trim_pitch: f64,
}

impl Autopilot {
    /// The derivatives of the outputs of a tick now, at `inputs` and along `direction`. The autopilot does not change.
    ///
    /// The LFT is closed at the scheduling parameter of the measured speed, which the direction moves too. Where a
    /// command is limited its derivative is zero; at a corner of the trim table it is the right-hand one.
    ///
    /// # Errors
    /// [`TickError::SingularLoop`].
    pub fn tangents(&self, inputs: &Inputs, direction: &Inputs) -> Result<OutputTangents, TickError> {
        let plan = &*self.plan;
        let (y, dy): (Vec<f64>, Vec<f64>) = plan.errors(inputs).zip(plan.errors(direction)).unzip();
        let rho = plan.rho(inputs.measured[SPEED]);
        let inside = rho.abs() <= 1.0;
        let slope = plan.trim.speed_slope(inputs.measured[SPEED]) / plan.half_range;
        let drho = if inside { slope * direction.measured[SPEED] } else { 0.0 };
        let theta = &[rho.clamp(-1.0, 1.0)][..plan.parameters];
        let mut commands = vec![0.0; plan.actuators.len()];
        let mut scaled = commands.clone();
        self.controller.tangent((&y, &dy), (theta, &[drho][..plan.parameters]), &mut commands)?;
        self.controller.peek(&y, theta, &mut scaled)?;
        for (index, command) in commands.iter_mut().enumerate() {
            let [scale, minimum, maximum] = plan.actuators[index];
            let value = plan.trim.command(inputs.references[SPEED], index) + scale * scaled[index];
            let feedforward =
                plan.trim.command_slope(inputs.references[SPEED], index) * direction.references[SPEED];
            let free = (minimum..=maximum).contains(&value);
            *command = if free { feedforward + scale * *command } else { 0.0 };
        }
        let trim_pitch = plan.trim.pitch_slope(inputs.references[SPEED]) * direction.references[SPEED];
        Ok(OutputTangents { commands, scheduling_parameter: drho, trim_pitch })
    }
}
