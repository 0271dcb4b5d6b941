//! Second-order shaping filter of the waves that a vehicle encounters.

use crate::GRAVITY;
use crate::spectrum::Spectrum;
use std::f64::consts::PI;

/// Shaping filter `2 b s/(s^2 + 2 b s + w^2)`; its largest gain is 1, at w.
///
/// The states are `[c; s]`, the elevation and its quadrature component:
///
/// ```text
/// c' = -2 b c - w s + 2 b n
/// s' = w c
/// ```
///
/// Driven by white noise, the output has the peak and the energy of the spectrum. Source of the form: T. I. Fossen,
/// Handbook of Marine Craft Hydrodynamics and Motion Control, 2011, section 8.2.7, where the damping ratio b/w is
/// fitted instead.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShapingFilter {
    /// Encounter frequency w of the peak \[rad/s\].
    pub frequency: f64,
    /// Half width b of the peak \[rad/s\].
    pub half_width: f64,
}

impl ShapingFilter {
    /// Returns the filter for a spectrum as encountered at a speed over ground \[m/s\] in waves of a heading \[rad\]:
    /// the encounter frequency of `w` is `w - w^2 U cos(heading)/g`, and the width of the peak scales with its
    /// derivative.
    ///
    /// Both are affine in the speed. `None` unless both are positive: in following seas, from the group velocity g/(2
    /// w) on, the encountered spectrum has no such peak.
    pub fn met(spectrum: &Spectrum, heading: f64, speed: f64) -> Option<Self> {
        let peak = spectrum.peak();
        let doppler = peak * speed * heading.cos() / GRAVITY;
        let (frequency, stretch) = (peak * (1.0 - doppler), 1.0 - 2.0 * doppler);
        // The output energy of the filter is pi b times the density at its peak.
        let half_width = stretch * spectrum.height().powi(2) / 16.0 / (PI * spectrum.density(peak));
        (frequency > 0.0 && half_width > 0.0).then_some(Self { frequency, half_width })
    }

    /// Returns the state equations: a row for each state, in terms of `[c, s, n]`.
    pub fn rates(&self) -> [[f64; 3]; 2] {
        let Self { frequency: w, half_width: b } = *self;
        [[-2.0 * b, -w, 2.0 * b], [w, 0.0, 0.0]]
    }
}
