//! Control law with references and measurements as inputs, and the filter of the speed reference.

use crate::design::Rejected;
use crate::example::{self, DEPTH, HEAVE, PITCH, RATE, SPEED, level};
use proptest::prelude::*;
use squid_scheduled::*;
use std::sync::LazyLock;

static CRUISE: LazyLock<Inputs> = LazyLock::new(|| Inputs {
    measured: vec![-0.01, 1.749, 0.0, 0.0, 0.0],
    references: vec![-0.01, 1.749, 0.0],
});

fn started(design: &ControllerDesign) -> Autopilot {
    let mut autopilot = Autopilot::new(design).unwrap();
    autopilot.initialise(0.0, &CRUISE).unwrap();
    autopilot
}

fn filtered(bandwidth: f64) -> ControllerDesign {
    ControllerDesign { reference_filter: Some(bandwidth), ..example::two_degrees() }
}

fn inputs() -> impl Strategy<Value = Inputs> {
    let measured = [-0.5..0.5, 0.3..3.2, 0.0..9.0, -0.3..0.3, -0.3..0.3];
    (measured, [-0.5..0.5, 0.3..3.2, 0.0..9.0]).prop_map(|(measured, references)| Inputs {
        measured: measured.into(),
        references: references.into(),
    })
}

fn assert_close(found: &[f64], expected: &[f64], tolerance: f64) {
    assert_eq!(found.len(), expected.len());
    for (found, expected) in found.iter().zip(expected) {
        assert!((found - expected).abs() <= tolerance * (1.0 + expected.abs()), "{found} is not {expected}");
    }
}

proptest! {
    /// Checks K (r - y) with r and y as separate inputs: the level trim that is subtracted from both cancels.
    #[test]
    fn references_less_measurements_are_errors(flight in prop::collection::vec(inputs(), 1..30)) {
        let (mut errors, mut both) = (started(&example::design()), started(&example::two_degrees()));
        for inputs in flight {
            errors.tick(&inputs).unwrap();
            both.tick(&inputs).unwrap();
            assert_close(&both.outputs().commands, &errors.outputs().commands, 1e-9);
            prop_assert_eq!(both.outputs().scheduling_parameter, errors.outputs().scheduling_parameter);
            prop_assert_eq!(&both.outputs().trim, &errors.outputs().trim);
        }
    }

    /// Checks that the command of tick k is output at tick k + d, until then the first one, and that nothing else is
    /// delayed.
    #[test]
    fn delay_shifts_commands(flight in prop::collection::vec(inputs(), 1..30), delay_ticks in 0..11usize) {
        let mut prompt = started(&filtered(0.7));
        let mut late = started(&ControllerDesign { delay_ticks, ..filtered(0.7) });
        let mut commands = vec![prompt.outputs().commands.clone(); delay_ticks];
        for inputs in flight {
            prompt.tick(&inputs).unwrap();
            late.tick(&inputs).unwrap();
            commands.push(prompt.outputs().commands.clone());
            prop_assert_eq!(&late.outputs().commands, &commands.remove(0));
            prop_assert_eq!(late.outputs().scheduling_parameter, prompt.outputs().scheduling_parameter);
            prop_assert_eq!(late.snapshot().state, prompt.snapshot().state);
        }
    }

    /// V_r(k Ts) = r + (V_r(0) - r) exp(-w_r k Ts) under a constant reference, for any communication points.
    #[test]
    fn filter_is_exact_exponential(
        bandwidth in 0.01..200.0f64,
        reference in 0.5..3.0f64,
        cuts in prop::collection::vec(1u32..40, 1..20),
    ) {
        let mut autopilot = started(&filtered(bandwidth));
        prop_assert_eq!(autopilot.filtered_speed(), 1.749, "the initialisation sets it to the reference");
        let held = Inputs { references: vec![-0.01, reference, 0.0], ..CRUISE.clone() };
        let mut ticks = 0;
        for cut in cuts {
            ticks += cut;
            autopilot.advance(f64::from(ticks) * 0.02, &held).unwrap();
            let expected = reference + (1.749 - reference) * (-bandwidth * f64::from(ticks) * 0.02).exp();
            prop_assert!((autopilot.filtered_speed() - expected).abs() < 1e-12);
        }
    }

    #[test]
    fn snapshot_contains_filter_and_delayed_commands(
        before in prop::collection::vec(inputs(), 1..20),
        after in prop::collection::vec(inputs(), 1..20),
    ) {
        let design = ControllerDesign { delay_ticks: 3, ..filtered(0.7) };
        let mut whole = started(&design);
        for inputs in &before {
            whole.tick(inputs).unwrap();
        }
        let mut again = started(&design);
        again.restore(&whole.snapshot()).unwrap();
        prop_assert_ne!(again.filtered_speed(), before.last().unwrap().references[SPEED], "in mid-filter");
        for inputs in &after {
            whole.tick(inputs).unwrap();
            again.tick(inputs).unwrap();
            prop_assert_eq!(whole.snapshot(), again.snapshot());
        }
    }

    /// Compares with central differences, away from the breakpoints of the trim table, initially and in a transient of
    /// V_r.
    #[test]
    fn tangents_are_derivatives(at in inputs(), direction in inputs(), initial: bool, delay_ticks in 0..2usize) {
        let near = |speed: f64| [0.49, 1.749, 3.0].iter().any(|corner| (speed - corner).abs() < 1e-3);
        prop_assume!(!near(at.measured[SPEED]) && !near(at.references[SPEED]));
        let mut design = ControllerDesign { delay_ticks, ..filtered(0.7) };
        design.controller_inputs[0] = example::input("depth", Kind::Reference, 2.0);
        design.controller_inputs[1] = example::input("heave", Kind::Measurement, 0.2);
        design.controller_inputs[2] = example::input("depth", Kind::Measurement, 2.0);
        design.actuators.iter_mut().for_each(|one| (one.minimum, one.maximum) = (-1e9, 1e9));
        let mut autopilot = started(&design);
        autopilot.tick(&Inputs { references: vec![0.1, 2.5, 4.0], ..CRUISE.clone() }).unwrap();
        if initial {
            autopilot.initialise(0.0, &at).unwrap();
        }
        let moved = |by: f64| {
            let mut moved = at.clone();
            moved.measured.iter_mut().zip(&direction.measured).for_each(|(to, d)| *to += by * d);
            moved.references.iter_mut().zip(&direction.references).for_each(|(to, d)| *to += by * d);
            let mut autopilot = autopilot.clone();
            if initial { autopilot.initialise(0.0, &moved).unwrap() } else { _ = autopilot.tick(&moved).unwrap() }
            autopilot.outputs().clone()
        };
        let (high, low) = (moved(1e-5), moved(-1e-5));
        let slopes: Vec<f64> =
            high.commands.iter().zip(&low.commands).map(|(high, low)| (high - low) / 2e-5).collect();
        let found = autopilot.tangents(initial, &at, &direction).unwrap();
        assert_close(&found.commands, &slopes, 1e-5);
        assert_close(&found.trim, &[(high.trim[0] - low.trim[0]) / 2e-5], 1e-5);
    }
}

/// Compares a gain on each kind of input with hand calculation: `u = D y` on the first actuator.
#[test]
fn inputs_are_deviations_from_the_level_trim_at_the_filtered_reference() {
    let kinds = [
        ("pitch", Kind::Reference, 0.2, 1.0),
        ("speed", Kind::Measurement, 0.5, 2.0),
        ("pitch_rate", Kind::Measurement, 0.1, 4.0),
        ("heave", Kind::Measurement, 0.4, 8.0),
        ("speed", Kind::Error, 0.3, 16.0),
    ];
    let mut design = filtered(10.0);
    design.controller_inputs = kinds.map(|(name, kind, scale, _)| example::input(name, kind, scale)).into();
    let gains = kinds.map(|(.., gain)| 1e-3 * gain).to_vec();
    let none = || vec![0.0; kinds.len()];
    design.lft.by = vec![none(); 2];
    design.lft.dty = vec![none(); 2];
    design.lft.duy = vec![gains, none(), none()];
    let mut autopilot = started(&design);
    let mut inputs = CRUISE.clone();
    (inputs.measured[RATE], inputs.measured[HEAVE]) = (0.05, -0.1);
    (inputs.measured[PITCH], inputs.measured[SPEED]) = (0.03, 1.9);
    inputs.references = vec![0.15, 3.0, 0.0];
    autopilot.tick(&inputs).unwrap();
    let speed = 3.0 - (3.0 - 1.749) * (-10.0 * 0.02f64).exp();
    assert!((autopilot.filtered_speed() - speed).abs() < 1e-15);
    autopilot.tick(&inputs).unwrap();
    let part = (speed - 1.749) / (3.0 - 1.749);
    let pitch = -0.01 + part * (-0.003 + 0.01);
    let heave = -0.0175 + part * (-0.009 + 0.0175);
    let y = [(0.15 - pitch) / 0.2, (1.9 - speed) / 0.5, 0.05 / 0.1, (-0.1 - heave) / 0.4, (3.0 - 1.9) / 0.3];
    let u: f64 = kinds.iter().zip(y).map(|((.., gain), y)| 1e-3 * gain * y).sum();
    let trim = [9.0 + part * 15.0, 8.0 + part * 15.0, 8.0 + part * 15.0];
    assert_close(&autopilot.outputs().commands, &[trim[0] + 100.0 * u, trim[1], trim[2]], 1e-13);
    assert_close(&autopilot.outputs().trim, &[pitch], 1e-15);
}

#[test]
fn level_flight_keeps_trim_commands() {
    let mut autopilot = started(&filtered(0.5));
    for speed in [0.5, 1.749, 2.8] {
        let level = level(autopilot.trim(), speed, 7.0);
        autopilot.initialise(0.0, &level).unwrap();
        let trim: Vec<f64> = (0..3).map(|index| autopilot.trim().command(speed, index)).collect();
        autopilot.advance(10.0, &level).unwrap();
        assert_eq!((autopilot.outputs().commands.as_slice(), autopilot.filtered_speed()), (&trim[..], speed));
    }
}

/// Checks that depths count from the initial one: a flight is the same to the bit at any initial depth.
#[test]
fn flight_does_not_depend_on_initial_depth() {
    let mut design = filtered(0.5);
    design.controller_inputs[0] = example::input("depth", Kind::Reference, 2.0);
    design.controller_inputs[2] = example::input("depth", Kind::Measurement, 2.0);
    design.signals[DEPTH].start = 20.0;
    assert_eq!((design.follows(DEPTH), design.measures(DEPTH), design.follows(PITCH)), (true, true, false));
    let flown = |start: f64| {
        let at = |k: f64| {
            let mut inputs = CRUISE.clone();
            inputs.references[DEPTH] = start + if k < 50.0 { 0.5 } else { 1.5 };
            inputs.measured[DEPTH] = start + 0.25 * (k / 64.0).floor();
            inputs
        };
        let mut autopilot = started(&design);
        autopilot.initialise(0.0, &at(0.0)).unwrap();
        assert_eq!(autopilot.origins()[DEPTH], start);
        let mut commands = vec![];
        for k in 0..200 {
            if k == 100 {
                let half = autopilot.snapshot();
                autopilot = started(&design);
                autopilot.restore(&half).unwrap();
            }
            autopilot.tick(&at(f64::from(k))).unwrap();
            commands.push(autopilot.outputs().commands.clone());
        }
        commands
    };
    let deep = flown(64.0);
    assert_eq!(deep, flown(0.0));
    assert!(deep[0] != deep[60] && deep[60] != deep[199]);
    let json = design.to_json().unwrap();
    assert_eq!(ControllerDesign::from_json(&json).unwrap(), design);
    Rejected::new(design).at("signals[2].start", |design| design.signals[DEPTH].start = f64::NAN);
}

#[test]
fn rejects_mismatched_snapshot() {
    let mut autopilot = started(&filtered(0.5));
    let good = autopilot.snapshot();
    let mut messages = String::new();
    for (change, sizes) in [
        ((|s: &mut Snapshot| s.filtered_speed = f64::NAN) as fn(&mut Snapshot), None),
        (|s| s.state.push(0.0), Some((3, 2))),
        (|s| s.delayed.push(0.0), Some((1, 0))),
        (|s| s.outputs.commands.truncate(1), Some((1, 3))),
    ] {
        let mut bad = good.clone();
        change(&mut bad);
        let error = autopilot.restore(&bad).unwrap_err();
        match error {
            SnapshotError::NotFinite { value } => assert!(value.is_nan() && sizes.is_none()),
            SnapshotError::Length { found, expected, .. } => assert_eq!(Some((found, expected)), sizes),
        }
        messages += &format!("{error}\n");
        assert_eq!(autopilot.snapshot(), good);
    }
    insta::assert_snapshot!(messages);
}

/// Checks that feedforward, level flight and trim pitch are those at the measured speed, for any reference.
#[test]
fn imposed_speed_replaces_reference() {
    let given = || {
        let mut design = example::two_degrees();
        design.controller_inputs[2] = example::input("pitch_rate", Kind::Measurement, 0.3);
        ControllerDesign { speed_given: true, ..design }
    };
    let mut free = given();
    free.speed_given = false;
    assert_eq!((given().follows(SPEED), given().measures(SPEED), free.follows(SPEED)), (false, true, true));
    let (mut one, mut other) = (started(&given()), started(&free));
    for (measured, reference) in [(1.1, 2.0), (2.4, 0.7), (0.6, 0.6)] {
        let at = |reference| Inputs {
            measured: vec![0.02, measured, 0.0, 0.01, 0.0],
            references: vec![0.05, reference, 0.0],
        };
        one.tick(&at(reference)).unwrap();
        other.tick(&at(measured)).unwrap();
        assert_eq!(one.outputs(), other.outputs());
        let direction = Inputs { measured: vec![0.0, 1.0, 0.0, 0.0, 0.0], references: vec![0.0, 5.0, 0.0] };
        let tangents = one.tangents(false, &at(reference), &direction).unwrap();
        let by = 1e-6;
        let moved = Inputs {
            measured: vec![0.02, measured + by, 0.0, 0.01, 0.0],
            references: vec![0.05, reference, 0.0],
        };
        let there = one.tangents(false, &moved, &direction).unwrap();
        for ((slope, before), after) in tangents.commands.iter().zip(&tangents.computed).zip(there.computed) {
            assert!(((after - before) / by - slope).abs() < 1e-3 * (1.0 + slope.abs()), "{slope}");
        }
        assert!(tangents.trim[0] != 0.0);
    }
    let json = given().to_json().unwrap();
    assert_eq!(ControllerDesign::from_json(&json).unwrap(), given());
    assert!(!free.to_json().unwrap().contains("speed_given"));
    let mut rejected = Rejected::new(given());
    rejected.at("speed_given", |design| design.reference_filter = Some(0.7));
    insta::assert_snapshot!(rejected.messages);
    assert!(ControllerDesign { speed_given: true, ..example::design() }.validate().is_err());
}
