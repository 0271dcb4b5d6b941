//! Exact derivatives of a tick with respect to its inputs.

use crate::{Autopilot, Inputs, TickError, Transition};

/// Directional derivatives of the outputs of a tick.
#[derive(Debug, Clone, PartialEq)]
pub struct OutputTangents {
    /// Derivatives of the commands, in the order of the design's actuators.
    pub commands: Vec<f64>,
    /// Commands computed by this tick, before the delay.
    pub computed: Vec<f64>,
    /// Derivative of the scheduling parameter.
    pub scheduling_parameter: f64,
    /// Derivatives of the references after all limits.
    pub references: Vec<f64>,
    /// Derivatives of the trims.
    pub trim: Vec<f64>,
}

/// Tick to differentiate.
#[derive(Clone, Copy, PartialEq)]
enum Tick {
    /// Initialisation.
    Initial,
    /// First tick, with an initialisation at the same inputs just before it.
    First,
    Next,
}

impl Autopilot {
    /// Returns the derivatives of the outputs of a tick at `inputs` along `direction`. The autopilot does not change.
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
        self.derive(if initial { Tick::Initial } else { Tick::Next }, inputs, direction)
    }

    /// Returns the derivatives, like [`tangents`](Self::tangents), of the first tick after
    /// [`initialise`](Self::initialise) with the same inputs.
    ///
    /// # Errors
    /// [`TickError::SingularLoop`].
    #[inline]
    pub fn first_tangents(&self, inputs: &Inputs, direction: &Inputs) -> Result<OutputTangents, TickError> {
        let first = self.derive(Tick::First, inputs, direction)?;
        if self.has_delay() {
            // The commands output by this tick were computed by the initialisation.
            let OutputTangents { commands, computed, .. } = self.derive(Tick::Initial, inputs, direction)?;
            return Ok(OutputTangents { commands, computed, ..first });
        }
        Ok(first)
    }

    #[inline]
    fn derive(&self, tick: Tick, inputs: &Inputs, direction: &Inputs) -> Result<OutputTangents, TickError> {
        let plan = &*self.plan;
        let starts = tick != Tick::Next;
        let yields = |signal: usize| !starts && plan.governor.yields(signal, self.saturation());
        // Reference at an initialisation, with its derivatives along `direction` and with respect to V_r.
        let initial_reference = |signal: usize, speed: f64| {
            let request = plan.requested(signal, inputs, None);
            let limited =
                plan.envelope.tangent(signal, request, Transition::default(), None, (&plan.trim, speed));
            let begins = plan.begins_as_measured(signal);
            let derivative = if begins { direction.measured[signal] } else { direction.references[signal] };
            (limited.value, limited.by_request * derivative, limited.by_speed)
        };
        let limited = |signal: usize, speed: f64| {
            let at = (&plan.trim, speed);
            if yields(signal) {
                let measured = plan.measured_near(signal, inputs, self.references());
                let to = plan.governor.yielded(self.references()[signal], measured);
                let limited = plan.envelope.tangent(signal, to, Transition::default(), None, at);
                let derivative = plan.governor.yielded(0.0, direction.measured[signal]);
                return (limited.value, limited.by_request * derivative, limited.by_speed);
            }
            let (last, dlast, last_by_speed) = match tick {
                Tick::Initial => return initial_reference(signal, speed),
                Tick::First => initial_reference(signal, speed),
                Tick::Next => (self.references()[signal], 0.0, 0.0),
            };
            let transition = if starts { Transition::default() } else { self.transitions[signal] };
            let request = plan.requested(signal, inputs, Some(last));
            let limited = plan.envelope.tangent(signal, request, transition, Some(last), at);
            (
                limited.value,
                limited.by_request * direction.references[signal] + limited.by_last * dlast,
                limited.by_speed + limited.by_last * last_by_speed,
            )
        };
        let filtered = self.filtered_speed();
        let speed_reference = (!plan.speed_given).then(|| {
            let (value, derivative, _) = limited(plan.speed, filtered);
            (value, derivative)
        });
        let (speed, dspeed) = match speed_reference {
            _ if plan.filter.is_some() && !starts => (filtered, 0.0),
            Some(speed_reference) => speed_reference,
            None => (inputs.measured[plan.speed], direction.measured[plan.speed]),
        };
        let each = |signal: usize| match speed_reference {
            Some(speed_reference) if signal == plan.speed => speed_reference,
            _ => {
                let (value, derivative, by_speed) = limited(signal, speed);
                (value, derivative + by_speed * dspeed)
            }
        };
        let (references, dreferences): (Vec<f64>, Vec<f64>) = (0..inputs.references.len()).map(each).unzip();
        let trim = plan.trim.at(speed);
        let origin =
            |signal: usize| if starts { plan.origin(signal, inputs) } else { self.origins()[signal] };
        let measured = |signal| plan.measured_near(signal, inputs, &references);
        let y: Vec<f64> =
            plan.y(measured, &references, |signal| trim.signal(signal, origin(signal))).collect();
        // At initialisation, a level that is the measured value changes with it.
        let dlevel = |signal: usize| {
            let is_origin = starts && plan.starts_as_measured(signal);
            let dorigin = if is_origin { direction.measured[signal] } else { 0.0 };
            plan.trim.signal_slope(speed, signal) * dspeed + dorigin
        };
        let dy: Vec<f64> = plan.y(|signal| direction.measured[signal], &dreferences, dlevel).collect();
        let rho = plan.rho(inputs.measured[plan.speed]);
        let inside = rho.abs() <= 1.0;
        let slope = plan.trim.speed_slope(inputs.measured[plan.speed]) / plan.half_range;
        let drho = if inside { slope * direction.measured[plan.speed] } else { 0.0 };
        let theta = &[rho.clamp(-1.0, 1.0)][..plan.parameters];
        let mut commands = vec![0.0; plan.actuators.len()];
        let mut computed = commands.clone();
        self.controller.tangent(&y, theta, &dy, &[drho][..plan.parameters], &mut commands)?;
        self.controller.clone().output(&y, theta, &mut computed)?;
        for (index, computed) in computed.iter_mut().enumerate() {
            *computed = plan.trim.command(speed, index) + plan.actuators[index].scale * *computed;
        }
        let protected_speed =
            plan.protected_speed(speed, if starts { &[] } else { self.saturation() }, &computed);
        for (index, (command, computed)) in commands.iter_mut().zip(&mut computed).enumerate() {
            let scale = plan.actuators[index].scale;
            let [minimum, maximum] = plan.limits(index, plan.trim.command(speed, index), protected_speed);
            let value = *computed;
            *computed = value.clamp(minimum, maximum);
            let feedforward = plan.trim.command_slope(speed, index) * dspeed;
            let free = (minimum..=maximum).contains(&value);
            // A delayed command does not depend on the inputs of its tick.
            let free = free && (tick == Tick::Initial || !self.has_delay());
            *command = if free { feedforward + scale * *command } else { 0.0 };
        }
        let trims =
            plan.trimmed.iter().map(|&signal| plan.trim.signal_slope(speed, signal) * dspeed).collect();
        Ok(OutputTangents {
            commands,
            computed,
            scheduling_parameter: drho,
            references: dreferences,
            trim: trims,
        })
    }
}
