//! Loads on a spheroid: published figures, the pressure integrated over the hull, a panel method.

use proptest::prelude::*;
use squid_sea::{Component, GRAVITY, Place, SeaError, Spectrum, Spheroid, Waves};
use std::f64::consts::{PI, TAU};

const DENSITY: f64 = 1025.0;
const NONE: [[f64; 3]; 3] = [[0.0; 3]; 3];

fn sea(heading: f64, seed: u64) -> Waves {
    Waves::new(&Spectrum::jonswap(0.2, 2.0, 3.3).unwrap(), heading, 20, seed).unwrap()
}

/// Lamb (1932), arts. 114 and 115: k1, k2 and k' of a prolate spheroid.
fn lamb(a: f64, b: f64) -> [f64; 3] {
    let e2 = 1.0 - (b / a).powi(2);
    let e = e2.sqrt();
    let half_log = 0.5 * ((1.0 + e) / (1.0 - e)).ln();
    let alpha = 2.0 * (1.0 - e2) / (e2 * e) * (half_log - e);
    let beta = 1.0 / e2 - (1.0 - e2) / (e2 * e) * half_log;
    let turn = e2 * e2 * (beta - alpha) / ((2.0 - e2) * (2.0 * e2 - (2.0 - e2) * (beta - alpha)));
    [alpha / (2.0 - alpha), beta / (2.0 - beta), turn]
}

/// A spheroid with the added mass of Lamb.
fn with_added_mass(a: f64, b: f64) -> Spheroid {
    let mass = Spheroid::new(a, b, DENSITY, NONE).unwrap().displacement();
    let [k1, k2, turn] = lamb(a, b);
    let diagonal = [k1 * mass, k2 * mass, turn * mass * (a * a + b * b) / 5.0];
    let matrix = std::array::from_fn(|i| std::array::from_fn(|j| if i == j { diagonal[i] } else { 0.0 }));
    Spheroid::new(a, b, DENSITY, matrix).unwrap()
}

/// The amplitudes of force and moment per metre of wave at a frequency \[rad/s\], by the loads a quarter of a period
/// apart.
fn amplitudes(hull: &Spheroid, heading: f64, depth: f64, frequency: f64) -> [f64; 3] {
    let one = Component { amplitude: 1.0, frequency, number: frequency * frequency / GRAVITY, phase: 0.0 };
    let waves = Waves::of(vec![one], heading);
    let quarter = TAU / frequency / 4.0;
    let loads = [0.0, quarter].map(|time| hull.in_waves(&waves, Place { time, x: 0.0, depth }, 0.0).1);
    std::array::from_fn(|i| loads[0][i].hypot(loads[1][i]))
}

fn close(found: f64, expected: f64, tolerance: f64) {
    assert!((found - expected).abs() <= tolerance, "{found} instead of {expected}");
}

/// Head sea of 1.2 rad/s: the published amplitudes per metre, to their digits. Surge and heave are equal there.
#[test]
fn froude_krylov_loads_are_the_published_ones() {
    for (a, b, depth, force, moment, digits) in
        [(2.0, 1.0, 5.0, 5897.21, 520.35, 5e-3), (0.8077, 0.0959, 2.0, 34.1949, 0.645938, 5e-5)]
    {
        let hull = Spheroid::new(a, b, DENSITY, NONE).unwrap();
        let [surge, heave, pitch] = amplitudes(&hull, PI, depth, 1.2);
        close(heave, force, digits);
        close(surge, force, digits);
        close(pitch, moment, digits.min(5e-3));
    }
}

/// A force on water of the same volume is what is left in long waves: it vanishes with the wave number.
#[test]
fn long_waves_accelerate_the_hull_like_water() {
    let hull = Spheroid::new(0.8077, 0.0959, DENSITY, NONE).unwrap();
    for frequency in [0.3, 0.1, 0.03] {
        let number = frequency * frequency / GRAVITY;
        let [surge, heave, pitch] = amplitudes(&hull, PI, 2.0, frequency);
        let water = hull.displacement() * GRAVITY * number * (-2.0 * number).exp();
        close(heave / water, 1.0, number);
        close(surge / water, 1.0, number);
        assert!(pitch / water < number);
    }
}

/// Capytaine 3.0.0, exciting force and moment per metre of wave, deep water, 60 by 90 panels. Panels lie inside the
/// hull: from 24 by 36 and 36 by 60 on the loads come nearer, to 1.3 % at last.
#[test]
fn loads_with_diffraction_are_those_of_a_panel_method() {
    for (a, b, depth, heading, frequency, expected) in [
        (2.0, 1.0, 5.0, PI, 1.2, [7155.5, 10164.5, 874.65]),
        (1.0, 0.125, 2.0, 0.75 * PI, 2.0, [85.615, 230.584, 12.758]),
    ] {
        let found = amplitudes(&with_added_mass(a, b), heading, depth, frequency);
        for (found, expected) in found.into_iter().zip(expected) {
            close(found / expected, 1.0, 0.02);
        }
    }
}

/// Diffraction multiplies force and moment by `1 + k1`, `1 + k2`, `1 + k' ((a^2 + b^2)/(a^2 - b^2))^2`.
#[test]
fn diffraction_is_a_factor() {
    let (a, b) = (1.5, 0.4);
    let [k1, k2, turn] = lamb(a, b);
    let slender = ((a * a + b * b) / (a * a - b * b)).powi(2);
    let bare = amplitudes(&Spheroid::new(a, b, DENSITY, NONE).unwrap(), 2.0, 3.0, 1.5);
    let full = amplitudes(&with_added_mass(a, b), 2.0, 3.0, 1.5);
    for (i, factor) in [1.0 + k1, 1.0 + k2, 1.0 + turn * slender].into_iter().enumerate() {
        close(full[i] / bare[i], factor, 1e-12);
    }
    // Lamb's own table, p. 155, to a unit of its last digit.
    for (ratio, printed) in [(8.01, [0.029, 0.945, 0.840]), (9.97, [0.021, 0.960, 0.883])] {
        lamb(ratio, 1.0).into_iter().zip(printed).for_each(|(found, printed)| close(found, printed, 1e-3));
    }
}

/// Force and moment of the pressure on the hull, by the midpoint rule over its surface.
fn integrated(waves: &Waves, centre: Place, pitch: f64, heading: f64, [a, b]: [f64; 2]) -> [f64; 3] {
    let (sin, cos) = pitch.sin_cos();
    let (rings, parts) = (200, 120);
    let mut sums = [0.0; 3];
    for ring in 0..rings {
        let polar = PI * (f64::from(ring) + 0.5) / f64::from(rings);
        for part in 0..parts {
            let around = TAU * (f64::from(part) + 0.5) / f64::from(parts);
            let unit = [polar.cos(), polar.sin() * around.sin(), polar.sin() * around.cos()];
            let [x, y, z] = [a * unit[0], b * unit[1], b * unit[2]];
            let (along, down) = (x * cos + z * sin, z * cos - x * sin);
            let pressure: f64 = waves
                .components()
                .iter()
                .map(|wave| {
                    let crest = (centre.x + along) * heading.cos() + y * heading.sin();
                    let angle = wave.number * crest - wave.frequency * centre.time + wave.phase;
                    let depth = centre.depth + down;
                    DENSITY * GRAVITY * wave.amplitude * (-wave.number * depth).exp() * angle.cos()
                })
                .sum();
            let area = a * b * b * polar.sin() * (PI / f64::from(rings)) * (TAU / f64::from(parts));
            let inward = [-unit[0] / a * area, -unit[2] / b * area];
            sums[0] += pressure * inward[0];
            sums[1] += pressure * inward[1];
            sums[2] += pressure * (z * inward[0] - x * inward[1]);
        }
    }
    sums
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]
    /// Short waves, any heading, any pitch: the closed form is the integral.
    #[test]
    fn froude_krylov_is_the_integral_of_the_pressure(
        heading in 0.0..PI, pitch in -1.2..1.2, seed in 0u64..100, time in 0.0..100.0, radius in 0.1..0.9,
    ) {
        let waves = sea(heading, seed);
        let centre = Place { time, x: 3.0, depth: 1.5 };
        let found = Spheroid::new(1.0, radius, DENSITY, NONE).unwrap().in_waves(&waves, centre, pitch).1;
        let expected = integrated(&waves, centre, pitch, heading, [1.0, radius]);
        let size = expected.iter().fold(0.0f64, |most, one| most.max(one.abs()));
        for i in 0..3 {
            close(found[i], expected[i], 2e-3 * size);
        }
    }

    /// The motion that comes with the load is that of the water there.
    #[test]
    fn the_motion_is_that_of_the_waves(time in 0.0..100.0, depth in 1.0..10.0) {
        let waves = sea(1.0, 5);
        let place = Place { time, x: -2.0, depth };
        let hull = Spheroid::new(1.0, 0.1, DENSITY, NONE).unwrap();
        prop_assert_eq!(hull.in_waves(&waves, place, 0.3).0, waves.motion(place));
    }
}

#[test]
fn the_hull_has_a_top() {
    let hull = Spheroid::new(1.0, 0.125, DENSITY, NONE).unwrap();
    for (station, pitch, expected) in [
        (0.0, 0.0, [0.0, 0.125]),
        (1.0, 0.0, [1.0, 0.0]),
        (1.0, PI / 2.0, [0.0, 1.0]),
        (-1.0, PI / 6.0, [-(0.75f64.sqrt()), -0.5]),
        (0.6, 0.0, [0.6, 0.1]),
    ] {
        hull.top(station, pitch).into_iter().zip(expected).for_each(|(found, one)| close(found, one, 1e-15));
    }
    close(hull.displacement(), 4.0 / 3.0 * PI * 0.125 * 0.125 * DENSITY, 1e-9);
}

#[test]
fn hulls_that_are_not_slender_are_refused() {
    for (a, b, density, mass, key) in [
        (1.0, 1.0, DENSITY, 0.0, "length"),
        (1.0, 0.0, DENSITY, 0.0, "diameter"),
        (1.0, 0.1, 0.0, 0.0, "density"),
        (f64::NAN, 0.1, DENSITY, 0.0, "length"),
        (1.0, 0.1, DENSITY, f64::NAN, "added_mass"),
    ] {
        let error = Spheroid::new(a, b, density, [[mass; 3]; 3]).unwrap_err();
        assert!(matches!(error, SeaError::NotAllowed { key: found, .. } if found == key), "{error}");
    }
}

proptest! {
    /// Derivatives of the load, by differences; short waves and long ones.
    #[test]
    fn slopes_are_differences(
        heading in 0.0..PI, pitch in -1.0..1.0, x in -50.0..50.0, depth in 1.0..5.0, period in 0.6..8.0,
    ) {
        let spectrum = Spectrum::jonswap(0.01, period, 3.3).unwrap();
        let waves = Waves::new(&spectrum, heading, 20, 5).unwrap();
        let hull = with_added_mass(0.8, 0.1);
        let at = |[time, x, depth, pitch]: [f64; 4]| hull.in_waves(&waves, Place { time, x, depth }, pitch).1;
        let here = [3.0, x, depth, pitch];
        let exact = hull.slopes_in_waves(&waves, Place { time: 3.0, x, depth }, pitch);
        let size: [f64; 3] = std::array::from_fn(|i| 0.1 + exact.iter().map(|slope| slope[i].abs()).sum::<f64>());
        for (j, slope) in exact.into_iter().enumerate() {
            let h = 1e-5;
            let moved = |by: f64| at(std::array::from_fn(|i| if i == j { here[i] + by } else { here[i] }));
            let (above, below) = (moved(h), moved(-h));
            for i in 0..3 {
                close((above[i] - below[i]) / (2.0 * h), slope[i], 1e-6 * size[i]);
            }
        }
    }
}
