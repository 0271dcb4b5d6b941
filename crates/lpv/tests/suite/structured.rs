//! Controllers of fixed structure: published plants with static output feedback, and scheduled loops.

use crate::common;
use nalgebra::dmatrix;
use squid_lpv::controller::Controller;
use squid_lpv::error::SynthesisError;
use squid_lpv::matrix::Mat;
use squid_lpv::partition::Group::{T, U, W, X, Y, Z};
use squid_lpv::plant::GeneralisedPlant;
use squid_lpv::structured::{STARTS, Structure, bound, minimax, tune};
use squid_lpv::synthesis::{Options, synthesise};

fn published(name: &str) -> GeneralisedPlant {
    common::plant(&common::case(&format!("compleib/compleib_{name}")))
}

/// Checks that static output feedback of a plant of COMPleib reaches at most `most`, and that its gain is that of the
/// loop.
fn static_output_feedback(name: &str, most: f64) {
    let plant = published(name);
    let structure = Structure::full(&plant, 0);
    let tuned = minimax(&plant, &structure, &vec![0.0; structure.gains()], STARTS).unwrap();
    let closed = plant.close(&structure.controller(&tuned.gains)).frozen(&[]).unwrap();
    let norm = closed.hinf_norm().value;
    assert!((norm - tuned.frozen_gain).abs() < 1e-6 * norm, "{name}: {norm} {}", tuned.frozen_gain);
    assert!(norm <= most, "{name}: {norm}");
}

/// The limits are the best gains known here of static output feedback, none of them from a published table.
#[test]
fn static_output_feedback_reaches_the_known_gains() {
    for (name, most) in [
        ("HE1", 0.1540),
        ("NN2", 2.2216),
        ("AC17", 6.6125),
        ("AC6", 4.1141),
        ("AC8", 2.0051),
        ("AC15", 15.19),
        ("REA1", 0.8718),
    ] {
        static_output_feedback(name, most);
    }
}

#[test]
#[ignore = "night: 16 starts with 16 and 24 gains take 15 s"]
fn static_output_feedback_with_many_gains_reaches_the_known_gain() {
    for (name, most) in [("DIS1", 4.18), ("HE4", 22.86)] {
        static_output_feedback(name, most);
    }
}

/// Returns a spring whose stiffness the parameter changes by 60 %, with a disturbance and noise.
fn spring() -> GeneralisedPlant {
    let blocks = [
        (X, X, dmatrix![0.0, 1.0; -1.0, -0.4]),
        (X, T, dmatrix![0.0; 1.0]),
        (X, W, dmatrix![0.0, 0.0; 1.0, 0.0]),
        (X, U, dmatrix![0.0; 1.0]),
        (T, X, dmatrix![0.6, 0.0]),
        (Z, X, dmatrix![1.0, 0.0; 0.0, 0.0]),
        (Z, U, dmatrix![0.0; 0.3]),
        (Y, X, dmatrix![1.0, 0.0]),
        (Y, W, dmatrix![0.0, 0.05]),
    ];
    GeneralisedPlant::new(vec![1], &blocks).unwrap()
}

/// The structure is position and filtered position with gains affine in theta: the bound for any trajectory falls below
/// that of the gains of smallest frozen norm, and is not below the least of any scheduled controller.
#[test]
fn the_proved_gain_is_minimised() {
    let plant = spring();
    // x' = -5 x + 5 y, u = g0 y + g1 x + w, z = g2 y + g3 x, w = theta z.
    let entry = |entries: &[(usize, usize, f64)]| {
        let mut m = Mat::zeros(3, 3);
        entries.iter().for_each(|(i, j, v)| m[(*i, *j)] = *v);
        m
    };
    let base = entry(&[(0, 0, -5.0), (0, 1, 5.0), (1, 2, 1.0)]);
    let base = Controller::from_matrix(&base, 1, 1, 1, vec![1]);
    let directions = [(1, 1), (1, 0), (2, 1), (2, 0)].map(|(i, j)| entry(&[(i, j, 1.0)])).to_vec();
    let structure = Structure::new(base, directions).unwrap();
    let start = [-1.0, 1.0, 0.0, 0.0];
    let frozen = minimax(&plant, &structure, &start, 6).unwrap();
    let tuned = tune(&plant, &structure, &start, 6).unwrap();
    let certified = &tuned.design.certified;
    let first = bound(&plant, &structure, &frozen.gains).unwrap();
    let least = synthesise(&plant, Options::default()).unwrap().gamma_optimum;
    assert!(certified.largest_eigenvalue < 0.0);
    assert!(certified.gamma < 0.98 * first.gamma, "{} {}", certified.gamma, first.gamma);
    assert!(certified.gamma > least && frozen.frozen_gain <= tuned.frozen_gain);
    assert_eq!(tuned.design.controller, structure.controller(&tuned.gains));
    let closed = plant.close(&tuned.design.controller);
    for (theta, frozen) in closed.sampled(41).unwrap() {
        assert!(frozen.hinf_norm().value < certified.gamma, "{theta}");
    }
}

/// No static output feedback stabilises a double integrator if only its position is measured.
#[test]
fn structures_without_a_stabilising_gain_are_rejected() {
    let blocks = [
        (X, X, dmatrix![0.0, 1.0; 0.0, 0.0]),
        (X, W, dmatrix![0.0; 1.0]),
        (X, U, dmatrix![0.0; 1.0]),
        (Z, X, dmatrix![1.0, 0.0]),
        (Y, X, dmatrix![1.0, 0.0]),
    ];
    let plant = GeneralisedPlant::new(vec![], &blocks).unwrap();
    let structure = Structure::full(&plant, 0);
    let error = minimax(&plant, &structure, &[0.0], 4).unwrap_err();
    assert!(matches!(error, SynthesisError::Numerical { .. }), "{error}");
    insta::assert_snapshot!(error);
    // One state is enough.
    let structure = Structure::full(&plant, 1);
    let tuned = minimax(&plant, &structure, &vec![0.0; structure.gains()], 4).unwrap();
    assert!(tuned.frozen_gain.is_finite());
}
