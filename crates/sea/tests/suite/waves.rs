//! Components, elevation and orbital motion.

use proptest::prelude::*;
use squid_sea::{Component, GRAVITY, Position, SeaError, Spectrum, Waves, encounter_frequency};
use std::f64::consts::{PI, TAU};

fn sea(heading: f64, seed: u64) -> Waves {
    Waves::new(&Spectrum::jonswap(1.0, 6.0, 3.3).unwrap(), heading, 100, seed).unwrap()
}

/// Height `4 sqrt(m0)` of that spectrum by quadrature: 1 - 0.287 ln gamma is a fit.
const HEIGHT: f64 = 1.0012;

fn close(found: f64, expected: f64, tolerance: f64) {
    assert!((found - expected).abs() <= tolerance, "{found} instead of {expected}");
}

/// Elevation and vertical velocity summed over the components, against the published figures of the spectrum. Beyond
/// ten times the peak lie 1.3 % of the variance at the surface; each frequency is random in its interval.
#[test]
fn components_match_the_spectrum() {
    const SEEDS: u64 = 20;
    let published = [(0.0, 0.337), (2.0, 0.213), (5.0, 0.137), (10.0, 0.0746)];
    let mut means = [0.0; 4];
    for waves in (0..SEEDS).map(|seed| sea(PI, seed)) {
        let rms = |of: &dyn Fn(f64) -> f64| {
            let squares = waves.components().iter().map(|w| (w.amplitude * of(w.frequency)).powi(2));
            (0.5 * squares.sum::<f64>()).sqrt()
        };
        close(4.0 * rms(&|_| 1.0), HEIGHT, 2e-4);
        for (mean, (depth, expected)) in means.iter_mut().zip(published) {
            let found = rms(&|w| w * (-w * w / GRAVITY * depth).exp());
            close(found, expected, 0.02 * expected);
            *mean += found / SEEDS as f64;
        }
        assert!(waves.components().windows(2).all(|pair| pair[0].frequency < pair[1].frequency));
    }
    for (mean, (_, expected)) in means.into_iter().zip(published) {
        close(mean, expected, 0.007 * expected);
    }
}

/// Elevation and velocity at a depth, sampled over an hour, have the rms of the spectrum.
#[test]
fn time_history_matches_the_spectrum() {
    let waves = sea(PI, 3);
    let (mut heights, mut speeds) = (0.0, 0.0);
    let count = 14_400;
    for i in 0..count {
        let time = 0.25 * f64::from(i);
        heights += waves.elevation(time, [0.0; 2]).powi(2);
        speeds += waves.motion(Position { time, north: 0.0, east: 0.0, depth: 5.0 }).velocity[2].powi(2);
    }
    close(4.0 * (heights / f64::from(count)).sqrt(), HEIGHT, 0.03);
    close((speeds / f64::from(count)).sqrt(), 0.137, 0.004);
}

#[test]
fn seed_reproduces_the_sea() {
    assert_eq!(sea(PI, 7), sea(PI, 7));
    assert_ne!(sea(PI, 7).components(), sea(PI, 8).components());
    assert_eq!(sea(PI, 7).components(), sea(1.0, 7).components());
    // Value of the first version: a seed gives the same sea in every version.
    close(sea(PI, 7).elevation(10.0, [2.0, 0.0]), ELEVATION_OF_SEED_7, 1e-9);
}

const ELEVATION_OF_SEED_7: f64 = 0.267_366_903_280;

proptest! {
    /// Derivatives against differences; the flow is incompressible and irrotational; the surface follows the elevation.
    #[test]
    fn motion_obeys_linear_theory(
        heading in -PI..PI, seed in 0u64..1000, time in 0.0..1000.0, north in -100.0..100.0, east in -100.0..100.0,
        depth in 0.0..20.0,
    ) {
        let waves = sea(heading, seed);
        let at = |[time, north, east, depth]: [f64; 4]| waves.motion(Position { time, north, east, depth });
        let position = [time, north, east, depth];
        let here = at(position);
        let h = 1e-5;
        let [by_north, by_east, by_depth] = here.by_place;
        for (j, slope) in [here.by_time, by_north, by_east, by_depth].into_iter().enumerate() {
            let shifted = |by: f64| at(std::array::from_fn(|i| position[i] + if i == j { by } else { 0.0 })).velocity;
            let (above, below) = (shifted(h), shifted(-h));
            (0..3).for_each(|i| close(slope[i], (above[i] - below[i]) / (2.0 * h), 1e-6));
        }
        for (i, j) in [(0, 1), (0, 2), (1, 2)] {
            close(here.by_place[i][j], here.by_place[j][i], 1e-12);
        }
        close(by_north[0] + by_east[1] + by_depth[2], 0.0, 1e-12);
        let surface = at([time, north, east, 0.0]).velocity[2];
        let rise = waves.elevation(time + h, [north, east]) - waves.elevation(time - h, [north, east]);
        close(-surface, rise / (2.0 * h), 1e-6);
    }

    /// The elevation varies along the direction of travel and is constant across it.
    #[test]
    fn waves_are_long_crested(heading in -PI..PI, time in 0.0..100.0, along in -50.0..50.0, across in -50.0..50.0) {
        let position = [along * heading.cos() - across * heading.sin(), along * heading.sin() + across * heading.cos()];
        close(sea(heading, 3).elevation(time, position), sea(0.0, 3).elevation(time, [along, 0.0]), 1e-10);
    }

    /// An observer moving with the vehicle sees the wave repeat after its encounter period.
    #[test]
    fn moving_observer_sees_the_encounter_frequency(
        heading in 0.0..PI, speed in -3.0..3.0, frequency in 0.3..3.0, time in 0.0..100.0,
    ) {
        let encounter = encounter_frequency(frequency, heading, speed);
        prop_assume!(encounter > 0.05);
        let number = frequency * frequency / GRAVITY;
        let waves = Waves::of(vec![Component { amplitude: 1.0, frequency, number, phase: 0.4 }], heading);
        let elevation = |time: f64| waves.elevation(time, [speed * time, 0.0]);
        close(elevation(time + TAU / encounter), elevation(time), 1e-9);
        close(elevation(time + PI / encounter), -elevation(time), 1e-9);
    }
}

/// 1 rad/s, head sea, 2 m/s: 1 + 2/9.81 rad/s.
#[test]
fn head_sea_raises_the_encounter_frequency() {
    close(encounter_frequency(1.0, PI, 2.0), 1.0 + 2.0 / 9.81, 1e-12);
    close(encounter_frequency(1.0, 0.0, 2.0), 1.0 - 2.0 / 9.81, 1e-12);
}

#[test]
fn rejects_parameters_out_of_range() {
    let spectrum = Spectrum::jonswap(1.0, 6.0, 3.3).unwrap();
    for (heading, components, key) in
        [(f64::NAN, 100, "heading"), (0.0, 19, "components"), (0.0, 1001, "components")]
    {
        let error = Waves::new(&spectrum, heading, components, 1).unwrap_err();
        assert!(matches!(error, SeaError::NotAllowed { key: found, .. } if found == key), "{error}");
    }
}
