//! Detection of failed sensors, and flight without them.

use crate::autopilot::Plan;
use crate::design::{Port, Source, Without};
use crate::{Autopilot, ControllerDesign, Inputs, Sensor, TickError, ticks};

/// Duration of the ramp from the last commands to the safe ones, s.
pub const RAMP: f64 = 0.5;

/// Time for which a lost sensor has to be plausible before it is used again, s.
pub const REGAINED_AFTER: f64 = 0.5;

/// State of a supervised autopilot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Health {
    /// Operation as designed.
    Ok,
    /// Command or reference limited.
    Limited,
    /// Speed sensor lost: the speed is estimated to return to its filtered reference, and its loop is open.
    SpeedLost,
    /// Depth, pitch or heading sensor lost: the signal is integrated from its rate, given by other sensors (dead
    /// reckoning).
    Reckoned,
    /// Sensor without replacement lost, such as that of a rate: the commands ramp to the safe ones.
    Failed,
}

/// Time constant with which the speed is estimated to return to V_r without its sensor, s.
pub const RETURN: f64 = 0.5;

/// Longest time without a new value that is attributed to a slow sensor, s; an older value is that of a vehicle at
/// rest.
pub const SLOWEST: f64 = 0.2;

/// Time after which the error bound of the estimate of a lost sensor stops growing, s.
pub const LONGEST: f64 = 10.0;

/// Expected change, in steps of the resolution, beyond which an unchanged value is that of a stuck sensor.
pub const STEPS: f64 = 3.0;

/// Value of [`Reading::same`] before the first tick.
pub const NEVER: u32 = u32::MAX;

/// State of a sensor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reading {
    /// Last measured value.
    pub last: f64,
    /// Value in use: the measurement, or the estimate while the sensor is lost.
    pub believed: f64,
    /// Mean over [`RETURN`] of the speed while its sensor is used.
    pub mean: f64,
    /// Expected change by the [`Source`] since the value changed last; for a lost sensor whose rate is measured, since
    /// it agrees with its estimate.
    pub moved: f64,
    /// Sum over the actuators of gain times command when the value changed last, for [`Source::Commands`].
    pub anchor: f64,
    /// Number of ticks for which the value has been the same; [`NEVER`] before the first.
    pub same: u32,
    /// Number of ticks for which the sensor has been lost; 0 if it is used.
    pub lost_for: u32,
    /// Number of ticks for which a lost sensor has been plausible.
    pub plausible_for: u32,
    /// Number of ticks in which a lost sensor contradicted its estimate, up to [`REGAINED_AFTER`]; set to that if it
    /// was stuck.
    pub wrong_for: u32,
}

/// Monitored sensor with its limits.
#[derive(Debug, Clone)]
struct MonitoredSensor {
    signal: usize,
    sensor: Sensor,
    range: [f64; 2],
    without: Without,
    /// `true` if its rate is measured.
    has_rate: bool,
    /// `true` if its reference is held while it is lost, for [`Source::Path`].
    holds: bool,
    /// Fraction of the distance to V_r by which the estimate of a lost speed moves per tick.
    returning: f64,
    /// [`SLOWEST`] in ticks, or the period of the sensor if that is longer.
    slowest: u32,
    /// [`REGAINED_AFTER`] in ticks.
    regained_after: u32,
}

/// Sample of a sensor at a tick.
#[derive(Debug, Clone, Copy)]
struct Sample {
    value: f64,
    /// Sum over the actuators of gain times command, for [`Source::Commands`].
    force: f64,
    is_valid: bool,
    /// `true` unless the sensor that measures its rate is lost.
    is_expected: bool,
    /// Number of ticks for which a value may be the same.
    stale: u32,
}

/// State of a [`Supervisor`].
#[derive(Debug, Clone, PartialEq)]
pub struct Supervised {
    /// State of each sensor.
    pub readings: Vec<Reading>,
    /// Commands, in the order of the actuators.
    pub commands: Vec<f64>,
    /// Commands at the start of the ramp to the safe ones.
    pub from: Vec<f64>,
    /// Ticks since the start of the ramp.
    pub failed_for: u32,
    /// `true` if a sensor is used again since the last tick.
    pub changed: bool,
}

/// Checks the sensors of an [`Autopilot`] before each tick, and replaces those that are lost.
///
/// A sensor with the value m_k at tick k, which was another n ticks ago, is plausible if
///
/// ```text
/// it is flagged valid, m_k is finite and within the range of its signal,
/// |m_k - m_(k-1)| <= error + rate n Ts, except at the first tick, and
/// it is not stuck: m_k differs from m_(k-1), or n Ts < stale_after + period, or its resolution is coarser than its
///     noise and its expected change is at most 3 steps + drift n Ts; if its rate is measured, it is also stuck when
///     its expected change exceeds error + drift n Ts, for any stale_after
/// ```
///
/// where n Ts is limited to [`SLOWEST`], or the period if that is longer, in the rate bound, and to [`LONGEST`] in the
/// drift bounds. The expected change follows from the [`Source`]. A sensor that is not plausible is lost. It is used
/// again after it was plausible for [`REGAINED_AFTER`] and, at the time t after its loss, no farther than
/// `error + drift min(t, LONGEST)` from its estimate. A sensor whose rate is measured, and that was stuck or
/// contradicted its estimate for [`REGAINED_AFTER`], also has to agree with it while the vehicle moves by more than
/// `error`; while that rate is lost too, nothing contradicts it. A sensor that stays farther away is lost until the
/// autopilot is initialised. The replacement of a lost sensor is
///
/// ```text
/// speed                    u_k = u_(k-1) + (1 - exp(-Ts/0.5 s)) (V_r - u_(k-1)), from its mean over 0.5 s
/// depth, pitch, heading    m_k = m_(k-1) + Ts rate_(k-1), the rate of its source; a reference of depth is held
/// any other                the last value, and the commands ramp to the safe ones in [`RAMP`]
/// ```
///
/// When a sensor is used again, the autopilot follows its own commands once, see [`Autopilot::follow`], so that the
/// command does not jump. Nothing is proved about a loop without a sensor.
#[derive(Debug, Clone)]
pub struct Supervisor {
    sensors: Vec<MonitoredSensor>,
    safe: Vec<f64>,
    sample_time: f64,
    /// Inputs passed to the autopilot.
    inputs: Inputs,
    state: Supervised,
}

impl Supervisor {
    /// Creates the supervisor of an autopilot of this design, which was initialised with these inputs.
    #[inline]
    pub fn new(design: &ControllerDesign, autopilot: &Autopilot, inputs: &Inputs) -> Self {
        let any = [f64::NEG_INFINITY, f64::INFINITY];
        let sensor = |(signal, port): (usize, &Port)| {
            let sensor = design.failsafe.as_ref()?.sensors.get(&port.name)?.clone();
            let (range, without) = (port.range.unwrap_or(any), design.without(signal));
            let source = design.source(signal);
            Some(MonitoredSensor {
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
        let sensors: Vec<MonitoredSensor> = design.signals.iter().enumerate().filter_map(sensor).collect();
        let commands = autopilot.outputs().commands.clone();
        Self {
            safe: design.failsafe.as_ref().map_or_else(Vec::new, |failsafe| failsafe.safe.clone()),
            sample_time: design.sample_time,
            inputs: inputs.clone(),
            state: Supervised {
                readings: sensors.iter().map(|one| Reading::new(inputs.measured[one.signal])).collect(),
                from: commands.clone(),
                commands,
                failed_for: 0,
                changed: false,
            },
            sensors,
        }
    }

    /// Restarts with an autopilot that was initialised with these inputs.
    pub fn initialise(&mut self, autopilot: &Autopilot, inputs: &Inputs) {
        for (one, reading) in self.sensors.iter().zip(&mut self.state.readings) {
            *reading = Reading::new(inputs.measured[one.signal]);
        }
        self.state.commands.copy_from_slice(&autopilot.outputs().commands);
        self.state.failed_for = 0;
        self.state.changed = false;
    }

    /// Returns the state, to be saved or restored.
    pub fn state(&mut self) -> &mut Supervised {
        &mut self.state
    }

    /// Returns the commands, in the order of the actuators.
    pub fn commands(&self) -> &[f64] {
        &self.state.commands
    }

    /// Returns `true` if the commands are the safe ones, or ramp to them.
    pub fn has_failed(&self) -> bool {
        self.fallbacks().any(|without| without == Without::Nothing)
    }

    /// Returns `true` if all sensors are used, and were at the last tick.
    pub fn is_complete(&self) -> bool {
        self.fallbacks().next().is_none() && !self.state.changed
    }

    /// Returns the state of the autopilot.
    pub fn health(&self, autopilot: &Autopilot) -> Health {
        let has_lost = |which: Without| self.fallbacks().any(|one| one == which);
        let limited = autopilot.outputs().reference_limited || autopilot.saturation.iter().any(|one| one.now);
        match () {
            () if has_lost(Without::Nothing) => Health::Failed,
            () if has_lost(Without::Reckoned) => Health::Reckoned,
            () if has_lost(Without::Speed) => Health::SpeedLost,
            () if limited => Health::Limited,
            () => Health::Ok,
        }
    }

    /// Returns the fallback for each lost sensor.
    fn fallbacks(&self) -> impl Iterator<Item = Without> {
        let all = self.sensors.iter().zip(&self.state.readings);
        all.filter(|(_, reading)| reading.lost_for > 0).map(|(one, _)| one.without)
    }

    /// Checks the sensors, once before each tick. `valid` holds the validity flag of each signal; a value that is the
    /// same for `stale_after` \[s\], if that is above 0, may be stuck.
    pub fn judge(&mut self, autopilot: &Autopilot, inputs: &Inputs, valid: &[bool], stale_after: f64) {
        self.inputs.measured.copy_from_slice(&inputs.measured);
        self.inputs.references.copy_from_slice(&inputs.references);
        self.predict(autopilot);
        for index in 0..self.sensors.len() {
            let is_expected = self.has_source(autopilot, index);
            let (one, reading) = (&self.sensors[index], &mut self.state.readings[index]);
            let was_lost = reading.lost_for > 0;
            let value =
                autopilot.plan.signals[one.signal].nearest(inputs.measured[one.signal], reading.believed);
            let stale = match stale_after {
                0.0 => u32::MAX,
                after => ticks(after + one.sensor.period, self.sample_time),
            };
            let force = autopilot.plan.sources.force(one.signal, &self.state.commands);
            let sample = Sample { value, force, is_valid: valid[one.signal], is_expected, stale };
            one.check(reading, sample, self.sample_time);
            self.inputs.measured[one.signal] = reading.believed;
            self.state.changed |= was_lost && reading.lost_for == 0;
        }
    }

    /// Holds the references of lost signals with [`Source::Path`] at their last values.
    fn hold(&mut self, autopilot: &Autopilot) {
        let held = |(one, reading): &(&MonitoredSensor, &Reading)| reading.lost_for > 0 && one.holds;
        for (MonitoredSensor { signal, .. }, _) in self.sensors.iter().zip(&self.state.readings).filter(held)
        {
            if let Some(reference) = self.inputs.references.get_mut(*signal) {
                *reference = autopilot.transitions[*signal].target_of(autopilot.references[*signal]);
            }
        }
    }

    /// Advances the estimates of the lost sensors, and the expected change of every sensor.
    fn predict(&mut self, autopilot: &Autopilot) {
        let Plan { sources, speed_given, .. } = &*autopilot.plan;
        for index in 0..self.sensors.len() {
            let MonitoredSensor { signal, without, returning, .. } = self.sensors[index];
            let Reading { believed, moved, anchor, lost_for, .. } = self.state.readings[index];
            let rate = match sources.rate(&autopilot.plan.trim, signal, |other| self.believed(other)) {
                None => sources.rate_from_commands(signal, &self.state.commands, anchor, moved),
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

    /// Returns `true` unless the sensor that measures the rate is lost; a path is integrated from the values in use.
    fn has_source(&self, autopilot: &Autopilot, index: usize) -> bool {
        let from = autopilot.plan.sources.rate_signal(self.sensors[index].signal);
        let is_lost = |from| {
            let mut all = self.sensors.iter().zip(&self.state.readings);
            all.any(|(one, reading)| one.signal == from && reading.lost_for > 0)
        };
        !from.is_some_and(is_lost)
    }

    /// Returns the value in use of a measured signal: the measurement, or the estimate while the sensor is lost.
    pub fn believed(&self, signal: usize) -> f64 {
        let index = self.sensors.iter().position(|one| one.signal == signal);
        index.map_or(0.0, |index| self.state.readings[index].believed)
    }

    /// Calls [`Autopilot::follow`] with the values in use.
    ///
    /// # Errors
    /// [`TickError`].
    pub fn follow(&mut self, autopilot: &mut Autopilot, applied: &[f64]) -> Result<(), TickError> {
        autopilot.store_applied(applied)?;
        self.state.commands.copy_from_slice(&autopilot.applied);
        self.state.failed_for = 0;
        if self.has_failed() {
            return Ok(());
        }
        self.state.changed = false;
        self.hold(autopilot);
        autopilot.follow(&self.inputs, applied)
    }

    /// Calls [`Autopilot::tick`] with the values in use.
    ///
    /// # Errors
    /// [`TickError`].
    pub fn tick(&mut self, autopilot: &mut Autopilot) -> Result<bool, TickError> {
        if self.has_failed() {
            self.ramp_to_safe();
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

    /// Advances the ramp of the commands to the safe ones by a tick.
    fn ramp_to_safe(&mut self) {
        let Supervised { commands, from, failed_for, .. } = &mut self.state;
        let ramp = ticks(RAMP, self.sample_time);
        if *failed_for == 0 {
            from.copy_from_slice(commands);
        }
        *failed_for = (*failed_for + 1).min(ramp);
        let fraction = f64::from(*failed_for) / f64::from(ramp);
        for ((command, from), safe) in commands.iter_mut().zip(from).zip(&self.safe) {
            *command = (1.0 - fraction) * *from + fraction * safe;
        }
    }
}

impl Reading {
    /// Creates the state of a sensor in use before its first tick.
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

impl MonitoredSensor {
    /// Checks a sample of the sensor and updates its state.
    fn check(&self, reading: &mut Reading, sample: Sample, sample_time: f64) {
        let Sample { value, force, is_valid, is_expected, stale } = sample;
        let Sensor { error, rate, drift, resolution, .. } = self.sensor;
        let near = |distance: f64, base: f64, rate: f64, ticks: u32| {
            distance.abs() <= base + rate * (f64::from(ticks) * sample_time)
        };
        let is_first = reading.same == NEVER;
        let changed = is_first || value != reading.last;
        let unchanged_for = increment(reading.same);
        let longest = ticks(LONGEST, sample_time);
        let should_move = |base: f64| !near(reading.moved, base, drift, unchanged_for.min(longest));
        let has_contradicted = reading.wrong_for >= self.regained_after;
        let is_stuck = !changed
            && (unchanged_for >= stale
                && (has_contradicted || resolution == 0.0 || should_move(STEPS * resolution))
                || self.has_rate && should_move(error));
        let in_range = self.range[0] <= value && value <= self.range[1];
        let is_rate_plausible =
            is_first || near(value - reading.last, error, rate, unchanged_for.min(self.slowest));
        let is_usable = is_valid && value.is_finite();
        let plausible = is_usable && in_range && is_rate_plausible && !is_stuck;
        let moved = reading.moved;
        reading.last = value;
        reading.same = if changed { 0 } else { unchanged_for };
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
                // The value has been wrong since it changed last.
                reading.believed += moved;
            }
            if self.without == Without::Speed {
                // The controller has integrated the noise of the frozen value.
                let most = ticks(RETURN, sample_time);
                let fraction = f64::from(reading.same.min(most)) / f64::from(most);
                reading.believed = reading.mean - fraction * (reading.believed - reading.mean);
            }
            reading.moved = 0.0;
            return;
        }
        reading.lost_for = increment(reading.lost_for);
        if plausible && !is_expected {
            // Nothing contradicts it.
            reading.believed = value;
            reading.lost_for = 1;
            reading.wrong_for = 0;
        }
        if plausible && near(value - reading.believed, error, drift, reading.lost_for.min(longest)) {
            reading.plausible_for = increment(reading.plausible_for);
        } else {
            reading.plausible_for = 0;
            reading.moved = 0.0;
            reading.wrong_for = (reading.wrong_for + u32::from(is_usable)).min(self.regained_after);
        }
        let is_confirmed =
            !self.has_rate || reading.wrong_for < self.regained_after || reading.moved.abs() > error;
        if reading.plausible_for >= self.regained_after && is_confirmed {
            *reading = Self::regained(*reading, value, force);
        }
    }

    /// Returns the state of a sensor that is used again.
    fn regained(reading: Reading, value: f64, force: f64) -> Reading {
        Reading { last: value, same: reading.same, anchor: force, ..Reading::new(value) }
    }
}

/// Increments a number of ticks, which stays below [`NEVER`].
fn increment(ticks: u32) -> u32 {
    if ticks < NEVER - 1 { ticks + 1 } else { NEVER - 1 }
}

/// Returns the fraction of the distance to V_r by which the estimate of a lost speed moves per tick.
pub fn returning(design: &ControllerDesign) -> f64 {
    -(-design.sample_time / RETURN).exp_m1()
}
