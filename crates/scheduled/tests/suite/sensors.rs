//! Sensors that are stuck, jump, or have coarse resolution, and dead reckoning without them.

use crate::example::{DEPTH, PITCH, RATE, SPEED};
use crate::supervised::{Flight, design, level};
use squid_scheduled::*;

const TICK: f64 = 0.02;

/// Returns healthy readings of all sensors of a vehicle that pitches up and down around its trim by 0.3 rad.
fn pitching(tick: u32) -> Inputs {
    let time = f64::from(tick) * TICK;
    let mut at = level();
    at.measured[PITCH] += 0.3 * (0.5 * time).sin();
    at.measured[RATE] = 0.15 * (0.5 * time).cos();
    // Depth of the path, z' = -V (theta - theta0).
    at.measured[DEPTH] = 20.0 - 1.9 * 0.6 * (1.0 - (0.5 * time).cos());
    at
}

/// Flies with the readings modified by `read`, the speed driven by the commands; returns the health of the autopilot
/// and its pitch error at each tick.
fn fly(ticks: u32, read: impl Fn(u32, &mut Inputs)) -> Vec<(Health, f64)> {
    let mut flight = Flight::new(&design(), &pitching(0));
    let thrust = |flight: &Flight| flight.supervisor.commands().iter().sum::<f64>();
    let (at_first, mut speed) = (thrust(&flight), 1.9);
    let each = |tick: u32| {
        let truth = pitching(tick);
        let mut at = truth.clone();
        speed += TICK * (0.01 * (thrust(&flight) - at_first) - (speed - 1.9) / 10.0);
        at.measured[SPEED] = speed;
        read(tick, &mut at);
        let mut health = flight.tick(&at, &[true; 5], None).unwrap();
        if health == Health::Limited {
            health = Health::Ok;
        }
        (health, flight.supervisor.believed(PITCH) - truth.measured[PITCH])
    };
    (0..ticks).map(each).collect()
}

/// Checks a pitch sensor that reads zero for ever, has an offset of 14 deg, or points up: it is never used again, and
/// dead reckoning is within 1 deg a minute.
#[test]
fn never_regains_permanently_wrong_pitch() {
    let wrong: [fn(&mut f64); 3] = [|pitch| *pitch = 0.0, |pitch| *pitch += 0.25, |pitch| *pitch = 1.5];
    for (index, wrong) in wrong.into_iter().enumerate() {
        let flight = fly(6000, |tick, at| {
            if tick >= 100 {
                wrong(&mut at.measured[PITCH])
            }
        });
        let lost = flight.iter().position(|(health, _)| *health == Health::Reckoned).unwrap();
        assert!((100..160).contains(&lost), "{index}: {lost}");
        for (tick, (health, error)) in flight[lost..].iter().enumerate() {
            assert_eq!(*health, Health::Reckoned, "{index}: {tick}");
            assert!(error.abs() < 0.02, "{index}: {tick}: {error}");
        }
    }
}

/// Checks a pitch sensor that is stuck for a while and then recovers: it is used after the vehicle moved by more than
/// its error.
#[test]
fn regains_recovered_pitch() {
    let stuck = pitching(100).measured[PITCH];
    let flight = fly(3000, |tick, at| {
        if (100..500).contains(&tick) {
            at.measured[PITCH] = stuck;
        }
    });
    assert!(flight[..100].iter().all(|(health, _)| *health == Health::Ok));
    assert!(flight[150..500].iter().all(|(health, _)| *health == Health::Reckoned));
    let back = 500 + flight[500..].iter().position(|(health, _)| *health == Health::Ok).unwrap();
    let moved = (500..back as u32)
        .map(|tick| pitching(tick).measured[PITCH] - pitching(500).measured[PITCH])
        .fold(0.0f64, |most, moved| most.max(moved.abs()));
    assert!(moved > 0.08, "{back}: {moved}");
    assert!(flight[back..].iter().all(|(health, _)| *health == Health::Ok));
    // A sensor with a single wrong value is used again at once.
    let flight = fly(300, |tick, at| {
        if tick == 100 {
            at.measured[PITCH] = -0.9
        }
    });
    assert_eq!(flight.iter().filter(|(health, _)| *health == Health::Reckoned).count(), 26);
}

/// Checks that a resolution of 0.57 deg, 3 cm and 2 cm/s, and constant values without noise cause no loss.
#[test]
fn accepts_coarse_resolution_without_noise() {
    let coarse = |value: &mut f64, step: f64| *value = (*value / step).round() * step;
    for slow in [1, 20] {
        let flight = fly(6000, |tick, at| {
            let mut now = pitching(tick / slow);
            now.measured[RATE] /= f64::from(slow);
            // The depth of the slower flight is that of its own path.
            now.measured[DEPTH] = 20.0 + f64::from(slow) * (now.measured[DEPTH] - 20.0);
            now.measured[SPEED] = at.measured[SPEED];
            *at = now;
            coarse(&mut at.measured[PITCH], 0.01);
            coarse(&mut at.measured[DEPTH], 0.03);
            coarse(&mut at.measured[SPEED], 0.02);
        });
        let lost = flight.iter().filter(|(health, _)| *health != Health::Ok).count();
        assert_eq!(lost, 0, "{slow}");
    }
    let flight = fly(6000, |_, at| *at = level());
    assert!(flight.iter().all(|(health, _)| *health == Health::Ok));
}

/// Checks that a stuck speed under rising thrust is lost where the thrust would have changed it by 9 cm/s.
#[test]
fn loses_stuck_speed_under_thrust() {
    let mut flight = Flight::new(&design(), &level());
    let mut at = level();
    let mut lost = None;
    let mut before = 0.0;
    for tick in 0..3000 {
        at.references[SPEED] = if tick < 1000 { 1.9 } else { 2.5 };
        let health = flight.tick(&at, &[true; 5], None).unwrap();
        if tick == 999 {
            before = flight.supervisor.commands().iter().sum::<f64>();
            assert_ne!(health, Health::SpeedLost);
        }
        if lost.is_none() && health == Health::SpeedLost {
            lost = Some(tick);
        }
    }
    let after: f64 = flight.supervisor.commands().iter().sum();
    assert!((after - before).abs() > 1.0, "{before} {after}");
    assert!(lost.is_some_and(|tick| tick > 1000 && tick < 2500), "{lost:?}");
}

/// Checks that a log with a declared period of 1 s is not stuck between two of its values, and may change by the amount
/// possible in a second.
#[test]
fn accepts_values_at_declared_period() {
    for (period, is_lost) in [(1.0, false), (0.0, true)] {
        let mut design = design();
        let sensor = design.failsafe.as_mut().unwrap().sensors.get_mut("speed").unwrap();
        (sensor.period, sensor.resolution, sensor.error) = (period, 0.0, 0.01);
        let mut flight = Flight::new(&design, &level());
        let mut at = level();
        let mut lost = 0;
        for tick in 0..1000 {
            if tick % 50 == 0 {
                at.measured[SPEED] = 1.9 + 0.05 * f64::from(tick / 50 % 3);
            }
            lost += usize::from(flight.tick(&at, &[true; 5], None).unwrap() == Health::SpeedLost);
        }
        assert_eq!(lost > 0, is_lost, "{period} s: {lost}");
    }
}

/// Checks that pitch and its rate, stuck together, are both used half a second after they recover.
#[test]
fn regains_attitude_sensor_that_was_stuck() {
    let stuck = pitching(100);
    let mut design = design();
    design.failsafe.as_mut().unwrap().sensors.get_mut("pitch_rate").unwrap().resolution = 0.0;
    let mut flight = Flight::new(&design, &pitching(0));
    let health = |tick: u32| {
        let mut at = pitching(tick);
        at.measured[SPEED] += 1e-6 * f64::from(tick % 2);
        if (100..700).contains(&tick) {
            (at.measured[PITCH], at.measured[RATE]) = (stuck.measured[PITCH], stuck.measured[RATE]);
        }
        flight.tick(&at, &[true; 5], None).unwrap()
    };
    let all: Vec<Health> = (0..1000).map(health).collect();
    assert!(all[130..700].iter().all(|one| *one == Health::Failed));
    assert!(all[730..].iter().all(|one| matches!(one, Health::Ok | Health::Limited)), "{:?}", &all[700..740]);
}
