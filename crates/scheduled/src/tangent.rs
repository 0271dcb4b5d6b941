//! Exact derivatives of a tick with respect to its inputs.

use crate::{Autopilot, Inputs, TickError, Transition};

/// The directional derivatives of the outputs of a tick.
#[derive(Debug, Clone, PartialEq)]
pub struct OutputTangents {
    /// Derivatives of the commands, in the order of the design's actuators.
    pub commands: Vec<f64>,
    /// The commands that this tick computes.
    pub computed: Vec<f64>,
    /// Derivative of the scheduling parameter.
    pub scheduling_parameter: f64,
    /// Derivatives of the references as they are used.
    pub references: Vec<f64>,
    /// Derivatives of the trims.
    pub trim: Vec<f64>,
}

/// A tick whose derivatives are asked for.
#[derive(Clone, Copy, PartialEq)]
enum Tick {
    /// The initialisation.
    Initial,
    /// The first, with an initialisation at the same inputs just before it.
    First,
    Next,
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
        self.derive(if initial { Tick::Initial } else { Tick::Next }, inputs, direction)
    }

    /// As [`tangents`](Self::tangents), of the first tick where [`initialise`](Self::initialise) is called again before
    /// it, with the same inputs.
    ///
    /// # Errors
    /// [`TickError::SingularLoop`].
    #[inline]
    pub fn first_tangents(&self, inputs: &Inputs, direction: &Inputs) -> Result<OutputTangents, TickError> {
        let first = self.derive(Tick::First, inputs, direction)?;
        if self.has_delay() {
            // What comes out was computed by the initialisation.
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
        // A reference at an initialisation, and how it moves with the inputs and with V_r.
        let begun = |signal: usize, speed: f64| {
            let asked = plan.asked(signal, inputs, None);
            let used = plan.envelope.tangent(signal, asked, Transition::default(), None, (&plan.trim, speed));
            let begins = plan.begins_as_measured(signal);
            let moves = if begins { direction.measured[signal] } else { direction.references[signal] };
            (used.value, used.by_asked * moves, used.by_speed)
        };
        let used = |signal: usize, speed: f64| {
            let at = (&plan.trim, speed);
            if yields(signal) {
                let measured = plan.measured_near(signal, inputs, self.references());
                let to = plan.governor.yielded(self.references()[signal], measured);
                let used = plan.envelope.tangent(signal, to, Transition::default(), None, at);
                let moves = plan.governor.yielded(0.0, direction.measured[signal]);
                return (used.value, used.by_asked * moves, used.by_speed);
            }
            let (last, dlast, last_by_speed) = match tick {
                Tick::Initial => return begun(signal, speed),
                Tick::First => begun(signal, speed),
                Tick::Next => (self.references()[signal], 0.0, 0.0),
            };
            let transition = if starts { Transition::default() } else { self.transitions[signal] };
            let asked = plan.asked(signal, inputs, Some(last));
            let used = plan.envelope.tangent(signal, asked, transition, Some(last), at);
            (
                used.value,
                used.by_asked * direction.references[signal] + used.by_last * dlast,
                used.by_speed + used.by_last * last_by_speed,
            )
        };
        let filtered = self.filtered_speed();
        let wanted = (!plan.speed_given).then(|| {
            let (value, moves, _) = used(plan.speed, filtered);
            (value, moves)
        });
        let (speed, dspeed) = match wanted {
            _ if plan.filter.is_some() && !starts => (filtered, 0.0),
            Some(wanted) => wanted,
            None => (inputs.measured[plan.speed], direction.measured[plan.speed]),
        };
        let each = |signal: usize| match wanted {
            Some(wanted) if signal == plan.speed => wanted,
            _ => {
                let (value, moves, by_speed) = used(signal, speed);
                (value, moves + by_speed * dspeed)
            }
        };
        let (references, dreferences): (Vec<f64>, Vec<f64>) = (0..inputs.references.len()).map(each).unzip();
        let trim = plan.trim.at(speed);
        let origin =
            |signal: usize| if starts { plan.origin(signal, inputs) } else { self.origins()[signal] };
        let measured = |signal| plan.measured_near(signal, inputs, &references);
        let y: Vec<f64> =
            plan.y(measured, &references, |signal| trim.signal(signal, origin(signal))).collect();
        // At initialisation a level that is the measured value moves with it.
        let moved = |signal: usize| {
            let moves = starts && plan.starts_as_measured(signal);
            let dorigin = if moves { direction.measured[signal] } else { 0.0 };
            plan.trim.signal_slope(speed, signal) * dspeed + dorigin
        };
        let dy: Vec<f64> = plan.y(|signal| direction.measured[signal], &dreferences, moved).collect();
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
        let ahead = plan.ahead(speed, if starts { &[] } else { self.saturation() }, &computed);
        for (index, (command, computed)) in commands.iter_mut().zip(&mut computed).enumerate() {
            let scale = plan.actuators[index].scale;
            let [minimum, maximum] = plan.limits(index, plan.trim.command(speed, index), ahead);
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
