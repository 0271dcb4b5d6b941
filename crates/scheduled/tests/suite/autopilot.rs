//! Times, inputs and outputs of ticks.

use crate::example::{self, PITCH, SIGNALS, SPEED, TRACKED};
use proptest::prelude::*;
use squid_scheduled::{Autopilot, Inputs, TickError};
use std::sync::LazyLock;

static CRUISE: LazyLock<Inputs> = LazyLock::new(|| inputs([-0.01, 1.749], [-0.01, 1.749]));

/// Measured values and references of pitch and speed; the other signals are 0.
fn inputs(measured: [f64; 2], references: [f64; 2]) -> Inputs {
    let mut inputs = Inputs { measured: vec![0.0; SIGNALS], references: vec![0.0; TRACKED] };
    (inputs.measured[PITCH], inputs.measured[SPEED]) = (measured[0], measured[1]);
    (inputs.references[PITCH], inputs.references[SPEED]) = (references[0], references[1]);
    inputs
}

/// Inputs that differ at every communication point.
fn inputs_at(time: f64) -> Inputs {
    inputs([0.1 * time.sin(), 1.7 + (0.7 * time).sin()], [0.17, 1.5 + 0.5 * (0.3 * time).cos()])
}

fn started() -> Autopilot {
    let mut autopilot = Autopilot::new(&example::design()).unwrap();
    autopilot.initialise(0.0, &CRUISE).unwrap();
    autopilot
}

/// Returns the number of ticks that run until a time.
fn ticks_to(autopilot: &mut Autopilot, to: f64, inputs: &Inputs) -> u64 {
    let before = autopilot.ticks();
    autopilot.advance(to, inputs).unwrap();
    autopilot.ticks() - before
}

#[test]
fn outputs_trim_for_zero_errors() {
    let mut autopilot = started();
    for second in 1..100 {
        autopilot.advance(f64::from(second), &CRUISE).unwrap();
        assert_eq!(autopilot.outputs().commands, [9.0, 8.0, 8.0]);
    }
    let outputs = autopilot.outputs();
    assert_eq!(
        (outputs.scheduling_parameter, &outputs.trim[..], outputs.out_of_range),
        (0.0, &[-0.01][..], false)
    );
}

/// Compares with hand calculation at rho = 0 and zero state: u = Duy_d y with Duy_d = Duy + Cu (I - A T/2)^-1 By T/2.
#[test]
fn initial_outputs_are_feedforward_and_direct_feedthrough() {
    let off = inputs([-0.01 - 0.17, 1.749], [-0.01, 1.749]);
    let mut autopilot = Autopilot::new(&example::design()).unwrap();
    autopilot.initialise(0.0, &off).unwrap();
    // I - A T/2 = [1.005 -0.01; 0.01 1.02]
    let determinant = 1.005 * 1.02 + 0.01 * 0.01;
    let x = [(1.02 * 0.3 + 0.01 * 0.1) / determinant, (-0.01 * 0.3 + 1.005 * 0.1) / determinant];
    let u = 0.1 + 0.01 * (0.1 * x[0] + 0.05 * x[1]);
    assert!((autopilot.outputs().commands[0] - (9.0 + 100.0 * u)).abs() < 1e-12);
    assert_eq!(autopilot.ticks(), 0);
    let initial = autopilot.outputs().clone();
    autopilot.advance(0.02, &off).unwrap();
    assert_eq!(
        (autopilot.ticks(), autopilot.outputs()),
        (1, &initial),
        "the first tick starts from rest too"
    );
}

#[test]
fn tick_uses_inputs_of_step_starting_with_it() {
    let mut autopilot = started();
    assert_eq!(ticks_to(&mut autopilot, 0.02, &CRUISE), 1);
    let moved = inputs([0.0, 1.749], [-0.01, 1.749]);
    assert_eq!(ticks_to(&mut autopilot, 0.03, &moved), 1, "the tick at 0.02 s");
    let held = autopilot.outputs().clone();
    assert_eq!(ticks_to(&mut autopilot, 0.04, &CRUISE), 0);
    assert_eq!(autopilot.outputs(), &held);
}

#[test]
fn large_steps_run_several_ticks() {
    let mut autopilot = started();
    assert_eq!(ticks_to(&mut autopilot, 1.0, &CRUISE), 50);
    assert_eq!(ticks_to(&mut autopilot, 1.005, &CRUISE), 1);
    assert_eq!(ticks_to(&mut autopilot, 1.02, &CRUISE), 0);
    assert_eq!(ticks_to(&mut autopilot, 2.0, &CRUISE), 49);
}

#[test]
fn rounding_neither_skips_nor_repeats_a_tick() {
    for step in [0.00999999999999934, 0.01, 0.010000000000000009] {
        let (mut autopilot, mut time) = (started(), 0.0);
        for _ in 0..100_000 {
            time += step;
            autopilot.advance(time, &CRUISE).unwrap();
        }
        assert_eq!(autopilot.ticks(), 50_000, "{step}");
    }
}

#[test]
fn reports_when_next_tick_is_due() {
    let mut autopilot = Autopilot::new(&example::design()).unwrap();
    autopilot.initialise(3.0, &CRUISE).unwrap();
    for tick in 0..1000 {
        let due = 3.0 + f64::from(tick) * 0.02;
        assert_eq!(autopilot.next_tick_time(), due);
        assert!(
            !autopilot.is_due_before(due) && !autopilot.is_due_before(due + 1e-9),
            "held back by rounding"
        );
        assert!(autopilot.is_due_before(due + 1e-6));
        autopilot.tick(&CRUISE).unwrap();
        assert_eq!(autopilot.ticks(), tick as u64 + 1);
    }
}

proptest! {
    /// Ticks use the inputs of the step that contains them. Here the inputs change at multiples of the sample time
    /// only, so all communication points must give the same outputs.
    #[test]
    fn outputs_do_not_depend_on_the_communication_points(
        cuts in prop::collection::vec(1u32..200, 1..60),
        start in -5.0..5.0f64,
        jitter in -1e-9..1e-9f64,
    ) {
        let (mut cut, mut whole) = (started(), started());
        cut.initialise(start, &inputs_at(0.0)).unwrap();
        whole.initialise(start, &inputs_at(0.0)).unwrap();
        let mut elapsed = 0.0;
        for (k, &steps) in cuts.iter().enumerate() {
            let inputs = inputs_at(k as f64);
            let pieces = 1 + steps % 5;
            let length = f64::from(steps) * 0.02;
            for piece in 1..=pieces {
                let to = start + elapsed + length * f64::from(piece) / f64::from(pieces) + jitter;
                cut.advance(to, &inputs).unwrap();
            }
            for _ in 0..steps {
                whole.tick(&inputs).unwrap();
            }
            elapsed += length;
            prop_assert_eq!(cut.ticks(), whole.ticks());
            prop_assert_eq!(cut.outputs(), whole.outputs());
        }
    }
}

#[test]
fn reports_once_when_speed_leaves_range() {
    let mut autopilot = started();
    let mut to = 0.0;
    let mut left = |speed: f64| {
        to += 0.1;
        let left_range = autopilot.advance(to, &inputs([-0.01, speed], [-0.01, 1.749])).unwrap();
        let outputs = autopilot.outputs();
        (left_range, outputs.out_of_range, outputs.scheduling_parameter)
    };
    assert_eq!(left(3.0), (false, false, 1.0));
    assert_eq!(left(3.1), (true, true, 1.0));
    assert_eq!(left(3.2), (false, true, 1.0));
    assert!(!left(1.0).1);
    assert_eq!(left(0.2), (true, true, -1.0));
    assert_eq!(left(0.49), (false, false, -1.0));
}

#[test]
fn commands_stay_within_their_limits() {
    let mut autopilot = started();
    autopilot.advance(5.0, &inputs([10.0, 1.749], [-0.01, 1.749])).unwrap();
    assert_eq!(autopilot.outputs().commands[0], -60.0);
    autopilot.advance(10.0, &inputs([-10.0, 1.749], [-0.01, 1.749])).unwrap();
    assert_eq!(autopilot.outputs().commands[0], 100.0);
}

#[test]
fn rejects_inputs_that_are_not_finite() {
    let mut autopilot = started();
    let error = autopilot.advance(1.0, &inputs([-0.01, f64::NAN], [-0.01, 1.749])).unwrap_err();
    assert!(matches!(error, TickError::InputNotFinite { name, .. } if name == "speed"));
}

#[test]
fn rejects_singular_loop() {
    let mut design = example::design();
    // I - Dtt_d Theta = 0 in the second channel at rho = 1, when its row of Ct is zero.
    design.lft.ct[1] = vec![0.0, 0.0];
    design.lft.dtt[1] = vec![0.0, 1.0];
    let mut autopilot = Autopilot::new(&design).unwrap();
    assert!(autopilot.initialise(0.0, &CRUISE).is_ok());
    let error = autopilot.initialise(0.0, &inputs([-0.01, 3.0], [-0.01, 1.749])).unwrap_err();
    assert!(matches!(error, TickError::SingularLoop { parameter: 1.0, .. }), "{error}");
}

#[test]
fn tracks_pitch_alone() {
    let mut design = example::design();
    design.controller_inputs.truncate(1);
    for rows in [&mut design.lft.by, &mut design.lft.duy, &mut design.lft.dty] {
        rows.iter_mut().for_each(|row| row.truncate(1));
    }
    let mut autopilot = Autopilot::new(&design).unwrap();
    autopilot.initialise(0.0, &inputs([-0.01, 1.749], [-0.01, 0.49])).unwrap();
    assert_eq!(autopilot.outputs().commands, [1.5, 1.0, 1.0], "an error of speed has no effect");
}
