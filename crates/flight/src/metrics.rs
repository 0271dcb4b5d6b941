//! Metrics of a flight, as a control engineer reads them off a plot.

use crate::flight::{Flight, Row};
use serde::Serialize;
use squid_auv::longitudinal::{DEPTH, SPEED};

/// Settling band around the new reference, relative to the step.
pub const SETTLED: f64 = 0.02;

/// Time \[s\] after a step during which the error does not count as tracking error.
pub const GRACE: f64 = 10.0;

/// Change of the pitch reference \[rad\] within a sample above which it is a step (1 deg); ramps of the trim pitch are
/// slower.
const JUMP: f64 = std::f64::consts::PI / 180.0;

/// Change of the depth reference \[m\] within a sample above which it is a step: 2.5 m/s at 100 Hz.
const DEPTH_JUMP: f64 = 0.025;

/// Metrics of a step response.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct StepFigures {
    /// Largest excursion beyond the new reference, relative to the step.
    pub overshoot: f64,
    /// Time from 10 % to 90 % of the step, s.
    pub rise_time: f64,
    /// Time from the step until the output stays within [`SETTLED`], s; infinite if it does not.
    pub settling_time: f64,
    /// Mean error over the last tenth of the record, relative to the step.
    pub steady_error: f64,
    /// Largest deviation of the speed from its reference, m/s.
    pub speed_deviation: f64,
    /// Largest use of an actuator, relative to its limits: 1 at a limit.
    pub actuator_use: f64,
}

impl StepFigures {
    /// Unknown metrics: the flight ended before the step.
    const NONE: Self = Self {
        overshoot: f64::NAN,
        rise_time: f64::NAN,
        settling_time: f64::NAN,
        steady_error: f64::NAN,
        speed_deviation: f64::NAN,
        actuator_use: f64::NAN,
    };

    /// Returns the metrics of a record with one step at `step_time` (s) of `height`, in the unit of the signal at an
    /// index of [`squid_auv::longitudinal::SIGNALS`].
    pub fn of(rows: &[Row], index: usize, (step_time, height): (f64, f64), limits: &[(f64, f64)]) -> Self {
        let after: Vec<&Row> = rows.iter().filter(|r| r.time >= step_time).collect();
        if after.is_empty() {
            return Self::NONE;
        }
        let progress = |r: &Row| 1.0 - r.error(index) / height;
        let first =
            |level: f64| after.iter().find(|r| progress(r) >= level).map_or(f64::INFINITY, |r| r.time);
        let last_outside = after.iter().rposition(|r| (progress(r) - 1.0).abs() > SETTLED);
        let tail = &after[after.len() - (after.len() / 10).max(1)..];
        let mean_progress = tail.iter().map(|r| progress(r)).sum::<f64>() / tail.len() as f64;
        Self {
            overshoot: after.iter().map(|r| progress(r) - 1.0).fold(0.0, f64::max),
            rise_time: if first(0.9).is_finite() { first(0.9) - first(0.1) } else { f64::INFINITY },
            settling_time: last_outside
                .map_or(0.0, |last| after.get(last + 1).map_or(f64::INFINITY, |r| r.time - step_time)),
            steady_error: (1.0 - mean_progress).abs(),
            speed_deviation: speed_deviation(rows),
            actuator_use: actuator_use(rows, limits),
        }
    }

    /// Returns the metrics of a flight with one step; NaN for those unknown because the flight ended at the surface.
    pub fn of_flight(flight: &Flight, index: usize, step: (f64, f64), limits: &[(f64, f64)]) -> Self {
        let figures = Self::of(&flight.rows, index, step, limits);
        if flight.surfacing.is_some() { figures.cut_short() } else { figures }
    }

    /// Returns the metrics of a flight that ended early: settling time and steady error are unknown.
    #[must_use]
    pub fn cut_short(self) -> Self {
        let rise_time = if self.rise_time.is_finite() { self.rise_time } else { f64::NAN };
        Self { rise_time, settling_time: f64::NAN, steady_error: f64::NAN, ..self }
    }
}

/// Step of a reference, and the response to it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step {
    /// Time of the step, s.
    pub time: f64,
    /// Signed height, rad or m.
    pub height: f64,
    /// Metrics of the response up to the next step.
    pub figures: StepFigures,
}

/// Metrics of a flight.
#[derive(Debug, Clone, PartialEq)]
pub struct FlightFigures {
    /// Steps of the reference, in order.
    pub steps: Vec<Step>,
    /// Largest error \[rad or m\] after the first step, except during [`GRACE`] after each step; over the entire flight
    /// if there is no step. `None` if the flight ends before any such time.
    pub error: Option<f64>,
    /// Largest deviation of the speed from its reference, m/s.
    pub speed_deviation: f64,
    /// Largest use of an actuator, relative to its limits: 1 at a limit.
    pub actuator_use: f64,
}

impl FlightFigures {
    /// Returns the metrics of a record for the output at an index of [`squid_auv::longitudinal::SIGNALS`]. `limits` are
    /// the minimum and maximum of each command.
    #[must_use]
    pub fn of(rows: &[Row], index: usize, limits: &[(f64, f64)]) -> Self {
        let jump = |i: usize| rows[i].reference(index) - rows[i - 1].reference(index);
        let least = if index == DEPTH { DEPTH_JUMP } else { JUMP };
        let begins: Vec<usize> = (1..rows.len()).filter(|i| jump(*i).abs() > least).collect();
        let ends = begins.iter().skip(1).copied().chain([rows.len()]);
        let step = |(begin, end): (&usize, usize)| {
            let (time, height) = (rows[*begin].time, jump(*begin));
            let figures = StepFigures::of(&rows[*begin..end], index, (time, height), limits);
            Step { time, height, figures }
        };
        let steps: Vec<Step> = begins.iter().zip(ends).map(step).collect();
        Self {
            error: error(rows, index, &steps),
            steps,
            speed_deviation: speed_deviation(rows),
            actuator_use: actuator_use(rows, limits),
        }
    }
}

fn error(rows: &[Row], index: usize, steps: &[Step]) -> Option<f64> {
    let first = steps.first().map_or(f64::NEG_INFINITY, |step| step.time);
    let is_tracking =
        |time: f64| time > first && steps.iter().all(|s| time < s.time || time > s.time + GRACE);
    let errors = rows.iter().filter(|r| is_tracking(r.time)).map(|r| r.error(index).abs());
    errors.reduce(f64::max)
}

/// Returns the RMS error of the signal at an index of [`squid_auv::longitudinal::SIGNALS`], in its unit.
pub fn rms(rows: &[Row], index: usize) -> f64 {
    (rows.iter().map(|row| row.error(index).powi(2)).sum::<f64>() / rows.len() as f64).sqrt()
}

/// The integral of t |error|/step over evenly spaced rows that begin with a step of a height, s^2.
pub fn itae(rows: &[Row], index: usize, height: f64) -> f64 {
    let since = |row: &Row| row.time - rows[0].time;
    let interval = rows.get(1).map_or(0.0, since);
    rows.iter().map(|row| since(row) * (row.error(index) / height).abs() * interval).sum()
}

fn speed_deviation(rows: &[Row]) -> f64 {
    rows.iter().map(|r| r.error(SPEED).abs()).fold(0.0, f64::max)
}

fn actuator_use(rows: &[Row], limits: &[(f64, f64)]) -> f64 {
    let each = rows.iter().flat_map(|r| r.commands.iter().zip(limits));
    each.map(|(command, (low, high))| used_fraction(*command, *low, *high)).fold(0.0, f64::max)
}

/// Returns the fraction of an actuator's range that a command uses: 0 at rest, 1 at a limit. If the range does not
/// contain 0, rest is its middle.
pub fn used_fraction(command: f64, low: f64, high: f64) -> f64 {
    let rest = if low <= 0.0 && high >= 0.0 { 0.0 } else { 0.5 * (low + high) };
    let span = if command >= rest { high - rest } else { rest - low };
    if span > 0.0 { (command - rest).abs() / span } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flight::Signals;
    use squid_auv::longitudinal::PITCH;

    /// Returns a flight at constant speed, from pitch and reference (rad) over time (s).
    fn simulated(duration: f64, step: f64, at: impl Fn(f64) -> (f64, f64)) -> Vec<Row> {
        let row = |i: u32| {
            let time = step * f64::from(i);
            let (pitch, reference) = at(time);
            let signals = Signals {
                measured: std::array::from_fn(|index| [pitch, 1.0].get(index).copied().unwrap_or_default()),
                references: [reference, 1.25, 0.0],
            };
            Row {
                time,
                signals,
                used: signals.references,
                depth: 0.0,
                rho: 0.0,
                out_of_range: false,
                commands: vec![3.0],
            }
        };
        (0..(duration / step) as u32).map(row).collect()
    }

    /// An error of exp(-t) has an ITAE of 1, and is within 2 % after ln 50.
    #[test]
    fn itae_of_a_known_response() {
        let rows = simulated(30.0, 1e-3, |time| (0.2 * (1.0 - (-time).exp()), 0.2));
        assert!((itae(&rows, PITCH, 0.2) - 1.0).abs() < 1e-3);
        let found = StepFigures::of(&rows, PITCH, (0.0, 0.2), &[]);
        assert!((found.settling_time - 50f64.ln()).abs() < 2e-3 && found.overshoot == 0.0, "{found:?}");
    }

    /// A second-order system with damping 0.5 overshoots by exp(-pi/sqrt(3)) = 16.3 %, settles to 2 % in 8.08 s and
    /// rises in 1.64 s.
    #[test]
    fn metrics_of_a_second_order_response() {
        let damped = 0.75f64.sqrt();
        let wave = |t: f64| (-0.5 * t).exp() * ((damped * t).cos() + 0.5 / damped * (damped * t).sin());
        let rows = simulated(40.0, 0.01, |time| {
            if time >= 5.0 { (0.2 * (1.0 - wave(time - 5.0)), 0.2) } else { (0.0, 0.0) }
        });
        let found = FlightFigures::of(&rows, PITCH, &[]);
        let [Step { time, height, figures }] = found.steps[..] else { panic!("{found:?}") };
        assert_eq!((time, height), (5.0, 0.2));
        assert_eq!(figures, StepFigures::of(&rows, PITCH, (5.0, 0.2), &[]));
        assert!((figures.overshoot - (-std::f64::consts::PI / 3f64.sqrt()).exp()).abs() < 1e-4);
        assert!((figures.settling_time - 8.08).abs() < 0.01, "{}", figures.settling_time);
        assert!((figures.rise_time - 1.64).abs() < 0.02, "{}", figures.rise_time);
        assert!(figures.steady_error < 1e-5);
    }

    #[test]
    fn metrics_of_an_unsettled_response() {
        let rows = simulated(10.0, 0.01, |time| (0.0, if time >= 5.0 { 0.2 } else { 0.0 }));
        let [Step { figures, .. }] = FlightFigures::of(&rows, PITCH, &[]).steps[..] else { panic!() };
        assert_eq!((figures.settling_time, figures.steady_error), (f64::INFINITY, 1.0));
    }

    #[test]
    fn each_step_ends_at_the_next() {
        let reference = |time: f64| if (4.0..8.0).contains(&time) { 0.1 } else { 0.0 };
        let found = FlightFigures::of(
            &simulated(12.0, 0.5, |time| (reference(time), reference(time))),
            PITCH,
            &[(2.0, 4.0)],
        );
        assert_eq!(
            found.steps.iter().map(|s| (s.time, s.height)).collect::<Vec<_>>(),
            [(4.0, 0.1), (8.0, -0.1)]
        );
        assert!(found.steps.iter().all(|s| s.figures.overshoot == 0.0 && s.figures.settling_time == 0.0));
        assert_eq!((found.speed_deviation, found.actuator_use), (0.25, 0.0));
    }

    /// Errors right after a step or before the first step are not tracking errors.
    #[test]
    fn error_excludes_the_time_after_each_step() {
        let error = |events: &'static [f64], at: fn(f64) -> f64| {
            let reference = move |time| 0.1 * events.iter().filter(|e| time >= **e).count() as f64;
            FlightFigures::of(&simulated(30.0, 0.5, |t| (reference(t) - at(t), reference(t))), PITCH, &[])
                .error
        };
        let near = |found: Option<f64>, expected: f64| {
            assert!((found.unwrap() - expected).abs() < 1e-12, "{found:?}")
        };
        let slow = |time: f64| if (2.0..12.0).contains(&time) { 5.0 } else { 0.1 };
        near(error(&[2.0], slow), 0.1);
        near(error(&[], slow), 5.0);
        let early = |time: f64| if time < 5.0 { 3.0 } else { 0.01 };
        near(error(&[10.0], early), 0.01);
        near(error(&[10.0, 15.0], early), 0.01);
        assert_eq!(error(&[25.0], early), None);
    }

    #[test]
    fn used_fraction_is_one_at_a_limit_and_zero_at_rest() {
        assert_eq!(used_fraction(-60.0, -60.0, 100.0), 1.0);
        assert_eq!(used_fraction(50.0, -60.0, 100.0), 0.5);
        assert_eq!(used_fraction(0.0, 0.0, 20.0), 0.0);
        assert_eq!(used_fraction(10.0, 0.0, 20.0), 0.5);
        assert_eq!(used_fraction(4.0, 2.0, 4.0), 1.0);
        assert_eq!(used_fraction(3.0, 2.0, 4.0), 0.0);
    }

    /// Metrics of a flight that ended at the surface: NaN if unknown, no panic.
    #[test]
    fn metrics_of_a_flight_that_ended_early() {
        assert!(StepFigures::of(&[], PITCH, (5.0, 0.2), &[]).settling_time.is_nan());
        let row = Row { time: 6.0, ..simulated(1.0, 1.0, |_| (0.01, 0.2)).remove(0) };
        let found = StepFigures::of(&[row], PITCH, (5.0, 0.2), &[]);
        assert_eq!((found.rise_time, found.settling_time), (f64::INFINITY, f64::INFINITY));
        let cut = found.cut_short();
        assert!(cut.rise_time.is_nan() && cut.settling_time.is_nan() && cut.steady_error.is_nan());
        assert_eq!(cut.speed_deviation, 0.25);
    }
}
