//! Pitch references beyond the envelope.

use crate::error::Error;
use crate::inputs::Inputs;
use crate::verdict::flown::{AT_ONCE, STEP_TIME, flight_from};
use rayon::prelude::*;
use serde::Serialize;
use squid_auv::longitudinal::{PITCH, SIGNALS, SPEED};
use squid_flight::flight::Row;
use squid_scheduled::{ControllerDesign, Manoeuvre, ReferenceLimits};

/// Size of a step relative to the distance from level flight to the end of the envelope; larger steps are limited to
/// the same reference.
const FACTOR: f64 = 3.0;

/// Steepest requested pitch, rad.
const STEEPEST: f64 = 1.5;

/// Duration of a step, least time from its end to the assessment of the remaining error, and duration of that
/// assessment (s).
const HELD: f64 = 40.0;
const AFTER: f64 = 8.0;
const WATCHED: f64 = 6.0;

/// Settling time of the reference model of pitch times its frequency; the remaining error is not assessed earlier.
const SETTLED: f64 = 10.0;

/// Width below which an envelope is not flown, rad.
const NARROW: f64 = 0.01;

/// Step of pitch beyond the envelope, held and taken back.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Beyond {
    /// Speed along the path, m/s.
    pub speed: f64,
    /// Requested pitch, rad.
    pub requested: f64,
    /// End of the envelope, rad.
    pub end: f64,
    /// Distance of pitch from the end of the envelope at the end of the step, relative to the distance of that end from
    /// level flight.
    pub pitch_error: f64,
    /// Error of the speed at that time, relative to the forward speed of the trim, or half the range of speed if that
    /// is larger.
    pub speed_error: f64,
    /// Largest loss of speed at any time, on the same scale.
    pub lost_speed: f64,
    /// Largest error of pitch from some seconds after the end of the step on, relative to the same distance.
    pub remaining_error: f64,
}

/// Time from the end of a step to the assessment of the remaining error, s.
pub(super) fn after(inputs: &Inputs) -> f64 {
    let pitch = inputs.design.tracked.iter().find(|t| t.index == PITCH);
    let settled = pitch.and_then(|t| t.model).map_or(0.0, |model| SETTLED / model.frequency);
    AFTER.max(settled)
}

impl Beyond {
    /// Flies the steps at a number of speeds, up and down; none for a design that does not follow pitch.
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
                let requested = level + (FACTOR * (end - level)).clamp(-STEEPEST, STEEPEST);
                Self::flown(inputs, controller, (speed, forward), (level, end, requested))
            })
            .collect()
    }

    fn flown(
        inputs: &Inputs,
        controller: &ControllerDesign,
        (speed, forward): (f64, f64),
        (level, end, requested): (f64, f64, f64),
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
        let manoeuvre = still.with_step(SIGNALS[PITCH].name, requested - level);
        let scale = (end - level).abs();
        let lost = Self {
            speed,
            requested,
            end,
            pitch_error: f64::INFINITY,
            speed_error: f64::INFINITY,
            lost_speed: f64::INFINITY,
            remaining_error: f64::INFINITY,
        };
        // The depth is such that no climb reaches the surface.
        let depth = inputs.design.depth + 2.0 * speed.abs() * manoeuvre.duration;
        let Some(flight) = flight_from(inputs, controller, depth, &manoeuvre)? else { return Ok(lost) };
        let rows = &flight.rows;
        let held = rows.iter().rfind(|row| row.time < STEP_TIME + HELD);
        // Half the range of speed is the scale near rest.
        let size = forward.abs().max(half_range);
        let slower = |row: &Row| (forward - row.measured(SPEED)) * forward.signum() / size;
        let pitch_error = held.map_or(f64::INFINITY, |row| (row.measured(PITCH) - end).abs() / scale);
        let speed_error = held.map_or(f64::INFINITY, |row| slower(row).abs());
        let lost_speed = rows.iter().map(slower).fold(0.0, f64::max);
        let late = rows.iter().filter(|row| row.time >= STEP_TIME + HELD + after);
        let remaining_error = late.map(|row| row.error(PITCH).abs() / scale);
        Ok(Self {
            pitch_error,
            speed_error,
            lost_speed,
            remaining_error: remaining_error.fold(0.0, f64::max),
            ..lost
        })
    }
}
