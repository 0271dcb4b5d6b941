//! The gain of a finished loop for every course of Theta and of Delta, and how large Delta may be.
//!
//! The inequality is that of [`crate::analysis::bounded_gain()`], with a point to start from that is made here: no
//! controller was built on it.

use crate::analysis::bounded_gain::{Base, clearest, search, worst_eigenvalue};
use crate::analysis::gain_bound::GainBound;
use crate::matrix::Mat;
use crate::robust::uncertain_plant::UncertainPlant;
use crate::system::controller::Controller;
use crate::system::model_error::LoopError;
use crate::system::partition::{Group, Sizes};
use crate::system::plant::ClosedLoop;
use nalgebra::{Complex, DVector};

/// A gain for every course of Theta and of Delta up to a size.
#[derive(Debug, Clone, PartialEq)]
pub struct RobustBound {
    /// The size of Delta.
    pub size: f64,
    /// The bound; channels ordered Theta's and Delta's of the plant, then the controller's.
    pub bound: GainBound,
}

/// A finished loop with what is unknown of its plant.
#[derive(Debug, Clone, Copy)]
pub struct RobustLoop<'a> {
    uncertain: &'a UncertainPlant,
    controller: &'a Controller,
}

/// How close to the least gamma a bound is sought, relatively: on the way, and at the end.
const ROUGH_TOLERANCE: f64 = 0.1;
const FINE_TOLERANCE: f64 = 0.01;

/// How often a search begins again, in the better coordinates that its last point gives.
const MOST_RESTARTS: usize = 3;

/// Steps of the size while the size at a gamma is bracketed, and how often the bracket is divided.
const SIZE_STRIDE: f64 = 1.2;
const MOST_STRIDES: usize = 30;
const BRACKET_DIVISIONS: usize = 5;

/// What part of gamma is given for an inequality that holds clearly: see [`RobustLoop::cleared`].
pub const CLEARANCE_SHARE: f64 = 0.01;

impl<'a> RobustLoop<'a> {
    /// The loop that a controller closes.
    pub fn new(uncertain: &'a UncertainPlant, controller: &'a Controller) -> Self {
        Self { uncertain, controller }
    }

    /// A bound at a size, with the Lyapunov matrix of some bound of the loop to begin with; `None` when none was found.
    pub fn bound(&self, size: f64, known: &GainBound) -> Option<RobustBound> {
        let gamma = FIRST_GAMMA_FACTOR * known.gamma;
        let s = self.balanced(size, gamma);
        let m = s.nrows();
        let none = f64::NAN;
        let guess = GainBound {
            gamma,
            x: known.x.clone(),
            s,
            t: Mat::zeros(m, m),
            lambda: 0.0,
            largest_eigenvalue: none,
        };
        let rough = self.searched(&RobustBound { size, bound: guess }, ROUGH_TOLERANCE)?;
        Some(self.tightened(rough))
    }

    /// The bound of another size, begun at one that is known.
    pub fn at_size(&self, known: &RobustBound, size: f64) -> Option<RobustBound> {
        let mut begin = RobustBound { size, bound: known.bound.clone() };
        begin.bound.largest_eigenvalue = self.worst_eigenvalue(&begin);
        let holds = begin.bound.largest_eigenvalue < 0.0;
        let found = self.searched(&begin, FINE_TOLERANCE).or_else(|| self.searched(&begin, ROUGH_TOLERANCE));
        let found = found
            .or_else(|| self.searched(&self.cleared(&begin)?, FINE_TOLERANCE))
            .or(holds.then_some(begin));
        Some(self.tightened(found?))
    }

    fn tightened(&self, mut at: RobustBound) -> RobustBound {
        for _ in 0..MOST_RESTARTS {
            match self.searched(&at, FINE_TOLERANCE) {
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

    /// The largest size at which the gain stays below `gamma`, within a few per cent, and the bound there. `None`
    /// when no size was found.
    pub fn largest_size(&self, known: &RobustBound, gamma: f64) -> Option<RobustBound> {
        let mut good = None;
        let mut at = known.clone();
        let mut too_large = f64::INFINITY;
        for _ in 0..MOST_STRIDES {
            let holds = at.bound.gamma <= gamma;
            if holds {
                good = Some(at.clone());
            } else {
                too_large = too_large.min(at.size);
            }
            if good.is_some() && too_large.is_finite() {
                break;
            }
            let next = if holds { at.size * SIZE_STRIDE } else { at.size / SIZE_STRIDE };
            match self.at_size(&at, next) {
                Some(found) => at = found,
                None if holds => too_large = next,
                None => return None,
            }
        }
        let mut good = good?;
        for _ in 0..BRACKET_DIVISIONS {
            let middle = (good.size * too_large).sqrt();
            match self.at_size(&good, middle) {
                Some(found) if found.bound.gamma <= gamma => good = found,
                _ => too_large = middle,
            }
        }
        Some(good)
    }

    /// A bound of the same size that holds as clearly as a gamma 1 % larger lets it: for a proof.
    pub fn cleared(&self, at: &RobustBound) -> Option<RobustBound> {
        let closed = self.closed(at.size);
        let none = LoopError::none(&closed);
        let mut best: Option<GainBound> = None;
        let given = GainBound { gamma: (1.0 + CLEARANCE_SHARE) * at.bound.gamma, ..at.bound.clone() };
        for _ in 0..MOST_RESTARTS {
            let from = best.as_ref().unwrap_or(&given);
            let Ok(found) = clearest(Base { closed: &closed, error: &none, bound: from }) else { break };
            if best.as_ref().is_some_and(|b| found.largest_eigenvalue >= b.largest_eigenvalue) {
                break;
            }
            best = Some(found);
        }
        let bound = best?;
        (bound.largest_eigenvalue < 0.0).then_some(RobustBound { size: at.size, bound })
    }

    /// S and T of Delta. Each is square, with a row for each channel of Delta.
    pub fn multipliers_of_delta(&self, bound: &GainBound) -> (Mat, Mat) {
        let (r, k) = (self.uncertain.scheduled_channels(), self.uncertain.unknown_channels());
        let part = |m: &Mat| m.view((r, r), (k, k)).into_owned();
        (part(&bound.s), part(&bound.t))
    }

    /// The bound of the loop that was shown through [`UncertainPlant::weighed`] with the multipliers S and T of
    /// Delta, at its `size` and `gamma`: where the gain shown is above 1, a guess alone.
    pub fn from_weighed(
        &self,
        shown: &GainBound,
        size: f64,
        gamma: f64,
        (s, t): (&Mat, &Mat),
    ) -> RobustBound {
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
            s: joined(&shown.s, s),
            t: joined(&shown.t, t),
            lambda: 0.0,
            largest_eigenvalue: f64::NAN,
        };
        let mut found = RobustBound { size, bound };
        found.bound.largest_eigenvalue = self.worst_eigenvalue(&found);
        found
    }

    fn worst_eigenvalue(&self, at: &RobustBound) -> f64 {
        let closed = self.closed(at.size);
        worst_eigenvalue(&closed, &LoopError::none(&closed), &at.bound)
    }

    fn closed(&self, size: f64) -> ClosedLoop {
        self.uncertain.sized(size).close(self.controller)
    }

    /// A diagonal S that balances what goes into a channel with what comes out, by the largest entries of the
    /// frequency response at Theta = 0; w and z count as one channel, in units in which a gain of `gamma` is 1.
    ///
    /// E. E. Osborne, J. ACM 7(4), 1960; as a multiplier M. G. Safonov, IEE Proc. D 129(6), 1982.
    fn balanced(&self, size: f64, gamma: f64) -> Mat {
        let closed = self.closed(size).in_units_of(gamma);
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
        Mat::from_diagonal(&DVector::from_iterator(m, t[..m].iter().map(|t| t * t)))
    }
}

/// The first guess at gamma, relative to the bound that is known.
const FIRST_GAMMA_FACTOR: f64 = 1.2;

/// Sweeps of the balancing, and entries that count for nothing beside the largest.
const BALANCING_SWEEPS: usize = 60;
const NEGLIGIBLE_ENTRY: f64 = 1e-9;

/// Frequencies of the balancing, rad/s: the decades and the number.
const FREQUENCY_DECADES: (f64, f64) = (-3.0, 3.0);
const FREQUENCY_COUNT: i32 = 40;

/// The largest size over frequency of each entry of the response of the channels, and of w and z as a last one.
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
