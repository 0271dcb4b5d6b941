//! Following the commands of another source, and taking over from it.

use crate::design::Rejected;
use crate::example::{self, DEPTH, PITCH, SPEED};
use nalgebra::{DMatrix, dmatrix};
use proptest::prelude::*;
use squid_scheduled::*;

/// Returns a design with two states and three actuators, whose state acts on the commands through Cu alone; the gain is
/// the pseudo-inverse of Cu.
fn design() -> ControllerDesign {
    let mut design = example::two_degrees();
    for actuator in &mut design.actuators {
        (actuator.minimum, actuator.maximum) = (-50.0, 50.0);
    }
    let alone = [&mut design.lft.bt, &mut design.lft.dut];
    alone.into_iter().flatten().flatten().for_each(|entry| *entry = 0.0);
    let discrete = Autopilot::new(&design).unwrap().controller().lft().cu.clone();
    let cu = DMatrix::from_fn(3, 2, |i, j| discrete.row(i)[j]);
    let gain = cu.pseudo_inverse(1e-12).unwrap();
    design.follow = vec![(0..2).map(|i| gain.row(i).iter().copied().collect()).collect()];
    design
}

fn inputs(pitch: f64, speed: f64) -> Inputs {
    Inputs { measured: vec![pitch, speed, 20.0, 0.0, 0.0], references: vec![0.1, 1.9, 22.0] }
}

fn started(design: &ControllerDesign) -> Autopilot {
    let mut autopilot = Autopilot::new(design).unwrap();
    autopilot.initialise(0.0, &inputs(-0.01, 1.749)).unwrap();
    autopilot
}

/// Returns the next commands of the autopilot from a state.
fn reachable(autopilot: &Autopilot, inputs: &Inputs, state: [f64; 2]) -> Vec<f64> {
    let mut other = autopilot.clone();
    let mut snapshot = other.snapshot();
    snapshot.state = state.to_vec();
    other.restore(&snapshot).unwrap();
    other.tick(inputs).unwrap();
    other.outputs().commands.clone()
}

proptest! {
    /// Checks that the next command is the applied one, and that a second call changes nothing.
    #[test]
    fn next_command_is_the_applied_one(
        pitch in -0.2..0.2f64,
        speed in 1.0..2.5f64,
        state in prop::array::uniform2(-0.05..0.05f64),
    ) {
        let mut autopilot = started(&design());
        let now = inputs(pitch, speed);
        // The first call moves the references to the measured values.
        autopilot.follow(&now, &[0.0; 3]).unwrap();
        let applied = reachable(&autopilot, &now, state);
        prop_assume!(applied.iter().all(|command| command.abs() < 49.0));
        autopilot.follow(&now, &applied).unwrap();
        let once = autopilot.snapshot();
        autopilot.follow(&now, &applied).unwrap();
        let again = autopilot.snapshot();
        for (one, other) in once.state.iter().zip(&again.state) {
            prop_assert!((one - other).abs() < 1e-9);
        }
        autopilot.tick(&now).unwrap();
        for (command, applied) in autopilot.outputs().commands.iter().zip(&applied) {
            prop_assert!((command - applied).abs() < 1e-6, "{command} is not {applied}");
        }
    }

    /// Checks that the range of the commands opens within a second from any applied command, for any command of the
    /// controller.
    #[test]
    fn commands_open_within_a_second(
        applied in prop::array::uniform3(-50.0..50.0f64),
        deviation in prop::array::uniform3(-1.0..1.0f64),
    ) {
        let mut autopilot = started(&design());
        autopilot.follow(&inputs(-0.01, 1.749), &applied).unwrap();
        let mut now = inputs(deviation[0], 1.75 + deviation[1]);
        now.references[0] = deviation[2];
        for tick in 0..50 {
            prop_assert!(autopilot.opens());
            autopilot.tick(&now).unwrap();
            for (command, applied) in autopilot.outputs().commands.iter().zip(&applied) {
                let (found, open) = ((command - applied).abs(), 100.0 * f64::from(tick) / 50.0);
                prop_assert!(found <= open * (1.0 + 1e-12) && command.abs() <= 50.0, "{found} {open}");
            }
        }
        prop_assert!(!autopilot.opens());
    }
}

/// Checks that references start at the measured values and go to the request through two lags of 1 s.
#[test]
fn references_start_at_measured_values() {
    let design = design();
    let mut autopilot = started(&design);
    let now = inputs(-0.05, 1.5);
    autopilot.follow(&now, &[1.0, 2.0, 3.0]).unwrap();
    assert!((autopilot.references()[PITCH] + 0.05).abs() < 1e-12);
    assert!((autopilot.references()[SPEED] - 1.5).abs() < 1e-12);
    assert!(autopilot.outputs().reference_limited);
    let depth_is_measured = design.measures(DEPTH);
    assert_eq!(autopilot.references()[DEPTH], if depth_is_measured { 20.0 } else { 22.0 });
    let ticks = (1.0 / design.sample_time).round() as usize;
    for tick in 0..ticks {
        autopilot.tick(&now).unwrap();
        let time = tick as f64 * design.sample_time;
        let remaining = 0.15 * (1.0 + time) * (-time).exp();
        assert!((autopilot.references()[PITCH] - (0.1 - remaining)).abs() < 1e-9);
    }
    for _ in 0..10 * ticks {
        autopilot.tick(&now).unwrap();
    }
    assert_eq!(autopilot.references()[PITCH], 0.1);
    assert_eq!(autopilot.references()[SPEED], 1.9);
    assert!(!autopilot.outputs().reference_limited);
}

/// Checks that the delayed commands are the applied ones until those of the controller are output.
#[test]
fn delay_holds_applied_commands() {
    let design = ControllerDesign { delay_ticks: 2, ..design() };
    let mut autopilot = started(&design);
    let now = inputs(-0.01, 1.749);
    autopilot.follow(&now, &[7.0, -70.0, 9.0]).unwrap();
    for _ in 0..2 {
        autopilot.tick(&now).unwrap();
        assert_eq!(autopilot.outputs().commands, [7.0, -50.0, 9.0]);
    }
}

/// Checks that an external limit acts on the states like one of the design.
#[test]
fn feeds_back_external_limits() {
    let gain = vec![vec![-0.3, 0.2, 0.1], vec![0.4, -0.1, 0.5]];
    let design = ControllerDesign { anti_windup: Some(gain.clone()), ..design() };
    let mut autopilot = started(&design);
    autopilot.tick(&inputs(-0.01, 1.749)).unwrap();
    let (before, commands) = (autopilot.snapshot(), autopilot.outputs().commands.clone());
    autopilot.feed_back(&commands).unwrap();
    assert_eq!(autopilot.snapshot(), before, "what came out is what was applied");
    let applied: Vec<f64> =
        commands.iter().zip([1.0, 0.0, -2.0]).map(|(command, cut)| command - cut).collect();
    autopilot.feed_back(&applied).unwrap();
    let cut = dmatrix![1.0; 0.0; -2.0] / design.actuators[0].scale;
    let implicit = DMatrix::identity(2, 2) - dmatrix![-0.5, 1.0; -1.0, -2.0] * (0.5 * design.sample_time);
    let expected = implicit.try_inverse().unwrap() * DMatrix::from_fn(2, 3, |i, j| gain[i][j]) * cut;
    for (i, state) in autopilot.snapshot().state.iter().enumerate() {
        assert!((state - before.state[i] - design.sample_time * expected[i]).abs() < 1e-12);
    }
}

/// Checks that gains are interpolated linearly over rho.
#[test]
fn interpolates_gains_linearly() {
    let at = |gains: &[f64], speed: f64| {
        let rows = |gain: &f64| vec![vec![*gain, 0.0, 0.0], vec![0.0, *gain, 0.0]];
        let design = ControllerDesign { follow: gains.iter().map(rows).collect(), ..design() };
        let mut autopilot = started(&design);
        autopilot.follow(&inputs(-0.01, speed), &[9.0, 9.0, 9.0]).unwrap();
        (autopilot.snapshot().state, autopilot.outputs().scheduling_parameter)
    };
    for speed in [0.1, 0.9, 1.3, 1.749, 2.2, 9.0] {
        let (state, rho) = at(&[0.01, 0.04, 0.03], speed);
        let expected = if rho < 0.0 { 0.04 + 0.03 * rho } else { 0.04 - 0.01 * rho };
        let (same, _) = at(&[expected], speed);
        assert!(state.iter().zip(&same).all(|(one, other)| (one - other).abs() < 1e-12), "{rho}");
    }
}

#[test]
fn rejects_invalid_commands_and_gains() {
    let mut autopilot = started(&design());
    let now = inputs(-0.01, 1.749);
    for value in [f64::NAN, f64::INFINITY, -500.1] {
        let (follow, feed_back) =
            (autopilot.follow(&now, &[0.0, value, 0.0]), autopilot.feed_back(&[value, 0.0, 0.0]));
        for (error, actuator) in [(follow, "thruster_2"), (feed_back, "thruster_1")] {
            let Err(TickError::AppliedTooLarge { name, value: found, most, .. }) = &error else {
                panic!("{error:?}")
            };
            assert_eq!((name.as_str(), found.to_bits(), *most), (actuator, value.to_bits(), 500.0));
        }
    }
    insta::assert_snapshot!(autopilot.follow(&now, &[0.0, -500.1, 0.0]).unwrap_err());
    Rejected::new(design()).at("follow", |short| drop(short.follow[0].pop()));
}
