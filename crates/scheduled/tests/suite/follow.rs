//! Following commands that are not the autopilot's, and taking over from them.

use crate::example::{self, DEPTH, PITCH, SPEED};
use nalgebra::{DMatrix, dmatrix};
use proptest::prelude::*;
use squid_scheduled::*;

/// Two states, three actuators; the state acts on the commands through Cu alone, and the gain is its pseudo-inverse.
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

/// What the autopilot commands next from a state.
fn reachable(autopilot: &Autopilot, inputs: &Inputs, state: [f64; 2]) -> Vec<f64> {
    let mut other = autopilot.clone();
    let mut snapshot = other.snapshot();
    snapshot.state = state.to_vec();
    other.restore(&snapshot).unwrap();
    other.tick(inputs).unwrap();
    other.outputs().commands.clone()
}

proptest! {
    /// The next command is what was applied, and a second call changes nothing.
    #[test]
    fn the_next_command_is_the_applied_one(
        pitch in -0.2..0.2f64,
        speed in 1.0..2.5f64,
        state in prop::array::uniform2(-0.05..0.05f64),
    ) {
        let mut autopilot = started(&design());
        let now = inputs(pitch, speed);
        // The references go to the measured values first.
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

    /// From whatever was applied the commands open in a second to the limits, whatever the controller wants.
    #[test]
    fn the_commands_open_within_a_second(
        applied in prop::array::uniform3(-50.0..50.0f64),
        turned in prop::array::uniform3(-1.0..1.0f64),
    ) {
        let mut autopilot = started(&design());
        autopilot.follow(&inputs(-0.01, 1.749), &applied).unwrap();
        let mut now = inputs(turned[0], 1.75 + turned[1]);
        now.references[0] = turned[2];
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

/// While it follows, references are where the vehicle is; then they go to what is asked through two lags of 1 s.
#[test]
fn references_begin_where_the_vehicle_is() {
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
        let left = 0.15 * (1.0 + time) * (-time).exp();
        assert!((autopilot.references()[PITCH] - (0.1 - left)).abs() < 1e-9);
    }
    for _ in 0..10 * ticks {
        autopilot.tick(&now).unwrap();
    }
    assert_eq!(autopilot.references()[PITCH], 0.1);
    assert_eq!(autopilot.references()[SPEED], 1.9);
    assert!(!autopilot.outputs().reference_limited);
}

/// Delayed commands are the applied ones until the controller's own come out.
#[test]
fn what_is_delayed_is_what_was_applied() {
    let design = ControllerDesign { delay_ticks: 2, ..design() };
    let mut autopilot = started(&design);
    let now = inputs(-0.01, 1.749);
    autopilot.follow(&now, &[7.0, -70.0, 9.0]).unwrap();
    for _ in 0..2 {
        autopilot.tick(&now).unwrap();
        assert_eq!(autopilot.outputs().commands, [7.0, -50.0, 9.0]);
    }
}

/// A limit that is not the design's acts on the states as one of the design.
#[test]
fn limits_beyond_the_own_are_fed_back() {
    let gain = vec![vec![-0.3, 0.2, 0.1], vec![0.4, -0.1, 0.5]];
    let design = ControllerDesign { anti_windup: Some(gain.clone()), ..design() };
    let mut autopilot = started(&design);
    autopilot.tick(&inputs(-0.01, 1.749)).unwrap();
    let (before, put_out) = (autopilot.snapshot(), autopilot.outputs().commands.clone());
    autopilot.feed_back(&put_out).unwrap();
    assert_eq!(autopilot.snapshot(), before, "what came out is what was applied");
    let applied: Vec<f64> =
        put_out.iter().zip([1.0, 0.0, -2.0]).map(|(command, cut)| command - cut).collect();
    autopilot.feed_back(&applied).unwrap();
    let cut = dmatrix![1.0; 0.0; -2.0] / design.actuators[0].scale;
    let implicit = DMatrix::identity(2, 2) - dmatrix![-0.5, 1.0; -1.0, -2.0] * (0.5 * design.sample_time);
    let moved = implicit.try_inverse().unwrap() * DMatrix::from_fn(2, 3, |i, j| gain[i][j]) * cut;
    for (i, state) in autopilot.snapshot().state.iter().enumerate() {
        assert!((state - before.state[i] - design.sample_time * moved[i]).abs() < 1e-12);
    }
}

/// Gains over rho are linear in between.
#[test]
fn gains_are_linear_in_between() {
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
fn what_is_no_command_or_gain_is_refused() {
    let mut autopilot = started(&design());
    let now = inputs(-0.01, 1.749);
    for value in [f64::NAN, f64::INFINITY, -500.1] {
        let words = autopilot.follow(&now, &[0.0, value, 0.0]).unwrap_err().to_string();
        assert!(words.starts_with(&format!("the applied command of thruster_2 is {value} N")), "{words}");
        assert!(words.contains("500 N"), "{words}");
        assert_eq!(autopilot.feed_back(&[value, 0.0, 0.0]).unwrap_err().to_string().len(), words.len());
    }
    let mut short = design();
    short.follow[0].pop();
    assert_eq!(Autopilot::new(&short).unwrap_err().to_string(), "follow has 1 entries, but must have 2");
}
