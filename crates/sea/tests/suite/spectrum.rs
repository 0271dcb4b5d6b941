//! Spectra.

use squid_sea::{GRAVITY, SeaError, Spectrum};
use std::f64::consts::TAU;

/// Returns the integral of a function of the frequency, by the midpoint rule.
fn integral(of: impl Fn(f64) -> f64) -> f64 {
    let step = 2e-4;
    (0..500_000).map(|i| of((f64::from(i) + 0.5) * step) * step).sum()
}

fn close(found: f64, expected: f64, tolerance: f64) {
    assert!((found - expected).abs() <= tolerance, "{found} instead of {expected}");
}

/// Published height and peak of the formula of DNV-RP-C205 with Hs = 2.5 m, Tp = 7 s, to their digits.
#[test]
fn height_and_peak_match_published_values() {
    let spectrum = Spectrum::jonswap(2.5, 7.0, 1.932).unwrap();
    close(4.0 * integral(|w| spectrum.density(w)).sqrt(), 2.497, 5e-4);
    close(spectrum.density(TAU / 7.0), 0.9768, 5e-5);
    close(spectrum.peak(), TAU / 7.0, 1e-15);
}

/// The rms of the vertical orbital velocity follows from `w exp(-k depth)` and the spectrum.
#[test]
fn orbital_velocities_match_published_values() {
    let spectrum = Spectrum::jonswap(1.0, 6.0, 3.3).unwrap();
    for (depth, expected, digit) in
        [(0.0, 0.337, 1e-3), (2.0, 0.213, 1e-3), (5.0, 0.137, 1e-3), (10.0, 0.0746, 1e-4)]
    {
        let square = integral(|w| w * w * spectrum.density(w) * (-2.0 * w * w / GRAVITY * depth).exp());
        close(square.sqrt(), expected, 0.5 * digit);
    }
}

/// Reference values: Python's wavespectra 4.9.0, `construct.frequency.jonswap` with `alpha = 5/16 Hs^2 fp^4 (1 - 0.287
/// ln gamma) (2 pi)^4/g^2` and its g, divided by 2 pi; to the digits printed.
#[test]
fn densities_match_wavespectra() {
    let frequencies = [0.5, 0.7, 0.8, 0.9, 1.0, 1.2, 1.5, 2.0, 3.0];
    let moderate = [
        7.568510225e-05,
        0.209385855,
        0.5271038335,
        0.9764450786,
        0.6134232224,
        0.2795682088,
        0.1153483476,
        0.03054224864,
        0.00418907866,
    ];
    let peaked = [
        2.834120254e-10,
        0.002806904432,
        0.01928464802,
        0.04960889217,
        0.1449968793,
        0.06627096455,
        0.02417405211,
        0.007027562116,
        0.0009979098248,
    ];
    let full = [
        4.311470356e-10,
        0.004269999114,
        0.02921860082,
        0.06437481989,
        0.08358366819,
        0.07315140627,
        0.03677490362,
        0.01069083984,
        0.001518093179,
    ];
    for (spectrum, expected) in [
        (Spectrum::jonswap(2.5, 7.0, 1.932), moderate),
        (Spectrum::jonswap(1.0, 6.0, 3.3), peaked),
        (Spectrum::jonswap(1.0, 6.0, 1.0), full),
    ] {
        let spectrum = spectrum.unwrap();
        for (frequency, expected) in frequencies.into_iter().zip(expected) {
            close(spectrum.density(frequency), expected, 1e-9 * expected);
        }
    }
}

/// The Pierson-Moskowitz spectrum has a closed form: `4 sqrt(m0) = Hs`.
#[test]
fn pierson_moskowitz_spectrum_has_its_height() {
    let spectrum = Spectrum::jonswap(3.0, 9.0, 1.0).unwrap();
    close(4.0 * integral(|w| spectrum.density(w)).sqrt(), 3.0, 1e-6);
}

/// The least period named in the error is accepted; a slightly shorter one is not.
#[test]
fn rejects_breaking_waves() {
    for height in [0.1, 0.5, 2.5, 8.0, 12.0, 20.0] {
        let error = Spectrum::jonswap(height, 2.0 * f64::sqrt(height), 3.3).unwrap_err();
        let SeaError::TooSteep { least_period, steepness, limit, .. } = error else { panic!("{error}") };
        assert!(steepness > limit && (0.04..0.0667).contains(&limit));
        assert!(Spectrum::jonswap(height, least_period + 1e-6, 3.3).is_ok());
        assert!(Spectrum::jonswap(height, least_period - 1e-6, 3.3).is_err());
    }
    for height in [1e9, 1e66, 1e300, f64::MAX] {
        assert!(matches!(Spectrum::jonswap(height, 10.0, 3.3), Err(SeaError::TooSteep { .. })), "{height}");
    }
    let text = Spectrum::jonswap(2.0, 3.0, 3.3).unwrap_err().to_string();
    assert!(text.contains("at least 4.38 s"), "{text}");
}

#[test]
fn rejects_parameters_out_of_range() {
    for (height, period, gamma, key) in [
        (0.0, 6.0, 3.3, "height"),
        (f64::NAN, 6.0, 3.3, "height"),
        (1.0, 0.4, 3.3, "period"),
        (1.0, 31.0, 3.3, "period"),
        (1.0, f64::INFINITY, 3.3, "period"),
        (1.0, 6.0, 0.9, "gamma"),
        (1.0, 6.0, 7.1, "gamma"),
    ] {
        let error = Spectrum::jonswap(height, period, gamma).unwrap_err();
        assert!(matches!(error, SeaError::NotAllowed { key: found, .. } if found == key), "{error}");
    }
}
