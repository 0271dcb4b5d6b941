//! Anti-windup: the excess over the limits is fed back to the controller's states.

use crate::design::key;
use crate::example;
use nalgebra::{DMatrix, DVector, dmatrix};
use squid_scheduled::*;

const GAIN: [[f64; 3]; 2] = [[-0.3, 0.2, 0.1], [0.4, -0.1, 0.5]];

fn with_gain(design: ControllerDesign) -> ControllerDesign {
    ControllerDesign { anti_windup: Some(GAIN.map(Vec::from).to_vec()), ..design }
}

fn limited(reach: f64) -> ControllerDesign {
    let mut design = example::two_degrees();
    for actuator in &mut design.actuators {
        (actuator.minimum, actuator.maximum) = (-reach, reach);
    }
    design
}

fn inputs(pitch_reference: f64) -> Inputs {
    Inputs { measured: vec![-0.01, 1.749, 0.0, 0.0, 0.0], references: vec![pitch_reference, 1.749, 0.0] }
}

fn started(design: &ControllerDesign) -> Autopilot {
    let mut autopilot = Autopilot::new(design).unwrap();
    autopilot.initialise(0.0, &inputs(-0.01)).unwrap();
    autopilot
}

#[test]
fn has_no_effect_within_limits() {
    let (mut with, mut without) =
        (started(&with_gain(example::two_degrees())), started(&example::two_degrees()));
    for tick in 0..50 {
        let wanted = inputs(0.2 * f64::from(tick).sin());
        with.tick(&wanted).unwrap();
        without.tick(&wanted).unwrap();
        assert_eq!(with.snapshot(), without.snapshot());
    }
}

/// Checks that `(I - A T/2)^-1 T E phi` is added to the states, phi in units of the scales.
#[test]
fn adds_excess_to_states() {
    let wanted = inputs(1.5);
    let (mut with, mut without, mut free) =
        (started(&with_gain(limited(50.0))), started(&limited(50.0)), started(&limited(1e6)));
    for one in [&mut with, &mut without, &mut free] {
        one.tick(&wanted).unwrap();
    }
    let phi = DVector::from_iterator(
        3,
        free.outputs().commands.iter().zip(&with.outputs().commands).map(|(free, cut)| (free - cut) / 100.0),
    );
    assert!(phi[0] > 0.1, "{phi}");
    let step = example::design().sample_time;
    let implicit = DMatrix::identity(2, 2) - dmatrix![-0.5, 1.0; -1.0, -2.0] * (0.5 * step);
    let gain = DMatrix::from_fn(2, 3, |i, j| GAIN[i][j]);
    let expected = implicit.try_inverse().unwrap() * gain * phi * step;
    let (with, without) = (with.snapshot().state, without.snapshot().state);
    for (i, expected) in expected.iter().enumerate() {
        assert!((with[i] - without[i] - expected).abs() < 1e-15, "{i}");
    }
}

#[test]
fn gain_round_trips() {
    let design = with_gain(example::two_degrees());
    let json = design.to_json().unwrap();
    assert_eq!(ControllerDesign::from_json(&json).unwrap(), design);
    let wrong = json.replace("[0.4, -0.1, 0.5]", "[0.4, -0.1]");
    assert_ne!(wrong, json);
    let error = ControllerDesign::from_json(&wrong).unwrap_err();
    assert_eq!(key(&error), "anti_windup[1]", "{error}");
}
