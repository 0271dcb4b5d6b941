//! Shaping filter in position of a spectrum.

use squid_sea::{ShapingFilter, Spectrum, encounter_frequency};
use std::f64::consts::PI;

/// Returns `|H(w)|^2` of a filter from its state equations.
fn power(filter: &ShapingFilter, w: f64) -> f64 {
    let [[a, b, n], [c, d, _]] = filter.rates();
    // (jw - a) c - b s = n, s = c c/(jw - d).
    assert_eq!(d, 0.0);
    let (re, im) = (-a, w - c * -b / w);
    n * n / (re * re + im * im)
}

/// Filtered noise at rest has the peak frequency, peak density and energy of the spectrum.
#[test]
fn filter_has_the_peak_and_energy_of_the_spectrum() {
    for gamma in [1.0, 3.3] {
        let spectrum = Spectrum::jonswap(1.5, 7.0, gamma).unwrap();
        let filter = ShapingFilter::met(&spectrum, PI, 0.0).unwrap();
        assert!((filter.frequency - spectrum.peak()).abs() < 1e-12);
        assert!((power(&filter, filter.frequency) - 1.0).abs() < 1e-12);
        let step = 1e-3;
        let area: f64 = (0..2_000_000).map(|i| power(&filter, (f64::from(i) + 0.5) * step) * step).sum();
        let energy = area * spectrum.density(spectrum.peak());
        // The energy beyond 2000 rad/s is a fraction 2 b/2000.
        assert!((energy / (1.5_f64.powi(2) / 16.0) - 1.0).abs() < 1e-3, "{energy}");
    }
}

/// The filter peaks at the encounter frequency, is affine in the speed, and ends at the group velocity of following
/// seas.
#[test]
fn filter_peaks_at_the_encounter_frequency() {
    let spectrum = Spectrum::jonswap(0.5, 5.0, 3.3).unwrap();
    for heading in [PI, 2.0, 0.5] {
        let at = |speed| ShapingFilter::met(&spectrum, heading, speed).unwrap();
        let [slow, middle, fast] = [at(0.5), at(1.25), at(2.0)];
        assert!((fast.frequency - encounter_frequency(spectrum.peak(), heading, 2.0)).abs() < 1e-12);
        assert!((0.5 * (slow.frequency + fast.frequency) - middle.frequency).abs() < 1e-12);
        assert!((0.5 * (slow.half_width + fast.half_width) - middle.half_width).abs() < 1e-12);
        assert_eq!(fast.frequency > slow.frequency, heading > 0.5 * PI);
    }
    assert_eq!(ShapingFilter::met(&spectrum, 0.0, 3.9).map(|_| ()), Some(()));
    assert_eq!(ShapingFilter::met(&spectrum, 0.0, 4.0), None);
}
