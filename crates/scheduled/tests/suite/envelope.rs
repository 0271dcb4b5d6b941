//! Limits of the references to what the vehicle can hold.

use crate::design::Rejected;
use crate::example::{self, DEPTH, PITCH, SPEED};
use proptest::prelude::*;
use squid_scheduled::*;
use std::collections::BTreeMap;

/// Limits of the pitch reference in the three rows of the trim table.
const LEAST: [f64; 3] = [-0.2, -0.3, -0.5];
const MOST: [f64; 3] = [0.1, 0.3, 0.4];

fn design(filter: Option<f64>) -> ControllerDesign {
    let columns =
        |least: [f64; 3], most: [f64; 3]| Some([least, most].map(|end| OverSpeed::from(end.to_vec())));
    let mut design = ControllerDesign { reference_filter: filter, ..example::two_degrees() };
    design.controller_inputs[3] = example::input("depth", Kind::Measurement, 2.0);
    design.controller_inputs[1] = example::input("depth", Kind::Reference, 2.0);
    design.envelope = BTreeMap::from([
        ("pitch".to_owned(), ReferenceLimits { range: columns(LEAST, MOST), rate: None }),
        ("depth".to_owned(), ReferenceLimits { range: None, rate: columns([-0.2; 3], [0.1, 0.5, 0.9]) }),
        (
            "speed".to_owned(),
            ReferenceLimits { range: columns([0.49; 3], [3.0; 3]), rate: columns([-0.5; 3], [0.4; 3]) },
        ),
    ]);
    design
}

fn inputs(pitch: f64, speed: f64, depth: f64) -> Inputs {
    Inputs { measured: vec![-0.01, 1.749, 20.0, 0.0, 0.0], references: vec![pitch, speed, depth] }
}

fn started(design: &ControllerDesign, at: &Inputs) -> Autopilot {
    let mut autopilot = Autopilot::new(design).unwrap();
    autopilot.initialise(0.0, at).unwrap();
    autopilot
}

#[test]
fn references_are_limited_over_speed() {
    let mut autopilot = started(&design(Some(1.0)), &inputs(6.0, 1.749, 20.0));
    assert_eq!(autopilot.references(), [0.3, 1.749, 20.0]);
    assert!(autopilot.outputs().reference_limited);
    autopilot.tick(&inputs(-9.0, 1.749, 20.0)).unwrap();
    assert_eq!(autopilot.references()[PITCH], -0.3);
    autopilot.tick(&inputs(0.2, 1.749, 20.0)).unwrap();
    assert_eq!((autopilot.references()[PITCH], autopilot.outputs().reference_limited), (0.2, false));
    // Half way between two rows.
    let speed = 0.5 * (1.749 + 3.0);
    let autopilot = started(&design(Some(1.0)), &inputs(6.0, speed, 20.0));
    assert!((autopilot.references()[PITCH] - 0.35).abs() < 1e-12);
}

/// Checks that each tick moves a reference by its rate limit, and finally exactly to the request.
#[test]
fn rates_are_limited() {
    let mut autopilot = started(&design(Some(1.0)), &inputs(0.0, 1.749, 20.0));
    let request = inputs(0.0, 9.0, 20.02);
    for tick in 1..=10 {
        let before = autopilot.filtered_speed();
        autopilot.tick(&request).unwrap();
        let depth = autopilot.references()[DEPTH];
        assert!(depth <= 20.02 && (depth - (20.0 + 0.0100 * f64::from(tick))).abs() < 1e-4 || depth == 20.02);
        assert!(autopilot.filtered_speed() >= before);
    }
    assert_eq!(autopilot.references()[DEPTH], 20.02);
    for _ in 0..200 {
        autopilot.tick(&request).unwrap();
    }
    assert_eq!(autopilot.references()[SPEED], 3.0, "the fastest speed of the trim table");
    assert!(autopilot.outputs().reference_limited);
}

/// Checks that a depth requested at the start is approached from the measured depth.
#[test]
fn rate_limit_starts_at_measured_value() {
    let mut autopilot = started(&design(None), &inputs(0.0, 1.749, 50.0));
    assert_eq!(autopilot.references()[DEPTH], 20.0);
    autopilot.tick(&inputs(0.0, 1.749, 50.0)).unwrap();
    assert!((autopilot.references()[DEPTH] - 20.01).abs() < 1e-3);
}

/// Checks that the law for the limited references is that of a design without limits.
#[test]
fn law_is_unchanged_for_limited_references() {
    let with = design(Some(1.0));
    let without = ControllerDesign { envelope: BTreeMap::new(), ..with.clone() };
    let start = inputs(0.0, 1.749, 20.0);
    let (mut with, mut without) = (started(&with, &start), started(&without, &start));
    for tick in 0..300 {
        let t = f64::from(tick);
        let request = inputs((0.05 * t).sin(), 1.8 + (0.02 * t).cos(), 20.0 + (0.03 * t).sin());
        with.tick(&request).unwrap();
        let limited = Inputs { references: with.references().to_vec(), ..request };
        without.tick(&limited).unwrap();
        assert_eq!(with.outputs().commands, without.outputs().commands);
        assert_eq!(with.snapshot().state, without.snapshot().state);
    }
}

#[test]
fn rejects_invalid_envelopes() {
    let limits = |range: [f64; 2], rows: usize| ReferenceLimits {
        range: Some(range.map(|end| OverSpeed::Table(vec![end; rows]))),
        rate: None,
    };
    let rate = ReferenceLimits { range: None, rate: Some([0.1, 0.2].map(OverSpeed::Constant)) };
    let mut rejected = Rejected::new(design(None));
    for (key, name, limits) in [
        ("envelope", "heave", limits([0.0, 1.0], 3)),
        ("envelope.pitch.range", "pitch", limits([0.0, 1.0], 2)),
        ("envelope.pitch.range[0][0]", "pitch", limits([1.0, 0.0], 3)),
        ("envelope.depth.rate[0]", "depth", rate),
        ("envelope.speed.range", "speed", limits([0.0, 1.0], 3)),
        ("envelope.pitch.range[0][0]", "pitch", limits([f64::NAN, 0.0], 3)),
    ] {
        rejected.at(key, |design| drop(design.envelope.insert(name.to_owned(), limits)));
    }
    insta::assert_snapshot!(rejected.messages);
}

proptest! {
    /// Compares with central differences where no limit is reached or left.
    #[test]
    fn tangents_are_derivatives(
        pitch in -1.0..1.0f64,
        speed in 0.6..2.9f64,
        depth in 19.0..21.0f64,
        direction in prop::collection::vec(-1.0..1.0f64, 8),
        filter: bool,
        when in 0..3,
    ) {
        // Cases: the initialisation; the first tick, with an initialisation at the same inputs before it; a later tick.
        let (initial, first) = (when == 0, when == 1);
        prop_assume!([0.49, 1.749, 3.0].iter().all(|corner| (speed - corner).abs() > 1e-3));
        let mut design = design(filter.then_some(0.7));
        design.actuators.iter_mut().for_each(|one| (one.minimum, one.maximum) = (-1e9, 1e9));
        let mut autopilot = started(&design, &inputs(0.0, 2.0, 20.0));
        autopilot.tick(&inputs(0.1, 2.5, 21.0)).unwrap();
        let mut at = inputs(pitch, speed, depth);
        at.measured[SPEED] = 1.9;
        if initial || first {
            autopilot.initialise(0.0, &at).unwrap();
        }
        let direction = Inputs { measured: direction[..5].to_vec(), references: direction[5..].to_vec() };
        let moved = |by: f64| {
            let mut moved = at.clone();
            moved.measured.iter_mut().zip(&direction.measured).for_each(|(to, d)| *to += by * d);
            moved.references.iter_mut().zip(&direction.references).for_each(|(to, d)| *to += by * d);
            let mut autopilot = autopilot.clone();
            if initial || first {
                autopilot.initialise(0.0, &moved).unwrap();
            }
            if !initial {
                autopilot.tick(&moved).unwrap();
            }
            let all: Vec<f64> = autopilot.references().iter().chain(&autopilot.outputs().commands).copied().collect();
            all
        };
        let (high, here, low) = (moved(1e-5), moved(0.0), moved(-1e-5));
        let found = if first {
            autopilot.first_tangents(&at, &direction).unwrap()
        } else {
            autopilot.tangents(initial, &at, &direction).unwrap()
        };
        let found: Vec<f64> = found.references.into_iter().chain(found.commands).collect();
        let each = || high.iter().zip(&here).zip(&low);
        // Points at the edge of a limit are excluded: the one-sided derivatives differ.
        prop_assume!(each().all(|((high, here), low)| (high - 2.0 * here + low).abs() < 1e-7 * here.abs().max(1.0)));
        for (found, ((high, _), low)) in found.iter().zip(each()) {
            let slope = (high - low) / 2e-5;
            prop_assert!((found - slope).abs() < 1e-5 * slope.abs().max(1.0), "{} {}", found, slope);
        }
    }
}
