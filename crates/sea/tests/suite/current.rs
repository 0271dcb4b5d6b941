//! Layers, and the Gauss-Markov process.

use proptest::prelude::*;
use squid_sea::{GaussMarkov, Layers, SeaError, Wandering};

fn close(found: f64, expected: f64, tolerance: f64) {
    assert!((found - expected).abs() <= tolerance, "{found} instead of {expected}");
}

const FREE: Wandering = Wandering { mu: 0.02, noise: 0.03, min: -9.0, max: 9.0 };

fn history(parameters: Wandering, seed: u64, step: f64, count: usize) -> Vec<f64> {
    let mut process = GaussMarkov::new(parameters, seed).unwrap();
    let mut next = || {
        process.advance(step);
        process.value()
    };
    (0..count).map(|_| next()).collect()
}

#[test]
fn current_is_linear_between_layers() {
    let layers = Layers::new(&[[5.0, 1.0], [10.0, 0.5], [30.0, -0.5]]).unwrap();
    for (depth, velocity, slope) in [
        (0.0, 1.0, 0.0),
        (5.0, 1.0, -0.1),
        (7.5, 0.75, -0.1),
        (10.0, 0.5, -0.05),
        (20.0, 0.0, -0.05),
        (30.0, -0.5, 0.0),
        (99.0, -0.5, 0.0),
        (-1.0, 1.0, 0.0),
    ] {
        let found = layers.at(depth);
        close(found.0, velocity, 1e-15);
        close(found.1, slope, 1e-15);
    }
    assert_eq!(Layers::new(&[[0.0, 0.3]]).unwrap().at(20.0), (0.3, 0.0));
}

#[test]
fn rejects_invalid_layers() {
    let refused: [&[[f64; 2]]; 5] =
        [&[], &[[-1.0, 0.0]], &[[5.0, 0.0], [5.0, 1.0]], &[[f64::NAN, 0.0]], &[[0.0, f64::INFINITY]]];
    for layers in refused {
        let error = Layers::new(layers).unwrap_err();
        assert!(matches!(error, SeaError::NotAllowed { key: "layers", .. }), "{error}");
    }
}

/// The stationary deviation is noise/sqrt(2 mu), and values a time tau apart are correlated by exp(-mu tau), for any
/// step: over 4000 correlation times.
#[test]
fn deviation_and_correlation_match_the_process() {
    for step in [0.5, 5.0] {
        let values = history(FREE, 11, step, (2e5 / step) as usize);
        let mean = |of: &dyn Fn(usize) -> f64, count: usize| (0..count).map(of).sum::<f64>() / count as f64;
        let variance = mean(&|i| values[i].powi(2), values.len());
        close(variance.sqrt(), 0.03 / 0.04f64.sqrt(), 0.004);
        let apart = (25.0 / step) as usize;
        let product = mean(&|i| values[i] * values[i + apart], values.len() - apart);
        close(product / variance, (-0.5f64).exp(), 0.04);
    }
}

/// The process with mu = 0 is a random walk: its variance is noise^2 t.
#[test]
fn random_walk_variance_grows_with_time() {
    let parameters = Wandering { mu: 0.0, ..FREE };
    let ends = (0..2000).map(|seed| history(parameters, seed, 4.0, 25)[24].powi(2));
    close(ends.sum::<f64>() / 2000.0, 0.03 * 0.03 * 100.0, 0.01);
}

proptest! {
    #[test]
    fn limits_hold(seed in 0u64..1000, min in -0.1..0.0, max in 0.0..0.1) {
        let values = history(Wandering { min, max, ..FREE }, seed, 1.0, 500);
        prop_assert!(values.iter().all(|value| (min..=max).contains(value)));
        prop_assert!(values.contains(&min) && values.contains(&max), "they are reached");
    }
}

#[test]
fn seed_reproduces_the_process() {
    assert_eq!(history(FREE, 3, 0.1, 50), history(FREE, 3, 0.1, 50));
    assert_ne!(history(FREE, 3, 0.1, 50), history(FREE, 4, 0.1, 50));
}

#[test]
fn rejects_parameters_out_of_range() {
    for (parameters, key) in [
        (Wandering { mu: -0.1, ..FREE }, "mu"),
        (Wandering { noise: f64::NAN, ..FREE }, "noise"),
        (Wandering { min: 0.1, ..FREE }, "min"),
        (Wandering { max: -0.1, ..FREE }, "max"),
    ] {
        let error = GaussMarkov::new(parameters, 1).unwrap_err();
        assert!(matches!(error, SeaError::NotAllowed { key: found, .. } if found == key), "{error}");
    }
}
