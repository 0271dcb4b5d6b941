//! Level trim over speed, interpolated linearly.

use crate::TrimTable;
use signals::{Each, measured};

/// The trim table.
#[derive(Debug, Clone, PartialEq)]
pub struct Trim {
    table: TrimTable,
}

/// A position between two rows: `(1 - fraction) row[index] + fraction row[index + 1]`.
#[derive(Debug, Clone, Copy)]
struct Place {
    index: usize,
    fraction: f64,
}

/// Limit of the extrapolation, in lengths of the first or last interval, so that no speed overflows.
pub const FARTHEST: f64 = 1e100;

impl Place {
    /// This place, limited to [`FARTHEST`] beyond the table.
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
    /// A checked table with at least two rows and increasing speeds.
    pub(crate) fn new(table: TrimTable) -> Self {
        Self { table }
    }

    /// Speed V in m/s along the path at forward speed u in m/s; extrapolated from the first and last interval.
    pub fn speed(&self, forward_speed: f64) -> f64 {
        let speeds = &self.table.speed;
        find(&self.table.forward_speed, forward_speed).limited().interpolate(|row| speeds[row])
    }

    /// Forward speed u in m/s at speed V in m/s along the path; extrapolated from the first and last interval.
    pub fn forward_speed(&self, speed: f64) -> f64 {
        find(&self.table.speed, speed).limited().interpolate(|row| self.table.forward_speed[row])
    }

    /// Pitch angle in rad at forward speed u in m/s; constant beyond the table.
    pub fn pitch(&self, forward_speed: f64) -> f64 {
        self.level(forward_speed).pitch()
    }

    /// Command of one actuator at forward speed u in m/s; constant beyond the table.
    pub fn command(&self, forward_speed: f64, actuator: usize) -> f64 {
        self.level(forward_speed).command(actuator)
    }

    /// Each signal in level flight at forward speed u in m/s and at a depth in m; the pitch angle is constant beyond
    /// the table.
    pub fn signals(&self, forward_speed: f64, depth: f64) -> Each<f64> {
        self.level(forward_speed).signals(depth)
    }

    /// Level flight at forward speed u in m/s, looked up once; constant beyond the table.
    pub(crate) fn level(&self, forward_speed: f64) -> Level<'_> {
        let mut place = find(&self.table.forward_speed, forward_speed);
        place.fraction = place.fraction.clamp(0.0, 1.0);
        Level { table: &self.table, place, forward_speed }
    }

    /// Slope of the speed along the path over forward speed u in m/s, right-hand at a corner.
    #[inline]
    pub fn speed_slope(&self, forward_speed: f64) -> f64 {
        let speeds = &self.table.speed;
        self.slope(find(&self.table.forward_speed, forward_speed), |row| speeds[row])
    }

    /// Slope of the pitch angle over forward speed u in rad s/m, zero beyond the table.
    #[inline]
    pub fn pitch_slope(&self, forward_speed: f64) -> f64 {
        self.slope_within(forward_speed, |row| self.table.pitch[row])
    }

    /// Slope of each signal in level flight over forward speed u in m/s, right-hand at a corner.
    #[inline]
    pub fn signal_slopes(&self, forward_speed: f64) -> Each<f64> {
        let (pitch, slope) = (self.pitch(forward_speed), self.pitch_slope(forward_speed));
        let heave = pitch.tan() + forward_speed * slope / pitch.cos().powi(2);
        measured([1.0, heave, 0.0, slope, 0.0])
    }

    /// Slope of the command of one actuator over forward speed u in m/s, zero beyond the table.
    #[inline]
    pub fn command_slope(&self, forward_speed: f64, actuator: usize) -> f64 {
        self.slope_within(forward_speed, |row| self.table.actuators[row][actuator])
    }

    fn slope(&self, place: Place, column: impl Fn(usize) -> f64) -> f64 {
        let grid = &self.table.forward_speed;
        let (low, high) = (place.index, place.index + 1);
        (column(high) - column(low)) / (grid[high] - grid[low])
    }

    fn slope_within(&self, forward_speed: f64, column: impl Fn(usize) -> f64) -> f64 {
        let place = find(&self.table.forward_speed, forward_speed);
        let inside = (0.0..=1.0).contains(&place.fraction);
        if inside { self.slope(place, column) } else { 0.0 }
    }
}

/// Level flight at one speed.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Level<'a> {
    table: &'a TrimTable,
    place: Place,
    forward_speed: f64,
}

impl Level<'_> {
    /// Each signal at a depth in m: y0 = C x0 with x0 = [u, u tan(theta), 0, theta, depth], the path being level.
    pub(crate) fn signals(&self, depth: f64) -> Each<f64> {
        let pitch = self.pitch();
        measured([self.forward_speed, self.forward_speed * pitch.tan(), 0.0, pitch, depth])
    }

    /// Pitch angle in rad.
    pub(crate) fn pitch(&self) -> f64 {
        self.place.interpolate(|row| self.table.pitch[row])
    }

    /// Command of one actuator.
    pub(crate) fn command(&self, actuator: usize) -> f64 {
        self.place.interpolate(|row| self.table.actuators[row][actuator])
    }
}

fn find(grid: &[f64], value: f64) -> Place {
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
    Place { index, fraction: (value - low) / (high - low) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn trim() -> Trim {
        Trim::new(TrimTable {
            speed: vec![0.5, 1.0, 3.0],
            forward_speed: vec![0.4, 0.9, 2.9],
            pitch: vec![-0.1, -0.05, -0.01],
            actuators: vec![vec![1.0, 2.0], vec![3.0, 4.0], vec![7.0, 0.0]],
        })
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
    fn any_value_is_found_in_any_grid() {
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
        assert!((trim().pitch_slope(0.6) - 0.1).abs() < 1e-15);
        assert_eq!((trim().command_slope(1.9, 0), trim().command_slope(1.9, 1)), (2.0, -2.0));
        assert_eq!((trim().command_slope(9.0, 0), trim().pitch_slope(0.1)), (0.0, 0.0));
    }

    /// [pitch, speed, depth, pitch rate, heave] on a level path; the slopes agree with central differences.
    #[test]
    fn level_flight_gives_every_signal() {
        assert_eq!(trim().signals(0.4, 7.0), [-0.1, 0.4, 7.0, 0.0, 0.4 * (-0.1f64).tan()]);
        assert_eq!(trim().signals(9.0, 7.0), [-0.01, 9.0, 7.0, 0.0, 9.0 * (-0.01f64).tan()]);
        for speed in [0.1, 0.6, 1.9, 9.0] {
            let (high, low) = (trim().signals(speed + 1e-6, 7.0), trim().signals(speed - 1e-6, 7.0));
            for (place, slope) in trim().signal_slopes(speed).into_iter().enumerate() {
                assert!((slope - (high[place] - low[place]) / 2e-6).abs() < 1e-8, "{speed}, {place}");
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
        assert_eq!((trim().pitch(9.0), trim().pitch(-9.0)), (-0.01, -0.1));
        assert_eq!((trim().command(9.0, 0), trim().command(9.0, 1)), (7.0, 0.0));
    }
}
