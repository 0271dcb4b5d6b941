//! The course on which laws are tuned and compared at one speed: a pitch step up and down, a gust, and a speed step.

use crate::error::Error;
use crate::peers::law::{Law, fly};
use crate::subject::Subject;
use squid_auv::Current;
use squid_auv::longitudinal::{PITCH, SPEED};
use squid_auv::only;
use squid_design::check::flown::GUST;
use squid_flight::error::Error as FlightError;
use squid_flight::flight::{Course, Demand, Disturbance, Row};

/// The pitch step up (s).
const UP: f64 = 2.0;
/// The pitch step down (s).
const DOWN: f64 = 20.0;
/// The gust (s).
const GUST_AT: f64 = 34.0;
/// The speed step (s).
const SPEED_AT: f64 = 44.0;
/// The end (s).
const END: f64 = 64.0;

/// The band around the new reference, relative to the step, within which a response is settled.
const SETTLED: f64 = 0.02;

/// Figures of a step response.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step {
    /// The integral of t |error|/step (s^2). Source: D. Graham, R. Lathrop, Trans. AIEE 72, 1953.
    pub itae: f64,
    /// Overshoot relative to the step.
    pub overshoot: f64,
    /// Settling time, s; infinite if it does not settle within 2 %.
    pub settling_time: f64,
}

impl Step {
    /// The figures of a lost flight.
    const LOST: Self = Self { itae: f64::INFINITY, overshoot: f64::INFINITY, settling_time: f64::INFINITY };

    /// The figures of a window of rows that starts with the step of a reference.
    fn of(rows: &[&Row], index: usize, step: f64) -> Self {
        let Some(first) = rows.first() else { return Self::LOST };
        let since = |row: &Row| row.time - first.time;
        let left = |row: &Row| row.error(index) / step;
        let dt = rows.get(1).map_or(0.0, |second| since(second));
        let outside = rows.iter().rposition(|row| left(row).abs() > SETTLED);
        Self {
            itae: rows.iter().map(|row| since(row) * left(row).abs() * dt).sum(),
            overshoot: rows.iter().map(|row| -left(row)).fold(0.0, f64::max),
            settling_time: rows
                .get(outside.map_or(0, |last| last + 1))
                .map_or(f64::INFINITY, |row| since(row)),
        }
    }
}

/// Figures of a flight on the course; infinite if it was lost.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CourseFigures {
    /// The pitch step up.
    pub pitch: Step,
    /// The speed step.
    pub speed: Step,
    /// Largest pitch error after the gust, rad.
    pub gust: f64,
    /// Largest command, as a fraction of the range from the trim to a limit.
    pub effort: f64,
}

/// The height of the speed step (m/s) at a speed, towards the middle of the range.
pub fn speed_step(subject: &Subject, speed: f64) -> f64 {
    let (middle, half_range) = subject.inputs.design.scheduling();
    let size = (0.2 * half_range).min(0.3);
    if speed <= middle { size } else { -size }
}

/// Simulates the nominal vehicle on the course at a speed (m/s).
///
/// # Errors
/// The errors of the trim; a flight that diverges or surfaces is not an error.
pub fn fly_at(subject: &Subject, law: &dyn Law, speed: f64) -> Result<CourseFigures, Error> {
    let pitch_step = subject.stored.manoeuvre.step("pitch");
    let speed_step = speed_step(subject, speed);
    let demand = |time: f64| {
        let time = time + 1e-9;
        Demand {
            speed: if time < SPEED_AT { speed } else { speed + speed_step },
            above_trim: only(PITCH, if (UP..DOWN).contains(&time) { pitch_step } else { 0.0 }),
            disturbance: Disturbance {
                current: Current { vertical: if time < GUST_AT { 0.0 } else { GUST }, ..Current::default() },
                ..Disturbance::default()
            },
        }
    };
    let course = Course { duration: END, demand };
    let rows = match fly(subject, law, &subject.inputs.vehicle, &[], course) {
        Ok(flight) if flight.surfacing.is_none() => flight.rows,
        Ok(_) => return Ok(CourseFigures::LOST),
        Err(reason @ Error::Flight(FlightError::Trim { .. })) => return Err(reason),
        Err(_) => return Ok(CourseFigures::LOST),
    };
    let window = |from: f64, to: f64| -> Vec<&Row> {
        rows.iter().filter(|row| (from..to).contains(&(row.time + 1e-9))).collect()
    };
    Ok(CourseFigures {
        pitch: Step::of(&window(UP, DOWN), PITCH, pitch_step),
        speed: Step::of(&window(SPEED_AT, END), SPEED, speed_step),
        gust: window(GUST_AT, SPEED_AT).iter().map(|row| row.error(PITCH).abs()).fold(0.0, f64::max),
        effort: rows.iter().map(|row| effort(subject, &rows[0], row)).fold(0.0, f64::max),
    })
}

/// The largest change of a command from the start, relative to the range to its limit.
fn effort(subject: &Subject, start: &Row, row: &Row) -> f64 {
    let each = subject.inputs.vehicle.actuators.iter().zip(row.commands.iter().zip(&start.commands));
    each.map(|(a, (now, trim))| (now - trim) / if now > trim { a.max - trim } else { a.min - trim })
        .fold(0.0, f64::max)
}

impl CourseFigures {
    /// The figures of a flight that diverged or surfaced.
    pub const LOST: Self =
        Self { pitch: Step::LOST, speed: Step::LOST, gust: f64::INFINITY, effort: f64::INFINITY };
}

/// Figures of the design's manoeuvre, a pitch step during a speed ramp, and the largest speed error (m/s).
pub fn fly_ramp(subject: &Subject, law: &dyn Law) -> (Step, f64) {
    let m = &subject.stored.manoeuvre;
    let course = Course { duration: m.duration, demand: |time| Demand::of(m, time) };
    let flown = fly(subject, law, &subject.inputs.vehicle, &[], course);
    let Some(flight) = flown.ok().filter(|flight| flight.surfacing.is_none()) else {
        return (Step::LOST, f64::INFINITY);
    };
    let after: Vec<&Row> = flight.rows.iter().filter(|row| row.time + 1e-9 >= m.step_time).collect();
    let speed = flight.rows.iter().map(|row| row.error(SPEED).abs()).fold(0.0, f64::max);
    (Step::of(&after, PITCH, m.step("pitch")), speed)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The first signals; the others are 0.
    fn signals_of(first: [f64; 2]) -> squid_auv::Each<f64> {
        std::array::from_fn(|place| first.get(place).copied().unwrap_or_default())
    }

    /// An error of exp(-t) has an ITAE of 1 and is within 2 % after ln 50.
    #[test]
    fn figures_of_a_known_response() {
        let row = |i: u32| {
            let time = 1e-3 * f64::from(i);
            let signals = squid_flight::flight::Signals {
                measured: signals_of([0.2 * (1.0 - (-time).exp()), 1.0]),
                references: [0.2, 1.0, 0.0],
            };
            Row {
                time,
                signals,
                used: signals.references,
                depth: 0.0,
                rho: 0.0,
                out_of_range: false,
                commands: vec![],
            }
        };
        let rows: Vec<Row> = (0..30_000).map(row).collect();
        let found = Step::of(&rows.iter().collect::<Vec<_>>(), PITCH, 0.2);
        assert!((found.itae - 1.0).abs() < 1e-3 && found.overshoot == 0.0, "{found:?}");
        assert!((found.settling_time - 50f64.ln()).abs() < 2e-3, "{found:?}");
    }
}
