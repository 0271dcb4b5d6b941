//! Figures of a step response.

use crate::flight::Row;

/// What a pitch step response amounts to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepFigures {
    /// Largest excursion beyond the new reference, relative to the step.
    pub overshoot: f64,
    /// From 10 % to 90 % of the step, s.
    pub rise_time: f64,
    /// From the step until the pitch stays within 2 % of the step, s; infinity if it does not.
    pub settling_time: f64,
    /// Mean error over the last tenth of the record, relative to the step.
    pub steady_error: f64,
    /// Largest deviation of the speed from its reference, m/s.
    pub speed_deviation: f64,
    /// Largest use of an actuator, relative to its limits: 1 is at a limit.
    pub actuator_use: f64,
}

/// How much of an actuator a command uses: 0 at rest, 1 at a limit. Where the range does not hold 0, rest is its middle.
fn used_fraction(command: f64, low: f64, high: f64) -> f64 {
    let rest = if low <= 0.0 && high >= 0.0 { 0.0 } else { 0.5 * (low + high) };
    let room = if command >= rest { high - rest } else { rest - low };
    if room > 0.0 { (command - rest).abs() / room } else { 0.0 }
}

impl StepFigures {
    /// Reads the figures off a record with one step of `height` (rad) at `step_time` (s).
    pub fn of(rows: &[Row], step_time: f64, height: f64, limits: &[(f64, f64)]) -> Self {
        let after: Vec<&Row> = rows.iter().filter(|r| r.time >= step_time).collect();
        let done = |r: &Row| 1.0 - (r.pitch_reference - r.pitch) / height;
        let first = |level: f64| after.iter().find(|r| done(r) >= level).map_or(f64::INFINITY, |r| r.time);
        let last_outside = after.iter().rposition(|r| (done(r) - 1.0).abs() > 0.02);
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
            rise_time: first(0.9) - first(0.1),
            settling_time,
            steady_error: (1.0 - mean_done).abs(),
            speed_deviation: rows.iter().map(|r| (r.speed_reference - r.speed).abs()).fold(0.0, f64::max),
            actuator_use: rows.iter().map(used).fold(0.0, f64::max),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::used_fraction;

    #[test]
    fn use_is_one_at_a_limit_and_zero_at_rest() {
        assert_eq!(used_fraction(-60.0, -60.0, 100.0), 1.0);
        assert_eq!(used_fraction(50.0, -60.0, 100.0), 0.5);
        assert_eq!(used_fraction(0.0, 0.0, 20.0), 0.0);
        assert_eq!(used_fraction(10.0, 0.0, 20.0), 0.5);
        assert_eq!(used_fraction(4.0, 2.0, 4.0), 1.0);
        assert_eq!(used_fraction(3.0, 2.0, 4.0), 0.0);
    }
}
