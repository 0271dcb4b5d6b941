//! Removal of controller states, with and without a limit on the fastest mode.

use crate::common;

use nalgebra::Complex;
use squid_lpv::controller::Controller;
use squid_lpv::matrix::Mat;
use squid_lpv::parameter_grid::parameter_grid;
use squid_lpv::partition::Group::{T, X};
use squid_lpv::plant::GeneralisedPlant;
use squid_lpv::reduce::{Reductions, reduce, without_fast_modes};
use squid_lpv::synthesis::{Design, Options, synthesise};

#[test]
fn a_reduced_controller_keeps_the_limit_on_its_fastest_mode() {
    let plant = common::plant(&common::case("compleib/compleib_HE4"));
    let thetas = parameter_grid(plant.blocks.len());
    let fastest = |design: &Design| design.controller.fastest_mode(&thetas);
    let design = synthesise(&plant, Options::default()).unwrap();
    let free = reduce(&plant, &design, None);
    assert!(free.controller.a().nrows() < design.controller.a().nrows(), "something can be removed");
    assert!(fastest(&free) > 0.0);

    let allowed = 1.001 * fastest(&free);
    assert_eq!(reduce(&plant, &design, Some(allowed)), free);

    // No controller between the full and the smallest one is slower: the full one is returned unchanged.
    let refused = reduce(&plant, &design, Some(0.5 * fastest(&free)));
    assert!(refused == design || fastest(&refused) <= 0.5 * fastest(&free));
    assert_ne!(refused, free);
}

/// Returns a scheduled design for a plant of one parameter, with its sizes: states and channels.
fn scheduled() -> (GeneralisedPlant, Design) {
    let plant = common::plant(&common::case("lpv01_lpvtools_lft_tutorial"));
    let design = synthesise(&plant, Options::default()).unwrap();
    (plant, design)
}

fn smallest(plant: &GeneralisedPlant, design: &Design, rise: f64) -> Design {
    Reductions::of(plant, design, rise, None).next().unwrap_or_else(|| design.clone())
}

fn sizes(design: &Design) -> (usize, usize) {
    let sizes = design.controller.parts.sizes();
    (sizes.x, sizes.t)
}

/// The bound is that of the smaller controller itself: no frozen gain is above it, and it rises by the share at most.
#[test]
fn a_smaller_controller_keeps_its_bound() {
    let (plant, design) = scheduled();
    let mut before = sizes(&design);
    for rise in [0.01, 0.1, 0.5] {
        let fewer = smallest(&plant, &design, rise);
        let (states, channels) = sizes(&fewer);
        assert!(states <= before.0 && channels <= before.1, "{rise}: {:?} after {before:?}", sizes(&fewer));
        assert!(
            fewer.certified.gamma <= (1.0 + rise) * design.certified.gamma
                && fewer.certified.largest_eigenvalue < 0.0
        );
        assert_eq!(
            (fewer.certified.x.nrows(), fewer.controller.blocks),
            (plant.a().nrows() + states, vec![channels])
        );
        let closed =
            plant.close(&Controller { parts: fewer.controller.parts.clone(), blocks: vec![channels] });
        for (theta, frozen) in closed.sampled(21).unwrap() {
            assert!(frozen.hinf_norm().value < fewer.certified.gamma, "{theta}");
        }
        before = (states, channels);
    }
    assert!(before < sizes(&design), "something can be removed");
}

/// Other coordinates of states and channels, of controller and plant, give the same sizes and the same gains.
#[test]
fn the_reduction_does_not_depend_on_coordinates() {
    let (plant, design) = scheduled();
    let fewer = smallest(&plant, &design, 0.1);
    let (n, r) = sizes(&design);
    let skewed = |size: usize| {
        Mat::from_fn(size, size, |i, j| {
            if i == j { 3f64.powi(i as i32 % 5 - 2) } else { 0.1 / (1 + i + 2 * j) as f64 }
        })
    };
    let (states, channels) = (skewed(n), skewed(r));
    let inverse = |m: &Mat| m.clone().try_inverse().unwrap();
    let moved = design
        .controller
        .parts
        .transformed(&[(X, &inverse(&states)), (T, &inverse(&channels))], &[(X, &states), (T, &channels)]);
    let lift = |m: &Mat, of: &Mat, own: &Mat| {
        let mut all = Mat::identity(of.nrows(), of.nrows());
        let first = of.nrows() - own.nrows();
        all.view_mut((first, first), own.shape()).copy_from(own);
        all.transpose() * m * all
    };
    let mut other = design.clone();
    other.controller = Controller { parts: moved, blocks: design.controller.blocks.clone() };
    other.certified.x = lift(&design.certified.x, &design.certified.x, &states);
    other.certified.factor = None;
    (other.certified.s, other.certified.t) = (
        lift(&design.certified.s, &design.certified.s, &channels),
        lift(&design.certified.t, &design.certified.s, &channels),
    );
    let again = smallest(&plant, &other, 0.1);
    assert_eq!(sizes(&again), sizes(&fewer));
    let gain = |design: &Design, theta: f64| {
        let frozen = plant.close(&design.controller).frozen(&[theta]).unwrap();
        frozen.hinf_norm().value
    };
    for theta in [-1.0, 0.3, 1.0] {
        let [one, other] = [&fewer, &again].map(|design| gain(design, theta));
        assert!((one - other).abs() < 1e-6 * one, "{theta}: {one} {other}");
    }
}

/// States and channels without effect are all removed, and nothing else changes.
#[test]
fn parts_without_effect_are_removed() {
    let (plant, design) = scheduled();
    let fewer = smallest(&plant, &design, 1e-3);
    let (n, r) = sizes(&design);
    let mut padded = design.clone();
    let mut parts = design.controller.parts.resized(X, n + 2).resized(T, r + 3);
    parts.block_mut(X, X).view_mut((n, n), (2, 2)).fill_with_identity();
    parts.block_mut(X, X).view_mut((n, n), (2, 2)).scale_mut(-1.0);
    padded.controller = Controller { parts, blocks: vec![r + 3] };
    let grown = |m: &Mat, by: usize, diagonal: f64| {
        let size = m.nrows() + by;
        Mat::from_fn(size, size, |i, j| match (i < m.nrows(), j < m.nrows()) {
            (true, true) => m[(i, j)],
            _ if i == j => diagonal,
            _ => 0.0,
        })
    };
    padded.certified.x = grown(&design.certified.x, 2, 1.0);
    padded.certified.factor = None;
    padded.certified.s = grown(&design.certified.s, 3, 1.0);
    padded.certified.t = grown(&design.certified.t, 3, 0.0);
    let again = smallest(&plant, &padded, 1e-3);
    assert!(sizes(&again).0 <= n && sizes(&again).1 <= r, "{:?} {:?}", sizes(&again), sizes(&fewer));
}

#[test]
fn fast_modes_are_replaced_by_their_static_gain() {
    let plant = common::plant(&common::case("compleib/compleib_AC15"));
    let design = synthesise(&plant, Options::default()).unwrap();
    let mut modes: Vec<f64> = design.controller.frozen(&[]).unwrap().poles().iter().map(|p| -p.re).collect();
    modes.sort_by(f64::total_cmp);
    let [.., second, fastest] = modes[..] else { panic!("{modes:?}") };
    let without = |limit: f64| without_fast_modes(&plant, &design, limit, 0.2);
    assert!(without(4.0 * fastest).is_none(), "there are none");
    let slowest = 0.5 * modes[0];
    assert!(without(slowest).is_none_or(|d| d.controller.fastest_mode(&[vec![]]) <= slowest));

    let slower = without((second * fastest).sqrt()).unwrap();
    let frozen = |design: &Design| design.controller.frozen(&[]).unwrap();
    assert_eq!(frozen(&slower).a.nrows(), modes.len() - 1);
    assert!(slower.controller.fastest_mode(&[vec![]]) < 1.001 * second);
    let gains = [&design, &slower].map(|d| frozen(d).response(Complex::new(0.0, 0.0)).unwrap());
    assert!((&gains[0] - &gains[1]).norm() < 1e-9 * gains[0].norm());
    let norm = plant.close(&slower.controller).frozen(&[]).unwrap().hinf_norm().value;
    assert!(norm <= slower.certified.gamma && slower.certified.gamma < 1.2 * design.certified.gamma);
}
