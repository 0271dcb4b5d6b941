//! Reference governor: references yield while a steering actuator stays at its limit, and return.

use crate::design::Rejected;
use crate::example::{self, PITCH, SPEED};
use proptest::prelude::*;
use squid_scheduled::*;

/// Ticks in [`HELD`].
const HELD_TICKS: usize = 50;
const MEASURED: f64 = -0.31;

/// Returns a design whose first thruster steers pitch and is weak; the others push along the hull.
fn design() -> ControllerDesign {
    let mut design = example::two_degrees();
    design.actuators[0].steers = vec!["pitch".into()];
    (design.actuators[0].minimum, design.actuators[0].maximum) = (-1e-6, 1e-6);
    design.trim.actuators.iter_mut().for_each(|row| row[0] = 0.0);
    let ends = [-0.5, 0.5].map(OverSpeed::Constant);
    design.envelope.insert("pitch".into(), ReferenceLimits { range: Some(ends), rate: None });
    design
}

/// Returns measurements and references at 1.9 m/s.
fn inputs(pitch: f64, reference: f64) -> Inputs {
    Inputs { measured: vec![pitch, 1.9, 0.0, 0.0, 0.0], references: vec![reference, 1.9, 0.0] }
}

fn started(design: &ControllerDesign) -> Autopilot {
    let mut autopilot = Autopilot::new(design).unwrap();
    autopilot.initialise(0.0, &inputs(-0.01, -0.01)).unwrap();
    autopilot
}

/// Returns an autopilot after a number of ticks with an unreachable pitch request, and its pitch reference at each.
fn held(design: &ControllerDesign, ticks: usize) -> (Autopilot, Vec<f64>) {
    let mut autopilot = started(design);
    let references = (0..ticks).map(|_| {
        autopilot.tick(&inputs(MEASURED, 0.4)).unwrap();
        assert!(autopilot.saturation()[0].now);
        autopilot.references()[PITCH]
    });
    let references = references.collect();
    (autopilot, references)
}

#[test]
fn reference_yields_to_measurement_after_a_second() {
    let (_, references) = held(&design(), 200);
    assert!(references[..HELD_TICKS].iter().all(|one| *one == 0.4), "{references:?}");
    for (index, one) in references[HELD_TICKS..].iter().enumerate() {
        let remaining = (-0.02 / 0.3 * (index + 1) as f64).exp();
        let expected = MEASURED + remaining * (0.4 - MEASURED);
        assert!((one - expected).abs() < 1e-12, "{index}: {one} {expected}");
    }
}

#[test]
fn yielding_reference_stays_in_range() {
    let mut autopilot = started(&design());
    for _ in 0..400 {
        autopilot.tick(&inputs(-0.9, 0.4)).unwrap();
    }
    assert_eq!(autopilot.references()[PITCH], -0.5);
}

#[test]
fn yields_only_to_steering_actuators() {
    let mut other = design();
    other.actuators[0].steers = vec![];
    let (autopilot, references) = held(&other, 200);
    assert!(references.iter().all(|one| *one == 0.4));
    assert_eq!(autopilot.saturation()[0], Saturation { now: true, ticks: HELD_TICKS as u32 });
}

#[test]
fn returns_to_request_within_rate_limit() {
    let mut quick = design();
    (quick.actuators[0].minimum, quick.actuators[0].maximum) = (-5.0, 5.0);
    let mut slow = quick.clone();
    slow.envelope.get_mut("pitch").unwrap().rate = Some([-0.1, 0.1].map(OverSpeed::Constant));
    let [mut free, mut limited] = [&quick, &slow].map(|design| {
        let mut autopilot = started(design);
        for _ in 0..100 {
            autopilot.tick(&inputs(MEASURED, 0.4)).unwrap();
        }
        assert!(autopilot.references()[PITCH] < 0.3, "{:?}", autopilot.references());
        // The measurement equals the request from here on: the command leaves its limit.
        for _ in 0..60 {
            autopilot.tick(&inputs(0.4, 0.4)).unwrap();
        }
        assert!(!autopilot.saturation()[0].now);
        autopilot
    });
    let mut last = free.references()[PITCH];
    for _ in 0..1000 {
        let before = limited.references()[PITCH];
        limited.tick(&inputs(0.4, 0.4)).unwrap();
        assert!((limited.references()[PITCH] - before).abs() <= 0.1 * 0.02 + 1e-15);
        free.tick(&inputs(0.4, 0.4)).unwrap();
        assert!(free.references()[PITCH] >= last);
        last = free.references()[PITCH];
    }
    assert_eq!((last, limited.references()[PITCH]), (0.4, 0.4));
    assert!(!free.outputs().reference_limited);
}

/// Checks that after a change of the request the reference stays between its start and the new request.
#[test]
fn stays_between_start_and_changed_request() {
    let (mut autopilot, references) = held(&design(), 200);
    let start = references[199];
    for request in [0.4, 0.1, -0.2, 0.3] {
        for _ in 0..5 {
            autopilot.tick(&inputs(autopilot.references()[PITCH], request)).unwrap();
            let now = autopilot.references()[PITCH];
            assert!((start.min(request)..=start.max(request)).contains(&now), "{request}: {now}");
        }
    }
}

#[test]
fn thrusters_do_not_brake_while_steering_is_saturated() {
    let braked = |steers: bool| {
        let mut design = design();
        if !steers {
            design.actuators[0].steers = vec![];
        }
        let mut autopilot = started(&design);
        let mut least = f64::INFINITY;
        for _ in 0..100 {
            let mut at = inputs(MEASURED, 0.4);
            // The speed is far too high: the thrusters would brake.
            at.measured[SPEED] = 2.9;
            autopilot.tick(&at).unwrap();
            assert!(autopilot.saturation()[0].now);
            least = autopilot.outputs().commands[1..].iter().copied().fold(least, f64::min);
        }
        least
    };
    assert!(braked(false) < -1.0);
    assert_eq!(braked(true), 0.0);
}

#[test]
fn snapshot_restores_governor() {
    let (mut one, _) = held(&design(), 70);
    let mut other = started(&design());
    other.restore(&one.snapshot()).unwrap();
    assert_eq!(one.saturation(), other.saturation());
    for tick in 0..200 {
        let at = inputs(if tick < 20 { MEASURED } else { 0.3 }, 0.4);
        one.tick(&at).unwrap();
        other.tick(&at).unwrap();
        assert_eq!(one.snapshot(), other.snapshot());
    }
}

#[test]
fn rejects_signals_that_cannot_be_steered() {
    let mut rejected = Rejected::new(design());
    for name in ["speed", "heave", "thruster_1"] {
        rejected.at("actuators[2].steers", |design| design.actuators[2].steers = vec![name.to_owned()]);
    }
    insta::assert_snapshot!(rejected.messages);
}

proptest! {
    /// Compares with central differences, while a reference yields and during its return.
    #[test]
    fn tangents_are_derivatives(
        pitch in -0.4..0.4f64,
        direction in prop::collection::vec(-1.0..1.0f64, 8),
        back in 0usize..120,
    ) {
        let (mut autopilot, _) = held(&design(), 70);
        for _ in 0..back {
            autopilot.tick(&inputs(0.4, 0.4)).unwrap();
        }
        let at = inputs(pitch, 0.3);
        let direction = Inputs { measured: direction[..5].to_vec(), references: direction[5..].to_vec() };
        let moved = |by: f64| {
            let mut moved = at.clone();
            moved.measured.iter_mut().zip(&direction.measured).for_each(|(to, d)| *to += by * d);
            moved.references.iter_mut().zip(&direction.references).for_each(|(to, d)| *to += by * d);
            let mut autopilot = autopilot.clone();
            autopilot.tick(&moved).unwrap();
            let all: Vec<f64> = autopilot.references().iter().chain(&autopilot.outputs().commands).copied().collect();
            all
        };
        let (high, here, low) = (moved(1e-5), moved(0.0), moved(-1e-5));
        let found = autopilot.tangents(false, &at, &direction).unwrap();
        let found: Vec<f64> = found.references.into_iter().chain(found.commands).collect();
        let each = || high.iter().zip(&here).zip(&low);
        prop_assume!(each().all(|((high, here), low)| (high - 2.0 * here + low).abs() < 1e-7 * here.abs().max(1.0)));
        for (found, ((high, _), low)) in found.iter().zip(each()) {
            let slope = (high - low) / 2e-5;
            prop_assert!((found - slope).abs() < 1e-5 * slope.abs().max(1.0), "{} {}", found, slope);
        }
    }
}
