//! Sensors.

use proptest::prelude::*;
use squid_sea::{SeaError, Sensor, SensorErrors};

const NONE: SensorErrors = SensorErrors::NONE;
const TICK: f64 = 0.02;

fn sensor(errors: SensorErrors) -> Sensor {
    Sensor::new(errors, TICK, 5, 0).unwrap()
}

/// Returns the readings of a signal that counts the ticks.
fn readings(errors: SensorErrors, ticks: u32) -> Vec<f64> {
    let mut sensor = sensor(errors);
    (0..ticks).map(|n| sensor.read(f64::from(n))).collect()
}

fn close(found: f64, expected: f64, tolerance: f64) {
    assert!((found - expected).abs() <= tolerance, "{found} instead of {expected}");
}

#[test]
fn perfect_sensor_reads_the_value() {
    assert_eq!(readings(NONE, 4), [0.0, 1.0, 2.0, 3.0]);
    assert_eq!(readings(SensorErrors { rate: 50.0, ..NONE }, 4), [0.0, 1.0, 2.0, 3.0]);
}

/// 10 Hz at ticks of 0.02 s: every fifth tick; 20 Hz: after 0.06 and 0.1 s in turn, the first ticks after 0.05 and 0.1
/// s.
#[test]
fn holds_samples() {
    let values = readings(SensorErrors { rate: 10.0, ..NONE }, 11);
    assert_eq!(values, [0.0, 0.0, 0.0, 0.0, 0.0, 5.0, 5.0, 5.0, 5.0, 5.0, 10.0]);
    let values = readings(SensorErrors { rate: 20.0, ..NONE }, 11);
    assert_eq!(values, [0.0, 0.0, 0.0, 3.0, 3.0, 5.0, 5.0, 5.0, 8.0, 8.0, 10.0]);
}

/// Delays are rounded up to whole ticks; until the delay has passed, the first sample is read.
#[test]
fn delays_samples() {
    assert_eq!(readings(SensorErrors { delay: 0.04, ..NONE }, 5), [0.0, 0.0, 0.0, 1.0, 2.0]);
    assert_eq!(readings(SensorErrors { delay: 0.041, ..NONE }, 5), [0.0, 0.0, 0.0, 0.0, 1.0]);
    let values = readings(SensorErrors { delay: 0.04, rate: 10.0, ..NONE }, 9);
    assert_eq!(values, [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 5.0, 5.0]);
}

#[test]
fn noise_and_bias_match_the_parameters() {
    let mut sensor = sensor(SensorErrors { noise: 0.2, bias: 0.05, ..NONE });
    let deviations: Vec<f64> = (0..40_000).map(|_| sensor.read(1.0) - 1.0).collect();
    let mean = deviations.iter().sum::<f64>() / deviations.len() as f64;
    let square = deviations.iter().map(|one| (one - mean).powi(2)).sum::<f64>() / deviations.len() as f64;
    close(mean, 0.05, 0.004);
    close(square.sqrt(), 0.2, 0.003);
}

proptest! {
    /// A reading is a multiple of the quantum and at most half of it away from the value.
    #[test]
    fn quantises_readings(value in -5.0..5.0, quantum in 0.01..1.0) {
        let reading = sensor(SensorErrors { quantum, ..NONE }).read(value);
        close(reading / quantum, (reading / quantum).round(), 1e-9);
        prop_assert!((reading - value).abs() <= 0.5 * quantum * (1.0 + 1e-9));
    }

    /// Sensors with another number or another seed have other noise.
    #[test]
    fn sensors_have_independent_noise(seed in 0u64..1000, number in 0u32..4) {
        let reading = |seed, number| {
            let mut sensor = Sensor::new(SensorErrors { noise: 1.0, ..NONE }, TICK, seed, number).unwrap();
            [0; 4].map(|_| sensor.read(0.0))
        };
        prop_assert_eq!(reading(seed, number), reading(seed, number));
        prop_assert!(reading(seed, number) != reading(seed, number + 1));
        prop_assert!(reading(seed, number) != reading(seed + 1, number));
    }
}

#[test]
fn rejects_parameters_out_of_range() {
    for (errors, key) in [
        (SensorErrors { noise: -0.1, ..NONE }, "noise"),
        (SensorErrors { bias: f64::INFINITY, ..NONE }, "bias"),
        (SensorErrors { quantum: -1.0, ..NONE }, "quantum"),
        (SensorErrors { rate: 0.0, ..NONE }, "rate"),
        (SensorErrors { rate: f64::NAN, ..NONE }, "rate"),
        (SensorErrors { delay: 10.1, ..NONE }, "delay"),
    ] {
        let error = Sensor::new(errors, TICK, 1, 0).unwrap_err();
        assert!(matches!(error, SeaError::NotAllowed { key: found, .. } if found == key), "{error}");
    }
}
