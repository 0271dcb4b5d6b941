//! Level trim over speed, interpolated linearly.

use crate::TrimTable;
use crate::design::{OverSpeed, Port};
use squid_signals::Level;

/// Trim table.
#[derive(Debug, Clone, PartialEq)]
pub struct Trim {
    table: TrimTable,
    /// Level of each signal, with its column if it has one.
    signals: Vec<(Level, Vec<f64>)>,
}

/// Position between two rows: `(1 - fraction) row[index] + fraction row[index + 1]`.
#[derive(Debug, Clone, Copy)]
struct Position {
    index: usize,
    fraction: f64,
}

/// Limit of the extrapolation, in lengths of the first or last interval, so that no speed overflows.
pub const FARTHEST: f64 = 1e100;

impl Position {
    /// Limits the position to [`FARTHEST`] beyond the table.
    fn limited(self) -> Self {
        Self { fraction: self.fraction.clamp(-FARTHEST, FARTHEST), ..self }
    }

    fn interpolate(self, column: impl Fn(usize) -> f64) -> f64 {
        let (low, high) = (column(self.index), column(self.index + 1));
        // Exact at both ends.
        (1.0 - self.fraction) * low + self.fraction * high
    }
}

impl Trim {
    /// Creates the trim from a checked table with at least two rows and increasing speeds.
    pub(crate) fn new(table: TrimTable, signals: &[Port]) -> Self {
        let column = |name: &str| table.signals.get(name).cloned().unwrap_or_default();
        let signals = signals.iter().map(|signal| (signal.level, column(&signal.name))).collect();
        Self { table, signals }
    }

    /// Returns the speed V in m/s along the path at forward speed u in m/s; extrapolated from the first and last
    /// interval.
    pub fn speed(&self, forward_speed: f64) -> f64 {
        let speeds = &self.table.speed;
        find(&self.table.forward_speed, forward_speed).limited().interpolate(|row| speeds[row])
    }

    /// Returns the forward speed u in m/s at speed V in m/s along the path; extrapolated from the first and last
    /// interval.
    pub fn forward_speed(&self, speed: f64) -> f64 {
        find(&self.table.speed, speed).limited().interpolate(|row| self.table.forward_speed[row])
    }

    /// Returns a signal in trim at forward speed u in m/s; `start` is its value if its level is [`Level::Start`]. The
    /// trim is constant beyond the table.
    pub fn signal(&self, forward_speed: f64, signal: usize, start: f64) -> f64 {
        self.at(forward_speed).signal(signal, start)
    }

    /// Returns the number of signals of the design.
    pub fn signals(&self) -> usize {
        self.signals.len()
    }

    /// Returns the command of an actuator at forward speed u in m/s; constant beyond the table.
    pub fn command(&self, forward_speed: f64, actuator: usize) -> f64 {
        self.at(forward_speed).command(actuator)
    }

    /// Returns the trim at forward speed u in m/s, looked up once; constant beyond the table.
    pub(crate) fn at(&self, forward_speed: f64) -> AtSpeed<'_> {
        let mut position = find(&self.table.forward_speed, forward_speed);
        position.fraction = position.fraction.clamp(0.0, 1.0);
        AtSpeed { trim: self, position, forward_speed }
    }

    /// Returns the slope of the speed along the path over forward speed u in m/s, right-hand at a breakpoint.
    #[inline]
    pub fn speed_slope(&self, forward_speed: f64) -> f64 {
        let speeds = &self.table.speed;
        self.slope(find(&self.table.forward_speed, forward_speed), |row| speeds[row])
    }

    /// Returns the slope of a signal in trim over forward speed u in m/s, right-hand at a breakpoint; zero beyond the
    /// table for a column.
    #[inline]
    pub fn signal_slope(&self, forward_speed: f64, signal: usize) -> f64 {
        match &self.signals[signal] {
            (Level::Scheduled, _) => 1.0,
            (Level::Trim, column) => self.slope_within(forward_speed, |row| column[row]),
            (Level::Start | Level::Zero, _) => 0.0,
        }
    }

    /// Returns the slope of the command of an actuator over forward speed u in m/s, zero beyond the table.
    #[inline]
    pub fn command_slope(&self, forward_speed: f64, actuator: usize) -> f64 {
        self.slope_within(forward_speed, |row| self.table.actuators[row][actuator])
    }

    fn slope(&self, position: Position, column: impl Fn(usize) -> f64) -> f64 {
        let grid = &self.table.forward_speed;
        let (low, high) = (position.index, position.index + 1);
        (column(high) - column(low)) / (grid[high] - grid[low])
    }

    /// Returns a tabulated value at forward speed u in m/s; constant beyond the table.
    pub fn over(&self, forward_speed: f64, number: &OverSpeed) -> f64 {
        self.at(forward_speed).value(number)
    }

    /// Returns the slope of a tabulated value over forward speed u in m/s, zero beyond the table.
    #[inline]
    pub(crate) fn slope_of_value(&self, forward_speed: f64, number: &OverSpeed) -> f64 {
        match number {
            OverSpeed::Constant(_) => 0.0,
            OverSpeed::Table(column) => self.slope_within(forward_speed, |row| column[row]),
        }
    }

    fn slope_within(&self, forward_speed: f64, column: impl Fn(usize) -> f64) -> f64 {
        let position = find(&self.table.forward_speed, forward_speed);
        let inside = (0.0..=1.0).contains(&position.fraction);
        if inside { self.slope(position, column) } else { 0.0 }
    }
}

/// Trim at one speed.
#[derive(Debug, Clone, Copy)]
pub(crate) struct AtSpeed<'a> {
    trim: &'a Trim,
    position: Position,
    forward_speed: f64,
}

impl AtSpeed<'_> {
    /// Returns y0 of a signal; `start` is its value if its level is [`Level::Start`].
    pub(crate) fn signal(&self, signal: usize, start: f64) -> f64 {
        match &self.trim.signals[signal] {
            (Level::Scheduled, _) => self.forward_speed,
            (Level::Trim, column) => self.position.interpolate(|row| column[row]),
            (Level::Start, _) => start,
            (Level::Zero, _) => 0.0,
        }
    }

    /// Returns a tabulated value; exact where both rows have the same value.
    pub(crate) fn value(&self, number: &OverSpeed) -> f64 {
        match number {
            OverSpeed::Constant(value) => *value,
            OverSpeed::Table(column) => {
                let (low, high) = (column[self.position.index], column[self.position.index + 1]);
                low + self.position.fraction * (high - low)
            }
        }
    }

    /// Returns the command of an actuator.
    pub(crate) fn command(&self, actuator: usize) -> f64 {
        self.position.interpolate(|row| self.trim.table.actuators[row][actuator])
    }
}

fn find(grid: &[f64], value: f64) -> Position {
    let last = grid.len() - 2;
    // Trim tables are almost evenly spaced: a first guess saves most of the search.
    let fraction = (value - grid[0]) / (grid[last + 1] - grid[0]);
    let mut index = ((fraction * (last + 1) as f64) as usize).min(last);
    while index < last && grid[index + 1] <= value {
        index += 1;
    }
    while index > 0 && grid[index] > value {
        index -= 1;
    }
    let (low, high) = (grid[index], grid[index + 1]);
    Position { index, fraction: (value - low) / (high - low) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Indices of the signals of the table.
    const ANGLE: usize = 0;
    const SPEED: usize = 1;
    const DEPTH: usize = 2;
    const RATE: usize = 3;

    fn trim() -> Trim {
        let port = |name: &str, level| Port {
            name: name.to_owned(),
            unit: "1".to_owned(),
            measured: name.to_owned(),
            reference: None,
            level,
            start: 0.0,
            range: None,
            circular: false,
            nominal: 1.0,
        };
        let table = TrimTable {
            speed: vec![0.5, 1.0, 3.0],
            forward_speed: vec![0.4, 0.9, 2.9],
            signals: [("angle".to_owned(), vec![-0.1, -0.05, -0.01])].into(),
            actuators: vec![vec![1.0, 2.0], vec![3.0, 4.0], vec![7.0, 0.0]],
        };
        let signals = [
            port("angle", Level::Trim),
            port("speed", Level::Scheduled),
            port("depth", Level::Start),
            port("rate", Level::Zero),
        ];
        Trim::new(table, &signals)
    }

    #[test]
    fn is_exact_on_the_grid_and_linear_in_between() {
        for (u, v) in [(0.4, 0.5), (0.9, 1.0), (2.9, 3.0)] {
            assert_eq!(trim().speed(u), v);
            assert_eq!(trim().forward_speed(v), u);
        }
        assert_eq!((trim().command(1.9, 0), trim().command(1.9, 1)), (5.0, 2.0));
        assert!((trim().speed(0.65) - 0.75).abs() < 1e-15);
    }

    #[test]
    fn finds_any_value_in_any_grid() {
        let grid = [-1.0, -0.99, 0.0, 0.5, 7.0, 7.1];
        let known = grid.iter().flat_map(|at| [*at, at - 1e-9, at + 1e-9]);
        for value in known.chain([f64::NEG_INFINITY, -5.0, 3.0, 50.0, f64::INFINITY, f64::NAN]) {
            let above = grid.partition_point(|&point| point <= value);
            assert_eq!(find(&grid, value).index, above.clamp(1, grid.len() - 1) - 1, "{value}");
        }
    }

    #[test]
    fn slopes_are_those_of_the_intervals() {
        assert_eq!(
            (trim().speed_slope(0.65), trim().speed_slope(1.9), trim().speed_slope(9.0)),
            (1.0, 1.0, 1.0)
        );
        assert!((trim().signal_slope(0.6, ANGLE) - 0.1).abs() < 1e-15);
        assert_eq!((trim().command_slope(1.9, 0), trim().command_slope(1.9, 1)), (2.0, -2.0));
        assert_eq!((trim().command_slope(9.0, 0), trim().signal_slope(0.1, ANGLE)), (0.0, 0.0));
    }

    /// Checks each kind of level, and the slopes against central differences.
    #[test]
    fn gives_every_level() {
        let at = |speed: f64| [ANGLE, SPEED, DEPTH, RATE].map(|signal| trim().signal(speed, signal, 7.0));
        assert_eq!(at(0.4), [-0.1, 0.4, 7.0, 0.0]);
        assert_eq!(at(9.0), [-0.01, 9.0, 7.0, 0.0]);
        for speed in [0.1, 0.6, 1.9, 9.0] {
            let (high, low) = (at(speed + 1e-6), at(speed - 1e-6));
            for signal in [ANGLE, SPEED, DEPTH, RATE] {
                let slope = trim().signal_slope(speed, signal);
                assert!((slope - (high[signal] - low[signal]) / 2e-6).abs() < 1e-8, "{speed}, {signal}");
            }
        }
    }

    #[test]
    fn extrapolates_speed_and_holds_the_rest() {
        assert!((trim().speed(3.9) - 4.0).abs() < 1e-14);
        assert!((trim().speed(0.3) - 0.4).abs() < 1e-15);
        let far = [trim().speed(1e308), trim().forward_speed(1e308)];
        assert!(far.iter().all(|speed| speed.is_finite() && *speed > 1e99), "{far:?}");
        assert!(trim().speed(-1e308) < -1e99);
        assert_eq!((trim().signal(9.0, ANGLE, 0.0), trim().signal(-9.0, ANGLE, 0.0)), (-0.01, -0.1));
        assert_eq!((trim().command(9.0, 0), trim().command(9.0, 1)), (7.0, 0.0));
    }
}
