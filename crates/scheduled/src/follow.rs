//! Commands that are not the autopilot's: following them, and taking over from them without a jump.

use crate::{Actuator, Autopilot, Inputs, Saturation, TickError, Transition};

/// How often the state is corrected in a tick: what F leaves, because it is interpolated, is corrected again.
pub const CORRECTIONS: usize = 2;

impl Autopilot {
    /// Follows commands that are not its own: of a pilot, of another design. To be called before each tick while those
    /// are applied, and once before the first tick after.
    ///
    /// ```text
    /// reference_i = measured_i within its range, if it is measured
    /// V_r         = the reference of the speed
    /// x          <- x - F(rho) (trim + scale u - applied)/scale, and the same with the new u
    /// ```
    ///
    /// F(rho) is the gain `follow` of the design: the next tick commands what is applied, as nearly as the controller
    /// can at all: two thrusters that it commands alike stay alike. From there each reference goes on with the rate of
    /// the vehicle, where a sensor knows it, and to what is asked through two lags of 1 s, within its limits. Nothing
    /// is proved of a loop while it follows.
    ///
    /// `applied` are commands in the order of the actuators, as those of [`Outputs`](crate::Outputs); one beyond the
    /// limits of its actuator is that limit.
    ///
    /// # Errors
    /// [`TickError`]; the autopilot is then to be initialised again, but after [`TickError::AppliedTooLarge`].
    pub fn follow(&mut self, inputs: &Inputs, applied: &[f64]) -> Result<(), TickError> {
        self.take_applied(applied)?;
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
        for _ in 0..CORRECTIONS {
            self.compute_outputs(inputs, false)?;
            let Self { plan, controller, outputs, excess, applied, .. } = self;
            for (((error, command), applied), actuator) in
                excess.iter_mut().zip(&outputs.commands).zip(&*applied).zip(&plan.actuators)
            {
                *error += (command - applied) / actuator.scale;
            }
            plan.following.correct(outputs.scheduling_parameter, excess, controller.state_mut());
        }
        let Self { delayed, applied, .. } = self;
        delayed.chunks_exact_mut(applied.len()).for_each(|row| row.copy_from_slice(applied));
        self.compute_outputs(inputs, false)?;
        self.note_saturation();
        Ok(())
    }

    /// What the actuators really got since the last tick, where something else limits them further: the anti-windup
    /// knows of it. To be called before a tick.
    ///
    /// ```text
    /// x <- x + E (command - applied)/scale      E: the gain `anti_windup` of the design
    /// ```
    ///
    /// # Errors
    /// [`TickError::AppliedTooLarge`]; nothing is changed.
    pub fn feed_back(&mut self, applied: &[f64]) -> Result<(), TickError> {
        self.take_applied(applied)?;
        let Self { plan, controller, outputs, excess, applied, .. } = self;
        let Some(gain) = &plan.anti_windup else { return Ok(()) };
        let each = excess.iter_mut().zip(&outputs.commands).zip(&*applied).zip(&plan.actuators);
        for (((excess, command), applied), actuator) in each {
            *excess = (command - applied) / actuator.scale;
        }
        controller.add_to_state(gain, excess);
        Ok(())
    }

    /// Sets a reference to the measured value, from where it goes on with the rate of that and then to what is asked.
    fn begin_reference(&mut self, reference: usize, inputs: &Inputs) {
        let Self { plan, references, transitions, filtered_speed, .. } = self;
        let port = &plan.signals[reference];
        let asked = inputs.references[reference];
        let from = if plan.measured[reference] { inputs.measured[reference] } else { asked };
        let from = port.nearest(from, references[reference]);
        let trim = plan.trim.at(*filtered_speed);
        references[reference] = plan.envelope.target(reference, from, trim);
        let rate = plan.sources.rate(&plan.trim, reference, |signal| inputs.measured[signal]).unwrap_or(0.0);
        let rate = plan.envelope.rate(reference, rate, trim);
        transitions[reference] = Transition { rate, ..Transition::from(references[reference]) };
    }

    /// Takes what the actuators got, within their limits.
    ///
    /// # Errors
    /// [`TickError::AppliedTooLarge`]; nothing is changed.
    pub(crate) fn take_applied(&mut self, applied: &[f64]) -> Result<(), TickError> {
        let Self { plan, applied: taken, .. } = self;
        for (value, actuator) in applied.iter().zip(&plan.actuators) {
            check_applied(actuator, *value)?;
        }
        for ((taken, value), actuator) in taken.iter_mut().zip(applied).zip(&plan.actuators) {
            *taken = value.clamp(actuator.minimum, actuator.maximum);
        }
        Ok(())
    }
}

/// Refuses an applied command that an actuator cannot have got.
fn check_applied(actuator: &Actuator, value: f64) -> Result<(), TickError> {
    let most = actuator.largest_applied();
    if value.abs() <= most {
        return Ok(());
    }
    let Actuator { name, unit, .. } = actuator;
    Err(TickError::AppliedTooLarge { name: name.clone(), value, unit: unit.clone(), most })
}
