//! Stability margins of a sampled loop.
//!
//! The loop is opened at one point, where the return ratio L follows from the sensitivity: `S = 1/(1 + L)`, `L = 1/S -
//! 1`. With `z = exp(j w T)`, w up to pi/T:
//!
//! ```text
//! gain    1/|L| where L is real and negative: the factors on the loop gain at which L passes through the point -1
//! phase   |arg(-L)| where |L| = 1
//! delay   (arg(-L) in [0, 2 pi))/w where |L| = 1: the least tau at which exp(-j w tau) L is -1
//! disk    alpha = 1/sup|S - 1/2|: stable for every factor (1 + d)/(1 - d) on the loop, d complex and dynamic,
//!         |d| < alpha/2: gains from (2 - alpha)/(2 + alpha) to (2 + alpha)/(2 - alpha), phases up to 2 atan(alpha/2)
//! ```
//!
//! Source of the (symmetric) disk margin: P. Seiler, A. Packard, P. Gahinet, "An Introduction to Disk Margins", IEEE
//! Control Systems Magazine 40(5), 2020, theorem 1.

use nalgebra::{Complex, DMatrix};
use squid_lpv::matrix::{complex_eigenvalues, largest};
use squid_lpv::state_space::StateSpace;
use std::f64::consts::{PI, TAU};
use std::ops::Range;

/// Number of frequencies at which a loop is evaluated, in addition to those of its modes; crossings and peaks are
/// refined between them.
const FREQUENCIES: usize = 300;
/// Lowest nonzero frequency, relative to the highest, pi/T.
const LOWEST: f64 = 1e-6;
/// Number of bisections of a crossing, and of refinements of a peak.
const BISECTIONS: u32 = 24;

/// Margins at one point of a loop; infinite if no such change makes it unstable.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Margins {
    /// Least factor above 1 on the gain that makes the loop unstable.
    pub gain_up: f64,
    /// Largest factor below 1 on the gain that makes the loop unstable; 0 if there is none.
    pub gain_down: f64,
    /// Phase margin, rad.
    pub phase: f64,
    /// Delay margin, s.
    pub delay: f64,
    /// Disk margin alpha.
    pub disk: f64,
}

impl Margins {
    /// Returns the phase margin guaranteed by the disk margin, rad.
    pub fn disk_phase(&self) -> f64 {
        2.0 * (0.5 * self.disk).atan()
    }

    /// Updates the gain margins by a point of L on the real axis.
    fn update_gain(&mut self, l: Complex<f64>) {
        let factor = -1.0 / l.re;
        if factor > 1.0 {
            self.gain_up = self.gain_up.min(factor);
        } else if factor > 0.0 {
            self.gain_down = self.gain_down.max(factor);
        }
    }
}

/// Stable sampled loop, and the points at which it can be opened.
#[derive(Debug, Clone)]
pub struct Opened {
    /// Sensitivity `S = (I + L)^-1` at all points: from a signal added at each to the sum there. An entry of its
    /// diagonal is the sensitivity at one point with the loop closed at the others.
    sensitivity: StateSpace,
    /// Sample time, s.
    sample_time: f64,
    /// S over a grid of frequencies (rad/s).
    grid: Vec<(f64, Response)>,
}

type Response = DMatrix<Complex<f64>>;

impl Opened {
    /// Evaluates this sensitivity at all points over a grid of frequencies, for this sample time (s).
    pub fn new(sensitivity: StateSpace, sample_time: f64) -> Self {
        let mut opened = Self { sensitivity, sample_time, grid: vec![] };
        let highest = PI / sample_time;
        let at = |k: usize| highest * LOWEST.powf(1.0 - k as f64 / (FREQUENCIES - 1) as f64);
        let modes = opened.sensitivity.poles().into_iter().map(|z| z.ln().norm() / sample_time);
        let modes = modes.filter(|omega| *omega < highest);
        let mut all: Vec<f64> = std::iter::once(0.0).chain((0..FREQUENCIES).map(at)).chain(modes).collect();
        all.sort_by(f64::total_cmp);
        opened.grid =
            all.iter().map(|omega| (*omega, opened.response(&opened.sensitivity, *omega))).collect();
        opened
    }

    /// Frequency response of a system; NaN at a pole.
    fn response(&self, system: &StateSpace, omega: f64) -> Response {
        let response = system.response((Complex::new(0.0, omega) * self.sample_time).exp());
        response.unwrap_or_else(|| Response::from_element(system.d.nrows(), system.d.ncols(), NOT_A_NUMBER))
    }

    /// Returns the margins at one point with the loop closed at the others.
    pub fn margins(&self, index: usize) -> Margins {
        let alone = self.sensitivity.part(index, index);
        let l = |omega: f64| 1.0 / self.response(&alone, omega)[(0, 0)] - 1.0;
        let mut margins = Margins {
            gain_up: f64::INFINITY,
            gain_down: 0.0,
            phase: f64::INFINITY,
            delay: f64::INFINITY,
            disk: 1.0 / self.peak(index, 0.5),
        };
        let known: Vec<(f64, Complex<f64>)> =
            self.grid.iter().map(|(omega, s)| (*omega, 1.0 / s[(index, index)] - 1.0)).collect();
        for pair in known.windows(2) {
            let [(low, at_low), (high, at_high)] = [pair[0], pair[1]];
            if (at_low.norm() > 1.0) != (at_high.norm() > 1.0) {
                let omega = crossing(low, high, |omega| l(omega).norm() > 1.0);
                let lag = lag(l(omega));
                margins.phase = margins.phase.min(lag.min(TAU - lag));
                margins.delay = margins.delay.min(lag / omega);
            }
            if (at_low.im > 0.0) != (at_high.im > 0.0) && at_low.re.min(at_high.re) < 0.0 {
                margins.update_gain(l(crossing(low, high, |omega| l(omega).im > 0.0)));
            }
        }
        // L is real at both ends.
        known.first().into_iter().chain(known.last()).for_each(|(_, l)| margins.update_gain(*l));
        margins
    }

    /// Returns the largest |S| over all points, opened one at a time.
    pub fn peak_of_sensitivity(&self) -> f64 {
        let points = 0..self.sensitivity.d.nrows();
        largest(0.0, points.map(|point| self.peak(point, 0.0)))
    }

    /// Largest `|S - c|` at a point.
    fn peak(&self, index: usize, c: f64) -> f64 {
        let alone = self.sensitivity.part(index, index);
        let at = |omega: f64| (self.response(&alone, omega)[(0, 0)] - c).norm();
        let known: Vec<f64> = self.grid.iter().map(|(_, s)| (s[(index, index)] - c).norm()).collect();
        let Some(most) = (0..known.len()).max_by(|i, j| known[*i].total_cmp(&known[*j])) else {
            return f64::NAN;
        };
        let (mut best, mut peak) = (self.grid[most].0, known[most]);
        let mut step = self.grid[(most + 1).min(known.len() - 1)].0 - self.grid[most.saturating_sub(1)].0;
        for _ in 0..BISECTIONS {
            step *= 0.5;
            for omega in [best - step, best + step] {
                let value = at(omega);
                (best, peak) = if value > peak { (omega, value) } else { (best, peak) };
            }
        }
        peak
    }

    /// Returns the smallest common delay \[s\] at some points that makes the loop unstable: an eigenvalue of `exp(-j w
    /// tau) L` is then -1.
    pub fn common_delay(&self, points: Range<usize>) -> f64 {
        let block = self.sensitivity.parts(points.clone(), points.clone());
        let of = |s: &Response| -> Vec<Complex<f64>> {
            let l = s.clone().try_inverse().map(|inverse| inverse - Response::identity(s.nrows(), s.nrows()));
            let mut values = l.map_or(vec![], |l| complex_eigenvalues(&l));
            values.sort_by(|a, b| a.norm().total_cmp(&b.norm()));
            values
        };
        let at = |omega: f64| of(&self.response(&block, omega));
        let within = |s: &Response| s.rows_range(points.clone()).columns_range(points.clone()).into_owned();
        let larger = |values: &[Complex<f64>], k: usize| values.get(k).is_some_and(|v| v.norm() > 1.0);
        let known: Vec<(f64, Vec<Complex<f64>>)> =
            self.grid.iter().map(|(omega, s)| (*omega, of(&within(s)))).collect();
        let mut least = f64::INFINITY;
        for pair in known.windows(2) {
            let [(low, at_low), (high, at_high)] = [&pair[0], &pair[1]];
            for k in (0..at_low.len()).filter(|k| larger(at_low, *k) != larger(at_high, *k)) {
                let omega = crossing(*low, *high, |omega| larger(&at(omega), k));
                least = at(omega).get(k).map_or(least, |l| least.min(lag(*l) / omega));
            }
        }
        least
    }
}

const NOT_A_NUMBER: Complex<f64> = Complex::new(f64::NAN, f64::NAN);

/// Frequency between two others at which a condition changes.
fn crossing(mut low: f64, mut high: f64, condition: impl Fn(f64) -> bool) -> f64 {
    let first = condition(low);
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (low + high);
        if condition(middle) == first { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// Clockwise rotation of a point onto the negative real axis, from 0 to 2 pi.
fn lag(l: Complex<f64>) -> f64 {
    (-l).arg().rem_euclid(TAU)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::dmatrix;

    const T: f64 = 0.01;

    /// S = 1/(1 + L) of a sampled integrator with a hold, L = k T/(z - 1) = g/(z - 1): S = (z - 1)/(z - 1 + g).
    fn integrator(g: f64) -> StateSpace {
        StateSpace { a: dmatrix![1.0 - g], b: dmatrix![1.0], c: dmatrix![-g], d: dmatrix![1.0] }
    }

    /// |L| = 1 at 2 sin(w T/2) = g, where arg L = -pi/2 - w T/2; L(-1) = -g/2; S - 1/2 = (z - 1 - g)/(2 (z - 1 + g)) is
    /// largest at z = -1.
    #[test]
    fn margins_of_a_sampled_integrator() {
        let g = 0.3;
        let found = Opened::new(integrator(g), T).margins(0);
        let crossover = 2.0 * (0.5 * g).asin() / T;
        let phase = 0.5 * PI - 0.5 * crossover * T;
        assert!((found.phase - phase).abs() < 1e-6, "{found:?}");
        assert!((found.delay - phase / crossover).abs() < 1e-6, "{found:?}");
        assert!((found.gain_up - 2.0 / g).abs() < 1e-9 && found.gain_down == 0.0, "{found:?}");
        assert!((found.disk - 2.0 * (2.0 - g) / (2.0 + g)).abs() < 1e-8, "{found:?}");
        assert!((Opened::new(integrator(g), T).common_delay(0..1) - found.delay).abs() < 1e-9);
        // S = (z - 1)/(z - 1 + g) is largest at z = -1, too.
        assert!((Opened::new(integrator(g), T).peak_of_sensitivity() - 2.0 / (2.0 - g)).abs() < 1e-9);
        // The disk lies within the gain and phase margins.
        assert!(
            found.disk_phase() <= found.phase && (2.0 + found.disk) / (2.0 - found.disk) <= found.gain_up
        );
    }

    /// L = g/(z - a), a > 1, is unstable below g = a - 1 and above a + 1.
    #[test]
    fn unstable_plant_has_least_gain() {
        let (a, g) = (1.1, 0.4);
        let s = StateSpace { a: dmatrix![a - g], b: dmatrix![1.0], c: dmatrix![-g], d: dmatrix![1.0] };
        let found = Opened::new(s, T).margins(0);
        assert!((found.gain_up - (a + 1.0) / g).abs() < 1e-9, "{found:?}");
        assert!((found.gain_down - (a - 1.0) / g).abs() < 1e-9, "{found:?}");
    }

    /// Two decoupled loops: the faster one limits the delay. An orthogonal similarity transform keeps the eigenvalues.
    #[test]
    fn common_delay_is_least_delay_of_eigenvalues() {
        let rotation = dmatrix![0.8, -0.6; 0.6, 0.8];
        let gains = dmatrix![0.1, 0.0; 0.0, 0.3];
        let g = &rotation * gains * rotation.transpose();
        let one = DMatrix::identity(2, 2);
        let s = StateSpace { a: &one - &g, b: one.clone(), c: -&g, d: one };
        let each = Opened::new(integrator(0.3), T).margins(0).delay;
        assert!((Opened::new(s, T).common_delay(0..2) - each).abs() < 1e-8);
    }

    /// A mode with damping 1e-4 between two frequencies of the grid: the peak is that of the H-infinity norm.
    #[test]
    fn disk_margin_resolves_narrow_peak() {
        let (radius, angle) = ((-1e-4f64 * 0.0777).exp(), 0.0777f64);
        let a =
            dmatrix![radius * angle.cos(), -radius * angle.sin(); radius * angle.sin(), radius * angle.cos()];
        let s = StateSpace { a, b: dmatrix![1e-4; 0.0], c: dmatrix![0.0, 1.0], d: dmatrix![1.0] };
        let half = StateSpace { d: dmatrix![0.5], ..s.clone() }.from_circle_to_axis().unwrap();
        let found = Opened::new(s, T).margins(0).disk;
        let expected = 1.0 / half.hinf_norm().value;
        assert!((found - expected).abs() < 1e-6 * expected, "{found} {expected}");
    }

    /// A loop whose gain never reaches 1 cannot be made unstable by delay.
    #[test]
    fn a_weak_loop_has_no_delay_margin() {
        let s =
            StateSpace { a: dmatrix![0.9 - 0.05], b: dmatrix![1.0], c: dmatrix![-0.05], d: dmatrix![1.0] };
        let found = Opened::new(s, T).margins(0);
        assert_eq!((found.delay, found.phase), (f64::INFINITY, f64::INFINITY));
        assert!((found.gain_up - 1.9 / 0.05).abs() < 1e-9, "{found:?}");
    }
}
