//! Scalings that prove a level on an interval, computed for two frequencies.
//!
//! If rows of M are nearly dependent, the centre of all scalings that hold at one frequency is far out in a direction
//! that M nearly annihilates there, and holds only nearby: on a hundredth of a frequency, at any frequency and level.
//! The centre of all that hold at two frequencies is not. As Phi is concave in M, it is positive definite between them
//! up to the curvature of M.

use super::interval::{Interval, good_interval};
use super::structure::{Structure, StructureError};
use super::upper::DgScalings;
use super::upper::{UpperBound, UpperBoundOptions, common_bound};
use crate::system::StateSpace;
use nalgebra::Complex;

/// The fraction of the slowest mode below which a frequency is slow.
const SLOW_RATIO: f64 = 0.05;

/// The usual number of short intervals: some lie around every peak.
const FEW_SHORT: usize = 32;

/// The range of frequency ratios between whose ends scalings are searched, and the number of trials per frequency.
const WIDEST: f64 = 4.0;
const NARROWEST: f64 = 1.02;
const TRIES: usize = 3;

/// The relative tolerance of the bound.
const TIGHT: f64 = 2e-4;

/// The levels of a search.
#[derive(Clone, Copy)]
pub(super) struct Levels {
    /// The level to be proved.
    pub(super) level: f64,
    /// The highest level accepted instead.
    pub(super) ceiling: f64,
}

/// An interval on which scalings prove a level.
pub(super) struct Shown {
    /// An upper bound of mu.
    pub(super) level: f64,
    pub(super) interval: Interval,
    pub(super) bound: UpperBound,
}

/// The search for such scalings, continued from one frequency to the next.
pub(super) struct Wide {
    /// A rate below all modes, rad/s.
    pub(super) slow: f64,
    /// The number of scalings for one frequency that held on a short interval.
    short: usize,
    /// `true` if the last such interval was short, and more than a few were.
    narrow: bool,
    /// The ratio of frequencies to be tried next.
    ratio: f64,
}

impl Wide {
    pub(super) fn new(system: &StateSpace) -> Self {
        let slowest = system.poles().iter().map(|p| p.norm()).fold(f64::INFINITY, f64::min);
        Self { slow: SLOW_RATIO * slowest, short: 0, narrow: false, ratio: WIDEST }
    }

    /// Returns `true` if scalings for one frequency (rad/s) are to be skipped.
    pub(super) fn is_first(&self, omega: f64) -> bool {
        self.narrow && omega.is_finite()
    }

    /// Records the interval of scalings for one frequency; returns `true` if scalings for two are to be tried.
    pub(super) fn is_next(&mut self, omega: f64, interval: Interval) -> bool {
        let is_short = interval.is_short(omega.max(self.slow));
        self.short += usize::from(is_short);
        let was_narrow = self.narrow;
        self.narrow = is_short && (omega < self.slow || self.short > FEW_SHORT);
        self.narrow && !was_narrow
    }

    /// Returns scalings that prove a level around a frequency (rad/s) in a gap, or else a higher level, up to the
    /// ceiling.
    pub(super) fn shown(
        &mut self,
        system: &StateSpace,
        structure: &Structure,
        levels: Levels,
        gap: (f64, f64),
        omega: f64,
        start: Option<&DgScalings>,
    ) -> Result<Option<Shown>, StructureError> {
        let (low, high) = gap;
        for _ in 0..TRIES {
            let ratio = self.ratio;
            let ends = if omega == 0.0 {
                (0.0, high.min((ratio - 1.0) * self.slow))
            } else {
                (low.max(omega / ratio), high.min(omega * ratio))
            };
            let found = shown_between(system, structure, levels, ends, start)?;
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
    system: &StateSpace,
    structure: &Structure,
    levels: Levels,
    ends: (f64, f64),
    start: Option<&DgScalings>,
) -> Result<Option<Shown>, StructureError> {
    let (Levels { mut level, ceiling }, (from, to)) = (levels, ends);
    let at = |omega: f64| system.response(Complex::new(0.0, omega));
    let Some(ends) = at(from).zip(at(to)).map(|(a, b)| [a, b]) else { return Ok(None) };
    let options = UpperBoundOptions { level, tight: TIGHT, from: start };
    let mut bound = common_bound(&ends, structure, options)?;
    if level <= bound.value && bound.value < ceiling {
        level = bound.value * (1.0 + TIGHT);
        bound =
            common_bound(&ends, structure, UpperBoundOptions { level, from: Some(&bound.start), ..options })?;
    }
    let middle = if from > 0.0 { (from * to).sqrt() } else { 0.5 * to };
    let interval = (bound.value < level).then(|| good_interval(system, &bound.scalings, level, middle));
    Ok(interval.flatten().map(|interval| Shown { level, interval, bound }))
}
