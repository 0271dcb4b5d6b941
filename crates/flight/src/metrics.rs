//! Figures of a step response.

use crate::flight::Row;
use signals::{PITCH, SPEED};

/// The band around the new reference, relative to the step, within which a response counts as settled. The same as of
/// the main job, in `tools/fly/figures.py`.
pub const SETTLED: f64 = 0.02;

/// What a pitch step response amounts to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepFigures {
    /// Largest excursion beyond the new reference, relative to the step.
    pub overshoot: f64,
    /// From 10 % to 90 % of the step, s.
    pub rise_time: f64,
    /// From the step until the pitch stays within [`SETTLED`], s; infinity if it does not.
    pub settling_time: f64,
    /// Mean error over the last tenth of the record, relative to the step.
    pub steady_error: f64,
    /// Largest deviation of the speed from its reference, m/s.
    pub speed_deviation: f64,
    /// Largest use of an actuator, relative to its limits: 1 is at a limit.
    pub actuator_use: f64,
}

impl StepFigures {
    /// The figures of a flight that ended before its time: it might have left the band again, and no error is steady.
    #[must_use]
    pub fn cut_short(self) -> Self {
        let rise_time = if self.rise_time.is_finite() { self.rise_time } else { f64::NAN };
        Self { rise_time, settling_time: f64::NAN, steady_error: f64::NAN, ..self }
    }
}

/// How much of an actuator a command uses: 0 at rest, 1 at a limit. Where the range does not hold 0, rest is its
/// middle.
fn used_fraction(command: f64, low: f64, high: f64) -> f64 {
    let rest = if low <= 0.0 && high >= 0.0 { 0.0 } else { 0.5 * (low + high) };
    let room = if command >= rest { high - rest } else { rest - low };
    if room > 0.0 { (command - rest).abs() / room } else { 0.0 }
}

impl StepFigures {
    /// Of a flight that ended before the step: none is known.
    const NONE: Self = Self {
        overshoot: f64::NAN,
        rise_time: f64::NAN,
        settling_time: f64::NAN,
        steady_error: f64::NAN,
        speed_deviation: f64::NAN,
        actuator_use: f64::NAN,
    };

    /// Reads the figures off a record with one step of `height` (rad) at `step_time` (s).
    pub fn of(rows: &[Row], step_time: f64, height: f64, limits: &[(f64, f64)]) -> Self {
        let after: Vec<&Row> = rows.iter().filter(|r| r.time >= step_time).collect();
        if after.is_empty() {
            return Self::NONE;
        }
        let done = |r: &Row| 1.0 - r.error(PITCH) / height;
        let first = |level: f64| after.iter().find(|r| done(r) >= level).map_or(f64::INFINITY, |r| r.time);
        let last_outside = after.iter().rposition(|r| (done(r) - 1.0).abs() > SETTLED);
        let settling_time = match last_outside {
            Some(i) if i + 1 < after.len() => after[i + 1].time - step_time,
            Some(_) => f64::INFINITY,
            None => 0.0,
        };
        let tail = &after[after.len() - (after.len() / 10).max(1)..];
        let mean_done = tail.iter().map(|r| done(r)).sum::<f64>() / tail.len() as f64;
        let used = |r: &Row| {
            let each = r.commands.iter().zip(limits).map(|(c, (low, high))| used_fraction(*c, *low, *high));
            each.fold(0.0, f64::max)
        };
        Self {
            overshoot: after.iter().map(|r| done(r) - 1.0).fold(0.0, f64::max),
            rise_time: if first(0.9).is_finite() { first(0.9) - first(0.1) } else { f64::INFINITY },
            settling_time,
            steady_error: (1.0 - mean_done).abs(),
            speed_deviation: rows.iter().map(|r| r.error(SPEED).abs()).fold(0.0, f64::max),
            actuator_use: rows.iter().map(used).fold(0.0, f64::max),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use scheduled::Inputs;

    /// A second-order system with damping 0.5 overshoots by exp(-pi/sqrt(3)) = 16.3 %, leaves 2 % last at 8.08 s and
    /// rises in 1.64 s. The test in `tests/python/test_run.py` is of the same response.
    #[test]
    fn figures_of_a_known_response() {
        let damped = 0.75f64.sqrt();
        let wave = |t: f64| (-0.5 * t).exp() * ((damped * t).cos() + 0.5 / damped * (damped * t).sin());
        let row = |i: u32| {
            let time = 0.01 * f64::from(i);
            let reference = if time >= 5.0 { 0.2 } else { 0.0 };
            Row {
                time,
                signals: Inputs {
                    measured: [0.2 * (1.0 - if time >= 5.0 { wave(time - 5.0) } else { 1.0 }), 1.0],
                    references: [reference, 1.0],
                },
                depth: 0.0,
                rho: 0.0,
                out_of_range: false,
                commands: vec![],
            }
        };
        let rows: Vec<Row> = (0..4000).map(row).collect();
        let found = StepFigures::of(&rows, 5.0, 0.2, &[]);
        assert!((found.overshoot - (-std::f64::consts::PI / 3f64.sqrt()).exp()).abs() < 1e-4);
        assert!((found.settling_time - 8.08).abs() < 0.01, "{}", found.settling_time);
        assert!((found.rise_time - 1.64).abs() < 0.02, "{}", found.rise_time);
        assert!(found.steady_error < 1e-5);
    }

    #[test]
    fn use_is_one_at_a_limit_and_zero_at_rest() {
        assert_eq!(used_fraction(-60.0, -60.0, 100.0), 1.0);
        assert_eq!(used_fraction(50.0, -60.0, 100.0), 0.5);
        assert_eq!(used_fraction(0.0, 0.0, 20.0), 0.0);
        assert_eq!(used_fraction(10.0, 0.0, 20.0), 0.5);
        assert_eq!(used_fraction(4.0, 2.0, 4.0), 1.0);
        assert_eq!(used_fraction(3.0, 2.0, 4.0), 0.0);
    }

    /// A flight that ended at the surface: no panic, and no number for what it does not tell.
    #[test]
    fn figures_of_a_flight_that_was_cut_short() {
        assert!(StepFigures::of(&[], 5.0, 0.2, &[]).settling_time.is_nan());
        let row = Row {
            time: 6.0,
            signals: Inputs { measured: [0.01, 1.0], references: [0.2, 1.25] },
            depth: 0.1,
            rho: 0.0,
            out_of_range: false,
            commands: vec![],
        };
        let found = StepFigures::of(&[row], 5.0, 0.2, &[]);
        assert_eq!((found.rise_time, found.settling_time), (f64::INFINITY, f64::INFINITY));
        let cut = found.cut_short();
        assert!(cut.rise_time.is_nan() && cut.settling_time.is_nan() && cut.steady_error.is_nan());
        assert_eq!(cut.speed_deviation, 0.25);
    }
}
