//! The gain of a closed loop for every trajectory of Theta and Delta, and the largest size of Delta for a gain.
//!
//! The inequality is that of [`crate::analysis::bounded_gain()`]; a starting point is computed here, since no synthesis
//! provides one.

use crate::analysis::bounded_gain::{Base, GAMMA_SHARE, search, with_largest_margin, worst_eigenvalue};
use crate::analysis::gain_bound::GainBound;
use crate::matrix::{Mat, diagonal};
use crate::robust::uncertain_plant::UncertainPlant;
use crate::system::{ClosedLoop, Controller, Group, LoopError, Sizes};
use nalgebra::Complex;
use std::ops::Range;

/// A gain for every trajectory of Theta and of Delta up to a size.
#[derive(Debug, Clone, PartialEq)]
pub struct RobustBound {
    /// The size of Delta.
    pub size: f64,
    /// The bound; channels ordered Theta's and Delta's of the plant, then the controller's.
    pub bound: GainBound,
}

/// A closed loop with the uncertainty of its plant.
#[derive(Debug, Clone, Copy)]
pub struct RobustLoop<'a> {
    uncertain: &'a UncertainPlant,
    controller: &'a Controller,
}

/// The relative tolerances of gamma: in intermediate steps, and at the end.
const ROUGH_TOLERANCE: f64 = 0.1;
const FINE_TOLERANCE: f64 = 0.01;

/// The number of restarts, each in the coordinates of the last point.
const MOST_RESTARTS: usize = 3;

/// The size of all of the declared uncertainty, which limits the search.
pub const FULL_SIZE: f64 = 1.0;

/// The size of a first bound, and the largest number of halvings of one that is too large.
const FIRST_SIZE: f64 = 0.05;
const MOST_HALVINGS: i32 = 20;

/// The number of sizes tried for a first bound, each a tenth of the previous one.
const MOST_FIRST_SIZES: i32 = 4;

/// Scalings of a first S, tried if the search from it fails.
const FIRST_SCALES: [f64; 5] = [1.0, 0.1, 10.0, 0.01, 100.0];

/// The factor by which gamma is raised until a size is reached, and the largest number of increases.
const GAMMA_RAISE: f64 = 1.5;
const MOST_RAISES: usize = 6;

impl<'a> RobustLoop<'a> {
    /// Builds the loop that a controller closes.
    pub fn new(uncertain: &'a UncertainPlant, controller: &'a Controller) -> Self {
        Self { uncertain, controller }
    }

    /// Returns a bound at a small size, started from the Lyapunov matrix of a known bound of the loop, with the largest
    /// margin at `gamma`; `None` if none was found.
    pub fn at_small_size(&self, known: &GainBound, gamma: f64) -> Option<RobustBound> {
        let first = |size: f64| {
            let s = balanced(&self.closed(size), gamma);
            let from = |scale: &f64| {
                let guess = self.guess(known, &s * *scale);
                self.searched(&RobustBound { size, ..guess }, ROUGH_TOLERANCE)
            };
            FIRST_SCALES.iter().filter_map(from).find(|b| b.bound.gamma < gamma)
        };
        let mut sizes = (0..MOST_FIRST_SIZES).map(|k| FIRST_SIZE * 0.1f64.powi(k));
        self.with_margin(&sizes.find_map(first)?, gamma)
    }

    /// Returns a bound at size 1, started from the Lyapunov matrix of a known bound; `None` if none was found.
    pub fn bound(&self, known: &GainBound) -> Option<RobustBound> {
        let s = balanced(&self.closed(1.0), FIRST_GAMMA_FACTOR * known.gamma);
        let first = |scale: &f64| self.searched(&self.guess(known, &s * *scale), ROUGH_TOLERANCE);
        Some(self.tightened(FIRST_SCALES.iter().find_map(first)?))
    }

    /// Returns a starting point: the Lyapunov matrix of a known bound, with an S.
    fn guess(&self, known: &GainBound, s: Mat) -> RobustBound {
        let (gamma, t) = (FIRST_GAMMA_FACTOR * known.gamma, Mat::zeros(s.nrows(), s.nrows()));
        RobustBound { size: 1.0, bound: GainBound { gamma, s, t, lambda: 0.0, ..known.clone() } }
    }

    /// Returns the largest size, up to that of the bound, at which its multipliers prove gamma; `None` if there is
    /// none.
    pub fn at_gamma(&self, known: &RobustBound, gamma: f64) -> Option<RobustBound> {
        let bound = GainBound { gamma, ..known.bound.clone() };
        let at = RobustBound { size: known.size, bound };
        let sizes = (0..MOST_HALVINGS).map(|k| at.size * 0.5f64.powi(k));
        sizes.map(|size| self.resized(&at, size)).find(|b| b.bound.largest_eigenvalue < 0.0)
    }

    /// Returns the bound at another size, started from a known one.
    pub fn at_size(&self, known: &RobustBound, size: f64) -> Option<RobustBound> {
        let mut at = known.clone();
        for _ in 0..MOST_RAISES {
            if at.size >= size {
                let smaller = self.resized(&at, size);
                return (smaller.bound.largest_eigenvalue < 0.0).then(|| self.tightened(smaller));
            }
            at.bound.gamma *= GAMMA_RAISE;
            at = self.widened(&at, size);
        }
        None
    }

    /// Returns the largest size, up to about [`FULL_SIZE`], at which the gain stays below `gamma`, within a few per
    /// cent, and the bound there. `None` if the known multipliers prove it at no size.
    pub fn largest_size(&self, known: &RobustBound, gamma: f64) -> Option<RobustBound> {
        let found = self.widened(&self.at_gamma(known, gamma)?, FULL_SIZE);
        let full = self.resized(&found, FULL_SIZE);
        let is_larger = found.size > FULL_SIZE && full.bound.largest_eigenvalue < 0.0;
        Some(if is_larger { full } else { found })
    }

    fn tightened(&self, mut at: RobustBound) -> RobustBound {
        for _ in 0..MOST_RESTARTS {
            // A rougher search ends farther in the interior, where a finer one may be lost in rounding.
            let found =
                [FINE_TOLERANCE, ROUGH_TOLERANCE].into_iter().find_map(|within| self.searched(&at, within));
            match found {
                Some(next) if next.bound.gamma < at.bound.gamma => {
                    let settled = next.bound.gamma > (1.0 - 0.1 * FINE_TOLERANCE) * at.bound.gamma;
                    at = next;
                    if settled {
                        break;
                    }
                }
                _ => break,
            }
        }
        at
    }

    fn searched(&self, at: &RobustBound, tolerance: f64) -> Option<RobustBound> {
        let closed = self.closed(at.size);
        let base = Base { closed: &closed, error: &LoopError::none(&closed), bound: &at.bound };
        let (bound, _) = search(base, tolerance).ok()?;
        (bound.largest_eigenvalue < 0.0).then_some(RobustBound { size: at.size, bound })
    }

    /// Returns a bound at the same size with the largest margin at a gamma 1 % larger, for a proof.
    pub fn with_raised_gamma(&self, at: &RobustBound) -> Option<RobustBound> {
        self.with_margin(at, (1.0 + GAMMA_SHARE) * at.bound.gamma)
    }

    /// Returns a bound at the same size with the largest margin at a larger gamma.
    fn with_margin(&self, at: &RobustBound, gamma: f64) -> Option<RobustBound> {
        let closed = self.closed(at.size);
        let given = GainBound { gamma, ..at.bound.clone() };
        let bound = with_largest_margin(&closed, &LoopError::none(&closed), &given)?;
        Some(RobustBound { size: at.size, bound })
    }

    /// Returns S and T of Delta. Each is square, with one row per channel of Delta.
    pub fn multipliers_of_delta(&self, bound: &GainBound) -> (Mat, Mat) {
        let (r, k) = (self.of_delta().start, self.of_delta().len());
        let part = |m: &Mat| m.view((r, r), (k, k)).into_owned();
        (part(&bound.s), part(&bound.t))
    }

    /// Returns the bound of the loop proved through [`UncertainPlant::weighted`] with the multipliers S and T of Delta,
    /// at its `size` and `gamma`; if the proved gain is above 1, only an estimate.
    pub fn from_weighted(&self, shown: &GainBound, size: f64, gamma: f64, s: &Mat, t: &Mat) -> RobustBound {
        let (r, k) = (self.uncertain.scheduled_channels(), self.uncertain.unknown_channels());
        let joined = |theta: &Mat, delta: &Mat| {
            let m = theta.nrows() + k;
            let kept: Vec<usize> = (0..m).filter(|i| *i < r || *i >= r + k).collect();
            let mut out = Mat::zeros(m, m);
            for (i, &row) in kept.iter().enumerate() {
                for (j, &column) in kept.iter().enumerate() {
                    out[(row, column)] = theta[(i, j)];
                }
            }
            out.view_mut((r, r), (k, k)).copy_from(&(delta / shown.gamma));
            out
        };
        let bound = GainBound {
            gamma: gamma * shown.gamma,
            x: shown.x.clone(),
            factor: None,
            s: joined(&shown.s, s),
            t: joined(&shown.t, t),
            lambda: 0.0,
            largest_eigenvalue: f64::NAN,
        };
        let mut found = RobustBound { size, bound };
        found.bound.largest_eigenvalue = self.worst_eigenvalue(&found);
        found
    }

    /// Returns the channels of Delta.
    pub(crate) fn of_delta(&self) -> Range<usize> {
        let first = self.uncertain.scheduled_channels();
        first..first + self.uncertain.unknown_channels()
    }

    pub(crate) fn worst_eigenvalue(&self, at: &RobustBound) -> f64 {
        let closed = self.closed(at.size);
        worst_eigenvalue(&closed, &LoopError::none(&closed), &at.bound)
    }

    pub(crate) fn closed(&self, size: f64) -> ClosedLoop {
        self.uncertain.sized(size).close(self.controller)
    }
}

/// The initial gamma, relative to the known bound.
const FIRST_GAMMA_FACTOR: f64 = 1.2;

/// Returns a diagonal S that balances the gains into and out of each channel, by the largest entries of the frequency
/// response at Theta = 0; w and z are one channel, in units in which a gain of `gamma` is 1.
///
/// Sources: E. E. Osborne, J. ACM 7(4), 1960; as a multiplier M. G. Safonov, IEE Proc. D 129(6), 1982.
pub(crate) fn balanced(closed: &ClosedLoop, gamma: f64) -> Mat {
    let closed = closed.in_units_of(gamma);
    let m = closed.channels.len();
    let largest = largest_entries(&closed);
    let floor = NEGLIGIBLE_ENTRY * largest.amax().max(f64::MIN_POSITIVE);
    let mut t = vec![1.0f64; m + 1];
    for _ in 0..BALANCING_SWEEPS {
        for k in 0..m {
            let others = || (0..=m).filter(|j| *j != k);
            let row: f64 = others().map(|j| (largest[(k, j)] / t[j]).powi(2)).sum();
            let column: f64 = others().map(|i| (largest[(i, k)] * t[i]).powi(2)).sum();
            t[k] = ((column + floor * floor) / (row + floor * floor)).powf(0.25);
        }
    }
    diagonal(t[..m].iter().map(|t| t * t))
}

/// The number of sweeps of the balancing, and the relative size of negligible entries.
const BALANCING_SWEEPS: usize = 60;
const NEGLIGIBLE_ENTRY: f64 = 1e-9;

/// The frequencies of the balancing, rad/s: range in decades and number.
const FREQUENCY_DECADES: (f64, f64) = (-3.0, 3.0);
const FREQUENCY_COUNT: i32 = 40;

/// Returns the maximum over frequency of each entry of the response of the channels, with w and z as the last one.
fn largest_entries(closed: &ClosedLoop) -> Mat {
    let Sizes { t: m, w, z, .. } = closed.parts.sizes();
    let system = closed.parts.state_space(&[Group::T, Group::Z], &[Group::T, Group::W]);
    let mut largest = Mat::zeros(m + 1, m + 1);
    for step in 0..FREQUENCY_COUNT {
        let part = f64::from(step) / f64::from(FREQUENCY_COUNT - 1);
        let omega = 10f64.powf(FREQUENCY_DECADES.0 + (FREQUENCY_DECADES.1 - FREQUENCY_DECADES.0) * part);
        let Some(response) = system.response(Complex::new(0.0, omega)) else { continue };
        let group = |i: usize, count: usize| if i < m { (i, 1) } else { (m, count) };
        for i in 0..=m {
            for j in 0..=m {
                let ((row, rows), (column, columns)) = (group(i, z), group(j, w));
                let size = response.view((row, column), (rows, columns)).norm();
                largest[(i, j)] = f64::max(largest[(i, j)], size);
            }
        }
    }
    largest
}
