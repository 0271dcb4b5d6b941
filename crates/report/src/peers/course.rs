//! Course on which laws are tuned and compared at one speed: a step up and down of the controlled output, a gust, and a
//! step of the speed, unless that is imposed.

use crate::error::Error;
use crate::peers::law::Law;
use crate::subject::Subject;
use squid_auv::Current;
use squid_design::check::flown::GUST;
use squid_flight::error::Error as FlightError;
use squid_flight::flight::{Disturbance, Flight, Row, TemporaryDisturbance, Variations};
use squid_flight::metrics::{StepFigures, itae};
use squid_scheduled::Manoeuvre;

/// Times of the step up and down (s).
const UP: f64 = 2.0;
const DOWN: f64 = 20.0;
/// Time of the gust (s).
const GUST_AT: f64 = 34.0;
/// Time of the speed step (s).
const SPEED_AT: f64 = 44.0;
/// End of the course (s).
const END: f64 = 64.0;

/// Duration of a step of the speed (s), below any sample time, and half the time by which it begins earlier.
const AT_ONCE: f64 = 1e-6;

/// Returns the height of the speed step (m/s) at a speed, towards the middle of the range.
pub fn speed_step(subject: &Subject, speed: f64) -> f64 {
    let (middle, half_range) = subject.inputs.design.scheduling();
    let size = (0.2 * half_range).min(0.3);
    if speed <= middle { size } else { -size }
}

/// Returns the manoeuvre of a design with only a step of the speed (m/s) at a time (s), by [`speed_step`].
pub fn speed_stepped(subject: &Subject, speed: f64, at: f64, duration: f64) -> Manoeuvre {
    Manoeuvre {
        speed_from: speed,
        speed_to: speed + speed_step(subject, speed),
        ramp_start: at - 2.0 * AT_ONCE,
        ramp_duration: AT_ONCE,
        duration,
        ..subject.stored.manoeuvre.without_steps()
    }
}

/// Returns the factor on the duration of a course for a reference model slower than 1 rad/s.
pub(crate) fn slowness(subject: &Subject) -> f64 {
    let design = &subject.inputs.design;
    let model = design.tracked.iter().find(|t| t.index == design.stepped()).and_then(|t| t.model);
    model.map_or(1.0, |model| (1.0 / model.frequency).max(1.0))
}

/// ITAE (s^2), settling time (s) within 2 % and overshoot (%) of a response. Source of ITAE: D. Graham, R. Lathrop,
/// Trans. AIEE 72, 1953.
type Step = [f64; 3];

/// Returns the figures of a window of rows that begins with a step of a reference.
fn step(rows: &[Row], index: usize, height: f64) -> Step {
    let start = rows.first().map_or(f64::NAN, |row| row.time);
    let found = StepFigures::of(rows, index, (start, height), &[]);
    [itae(rows, index, height), found.settling_time, 100.0 * found.overshoot]
}

fn largest(rows: &[Row], of: impl Fn(&Row) -> f64) -> f64 {
    rows.iter().map(of).fold(0.0, f64::max)
}

/// Returns the gust across the path that acts on an axis; `None` if no gust does.
fn gust(subject: &Subject) -> Option<Current> {
    let moves = |symbol: &str| subject.inputs.design.states.iter().any(|state| state.symbol == symbol);
    match () {
        () if moves("w") => Some(Current { vertical: GUST, ..Current::default() }),
        () if moves("v") => Some(Current { east: GUST, ..Current::default() }),
        () => None,
    }
}

/// Simulates a law; `None` if the vehicle is lost.
fn flown(
    law: &Law,
    manoeuvre: &Manoeuvre,
    disturbances: &[TemporaryDisturbance],
) -> Result<Option<Flight>, Error> {
    let variations = Variations { disturbances, ..Variations::default() };
    match law.fly(&law.subject.inputs.vehicle, manoeuvre, &variations) {
        Ok(flight) => Ok(Some(flight).filter(|flight| flight.surfacing.is_none())),
        Err(reason @ Error::Flight(FlightError::Trim { .. })) => Err(reason),
        Err(_) => Ok(None),
    }
}

/// Returns the figures of a law at a speed (m/s) on the course of a design: of the step up and of the speed step, the
/// largest error after the gust (in the unit of the displayed step), and the largest command (% of the range from the
/// trim to a limit). NaN for a speed that the law does not track and a gust that does not act on the axis; infinite if
/// the vehicle is lost.
///
/// # Errors
/// Errors of the trim.
pub(crate) fn fly_at(first: &Subject, law: &Law, speed: f64) -> Result<[f64; 8], Error> {
    let (own, scale) = (first.step(), slowness(first));
    let tracked = law.subject.inputs.design.tracked_speed().is_some();
    let scheduled = law.subject.inputs.design.interface.scheduled().filter(|_| tracked);
    let [up, down, gust_at, speed_at, end] = [UP, DOWN, GUST_AT, SPEED_AT, END].map(|time| scale * time);
    let duration = if tracked { end } else { speed_at };
    let faster = speed_stepped(first, speed, speed_at, duration);
    let stepped = first.stepped(speed, (up, down), duration);
    let manoeuvre = Manoeuvre { steps: stepped.steps, step_time: up, step_end: down, ..faster };
    let water = gust(law.subject);
    let current = water.unwrap_or_default();
    let spell = TemporaryDisturbance::lasting(Disturbance { current, ..Disturbance::default() }, gust_at);
    let rows = flown(law, &manoeuvre, &[spell])?.map(|flight| flight.rows);
    let window = |from: f64, to: f64| {
        let rows = rows.as_deref()?;
        let index = |time: f64| rows.partition_point(|row| row.time + 1e-9 < time);
        rows.get(index(from)..index(to))
    };
    let lost = [f64::INFINITY; 3];
    let [itae, settled, overshoot] = window(up, down).map_or(lost, |rows| step(rows, own.index, own.height));
    let of_speed =
        |index| window(speed_at, end + 1.0).map_or(lost, |rows| step(rows, index, speed_step(first, speed)));
    let [speed_itae, speed_settled, speed_overshoot] = scheduled.map_or([f64::NAN; 3], of_speed);
    let error = |row: &Row| own.factor * row.error(own.index).abs();
    let peak = || window(gust_at, speed_at).map_or(f64::INFINITY, |rows| largest(rows, error));
    let effort = window(0.0, end + 1.0)
        .map_or(f64::INFINITY, |rows| 100.0 * largest(rows, |row| effort(law.subject, &rows[0], row)));
    let gusted = water.map_or(f64::NAN, |_| peak());
    Ok([itae, settled, overshoot, speed_itae, speed_settled, speed_overshoot, gusted, effort])
}

/// Returns the largest change of a command from the start, relative to the range to its limit.
fn effort(subject: &Subject, start: &Row, row: &Row) -> f64 {
    let each = subject.inputs.vehicle.actuators.iter().zip(row.commands.iter().zip(&start.commands));
    each.map(|(a, (now, trim))| (now - trim) / if now > trim { a.max - trim } else { a.min - trim })
        .fold(0.0, f64::max)
}

/// Returns the figures of the step of the design's manoeuvre, during its speed ramp, and the largest speed error (m/s);
/// NaN for a speed that the law does not track.
///
/// # Errors
/// Errors of the trim.
pub(crate) fn fly_ramp(first: &Subject, law: &Law) -> Result<[f64; 4], Error> {
    let (own, manoeuvre) = (first.step(), &first.stored.manoeuvre);
    let design = &law.subject.inputs.design;
    let tracked = design.interface.scheduled().filter(|_| design.tracked_speed().is_some());
    let Some(Flight { rows, .. }) = flown(law, manoeuvre, &[])? else {
        return Ok([
            f64::INFINITY,
            f64::INFINITY,
            f64::INFINITY,
            tracked.map_or(f64::NAN, |_| f64::INFINITY),
        ]);
    };
    let from = rows.partition_point(|row| row.time + 1e-9 < manoeuvre.step_time);
    let [itae, settled, overshoot] = step(&rows[from..], own.index, own.height);
    let off = tracked.map_or(f64::NAN, |index| largest(&rows, |row| row.error(index).abs()));
    Ok([itae, settled, overshoot, off])
}
