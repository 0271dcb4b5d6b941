//! Following the commands of another source, and taking over from it without a jump.

use crate::{Actuator, Autopilot, Inputs, Saturation, TickError, Transition};

impl Autopilot {
    /// Follows the commands of another source: of a pilot, of another design. To be called before each tick while those
    /// are applied, and once before the first tick after.
    ///
    /// ```text
    /// reference_i = measured_i + lag_i rate_i within its range, if it is measured; rate_i where a sensor gives it,
    ///               within its limits
    /// V_r         = the reference of the speed
    /// x          <- x - F(rho) (trim + scale u - applied)/scale
    /// ```
    ///
    /// F(rho) is the gain `follow` of the design: it brings the command of the controller as near to the applied one as
    /// possible. The next tick outputs the applied command; from there the range of each command opens within 1 s to
    /// the limits of its actuator, and F corrects the state for a command outside this range. Each reference continues
    /// with the rate of the vehicle, where a sensor gives it, and returns to the request through two lags of 1 s,
    /// within its limits. Nothing is proved about a loop while it follows, or while a command is limited by the opening
    /// range.
    ///
    /// `applied` holds commands in the order of the actuators, like [`Outputs`](crate::Outputs); they are clamped to
    /// the limits of the actuators.
    ///
    /// # Errors
    /// [`TickError`]; the autopilot then has to be initialised again, except after [`TickError::AppliedTooLarge`].
    pub fn follow(&mut self, inputs: &Inputs, applied: &[f64]) -> Result<(), TickError> {
        self.store_applied(applied)?;
        inputs.check(&self.plan.signals)?;
        self.saturation.fill(Saturation::default());
        let speed = self.plan.speed;
        let is_given = self.plan.speed_given;
        if !is_given {
            self.begin_reference(speed, inputs);
        }
        self.filtered_speed = if is_given { inputs.measured[speed] } else { self.references[speed] };
        for reference in 0..self.references.len() {
            if reference != speed || is_given {
                self.begin_reference(reference, inputs);
            }
        }
        self.compute_outputs(inputs, false)?;
        let Self { plan, controller, outputs, excess, applied, anchor, delayed, .. } = self;
        for (((error, command), applied), actuator) in
            excess.iter_mut().zip(&outputs.commands).zip(&*applied).zip(&plan.actuators)
        {
            *error += (command - applied) / actuator.scale;
        }
        plan.following.correct(outputs.scheduling_parameter, excess, controller.state_mut());
        excess.fill(0.0);
        for commands in [&mut outputs.commands, anchor] {
            commands.copy_from_slice(applied);
        }
        delayed.chunks_exact_mut(applied.len()).for_each(|row| row.copy_from_slice(applied));
        self.followed_for = 0;
        Ok(())
    }

    /// Returns `true` while the range of the commands opens after [`follow`](Self::follow).
    pub fn opens(&self) -> bool {
        self.followed_for < self.plan.opening.ticks
    }

    /// Returns the opening of the range of each command per tick, SI, and the ticks until it is open.
    pub fn opening(&self) -> (&[f64], u32) {
        (&self.plan.opening.steps, self.plan.opening.ticks)
    }

    /// Computes the outputs of a tick with the commands limited to the open range.
    pub(crate) fn compute_opening(&mut self, inputs: &Inputs) -> Result<(), TickError> {
        self.compute_outputs(inputs, false)?;
        if self.clamp_to_opening() {
            let Self { plan, controller, outputs, excess, .. } = self;
            plan.following.correct(outputs.scheduling_parameter, excess, controller.state_mut());
            self.compute_commands()?;
            self.clamp_to_opening();
            self.excess.fill(0.0);
        }
        self.followed_for += 1;
        Ok(())
    }

    /// Clamps the commands to the open range, and adds the difference to their excess. Returns `true` if any command
    /// changed.
    fn clamp_to_opening(&mut self) -> bool {
        let Self { plan, outputs, excess, anchor, followed_for, .. } = self;
        let mut any = false;
        for (index, command) in outputs.commands.iter_mut().enumerate() {
            let open = plan.opening.steps[index] * f64::from(*followed_for);
            let value = *command;
            *command = value.clamp(anchor[index] - open, anchor[index] + open);
            if *command != value {
                excess[index] += (value - *command) / plan.actuators[index].scale;
                any = true;
            }
        }
        any
    }

    /// Passes the commands actually applied since the last tick to the anti-windup, where something else limits them
    /// further. To be called before a tick.
    ///
    /// ```text
    /// x <- x + E (command - applied)/scale      E: the gain `anti_windup` of the design
    /// ```
    ///
    /// # Errors
    /// [`TickError::AppliedTooLarge`]; the autopilot is then unchanged.
    pub fn feed_back(&mut self, applied: &[f64]) -> Result<(), TickError> {
        self.store_applied(applied)?;
        let Self { plan, controller, outputs, excess, applied, .. } = self;
        let Some(gain) = &plan.anti_windup else { return Ok(()) };
        let each = excess.iter_mut().zip(&outputs.commands).zip(&*applied).zip(&plan.actuators);
        for (((excess, command), applied), actuator) in each {
            *excess = (command - applied) / actuator.scale;
        }
        controller.add_to_state(gain, excess);
        Ok(())
    }

    /// Sets a reference ahead of the measured value by the lag of the signal, from where it continues with the measured
    /// rate and returns to the request.
    fn begin_reference(&mut self, reference: usize, inputs: &Inputs) {
        let Self { plan, references, transitions, filtered_speed, .. } = self;
        let port = &plan.signals[reference];
        let request = inputs.references[reference];
        let from = if plan.measured[reference] { inputs.measured[reference] } else { request };
        let from = port.nearest(from, references[reference]);
        let trim = plan.trim.at(*filtered_speed);
        let rate = plan.sources.rate(&plan.trim, reference, |signal| inputs.measured[signal]).unwrap_or(0.0);
        let rate = plan.envelope.rate(reference, rate, trim);
        let lag = port.reference.as_ref().map_or(0.0, |one| one.lag);
        references[reference] = plan.envelope.target(reference, from + lag * rate, trim);
        transitions[reference] = Transition { rate, ..Transition::from(references[reference]) };
    }

    /// Stores the applied commands, clamped to the limits of the actuators.
    ///
    /// # Errors
    /// [`TickError::AppliedTooLarge`]; the autopilot is then unchanged.
    pub(crate) fn store_applied(&mut self, applied: &[f64]) -> Result<(), TickError> {
        let Self { plan, applied: stored, .. } = self;
        for (value, actuator) in applied.iter().zip(&plan.actuators) {
            check_applied(actuator, *value)?;
        }
        for ((stored, value), actuator) in stored.iter_mut().zip(applied).zip(&plan.actuators) {
            *stored = value.clamp(actuator.minimum, actuator.maximum);
        }
        Ok(())
    }
}

/// Rejects an applied command far beyond the limits of its actuator.
fn check_applied(actuator: &Actuator, value: f64) -> Result<(), TickError> {
    let most = actuator.largest_applied();
    if value.abs() <= most {
        return Ok(());
    }
    let Actuator { name, unit, .. } = actuator;
    Err(TickError::AppliedTooLarge { name: name.clone(), value, unit: unit.clone(), most })
}
