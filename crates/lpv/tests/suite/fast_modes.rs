//! Weights with poles far beyond the plant's: gamma and controller are those for moderately fast ones.

use crate::common;

use squid_lpv::partition::Group::{X, Z};
use squid_lpv::plant::GeneralisedPlant;
use squid_lpv::synthesis::{Design, Options, synthesise};

/// Returns the tutorial plant of LPVTools with one more output: a tenth of the plant's, low-pass filtered at `rate`.
fn with_filter(rate: f64) -> GeneralisedPlant {
    let p = common::plant(&common::case("lpv01_lpvtools_lft_tutorial"));
    let s = p.sizes();
    let parts = p.parts.resized(X, s.x + 1).resized(Z, s.z + 1);
    let mut out = GeneralisedPlant { parts, blocks: p.blocks.clone() };
    out.parts.block_mut(X, X).view_mut((s.x, 0), (1, s.x)).copy_from(&(p.c2() * rate));
    out.parts.block_mut(X, X)[(s.x, s.x)] = -rate;
    out.parts.block_mut(Z, X)[(s.z, s.x)] = 0.1;
    out
}

/// Checks that the bound is proved for the given plant by the eigenvalues of its loop, also at three frozen parameters.
fn assert_bounded(plant: &GeneralisedPlant, design: &Design) {
    assert!(design.certified.largest_eigenvalue < 0.0);
    let closed = plant.close(&design.controller);
    for theta in [-1.0, 0.0, 1.0] {
        let norm = closed.frozen(&[theta]).unwrap().hinf_norm().value;
        assert!(norm < design.certified.gamma, "{norm} against {}", design.certified.gamma);
    }
}

#[test]
fn gamma_and_bound_do_not_change_with_a_fast_filter() {
    let reference = synthesise(&with_filter(1e5), Options::default()).unwrap();
    for rate in [1e7, 1e8, 1e9, 1e10, 1e11, 1e12] {
        let plant = with_filter(rate);
        let design = synthesise(&plant, Options::default()).unwrap();
        let (least, proved) = (design.gamma_optimum, design.certified.gamma);
        println!("filter at {rate:.0e} rad/s: least {least:.5}, proved {proved:.5}");
        assert!((least / reference.gamma_optimum - 1.0).abs() < 3e-3);
        assert!(proved < 1.1 * reference.gamma_optimum);
        assert_bounded(&plant, &design);
    }
}
