//! Scalings that show a level on an interval, not at a frequency alone.
//!
//! Where rows of M nearly depend on one another the centre of all scalings that hold at one frequency is far out along
//! what M nearly annihilates there, and holds nowhere else: on a hundredth of a frequency, however low that is and
//! however high the level. The centre of all that hold at two frequencies is not. As Phi is concave in M it is positive
//! definite between them but for what M is curved.

use super::interval::{Interval, good_interval};
use super::structure::{Structure, StructureError};
use super::upper::DgScalings;
use super::upper::{UpperBound, UpperBoundOptions, common_bound};
use crate::system::state_space::StateSpace;
use nalgebra::Complex;

/// What is slow, relative to the slowest mode.
const SLOW_RATIO: f64 = 0.05;

/// So many short intervals are no reason to look for longer ones: some lie round every peak.
const FEW_SHORT: usize = 32;

/// Ratios to a frequency within which scalings are sought that hold at both ends, and how many are tried at one.
const WIDEST: f64 = 4.0;
const NARROWEST: f64 = 1.02;
const TRIES: usize = 3;

/// How close to the least bound, relatively, is close enough.
const TIGHT: f64 = 2e-4;

/// What scalings show on an interval.
pub(super) struct Shown {
    /// That mu is below this.
    pub(super) level: f64,
    pub(super) interval: Interval,
    pub(super) bound: UpperBound,
}

/// A search for them that goes on from one frequency to the next.
pub(super) struct Wide {
    /// The modes are faster than this, rad/s.
    pub(super) slow: f64,
    /// How many scalings for one frequency held on a short interval.
    short: usize,
    /// Whether the last did, and not a few alone.
    narrow: bool,
    /// The ratio of frequencies that is tried next.
    ratio: f64,
}

impl Wide {
    pub(super) fn new(system: &StateSpace) -> Self {
        let slowest = system.poles().iter().map(|p| p.norm()).fold(f64::INFINITY, f64::min);
        Self { slow: SLOW_RATIO * slowest, short: 0, narrow: false, ratio: WIDEST }
    }

    /// Whether scalings for one frequency (rad/s) need not be tried.
    pub(super) fn is_first(&self, omega: f64) -> bool {
        self.narrow && omega.is_finite()
    }

    /// Takes note of where scalings for one frequency held; whether to look for others.
    pub(super) fn is_next(&mut self, omega: f64, interval: Interval) -> bool {
        let is_short = interval.is_short(omega.max(self.slow));
        self.short += usize::from(is_short);
        let was_narrow = self.narrow;
        self.narrow = is_short && (omega < self.slow || self.short > FEW_SHORT);
        self.narrow && !was_narrow
    }

    /// Scalings that show a level round a frequency (rad/s) in a gap; where none do one that is higher, up to a
    /// ceiling.
    pub(super) fn shown(
        &mut self,
        (system, structure): (&StateSpace, &Structure),
        levels: (f64, f64),
        (low, high): (f64, f64),
        omega: f64,
        start: Option<&DgScalings>,
    ) -> Result<Option<Shown>, StructureError> {
        for _ in 0..TRIES {
            let ratio = self.ratio;
            let ends = if omega == 0.0 {
                (0.0, high.min((ratio - 1.0) * self.slow))
            } else {
                (low.max(omega / ratio), high.min(omega * ratio))
            };
            let found = shown_between((system, structure), levels, ends, start)?;
            if let Some(found) = found.filter(|f| f.interval.from <= omega && omega <= f.interval.to) {
                self.ratio = (ratio * ratio).min(WIDEST);
                return Ok(Some(found));
            }
            self.ratio = ratio.sqrt().max(NARROWEST);
        }
        Ok(None)
    }
}

fn shown_between(
    (system, structure): (&StateSpace, &Structure),
    (mut level, ceiling): (f64, f64),
    (from, to): (f64, f64),
    start: Option<&DgScalings>,
) -> Result<Option<Shown>, StructureError> {
    let at = |omega: f64| system.response(Complex::new(0.0, omega));
    let Some(ends) = at(from).zip(at(to)).map(|(a, b)| [a, b]) else { return Ok(None) };
    let asked = UpperBoundOptions { level, tight: TIGHT, from: start };
    let mut bound = common_bound(&ends, structure, asked)?;
    if level <= bound.value && bound.value < ceiling {
        level = bound.value * (1.0 + TIGHT);
        bound =
            common_bound(&ends, structure, UpperBoundOptions { level, from: Some(&bound.start), ..asked })?;
    }
    let middle = if from > 0.0 { (from * to).sqrt() } else { 0.5 * to };
    let interval = (bound.value < level).then(|| good_interval(system, &bound.scalings, level, middle));
    Ok(interval.flatten().map(|interval| Shown { level, interval, bound }))
}
