//! Waves as encountered by a vehicle, as noise through a filter of second order.

use crate::GRAVITY;
use crate::spectrum::Spectrum;
use std::f64::consts::PI;

/// The filter `2 b s/(s^2 + 2 b s + w^2)`, whose gain is 1 at w, its largest.
///
/// With states `[c; s]`, the elevation and what follows it by a quarter of a period, it is
///
/// ```text
/// c' = -2 b c - w s + 2 b n
/// s' = w c
/// ```
///
/// and driven by white noise it has the peak and the energy of the spectrum. Source of the form: T. I. Fossen, Handbook
/// of Marine Craft Hydrodynamics and Motion Control, 2011, section 8.2.7, where the damping b/w is fitted instead.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShapingFilter {
    /// w, the encounter frequency of the peak \[rad/s\].
    pub frequency: f64,
    /// b, half the width of the peak \[rad/s\].
    pub half_width: f64,
}

impl ShapingFilter {
    /// A spectrum as encountered at a speed over ground \[m/s\] in waves of a heading \[rad\]: the encounter frequency
    /// of `w` is `w - w^2 U cos(heading)/g`, and its neighbourhood is stretched by the derivative of that.
    ///
    /// Both are affine in the speed. `None` where one of them is not above 0: in following waves that the vehicle
    /// overtakes, or nearly moves with, the encountered spectrum has no such peak.
    pub fn met(spectrum: &Spectrum, heading: f64, speed: f64) -> Option<Self> {
        let peak = spectrum.peak();
        let carried = peak * speed * heading.cos() / GRAVITY;
        let (frequency, stretched) = (peak * (1.0 - carried), 1.0 - 2.0 * carried);
        // The energy of the filter's output is pi b times the density at its peak.
        let half_width = stretched * spectrum.height().powi(2) / 16.0 / (PI * spectrum.density(peak));
        (frequency > 0.0 && half_width > 0.0).then_some(Self { frequency, half_width })
    }

    /// The rates of its states by `[c, s, n]`, a row each.
    pub fn rates(&self) -> [[f64; 3]; 2] {
        let Self { frequency: w, half_width: b } = *self;
        [[-2.0 * b, -w, 2.0 * b], [w, 0.0, 0.0]]
    }
}
