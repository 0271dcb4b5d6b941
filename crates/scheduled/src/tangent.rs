//! Exact derivatives of a tick with respect to its inputs.

use crate::{Autopilot, Inputs, TickError};

/// The directional derivatives of the outputs of a tick.
#[derive(Debug, Clone, PartialEq)]
pub struct OutputTangents {
    /// Derivatives of the commands, in the order of the design's actuators.
    pub commands: Vec<f64>,
    /// The commands that this tick computes.
    pub computed: Vec<f64>,
    /// Derivative of the scheduling parameter.
    pub scheduling_parameter: f64,
    /// Derivatives of the trims.
    pub trim: Vec<f64>,
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
        let trim = plan.trim.at(speed);
        let origin =
            |signal: usize| if initial { plan.origin(signal, inputs) } else { self.origins()[signal] };
        let y: Vec<f64> = plan.y(inputs, |signal| trim.signal(signal, origin(signal))).collect();
        // At initialisation a level that is the measured value moves with it.
        let moved = |signal: usize| {
            let moves = initial && plan.starts_as_measured(signal);
            let dorigin = if moves { direction.measured[signal] } else { 0.0 };
            plan.trim.signal_slope(speed, signal) * dspeed + dorigin
        };
        let dy: Vec<f64> = plan.y(direction, moved).collect();
        let rho = plan.rho(inputs.measured[plan.speed]);
        let inside = rho.abs() <= 1.0;
        let slope = plan.trim.speed_slope(inputs.measured[plan.speed]) / plan.half_range;
        let drho = if inside { slope * direction.measured[plan.speed] } else { 0.0 };
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
        let trims =
            plan.trimmed.iter().map(|&signal| plan.trim.signal_slope(speed, signal) * dspeed).collect();
        Ok(OutputTangents { commands, computed, scheduling_parameter: drho, trim: trims })
    }
}
