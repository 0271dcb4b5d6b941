//! References beyond what the vehicle can hold.

use crate::error::Error;
use crate::inputs::Inputs;
use crate::verdict::flown::{AT_ONCE, STEP_TIME, flight_from};
use rayon::prelude::*;
use serde::Serialize;
use squid_auv::longitudinal::{PITCH, SIGNALS, SPEED};
use squid_flight::flight::Row;
use squid_scheduled::{ControllerDesign, Manoeuvre, ReferenceLimits};

/// How far a step goes, relative to the way from level flight to the end of the envelope; farther ones are limited to
/// the same reference.
const FACTOR: f64 = 3.0;

/// The steepest pitch that is asked, rad.
const STEEPEST: f64 = 1.5;

/// How long a step is held, how long after its end the rest is judged, at least, and how long it is watched (s).
const HELD: f64 = 40.0;
const AFTER: f64 = 8.0;
const WATCHED: f64 = 6.0;

/// The rest is not judged before the reference model of pitch has settled: this number over its frequency (s).
const SETTLED: f64 = 10.0;

/// An envelope that is narrower, rad, leaves nothing to fly.
const NARROW: f64 = 0.01;

/// A step of pitch that asks for more than the vehicle can hold, held and taken back.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Beyond {
    /// Speed along the path, m/s.
    pub speed: f64,
    /// The pitch that is asked, rad.
    pub asked: f64,
    /// The end of the envelope, rad.
    pub end: f64,
    /// How far pitch is from the end of the envelope when the step has been held, relative to the way there from level
    /// flight.
    pub off: f64,
    /// The error of the speed then, relative to the speed that is asked, or half the range of speed if that is more.
    pub speed_error: f64,
    /// The largest loss of speed at any time, relative to the same.
    pub lost_speed: f64,
    /// The largest error of pitch some seconds after the end of the step and later, relative to the same way.
    pub left: f64,
}

/// How long after the end of a step the rest is judged, s.
pub(super) fn after(inputs: &Inputs) -> f64 {
    let pitch = inputs.design.tracked.iter().find(|t| t.index == PITCH);
    let settled = pitch.and_then(|t| t.model).map_or(0.0, |model| SETTLED / model.frequency);
    AFTER.max(settled)
}

impl Beyond {
    /// The flights at a number of speeds, up and down; none for a design that does not follow pitch.
    ///
    /// # Errors
    /// The errors of the flights.
    pub fn of(inputs: &Inputs, controller: &ControllerDesign, speeds: usize) -> Result<Vec<Self>, Error> {
        let Some(ReferenceLimits { range: Some(range), .. }) = controller.envelope.get(SIGNALS[PITCH].name)
        else {
            return Ok(vec![]);
        };
        let table = squid_scheduled::Autopilot::new(controller)?.trim().clone();
        let mut all = vec![];
        for speed in inputs.design.spread(speeds) {
            let forward = table.forward_speed(speed);
            let level = table.signal(forward, PITCH, 0.0);
            for end in range {
                let end = table.over(forward, end);
                if (end - level).abs() > NARROW {
                    all.push((speed, forward, level, end));
                }
            }
        }
        all.into_par_iter()
            .map(|(speed, forward, level, end)| {
                let asked = level + (FACTOR * (end - level)).clamp(-STEEPEST, STEEPEST);
                Self::flown(inputs, controller, (speed, forward), (level, end, asked))
            })
            .collect()
    }

    fn flown(
        inputs: &Inputs,
        controller: &ControllerDesign,
        (speed, forward): (f64, f64),
        (level, end, asked): (f64, f64, f64),
    ) -> Result<Self, Error> {
        let (_, half_range) = inputs.design.scheduling();
        let after = after(inputs);
        let still = Manoeuvre {
            speed_from: speed,
            speed_to: speed,
            step_time: STEP_TIME,
            step_end: STEP_TIME + HELD,
            ramp_start: STEP_TIME,
            ramp_duration: AT_ONCE,
            duration: STEP_TIME + HELD + after + WATCHED,
            ..inputs.design.manoeuvre.without_steps()
        };
        let manoeuvre = still.with_step(SIGNALS[PITCH].name, asked - level);
        let way = (end - level).abs();
        let lost = Self {
            speed,
            asked,
            end,
            off: f64::INFINITY,
            speed_error: f64::INFINITY,
            lost_speed: f64::INFINITY,
            left: f64::INFINITY,
        };
        // So deep that no climb reaches the surface.
        let depth = inputs.design.depth + 2.0 * speed.abs() * manoeuvre.duration;
        let Some(flight) = flight_from(inputs, controller, depth, &manoeuvre)? else { return Ok(lost) };
        let rows = &flight.rows;
        let held = rows.iter().rfind(|row| row.time < STEP_TIME + HELD);
        // Near rest the range of speed is the measure.
        let size = forward.abs().max(half_range);
        let slower = |row: &Row| (forward - row.measured(SPEED)) * forward.signum() / size;
        let off = held.map_or(f64::INFINITY, |row| (row.measured(PITCH) - end).abs() / way);
        let speed_error = held.map_or(f64::INFINITY, |row| slower(row).abs());
        let lost_speed = rows.iter().map(slower).fold(0.0, f64::max);
        let late = rows.iter().filter(|row| row.time >= STEP_TIME + HELD + after);
        let left = late.map(|row| row.error(PITCH).abs() / way);
        Ok(Self { off, speed_error, lost_speed, left: left.fold(0.0, f64::max), ..lost })
    }
}
