//! The sampled autopilot: trim feedforward, and K(rho) on references and measurements.

mod envelope;
mod following;
mod governor;
mod opening;
mod plan;

use std::sync::Arc;

use crate::design::Port;
use crate::ports::{Inputs, Outputs};
use crate::{
    ControllerDesign, DesignError, Lft, LftController, Matrix, Snapshot, SnapshotError, TickError, Trim,
};

pub use governor::{HELD, RETURNING, Saturation, Transition};
pub(crate) use plan::Plan;

/// A controller that runs at multiples of its sample time.
///
/// Tick k is at the time `start + k Ts`. It uses the inputs of the step that contains this time, the end of the step
/// excluded; its outputs hold until the next tick. Ticks are counted, not derived from the time, so that rounding can
/// neither skip nor repeat a tick.
///
/// ```text
/// angles    = circular angles are unwrapped: the reference to the value nearest to the last one, the measured value to
///             the one nearest to the reference
/// reference = request, within its limits at V_r           see [`ControllerDesign::envelope`]; moves to the measured
///                                                         value while an actuator that steers it stays at its
///                                                         limit, and back to the request after that and after
///                                                         [`Self::follow`]
/// V_r'      = w_r (speed reference - V_r)                 without a filter V_r is the speed reference
/// y0(V_r)   = signals in trim at forward speed V_r, each by its [`Level`](squid_signals::Level): V_r itself, a column
///             of the trim table, the value measured at initialisation, or 0
/// y_i       = (reference_i - y0_i(V_r))/scale_i           an input of kind reference
/// y_i       = (measured_i - y0_i(V_r))/scale_i            an input of kind measurement
/// y_i       = (reference_i - measured_i)/scale_i          an input of kind error
/// rho       = clamp((V(u) - centre)/half_range, -1, 1)    V(u): speed along the path in trim at forward speed u
/// command_j = clamp(trim_j(V_r) + scale_j u_j, minimum_j, maximum_j)   while a steering actuator is at its limit,
///                                                                      the others do not push against V_r; for 1 s
///                                                                      after [`Self::follow`] see there
/// phi_j     = (trim_j(V_r) + scale_j u_j - command_j)/scale_j
/// ```
///
/// With anti-windup, `E phi` is added to the derivatives of the controller's states; see
/// [`ControllerDesign::anti_windup`].
///
/// With a delay of d ticks, the command of tick k is output at tick k + d; until then, that of the initialisation
/// holds.
///
/// After the output of a tick, V_r is advanced exactly for a constant reference:
/// `V_r += (1 - exp(-w_r Ts)) (speed reference - V_r)`. Initialisation sets it to the speed reference.
///
/// The feedforward uses the reference, not the measured speed, so that it adds no feedback to that of the design. If
/// the speed is imposed on the vehicle from outside, V_r is the measured speed, which closes no loop.
#[derive(Debug, Clone)]
pub struct Autopilot {
    pub(crate) plan: Arc<Plan>,
    pub(crate) controller: LftController,
    /// Controller input y.
    y: Vec<f64>,
    /// V_r in m/s.
    pub(crate) filtered_speed: f64,
    /// References after all limits.
    pub(crate) references: Vec<f64>,
    /// Requested references, within their ranges.
    targets: Vec<f64>,
    /// Transition of each reference to its target.
    pub(crate) transitions: Vec<Transition>,
    /// Saturation of each actuator.
    pub(crate) saturation: Vec<Saturation>,
    /// Value of each signal at initialisation, see [`Plan::origin`].
    origins: Vec<f64>,
    /// Applied commands of the last [`Self::follow`], SI.
    pub(crate) anchor: Vec<f64>,
    /// Ticks since then, up to those of the opening.
    pub(crate) followed_for: u32,
    /// Excess phi of u over the limits.
    pub(crate) excess: Vec<f64>,
    /// Applied commands last passed to [`Self::follow`] or [`Self::feed_back`], within the limits.
    pub(crate) applied: Vec<f64>,
    pub(crate) outputs: Outputs,
    /// Delayed commands, one row per tick; tick k has the row `k mod delay`.
    pub(crate) delayed: Vec<f64>,
    start: f64,
    next_tick: u64,
    /// `true` if the last tick was outside the scheduled range.
    outside: bool,
}

/// Excess of |rho| over 1 that is attributed to rounding and gives no warning.
pub const ROUNDING_OF_RHO: f64 = 1e-9;

/// Fraction of the sample time by which a tick may be late, because communication points are rounded.
const ROUNDING_OF_TIME: f64 = 1e-6;

impl Autopilot {
    /// Creates the autopilot of a design, with zero state.
    ///
    /// # Errors
    /// [`DesignError`].
    #[inline]
    pub fn new(design: &ControllerDesign) -> Result<Self, DesignError> {
        design.validate()?;
        let lft = Lft::from_rows(&design.lft, design.controller_inputs.len(), design.actuators.len())?;
        let plan = Plan::new(design, &lft)?;
        Ok(Self {
            controller: LftController::new(lft.discretise(design.sample_time)?),
            y: vec![0.0; plan.inputs.len()],
            filtered_speed: 0.0,
            references: vec![0.0; design.references().count()],
            targets: vec![0.0; design.references().count()],
            transitions: vec![Transition::default(); design.references().count()],
            saturation: vec![Saturation::default(); plan.actuators.len()],
            origins: vec![0.0; plan.signals.len()],
            anchor: vec![0.0; plan.actuators.len()],
            followed_for: plan.opening.ticks,
            excess: vec![0.0; plan.actuators.len()],
            applied: vec![0.0; plan.actuators.len()],
            outputs: Outputs {
                commands: vec![0.0; plan.actuators.len()],
                scheduling_parameter: 0.0,
                out_of_range: false,
                reference_limited: false,
                trim: vec![0.0; plan.trimmed.len()],
            },
            plan: Arc::new(plan),
            delayed: vec![0.0; design.delay_ticks * design.actuators.len()],
            start: 0.0,
            next_tick: 0,
            outside: false,
        })
    }

    /// Returns the trim table.
    pub fn trim(&self) -> &Trim {
        &self.plan.trim
    }

    /// Returns the signals in trim at a speed V in m/s along the path, as measurements and as references.
    pub fn level(&self, speed: f64) -> Inputs {
        let Plan { trim, signals, .. } = &*self.plan;
        let at = trim.at(trim.forward_speed(speed));
        let level = |(index, signal): (usize, &Port)| at.signal(index, signal.start);
        let measured: Vec<f64> = signals.iter().enumerate().map(level).collect();
        let tracked = signals.iter().filter(|signal| signal.reference.is_some()).count();
        Inputs { references: measured[..tracked].to_vec(), measured }
    }

    /// Returns the measured value of the scheduling signal.
    pub fn speed(&self, inputs: &Inputs) -> f64 {
        inputs.measured[self.plan.speed]
    }

    /// Returns the controller K(rho) in discrete time, with its state.
    pub fn controller(&self) -> &LftController {
        &self.controller
    }

    /// Returns the sampled anti-windup gain from phi to the controller's states, n x m, if there is one.
    pub fn anti_windup(&self) -> Option<&Matrix> {
        self.plan.anti_windup.as_ref()
    }

    /// Returns the gains of [`follow`](Self::follow) at values of rho from -1 to 1, evenly spaced, each n x m.
    pub fn follow_gains(&self) -> &[Matrix] {
        self.plan.following.gains()
    }

    /// Returns the constants of the transition of a reference: the factor of [`Transition::lag`] per tick, and the
    /// difference from the target that counts as zero.
    pub fn returning(&self, reference: usize) -> (f64, f64) {
        self.plan.governor.returning(reference)
    }

    /// Returns the fraction of the distance to the measured value by which a reference yields per tick, and the number
    /// of ticks that an actuator has to be at its limit before.
    pub fn yielding(&self) -> (f64, u32) {
        (self.plan.governor.yielding(), self.plan.governor.held())
    }

    /// Returns the saturation of each actuator.
    pub fn saturation(&self) -> &[Saturation] {
        &self.saturation
    }

    /// Returns the gain 1 - exp(-w_r Ts) of the filter of the speed reference, if there is one.
    pub fn filter(&self) -> Option<f64> {
        self.plan.filter
    }

    /// Returns the outputs of the last tick or of the initialisation.
    pub fn outputs(&self) -> &Outputs {
        &self.outputs
    }

    /// Returns the filtered speed reference V_r in m/s; without a filter, the speed reference of the last tick.
    pub fn filtered_speed(&self) -> f64 {
        self.filtered_speed
    }

    /// Returns the references of the last tick or of the initialisation, after all limits.
    pub fn references(&self) -> &[f64] {
        &self.references
    }

    /// Returns the value of each signal at initialisation, for those with
    /// [`Level::Start`](squid_signals::Level::Start).
    pub fn origins(&self) -> &[f64] {
        &self.origins
    }

    /// Returns the controller input y at the last tick or at initialisation, in the order of the design's inputs.
    pub fn controller_inputs(&self) -> &[f64] {
        &self.y
    }

    /// Returns the number of ticks since the initialisation.
    pub fn ticks(&self) -> u64 {
        self.next_tick
    }

    /// Returns the complete state, for [`restore`](Self::restore).
    pub fn snapshot(&self) -> Snapshot {
        Snapshot {
            state: self.controller.state().to_vec(),
            filtered_speed: self.filtered_speed,
            references: self.references.clone(),
            transitions: self.transitions.clone(),
            saturation: self.saturation.clone(),
            anchor: self.anchor.clone(),
            followed_for: self.followed_for,
            origins: self.origins.clone(),
            outputs: self.outputs.clone(),
            delayed: self.delayed.clone(),
            start: self.start,
            ticks: self.next_tick,
            outside: self.outside,
        }
    }

    /// Continues from a snapshot of an autopilot of the same design.
    ///
    /// # Errors
    /// [`SnapshotError`]; the autopilot is then unchanged.
    pub fn restore(&mut self, snapshot: &Snapshot) -> Result<(), SnapshotError> {
        let Self { controller, outputs, delayed, origins, references, transitions, .. } = &*self;
        let Outputs { commands, trim, .. } = outputs;
        snapshot.check([
            controller.state().len(),
            commands.len(),
            trim.len(),
            delayed.len(),
            origins.len(),
            references.len(),
            commands.len(),
            transitions.len(),
            commands.len(),
        ])?;
        self.controller.set_state(&snapshot.state);
        self.filtered_speed = snapshot.filtered_speed;
        self.references.copy_from_slice(&snapshot.references);
        self.transitions.copy_from_slice(&snapshot.transitions);
        self.saturation.copy_from_slice(&snapshot.saturation);
        self.anchor.copy_from_slice(&snapshot.anchor);
        self.followed_for = snapshot.followed_for.min(self.plan.opening.ticks);
        self.origins.copy_from_slice(&snapshot.origins);
        self.outputs.clone_from(&snapshot.outputs);
        self.delayed.copy_from_slice(&snapshot.delayed);
        self.start = snapshot.start;
        self.next_tick = snapshot.ticks;
        self.outside = snapshot.outside;
        Ok(())
    }

    /// Restarts at the time `start` in s, before the first tick: zero state, V_r at the speed reference, outputs for
    /// the present inputs.
    ///
    /// # Errors
    /// [`TickError`]; after [`TickError::OtherUnit`] and [`TickError::InputNotFinite`] the autopilot is unchanged.
    pub fn initialise(&mut self, start: f64, inputs: &Inputs) -> Result<(), TickError> {
        inputs.check(&self.plan.signals)?;
        for (index, port) in self.plan.signals.iter().enumerate() {
            if self.plan.measured[index] {
                port.check_first(inputs.measured[index], None)?;
            }
            if self.plan.followed.get(index) == Some(&true) {
                port.check_first(inputs.references[index], port.reference.as_ref())?;
            }
        }
        self.controller.reset();
        self.start = start;
        self.next_tick = 0;
        self.outside = false;
        self.transitions.fill(Transition::default());
        self.saturation.fill(Saturation::default());
        self.followed_for = self.plan.opening.ticks;
        for (signal, origin) in self.origins.iter_mut().enumerate() {
            *origin = self.plan.origin(signal, inputs);
        }
        self.compute_outputs(inputs, true)?;
        self.record_saturation();
        let Self { delayed, outputs, .. } = self;
        delayed
            .chunks_exact_mut(outputs.commands.len())
            .for_each(|row| row.copy_from_slice(&outputs.commands));
        Ok(())
    }

    /// Runs the ticks that are due before the time `to` in s, with constant inputs. Returns `true` if the speed left
    /// the scheduled range at one of them.
    ///
    /// # Errors
    /// [`TickError`].
    pub fn advance(&mut self, to: f64, inputs: &Inputs) -> Result<bool, TickError> {
        let mut left_range = false;
        while self.is_due_before(to) {
            left_range |= self.tick(inputs)?;
        }
        Ok(left_range)
    }

    /// Runs the next tick, regardless of the time. Returns `true` if the speed left the scheduled range at this tick.
    ///
    /// # Errors
    /// [`TickError`].
    pub fn tick(&mut self, inputs: &Inputs) -> Result<bool, TickError> {
        if self.opens() {
            self.compute_opening(inputs)?;
        } else {
            self.compute_outputs(inputs, false)?;
        }
        self.controller.update();
        if let Some(gain) = &self.plan.anti_windup {
            self.controller.add_to_state(gain, &self.excess);
        }
        self.delay_commands();
        self.update_governor();
        if let Some(gain) = self.plan.filter {
            self.filtered_speed += gain * (self.references[self.plan.speed] - self.filtered_speed);
        }
        let left_range = self.outputs.out_of_range && !self.outside;
        self.outside = self.outputs.out_of_range;
        self.next_tick += 1;
        Ok(left_range)
    }

    /// Skips the next tick, without a command.
    pub(crate) fn skip(&mut self) {
        self.next_tick += 1;
    }

    /// Returns `true` if commands are delayed.
    pub fn has_delay(&self) -> bool {
        !self.delayed.is_empty()
    }

    /// Returns the time of the next tick in s, `start + k Ts`.
    pub fn next_tick_time(&self) -> f64 {
        self.start + self.next_tick as f64 * self.plan.sample_time
    }

    /// Returns `true` if [`advance`](Self::advance) to the time `to` in s would run a tick.
    ///
    /// A tick within 1e-6 Ts, or a few units in the last place of a large time, before `to` belongs to the next
    /// interval, so that it runs once in spite of a rounded `to`.
    pub fn is_due_before(&self, to: f64) -> bool {
        self.next_tick_time() < to - self.rounding(to)
    }

    /// Returns `true` if the next tick is due at the time `now` in s or earlier.
    pub fn is_due_at(&self, now: f64) -> bool {
        self.next_tick_time() <= now + self.rounding(now)
    }

    fn rounding(&self, time: f64) -> f64 {
        ROUNDING_OF_TIME * self.plan.sample_time + 4.0 * f64::EPSILON * time.abs()
    }

    /// Stores the commands of this tick and outputs those computed `delay` ticks ago.
    fn delay_commands(&mut self) {
        let count = self.outputs.commands.len();
        let delay = self.delayed.len() / count;
        if delay > 0 {
            let first = (self.next_tick % delay as u64) as usize * count;
            self.outputs.commands.swap_with_slice(&mut self.delayed[first..first + count]);
        }
    }

    /// Advances the transitions of all references by a tick, and counts saturated ticks.
    fn update_governor(&mut self) {
        let Self { plan, references, targets, transitions, saturation, excess, .. } = self;
        for (signal, transition) in transitions.iter_mut().enumerate() {
            if plan.governor.yields(signal, saturation) {
                *transition = Transition::from(references[signal]);
            } else if transition.share != 0.0 {
                plan.governor.advance(signal, transition, targets[signal]);
            }
        }
        for (one, excess) in saturation.iter_mut().zip(excess) {
            plan.governor.count(one, *excess != 0.0);
        }
    }

    /// Sets a reference and its target for the next tick, or for the initialisation.
    fn update_reference(&mut self, signal: usize, inputs: &Inputs, initial: bool) {
        let Self { plan, references, targets, transitions, saturation, .. } = self;
        let (trim, last) = (plan.trim.at(self.filtered_speed), references[signal]);
        if !initial && plan.governor.yields(signal, saturation) {
            let measured = plan.measured_near(signal, inputs, references);
            references[signal] = plan.envelope.target(signal, plan.governor.yielded(last, measured), trim);
            return;
        }
        let last = (!initial).then_some(last);
        let requested = plan.requested(signal, inputs, last);
        targets[signal] = plan.envelope.target(signal, requested, trim);
        references[signal] = plan.envelope.limited(signal, targets[signal], transitions[signal], last, trim);
    }

    /// Records which commands of the last computed outputs are saturated, without counting a tick.
    pub(crate) fn record_saturation(&mut self) {
        for (one, excess) in self.saturation.iter_mut().zip(&self.excess) {
            *one = Saturation { now: *excess != 0.0, ticks: 0 };
        }
    }

    pub(crate) fn compute_outputs(&mut self, inputs: &Inputs, initial: bool) -> Result<(), TickError> {
        let Plan { speed, speed_given, filter, .. } = *self.plan;
        inputs.check(&self.plan.signals)?;
        // The speed reference comes first: the limits of the others depend on V_r, its own do not.
        if !speed_given {
            self.update_reference(speed, inputs, initial);
        }
        if initial || filter.is_none() {
            self.filtered_speed = if speed_given { inputs.measured[speed] } else { self.references[speed] };
        }
        for signal in 0..self.references.len() {
            if signal != speed || speed_given {
                self.update_reference(signal, inputs, initial);
            }
        }
        let plan = &*self.plan;
        let (trim, origins) = (plan.trim.at(self.filtered_speed), &self.origins);
        let used = self.references.iter().zip(&inputs.references).zip(&plan.followed).zip(&plan.signals);
        self.outputs.reference_limited = used.into_iter().any(|(((used, requested), followed), port)| {
            *followed && *used != port.nearest(*requested, *used)
        });
        let measured = |signal| plan.measured_near(signal, inputs, &self.references);
        plan.y(measured, &self.references, |signal| trim.signal(signal, origins[signal]))
            .zip(&mut self.y)
            .for_each(|(value, y)| *y = value);
        let rho = plan.rho(inputs.measured[plan.speed]);
        let clamped = rho.clamp(-1.0, 1.0);
        let outputs = &mut self.outputs;
        outputs.out_of_range = (rho - clamped).abs() > ROUNDING_OF_RHO;
        outputs.scheduling_parameter = clamped;
        for (value, &signal) in outputs.trim.iter_mut().zip(&plan.trimmed) {
            *value = trim.signal(signal, origins[signal]);
        }
        self.compute_commands()
    }

    /// Computes the commands for the controller input y.
    pub(crate) fn compute_commands(&mut self) -> Result<(), TickError> {
        let Self { plan, outputs, controller, .. } = self;
        let rho = [outputs.scheduling_parameter];
        controller.output(&self.y, &rho[..plan.parameters], &mut outputs.commands)?;
        let trim = plan.trim.at(self.filtered_speed);
        let commands = &mut outputs.commands;
        for (index, command) in commands.iter_mut().enumerate() {
            *command = trim.command(index) + plan.actuators[index].scale * *command;
            if !command.is_finite() {
                return Err(TickError::Diverged { index, value: *command });
            }
        }
        let protected_speed = plan.protected_speed(self.filtered_speed, &self.saturation, commands);
        for (index, (command, excess)) in commands.iter_mut().zip(&mut self.excess).enumerate() {
            let [minimum, maximum] = plan.limits(index, trim.command(index), protected_speed);
            let value = *command;
            *command = value.clamp(minimum, maximum);
            *excess = (value - *command) / plan.actuators[index].scale;
        }
        Ok(())
    }
}
