//! Exact derivatives of a tick with respect to its inputs.

use crate::{Autopilot, Inputs, TickError};
use signals::{DEPTH, SPEED};

/// The directional derivatives of the outputs of a tick.
#[derive(Debug, Clone, PartialEq)]
pub struct OutputTangents {
    /// Derivatives of the commands, in the order of the design's actuators.
    pub commands: Vec<f64>,
    /// The commands that this tick computes.
    pub computed: Vec<f64>,
    /// Derivative of the scheduling parameter.
    pub scheduling_parameter: f64,
    /// Derivative of the trim pitch.
    pub trim_pitch: f64,
}

impl Autopilot {
    /// The derivatives of the outputs of a tick at `inputs` along `direction`. The autopilot does not change.
    ///
    /// The outputs are those of the next tick, where a filtered V_r is constant, or with `initial` those of
    /// [`initialise`](Self::initialise), where V_r is the speed reference. The derivatives include that of the
    /// scheduling parameter. The derivative of a saturated or delayed command is zero; at a breakpoint of the trim
    /// table it is the right-hand one.
    ///
    /// # Errors
    /// [`TickError::SingularLoop`].
    #[inline]
    pub fn tangents(
        &self,
        initial: bool,
        inputs: &Inputs,
        direction: &Inputs,
    ) -> Result<OutputTangents, TickError> {
        let plan = &*self.plan;
        let (speed, dspeed) = if plan.filter.is_some() && !initial {
            (self.filtered_speed(), 0.0)
        } else {
            (plan.speed_reference(inputs), plan.speed_reference(direction))
        };
        // At initialisation depths are measured from the measured depth, which moves with the direction.
        let (depth, ddepth) = if initial {
            (plan.initial_depth(inputs), plan.depth.map_or(direction.measured[DEPTH], |_| 0.0))
        } else {
            (self.depth(), 0.0)
        };
        let (y0, slopes) = (plan.trim.signals(speed, depth), plan.trim.signal_slopes(speed));
        let y: Vec<f64> = plan.y(inputs, |signal| y0[signal]).collect();
        let moved = |signal: usize| slopes[signal] * dspeed + if signal == DEPTH { ddepth } else { 0.0 };
        let dy: Vec<f64> = plan.y(direction, moved).collect();
        let rho = plan.rho(inputs.measured[SPEED]);
        let inside = rho.abs() <= 1.0;
        let slope = plan.trim.speed_slope(inputs.measured[SPEED]) / plan.half_range;
        let drho = if inside { slope * direction.measured[SPEED] } else { 0.0 };
        let theta = &[rho.clamp(-1.0, 1.0)][..plan.parameters];
        let mut commands = vec![0.0; plan.actuators.len()];
        let mut computed = commands.clone();
        self.controller.tangent(&y, theta, &dy, &[drho][..plan.parameters], &mut commands)?;
        self.controller.clone().output(&y, theta, &mut computed)?;
        for (index, (command, computed)) in commands.iter_mut().zip(&mut computed).enumerate() {
            let [scale, minimum, maximum] = plan.actuators[index];
            let value = plan.trim.command(speed, index) + scale * *computed;
            *computed = value.clamp(minimum, maximum);
            let feedforward = plan.trim.command_slope(speed, index) * dspeed;
            let free = (minimum..=maximum).contains(&value);
            // A delayed command does not depend on the inputs of its tick.
            let free = free && (initial || !self.has_delay());
            *command = if free { feedforward + scale * *command } else { 0.0 };
        }
        let trim_pitch = plan.trim.pitch_slope(speed) * dspeed;
        Ok(OutputTangents { commands, computed, scheduling_parameter: drho, trim_pitch })
    }
}
