//! Published and analytic optima, and properties of every controller.

use crate::common;

use lpv::partition::Group;
use lpv::plant::GeneralisedPlant;
use lpv::synthesis::{Design, Options, ScalingClass, least_gamma, synthesise};

/// The result may be above the optimum by the tolerance, and below it only by rounding.
fn assert_optimum(name: &str, found: f64, expected: f64, rtol: f64) {
    let relative = found / expected - 1.0;
    println!(
        "{name}: found {found:.7}, expected {expected:.7}, relative {relative:+.1e}, tolerance {rtol:.0e}"
    );
    assert!(relative.abs() <= rtol, "{name}: {found} against {expected}");
}

fn gamma(plant: &GeneralisedPlant, scalings: ScalingClass) -> f64 {
    least_gamma(plant, scalings).unwrap().1.gamma
}

/// Cases of plain H-infinity synthesis: the LMIs of an LPV problem without parameters.
const PLAIN: [&str; 13] = [
    "hs01_brl_oscillator",
    "hs02_gamma_sqrt065",
    "hs04_active_suspension",
    "compleib/compleib_AC15",
    "compleib/compleib_AC4",
    "compleib/compleib_DIS1",
    "compleib/compleib_HE1",
    "compleib/compleib_HE4",
    "compleib/compleib_NN2",
    "compleib/compleib_NN8",
    "compleib/compleib_REA1",
    "compleib/compleib_TG1",
    "compleib/compleib_WEC1",
];

#[test]
fn plain_h_infinity() {
    for name in PLAIN {
        let case = common::case(name);
        let found = gamma(&common::plant(&case), ScalingClass::SymmetricAndSkew);
        let expected = &case["expected"];
        let rtol = expected["rtol"].as_f64().unwrap();
        assert_optimum(name, found, expected["gamma"].as_f64().unwrap(), rtol);
    }
}

#[test]
fn badly_scaled_plant() {
    let case = common::case("lpv01_lpvtools_lft_tutorial");
    let expected = &case["expected"];
    let rtol = expected["rtol"].as_f64().unwrap();
    let found = gamma(&common::plant(&case), ScalingClass::SymmetricAndSkew);
    assert_optimum("lpv01", found, expected["gamma_opt"].as_f64().unwrap(), rtol);
}

#[test]
fn skew_scalings_pay_with_a_repeated_parameter() {
    let case = common::case("lpv03_lpvtools_grid2lft");
    let expected = &case["expected"];
    let rtol = expected["rtol"].as_f64().unwrap();
    let plant = common::plant(&case);
    let both = gamma(&plant, ScalingClass::SymmetricAndSkew);
    let symmetric = gamma(&plant, ScalingClass::Symmetric);
    assert_optimum("lpv03, S and T", both, expected["gamma_opt_S_and_T"].as_f64().unwrap(), rtol);
    assert_optimum("lpv03, S alone", symmetric, expected["gamma_opt_S_only"].as_f64().unwrap(), rtol);
    assert!(both < symmetric);
}

#[test]
fn one_parameter_loses_nothing() {
    let case = common::case("lpv05_one_param_lossless");
    let expected = &case["expected"];
    let rtol = expected["rtol"].as_f64().unwrap();
    let list = |key: &str| -> Vec<f64> { serde_json::from_value(expected[key].clone()).unwrap() };
    let scales: Vec<f64> = serde_json::from_value(case["data"]["Bt_scale"].clone()).unwrap();
    for (i, scale) in scales.into_iter().enumerate() {
        let mut plant = common::plant(&case);
        plant.parts.block_mut(Group::X, Group::T).scale_mut(scale);
        assert_optimum(
            "lpv05, S and T",
            gamma(&plant, ScalingClass::SymmetricAndSkew),
            list("gamma_vertices")[i],
            rtol,
        );
        assert_optimum(
            "lpv05, S alone",
            gamma(&plant, ScalingClass::Symmetric),
            list("gamma_S_only")[i],
            rtol,
        );
    }
}

const SCHEDULED: [&str; 3] =
    ["lpv01_lpvtools_lft_tutorial", "lpv03_lpvtools_grid2lft", "lpv05_one_param_lossless"];

/// Frozen gains below the bound and stable, on a grid of the parameter box.
fn assert_frozen_gains_below_the_bound(plant: &GeneralisedPlant, design: &Design) {
    let closed = plant.close(&design.controller);
    let parameters = plant.blocks.len();
    let steps: usize = 9;
    for index in 0..steps.pow(parameters as u32) {
        let theta: Vec<f64> = (0..parameters)
            .map(|p| -1.0 + 2.0 * ((index / steps.pow(p as u32)) % steps) as f64 / (steps - 1) as f64)
            .collect();
        let frozen = closed.frozen(&theta).unwrap();
        let norm = frozen.hinf_norm();
        assert!(frozen.is_stable(), "{theta:?}");
        assert!(
            norm.value < design.certified.gamma,
            "{theta:?}: {} against {}",
            norm.value,
            design.certified.gamma
        );
    }
}

#[test]
fn every_controller_keeps_its_bound_when_frozen() {
    for name in PLAIN.into_iter().chain(SCHEDULED) {
        let plant = common::plant(&common::case(name));
        let design = synthesise(&plant, Options::default()).unwrap_or_else(|e| panic!("{name}: {e}"));
        println!("{name}: least {:.5}, certified {:.5}", design.gamma_optimum, design.certified.gamma);
        let most = design.gamma_design.max(1.1 * design.gamma_optimum);
        assert!(design.certified.gamma <= most * (1.0 + 1e-9), "{name}");
        assert!(design.certified.largest_eigenvalue < 0.0, "{name}");
        assert_frozen_gains_below_the_bound(&plant, &design);
    }
}
