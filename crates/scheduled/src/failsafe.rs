//! Sensors that fail: which are believed, and what is flown without the others.

use crate::autopilot::Plan;
use crate::design::{Port, Source, Without};
use crate::{Autopilot, ControllerDesign, Inputs, Sensor, TickError, ticks};

/// Time in which the commands go to the safe ones, s.
pub const RAMP: f64 = 0.5;

/// A sensor that is lost has to be plausible for so long until it is believed again, s.
pub const REGAINED_AFTER: f64 = 0.5;

/// How the autopilot is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Health {
    /// As designed.
    Ok,
    /// A command or a reference is limited.
    Limited,
    /// The speed is taken to be its filtered reference, or to go there: its loop is open.
    SpeedLost,
    /// A signal is reckoned from the sensors that know its rate: depth, pitch, heading.
    Reckoned,
    /// A sensor that nothing replaces is lost, such as that of a rate: the commands go to the safe ones.
    Failed,
}

/// Time constant with which the speed without its sensor is taken to return to V_r, s.
pub const RETURN: f64 = 0.5;

/// A value that has been the same for longer is that of a vehicle that does not move, not of a slow sensor, s.
pub const SLOWEST: f64 = 0.2;

/// What is expected of a sensor that is lost is not worse than after this time, s.
pub const LONGEST: f64 = 10.0;

/// A value that stays the same is that of a stuck sensor where it should have moved by so many of its steps.
pub const STEPS: f64 = 3.0;

/// For how many ticks a value has been the same that no tick has read yet.
pub const NEVER: u32 = u32::MAX;

/// What is known of a sensor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reading {
    /// The last value.
    pub last: f64,
    /// What is believed: the last value, or what is expected without it.
    pub believed: f64,
    /// The mean of a speed that is believed, over [`RETURN`].
    pub mean: f64,
    /// By how much it should have moved, as its [`Source`] says: since its value changed, or, of a sensor that is lost
    /// and whose rate is measured, since it agrees with what is expected.
    pub moved: f64,
    /// The sum of gain and command over the actuators when its value changed, of [`Source::Commands`].
    pub anchor: f64,
    /// For how many ticks the value has been the same; [`NEVER`] before the first.
    pub same: u32,
    /// For how many ticks the sensor has been lost; 0 if it is believed.
    pub lost_for: u32,
    /// For how many ticks a sensor that is lost has been plausible.
    pub plausible_for: u32,
    /// For how many ticks a sensor that is lost has contradicted what is expected, up to [`REGAINED_AFTER`]; as many if
    /// it was stuck.
    pub wrong_for: u32,
}

/// A sensor with the limits to what it may say.
#[derive(Debug, Clone)]
struct Watched {
    signal: usize,
    sensor: Sensor,
    range: [f64; 2],
    without: Without,
    /// Whether its rate is measured.
    has_rate: bool,
    /// Whether its reference is held while it is lost: it follows from the path alone.
    holds: bool,
    /// Part of the way to V_r that a speed that is lost is taken to go in a tick.
    returning: f64,
    /// [`SLOWEST`], or its period if that is longer, and [`REGAINED_AFTER`] in ticks.
    slowest: u32,
    regained_after: u32,
}

/// What a sensor says at a tick.
#[derive(Debug, Clone, Copy)]
struct Now {
    value: f64,
    /// The sum of gain and command over the actuators, for [`Source::Commands`].
    force: f64,
    is_valid: bool,
    /// Whether what it should say follows from others that are believed.
    is_expected: bool,
    /// For how many ticks a value may be the same.
    stale: u32,
}

/// The state of a [`Supervisor`].
#[derive(Debug, Clone, PartialEq)]
pub struct Supervised {
    /// Of each sensor.
    pub readings: Vec<Reading>,
    /// The commands, in the order of the actuators.
    pub commands: Vec<f64>,
    /// Those from which they go to the safe ones.
    pub from: Vec<f64>,
    /// For how many ticks they have.
    pub failed_for: u32,
    /// Whether the last tick was flown with other sensors.
    pub changed: bool,
}

/// Judges the sensors of an [`Autopilot`] before each tick, and flies without those that are lost.
///
/// A sensor with the value m_k at tick k, which was another n ticks ago, is plausible if
///
/// ```text
/// it is said to be valid, m_k is finite and within the range of its signal,
/// |m_k - m_(k-1)| <= error + rate n Ts, but at the first tick, and
/// it is not stuck: m_k differs from m_(k-1), or n Ts < stale_after + period, or its steps are coarser than its noise
///     and it should not have moved by more than 3 steps + drift n Ts; one whose rate is measured is stuck, too, where
///     it should have moved by more than error + drift n Ts, whatever stale_after is
/// ```
///
/// where n Ts is [`SLOWEST`] at most for the rate, or its period, and [`LONGEST`] for the drift. By how much it should
/// have moved follows from its [`Source`]. One that is not plausible is lost. It is believed again when for
/// [`REGAINED_AFTER`] it was plausible and, t after it was lost, not farther than `error + drift min(t, LONGEST)` from
/// what is expected. One whose rate is measured, and that was stuck or contradicted what is expected for
/// [`REGAINED_AFTER`], has to agree with it while the vehicle moves by more than `error`; while that rate is lost, too,
/// nothing contradicts it. One that stays farther is lost until the autopilot is initialised. Without it
///
/// ```text
/// a speed is taken to be   u_k = u_(k-1) + (1 - exp(-Ts/0.5 s)) (V_r - u_(k-1)), from its mean over 0.5 s
/// depth, pitch, heading    m_k = m_(k-1) + Ts rate_(k-1), the rate of its source; a reference of depth is held
/// another                  the last value, and the commands go to the safe ones in [`RAMP`]
/// ```
///
/// When a sensor is believed again, the autopilot follows its own commands once, see [`Autopilot::follow`]: its first
/// command is the last one. Nothing is proved of a loop without a sensor.
#[derive(Debug, Clone)]
pub struct Supervisor {
    watched: Vec<Watched>,
    safe: Vec<f64>,
    sample_time: f64,
    /// The inputs as the autopilot gets them.
    inputs: Inputs,
    state: Supervised,
}

impl Supervisor {
    /// The supervisor of an autopilot of this design, which was initialised with these inputs.
    #[inline]
    pub fn new(design: &ControllerDesign, autopilot: &Autopilot, inputs: &Inputs) -> Self {
        let any = [f64::NEG_INFINITY, f64::INFINITY];
        let sensor = |(signal, port): (usize, &Port)| {
            let sensor = design.failsafe.as_ref()?.sensors.get(&port.name)?.clone();
            let (range, without) = (port.range.unwrap_or(any), design.without(signal));
            let source = design.source(signal);
            Some(Watched {
                signal,
                range,
                without,
                has_rate: matches!(source, Some(Source::Rate(_))),
                holds: matches!(source, Some(Source::Path(_))),
                returning: returning(design),
                slowest: ticks(SLOWEST.max(sensor.period), design.sample_time),
                regained_after: ticks(REGAINED_AFTER, design.sample_time),
                sensor,
            })
        };
        let watched: Vec<Watched> = design.signals.iter().enumerate().filter_map(sensor).collect();
        let commands = autopilot.outputs().commands.clone();
        Self {
            safe: design.failsafe.as_ref().map_or_else(Vec::new, |failsafe| failsafe.safe.clone()),
            sample_time: design.sample_time,
            inputs: inputs.clone(),
            state: Supervised {
                readings: watched.iter().map(|one| Reading::new(inputs.measured[one.signal])).collect(),
                from: commands.clone(),
                commands,
                failed_for: 0,
                changed: false,
            },
            watched,
        }
    }

    /// Begins anew with an autopilot that was initialised with these inputs.
    pub fn initialise(&mut self, autopilot: &Autopilot, inputs: &Inputs) {
        for (one, reading) in self.watched.iter().zip(&mut self.state.readings) {
            *reading = Reading::new(inputs.measured[one.signal]);
        }
        self.state.commands.copy_from_slice(&autopilot.outputs().commands);
        self.state.failed_for = 0;
        self.state.changed = false;
    }

    /// The state, which can be saved and restored.
    pub fn state(&mut self) -> &mut Supervised {
        &mut self.state
    }

    /// The commands, in the order of the actuators.
    pub fn commands(&self) -> &[f64] {
        &self.state.commands
    }

    /// Whether the commands are the safe ones, or go there.
    pub fn has_failed(&self) -> bool {
        self.lost().any(|without| without == Without::Nothing)
    }

    /// Whether all sensors are believed, and were at the last tick.
    pub fn is_complete(&self) -> bool {
        self.lost().next().is_none() && !self.state.changed
    }

    /// How the autopilot is.
    pub fn health(&self, autopilot: &Autopilot) -> Health {
        let has_lost = |which: Without| self.lost().any(|one| one == which);
        let limited = autopilot.outputs().reference_limited || autopilot.saturation.iter().any(|one| one.now);
        match () {
            () if has_lost(Without::Nothing) => Health::Failed,
            () if has_lost(Without::Reckoned) => Health::Reckoned,
            () if has_lost(Without::Speed) => Health::SpeedLost,
            () if limited => Health::Limited,
            () => Health::Ok,
        }
    }

    /// What is flown without each sensor that is lost.
    fn lost(&self) -> impl Iterator<Item = Without> {
        let all = self.watched.iter().zip(&self.state.readings);
        all.filter(|(_, reading)| reading.lost_for > 0).map(|(one, _)| one.without)
    }

    /// Judges the sensors, once before each tick. `valid` says of each signal whether its measured value is valid;
    /// a value may be stuck that is the same for `stale_after` \[s\], if that is above 0.
    pub fn judge(&mut self, autopilot: &Autopilot, inputs: &Inputs, valid: &[bool], stale_after: f64) {
        self.inputs.measured.copy_from_slice(&inputs.measured);
        self.inputs.references.copy_from_slice(&inputs.references);
        self.expect(autopilot);
        for index in 0..self.watched.len() {
            let is_expected = self.has_source(autopilot, index);
            let (one, reading) = (&self.watched[index], &mut self.state.readings[index]);
            let was_lost = reading.lost_for > 0;
            let value =
                autopilot.plan.signals[one.signal].nearest(inputs.measured[one.signal], reading.believed);
            let stale = match stale_after {
                0.0 => u32::MAX,
                after => ticks(after + one.sensor.period, self.sample_time),
            };
            let force = autopilot.plan.sources.force(one.signal, &self.state.commands);
            let now = Now { value, force, is_valid: valid[one.signal], is_expected, stale };
            one.judge(reading, now, self.sample_time);
            self.inputs.measured[one.signal] = reading.believed;
            self.state.changed |= was_lost && reading.lost_for == 0;
        }
    }

    /// Holds the references of signals that follow from the path alone as they were used last.
    fn hold(&mut self, autopilot: &Autopilot) {
        let held = |(one, reading): &(&Watched, &Reading)| reading.lost_for > 0 && one.holds;
        for (Watched { signal, .. }, _) in self.watched.iter().zip(&self.state.readings).filter(held) {
            if let Some(reference) = self.inputs.references.get_mut(*signal) {
                *reference = autopilot.transitions[*signal].target_of(autopilot.references[*signal]);
            }
        }
    }

    /// Moves what is believed of the sensors that are lost, and by how much each should have moved.
    fn expect(&mut self, autopilot: &Autopilot) {
        let Plan { sources, speed_given, .. } = &*autopilot.plan;
        for index in 0..self.watched.len() {
            let Watched { signal, without, returning, .. } = self.watched[index];
            let Reading { believed, moved, anchor, lost_for, .. } = self.state.readings[index];
            let rate = match sources.rate(&autopilot.plan.trim, signal, |other| self.believed(other)) {
                None => sources.accelerated(signal, &self.state.commands, anchor, moved),
                rate => rate,
            };
            let rate = rate.filter(|_| self.has_source(autopilot, index));
            let step = self.sample_time * rate.unwrap_or(0.0);
            let reading = &mut self.state.readings[index];
            reading.moved += step;
            match without {
                _ if lost_for == 0 => {}
                Without::Reckoned => reading.believed += step,
                Without::Speed if !speed_given => {
                    reading.believed += returning * (autopilot.filtered_speed - believed);
                }
                _ => {}
            }
        }
    }

    /// Whether nothing that the rate of a sensor follows from is lost; a path goes on by what is believed.
    fn has_source(&self, autopilot: &Autopilot, index: usize) -> bool {
        let from = autopilot.plan.sources.rate_signal(self.watched[index].signal);
        let is_lost = |from| {
            let mut all = self.watched.iter().zip(&self.state.readings);
            all.any(|(one, reading)| one.signal == from && reading.lost_for > 0)
        };
        !from.is_some_and(is_lost)
    }

    /// The believed value of a signal that is measured: the last one, or what is reckoned without it.
    pub fn believed(&self, signal: usize) -> f64 {
        let index = self.watched.iter().position(|one| one.signal == signal);
        index.map_or(0.0, |index| self.state.readings[index].believed)
    }

    /// As [`Autopilot::follow`], with the sensors that are believed.
    ///
    /// # Errors
    /// [`TickError`].
    pub fn follow(&mut self, autopilot: &mut Autopilot, applied: &[f64]) -> Result<(), TickError> {
        autopilot.take_applied(applied)?;
        self.state.commands.copy_from_slice(&autopilot.applied);
        self.state.failed_for = 0;
        if self.has_failed() {
            return Ok(());
        }
        self.state.changed = false;
        self.hold(autopilot);
        autopilot.follow(&self.inputs, applied)
    }

    /// As [`Autopilot::tick`], with the sensors that are believed.
    ///
    /// # Errors
    /// [`TickError`].
    pub fn tick(&mut self, autopilot: &mut Autopilot) -> Result<bool, TickError> {
        if self.has_failed() {
            self.go_to_safe();
            autopilot.skip();
            return Ok(false);
        }
        self.state.failed_for = 0;
        self.hold(autopilot);
        if self.state.changed {
            autopilot.follow(&self.inputs, &self.state.commands)?;
            self.state.changed = false;
        }
        let left_range = autopilot.tick(&self.inputs)?;
        self.state.commands.copy_from_slice(&autopilot.outputs().commands);
        Ok(left_range)
    }

    /// The commands of the next tick on the way to the safe ones.
    fn go_to_safe(&mut self) {
        let Supervised { commands, from, failed_for, .. } = &mut self.state;
        let ramp = ticks(RAMP, self.sample_time);
        if *failed_for == 0 {
            from.copy_from_slice(commands);
        }
        *failed_for = (*failed_for + 1).min(ramp);
        let part = f64::from(*failed_for) / f64::from(ramp);
        for ((command, from), safe) in commands.iter_mut().zip(from).zip(&self.safe) {
            *command = (1.0 - part) * *from + part * safe;
        }
    }
}

impl Reading {
    /// A sensor that is believed, before its first tick.
    fn new(value: f64) -> Self {
        Self {
            last: value,
            believed: value,
            mean: value,
            moved: 0.0,
            anchor: 0.0,
            same: NEVER,
            lost_for: 0,
            plausible_for: 0,
            wrong_for: 0,
        }
    }
}

impl Watched {
    /// Takes a value of the sensor.
    fn judge(&self, reading: &mut Reading, now: Now, sample_time: f64) {
        let Now { value, force, is_valid, is_expected, stale } = now;
        let Sensor { error, rate, drift, resolution, .. } = self.sensor;
        let near = |distance: f64, base: f64, rate: f64, ticks: u32| {
            distance.abs() <= base + rate * (f64::from(ticks) * sample_time)
        };
        let is_first = reading.same == NEVER;
        let changed = is_first || value != reading.last;
        let since = next(reading.same);
        let longest = ticks(LONGEST, sample_time);
        let should_move = |base: f64| !near(reading.moved, base, drift, since.min(longest));
        let is_caught = reading.wrong_for >= self.regained_after;
        let is_stuck = !changed
            && (since >= stale && (is_caught || resolution == 0.0 || should_move(STEPS * resolution))
                || self.has_rate && should_move(error));
        let in_range = self.range[0] <= value && value <= self.range[1];
        let moves_as_it_may = is_first || near(value - reading.last, error, rate, since.min(self.slowest));
        let speaks = is_valid && value.is_finite();
        let plausible = speaks && in_range && moves_as_it_may && !is_stuck;
        let moved = reading.moved;
        reading.last = value;
        reading.same = if changed { 0 } else { since };
        if changed && !(self.has_rate && reading.lost_for > 0) {
            reading.moved = 0.0;
            reading.anchor = force;
        }
        if reading.lost_for == 0 {
            if plausible {
                reading.believed = value;
                if changed {
                    reading.mean += self.returning * (value - reading.mean);
                }
                return;
            }
            reading.lost_for = 1;
            reading.plausible_for = 0;
            reading.wrong_for = if is_stuck { self.regained_after } else { 0 };
            if self.without == Without::Reckoned {
                // Since its value changed last it has been wrong.
                reading.believed += moved;
            }
            if self.without == Without::Speed {
                // The controller has integrated the noise of a value that did not change.
                let most = ticks(RETURN, sample_time);
                let part = f64::from(reading.same.min(most)) / f64::from(most);
                reading.believed = reading.mean - part * (reading.believed - reading.mean);
            }
            reading.moved = 0.0;
            return;
        }
        reading.lost_for = next(reading.lost_for);
        if plausible && !is_expected {
            // Nothing contradicts it.
            reading.believed = value;
            reading.lost_for = 1;
            reading.wrong_for = 0;
        }
        if plausible && near(value - reading.believed, error, drift, reading.lost_for.min(longest)) {
            reading.plausible_for = next(reading.plausible_for);
        } else {
            reading.plausible_for = 0;
            reading.moved = 0.0;
            reading.wrong_for = (reading.wrong_for + u32::from(speaks)).min(self.regained_after);
        }
        let is_proven =
            !self.has_rate || reading.wrong_for < self.regained_after || reading.moved.abs() > error;
        if reading.plausible_for >= self.regained_after && is_proven {
            *reading = Self::regained(*reading, value, force);
        }
    }

    /// A sensor that is believed again.
    fn regained(reading: Reading, value: f64, force: f64) -> Reading {
        Reading { last: value, same: reading.same, anchor: force, ..Reading::new(value) }
    }
}

/// Counts a tick, and stays below [`NEVER`].
fn next(ticks: u32) -> u32 {
    if ticks < NEVER - 1 { ticks + 1 } else { NEVER - 1 }
}

/// Part of the way to V_r that a speed that is lost is taken to go in a tick.
pub fn returning(design: &ControllerDesign) -> f64 {
    -(-design.sample_time / RETURN).exp_m1()
}
