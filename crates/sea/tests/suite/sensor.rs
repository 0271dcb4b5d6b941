//! Sensors.

use proptest::prelude::*;
use squid_sea::{SeaError, Sensor, SensorErrors};

const NONE: SensorErrors = SensorErrors::NONE;
const TICK: f64 = 0.02;

fn sensor(errors: SensorErrors) -> Sensor {
    Sensor::new(errors, TICK, 5, 0).unwrap()
}

/// What is read at each tick of a signal that counts the ticks.
fn counted(errors: SensorErrors, ticks: u32) -> Vec<f64> {
    let mut sensor = sensor(errors);
    (0..ticks).map(|n| sensor.read(f64::from(n))).collect()
}

fn close(found: f64, expected: f64, tolerance: f64) {
    assert!((found - expected).abs() <= tolerance, "{found} instead of {expected}");
}

#[test]
fn a_sensor_without_errors_reads_what_is_there() {
    assert_eq!(counted(NONE, 4), [0.0, 1.0, 2.0, 3.0]);
    assert_eq!(counted(SensorErrors { rate: 50.0, ..NONE }, 4), [0.0, 1.0, 2.0, 3.0]);
}

/// 10 Hz at ticks of 0.02 s: every fifth; 20 Hz: after 0.06 and 0.1 s in turn, the first ticks after 0.05 and 0.1 s.
#[test]
fn samples_are_held() {
    let read = counted(SensorErrors { rate: 10.0, ..NONE }, 11);
    assert_eq!(read, [0.0, 0.0, 0.0, 0.0, 0.0, 5.0, 5.0, 5.0, 5.0, 5.0, 10.0]);
    let read = counted(SensorErrors { rate: 20.0, ..NONE }, 11);
    assert_eq!(read, [0.0, 0.0, 0.0, 3.0, 3.0, 5.0, 5.0, 5.0, 8.0, 8.0, 10.0]);
}

/// Rounded up to whole ticks; until the first sample has come it is read all the same.
#[test]
fn samples_come_late() {
    assert_eq!(counted(SensorErrors { delay: 0.04, ..NONE }, 5), [0.0, 0.0, 0.0, 1.0, 2.0]);
    assert_eq!(counted(SensorErrors { delay: 0.041, ..NONE }, 5), [0.0, 0.0, 0.0, 0.0, 1.0]);
    let read = counted(SensorErrors { delay: 0.04, rate: 10.0, ..NONE }, 9);
    assert_eq!(read, [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 5.0, 5.0]);
}

#[test]
fn noise_and_bias_are_what_is_said() {
    let mut sensor = sensor(SensorErrors { noise: 0.2, bias: 0.05, ..NONE });
    let off: Vec<f64> = (0..40_000).map(|_| sensor.read(1.0) - 1.0).collect();
    let mean = off.iter().sum::<f64>() / off.len() as f64;
    let square = off.iter().map(|one| (one - mean).powi(2)).sum::<f64>() / off.len() as f64;
    close(mean, 0.05, 0.004);
    close(square.sqrt(), 0.2, 0.003);
}

proptest! {
    /// What is read is a multiple of the quantum, and at most half of it away.
    #[test]
    fn steps_are_the_quantum(value in -5.0..5.0, quantum in 0.01..1.0) {
        let read = sensor(SensorErrors { quantum, ..NONE }).read(value);
        close(read / quantum, (read / quantum).round(), 1e-9);
        prop_assert!((read - value).abs() <= 0.5 * quantum * (1.0 + 1e-9));
    }

    /// A sensor of another number has other noise; so has another seed.
    #[test]
    fn each_sensor_has_noise_of_its_own(seed in 0u64..1000, number in 0u32..4) {
        let read = |seed, number| {
            let mut sensor = Sensor::new(SensorErrors { noise: 1.0, ..NONE }, TICK, seed, number).unwrap();
            [0; 4].map(|_| sensor.read(0.0))
        };
        prop_assert_eq!(read(seed, number), read(seed, number));
        prop_assert!(read(seed, number) != read(seed, number + 1));
        prop_assert!(read(seed, number) != read(seed + 1, number));
    }
}

#[test]
fn numbers_out_of_range_are_refused() {
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
