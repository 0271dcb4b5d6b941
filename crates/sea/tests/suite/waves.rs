//! Components, elevation and orbital motion.

use proptest::prelude::*;
use squid_sea::{Component, GRAVITY, Place, SeaError, Spectrum, Waves, encounter_frequency};
use std::f64::consts::{PI, TAU};

fn sea(heading: f64, seed: u64) -> Waves {
    Waves::new(&Spectrum::jonswap(1.0, 6.0, 3.3).unwrap(), heading, 100, seed).unwrap()
}

/// `4 sqrt(m0)` of that spectrum, by quadrature: 1 - 0.287 ln gamma is a fit.
const HEIGHT: f64 = 1.0012;

fn close(found: f64, expected: f64, tolerance: f64) {
    assert!((found - expected).abs() <= tolerance, "{found} instead of {expected}");
}

/// The elevation and the vertical velocity over the components, against the published figures of the spectrum. What
/// lies beyond ten times the peak is 1.3 % of the variance at the surface; each frequency is drawn in its interval.
#[test]
fn components_have_the_spectrum() {
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

/// The elevation and the velocity at a depth that are seen over an hour have the rms of the spectrum.
#[test]
fn what_is_seen_has_the_spectrum() {
    let waves = sea(PI, 3);
    let (mut heights, mut speeds) = (0.0, 0.0);
    let count = 14_400;
    for i in 0..count {
        let time = 0.25 * f64::from(i);
        heights += waves.elevation(time, [0.0; 2]).powi(2);
        speeds += waves.motion(Place { time, north: 0.0, east: 0.0, depth: 5.0 }).velocity[2].powi(2);
    }
    close(4.0 * (heights / f64::from(count)).sqrt(), HEIGHT, 0.03);
    close((speeds / f64::from(count)).sqrt(), 0.137, 0.004);
}

#[test]
fn the_seed_decides() {
    assert_eq!(sea(PI, 7), sea(PI, 7));
    assert_ne!(sea(PI, 7).components(), sea(PI, 8).components());
    assert_eq!(sea(PI, 7).components(), sea(1.0, 7).components());
    // Of the first version: a seed means the same sea in every later one.
    close(sea(PI, 7).elevation(10.0, [2.0, 0.0]), ELEVATION_OF_SEED_7, 1e-9);
}

const ELEVATION_OF_SEED_7: f64 = 0.267_366_903_280;

proptest! {
    /// Derivatives by differences; water keeps its volume and does not turn; at the surface it follows the elevation.
    #[test]
    fn the_motion_obeys_linear_theory(
        heading in -PI..PI, seed in 0u64..1000, time in 0.0..1000.0, north in -100.0..100.0, east in -100.0..100.0,
        depth in 0.0..20.0,
    ) {
        let waves = sea(heading, seed);
        let at = |[time, north, east, depth]: [f64; 4]| waves.motion(Place { time, north, east, depth });
        let place = [time, north, east, depth];
        let here = at(place);
        let h = 1e-5;
        let [by_north, by_east, by_depth] = here.by_place;
        for (j, slope) in [here.by_time, by_north, by_east, by_depth].into_iter().enumerate() {
            let moved = |by: f64| at(std::array::from_fn(|i| place[i] + if i == j { by } else { 0.0 })).velocity;
            let (above, below) = (moved(h), moved(-h));
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

    /// What is seen along the way of the waves, and across it nothing changes.
    #[test]
    fn crests_are_long(heading in -PI..PI, time in 0.0..100.0, along in -50.0..50.0, across in -50.0..50.0) {
        let place = [along * heading.cos() - across * heading.sin(), along * heading.sin() + across * heading.cos()];
        close(sea(heading, 3).elevation(time, place), sea(0.0, 3).elevation(time, [along, 0.0]), 1e-10);
    }

    /// Who moves along with the vehicle sees one wave come by that often: after its period all is as it was.
    #[test]
    fn the_frequency_of_encounter_is_what_a_moving_vehicle_sees(
        heading in 0.0..PI, speed in -3.0..3.0, frequency in 0.3..3.0, time in 0.0..100.0,
    ) {
        let met = encounter_frequency(frequency, heading, speed);
        prop_assume!(met > 0.05);
        let number = frequency * frequency / GRAVITY;
        let waves = Waves::of(vec![Component { amplitude: 1.0, frequency, number, phase: 0.4 }], heading);
        let seen = |time: f64| waves.elevation(time, [speed * time, 0.0]);
        close(seen(time + TAU / met), seen(time), 1e-9);
        close(seen(time + PI / met), -seen(time), 1e-9);
    }
}

/// 1 rad/s, head sea, 2 m/s: 1 + 2/9.81 rad/s.
#[test]
fn head_seas_are_met_more_often() {
    close(encounter_frequency(1.0, PI, 2.0), 1.0 + 2.0 / 9.81, 1e-12);
    close(encounter_frequency(1.0, 0.0, 2.0), 1.0 - 2.0 / 9.81, 1e-12);
}

#[test]
fn numbers_out_of_range_are_refused() {
    let spectrum = Spectrum::jonswap(1.0, 6.0, 3.3).unwrap();
    for (heading, components, key) in
        [(f64::NAN, 100, "heading"), (0.0, 19, "components"), (0.0, 1001, "components")]
    {
        let error = Waves::new(&spectrum, heading, components, 1).unwrap_err();
        assert!(matches!(error, SeaError::NotAllowed { key: found, .. } if found == key), "{error}");
    }
}
