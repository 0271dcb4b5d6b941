//! Spectrum of wind waves.

use crate::GRAVITY;
use crate::error::{SeaError, check};
use std::f64::consts::{PI, TAU};

/// Peak periods \[s\] between which the steepness limit varies; it is constant outside.
const STEEPNESS_PERIODS: [f64; 2] = [8.0, 15.0];
/// Limits of the mean steepness `2 pi Hs/(g Tp^2)` at these periods, linear in between. Source: DNV-RP-C205 (2010),
/// 3.5.4.
const STEEPNESS_LIMITS: [f64; 2] = [1.0 / 15.0, 1.0 / 25.0];

/// Width of the peak, below it and above it. Source: Hasselmann et al. (1973).
const PEAK_WIDTHS: [f64; 2] = [0.07, 0.09];

/// Number of intervals of Simpson's rule in [`Spectrum::integral`].
const INTERVALS: usize = 8;

/// JONSWAP spectrum `S(w) = 5/16 Hs^2 wp^4 w^-5 exp(-5/4 (wp/w)^4) gamma^r (1 - 0.287 ln gamma)` with `r = exp(-(w -
/// wp)^2/(2 sigma^2 wp^2))`, sigma = 0.07 up to the peak and 0.09 above it.
///
/// For gamma = 1 it is the Pierson-Moskowitz spectrum (1964) in terms of height and period. Sources: Hasselmann et al.
/// (1973); DNV-RP-C205 (2010), 3.5.5.
#[derive(Clone, Debug, PartialEq)]
pub struct Spectrum {
    height: f64,
    period: f64,
    gamma: f64,
}

/// Longest peak period \[s\].
const LONGEST: f64 = 30.0;

impl Spectrum {
    /// Returns the spectrum of significant height Hs \[m\], peak period Tp \[s\] and peak enhancement factor gamma.
    ///
    /// # Errors
    /// [`SeaError`]: a number outside its range; waves that would break.
    pub fn jonswap(height: f64, period: f64, gamma: f64) -> Result<Self, SeaError> {
        check("height", height, height > 0.0, "above 0 (m)")?;
        check("period", period, (0.5..=LONGEST).contains(&period), "from 0.5 to 30 (s)")?;
        check("gamma", gamma, (1.0..=7.0).contains(&gamma), "from 1 to 7")?;
        let steepness = TAU * height / (GRAVITY * period * period);
        let limit = steepness_limit(period);
        if steepness > limit {
            let least_period = least_period(height);
            return Err(SeaError::TooSteep { height, period, steepness, limit, least_period });
        }
        Ok(Self { height, period, gamma })
    }

    /// Returns the largest significant height before waves of the longest peak period break \[m\].
    pub fn highest() -> f64 {
        steepness_limit(LONGEST) * GRAVITY * LONGEST * LONGEST / TAU
    }

    /// Returns the significant height Hs \[m\].
    pub fn height(&self) -> f64 {
        self.height
    }

    /// Returns the peak period Tp \[s\].
    pub fn period(&self) -> f64 {
        self.period
    }

    /// Returns the peak enhancement factor; 1 for a fully developed sea.
    pub fn gamma(&self) -> f64 {
        self.gamma
    }

    /// Returns the peak frequency \[rad/s\].
    pub fn peak(&self) -> f64 {
        TAU / self.period
    }

    /// Returns S(w) \[m2 s/rad\] at a frequency above zero \[rad/s\].
    pub fn density(&self, frequency: f64) -> f64 {
        let peak = self.peak();
        let relative = frequency / peak;
        let width = PEAK_WIDTHS[usize::from(relative > 1.0)];
        let deviation = (relative - 1.0) / width;
        let enhanced =
            self.gamma.powf((-0.5 * deviation * deviation).exp()) * (1.0 - 0.287 * self.gamma.ln());
        let shape = relative.powi(-5) * (-1.25 * relative.powi(-4)).exp();
        5.0 / 16.0 * self.height * self.height / peak * shape * enhanced
    }

    /// Returns the integral of S between two frequencies \[m2\] by Simpson's rule; the interval must be short compared
    /// with the width of the peak.
    pub(crate) fn integral(&self, from: f64, to: f64) -> f64 {
        let step = (to - from) / INTERVALS as f64;
        let weight = |i: usize| match i {
            0 | INTERVALS => 1.0,
            i if i % 2 == 1 => 4.0,
            _ => 2.0,
        };
        let sum: f64 = (0..=INTERVALS).map(|i| weight(i) * self.density(from + i as f64 * step)).sum();
        sum * step / 3.0
    }
}

/// Returns the limit of the mean steepness for a peak period \[s\].
fn steepness_limit(period: f64) -> f64 {
    let [short, long] = STEEPNESS_PERIODS;
    let [steep, flat] = STEEPNESS_LIMITS;
    let fraction = ((period - short) / (long - short)).clamp(0.0, 1.0);
    steep + fraction * (flat - steep)
}

/// Returns the shortest peak period \[s\] of waves of a height \[m\], by bisection: the allowed height rises with the
/// period.
fn least_period(height: f64) -> f64 {
    let height_limit = |period: f64| steepness_limit(period) * GRAVITY * period * period / TAU;
    let (mut below, mut above) = (0.0, (height * PI).sqrt() + 60.0);
    // The tolerance is relative, so that the bisection ends for any height.
    while above - below > 1e-9 * above {
        let middle = 0.5 * (below + above);
        *(if height_limit(middle) < height { &mut below } else { &mut above }) = middle;
    }
    above
}
