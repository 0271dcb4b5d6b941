//! Singular problems: a controller is found, and the reported additions to the plant are correct.

use crate::common;

use nalgebra::dmatrix;
use squid_lpv::matrix::Mat;
use squid_lpv::partition::Group::{U, W, X, Y, Z};
use squid_lpv::plant::GeneralisedPlant;
use squid_lpv::regularise::Regularisation;
use squid_lpv::synthesis::{Design, Options, is_least, synthesise};

/// Returns the plant with the added outputs and disturbances, built as the remark describes them.
fn with(p: &GeneralisedPlant, added: &Regularisation) -> GeneralisedPlant {
    let s = p.sizes();
    let (more_z, more_w) = (added.weights.len(), added.noises.len());
    let weights = Mat::from_fn(more_z, s.u, |i, j| added.weights[i][j]);
    let noises = Mat::from_fn(s.y, more_w, |i, j| added.noises[j][i]);
    let parts = p.parts.resized(Z, s.z + more_z).resized(W, s.w + more_w);
    let mut out = GeneralisedPlant { parts, blocks: p.blocks.clone() };
    out.parts.block_mut(Z, U).rows_mut(s.z, more_z).copy_from(&weights);
    out.parts.block_mut(Y, W).columns_mut(s.w, more_w).copy_from(&noises);
    out
}

const UNITS: [f64; 5] = [1e3, 1e-2, 10.0, 0.1, 20.0];

/// Returns the plant with other units of u, y, z, w and time.
fn in_other_units(p: &GeneralisedPlant) -> GeneralisedPlant {
    let [u, y, z, w, rate] = UNITS;
    let mut out = p.clone();
    for (row, unit) in [(X, rate), (Z, z), (Y, y)] {
        out.parts.rows_mut(row).scale_mut(unit);
    }
    for (column, unit) in [(W, w), (U, u)] {
        out.parts.columns_mut(column).scale_mut(unit);
    }
    out
}

/// Designs for a singular plant without parameters, and checks the loops of the given and of the modified plant.
fn assert_holds(plant: &GeneralisedPlant) -> Design {
    let design = synthesise(plant, Options::default()).unwrap();
    let norm = |plant: &GeneralisedPlant| {
        let closed = plant.close(&design.controller).frozen(&[]).unwrap();
        assert!(closed.poles().iter().all(|pole| pole.re < 0.0));
        closed.hinf_norm().value
    };
    let added = design.regularisation.as_ref().unwrap();
    let (without, with) = (norm(plant), norm(&with(plant, added)));
    assert!(without < design.certified.gamma && with < design.gamma_design, "{without} {with}");
    assert!(without < with);
    design
}

#[test]
fn the_bound_is_near_the_least_gamma() {
    let plant = common::plant(&common::case("singular/five_states_one_control"));
    let design = assert_holds(&plant);
    assert!(design.certified.gamma <= 1.1001 * design.gamma_optimum, "{}", design.certified.gamma);
    assert!(design.lower > 0.99 * design.gamma_optimum);
    let added = design.regularisation.unwrap();
    assert_eq!((added.weights.len(), added.noises.len()), (1, plant.sizes().y));
}

/// The least gamma is zero without a weight on any control.
#[test]
fn additions_are_in_the_users_units() {
    let mut plant = common::plant(&common::case("compleib/compleib_DIS1"));
    plant.parts.block_mut(Z, U).fill(0.0);
    let added = |plant: &GeneralisedPlant| assert_holds(plant).regularisation.unwrap();
    let (here, there) = (added(&plant), added(&in_other_units(&plant)));
    let [u, y, z, w, _] = UNITS;
    for (one, other, unit) in [(here.weights, there.weights, z * u), (here.noises, there.noises, y * w)] {
        assert_eq!(one.len(), 4);
        for (one, other) in one.iter().flatten().zip(other.iter().flatten()) {
            // Balancing ends slightly differently from another start; an omitted unit is a factor of at least 10.
            let ratio = if *other == 0.0 { 1.0 } else { unit * one / other };
            assert!((0.5..2.0).contains(&ratio), "{one} {other}");
        }
    }
}

#[test]
fn a_plant_with_weights_and_noise_has_no_additions() {
    let design = synthesise(&common::plant(&common::case("hs02_gamma_sqrt065")), Options::default()).unwrap();
    assert_eq!(design.regularisation, None);
}

/// Returns a missile's pitch autopilot at one flight condition: measured are angle of attack, with the disturbance, and
/// rate, without noise; the weight on the control has three zeros at the origin and three modes at 1000 rad/s.
fn missile(damping: f64, stiffness: f64) -> GeneralisedPlant {
    let a = dmatrix![
        -damping, 1.0, 0.0, 0.0, 0.0, 0.0;
        -stiffness, 0.0, 0.0, 0.0, 0.0, 0.0;
        1.0, 0.0, -0.20101, 0.0, 0.0, 0.0;
        0.0, 0.0, 0.0, -12064.0, -1136.0, 1066.1;
        0.0, 0.0, 0.0, 10000.0, 0.0, 0.0;
        0.0, 0.0, 0.0, 0.0, -1000.0, 0.0];
    let blocks = [
        (X, X, a),
        (X, W, dmatrix![0.0; 0.0; 1.0; 0.0; 0.0; 0.0]),
        (X, U, dmatrix![0.0; 1.0; 0.0; 10.0; 0.0; 0.0]),
        (
            Z,
            X,
            dmatrix![0.0, 0.0, 2.0101, 0.0, 0.0, 0.0; 0.0, 0.0, 0.0, -11676.1395, -1099.4776, 1031.824885],
        ),
        (Z, U, dmatrix![0.0; 9.6785]),
        (Y, X, dmatrix![1.0, 0.0, 0.0, 0.0, 0.0, 0.0; 0.0, 1.0, 0.0, 0.0, 0.0, 0.0]),
        (Y, W, dmatrix![1.0; 0.0]),
    ];
    GeneralisedPlant::new(vec![], &blocks).unwrap()
}

/// One combination of the measurements is free of noise at every frequency if they are more than the disturbances; with
/// more controls than outputs, in the dual plant, one is free of weight. The first Riccati equation alone gives a lower
/// bound of gamma, and a controller that nearly attains it an upper one.
#[test]
fn more_measurements_than_disturbances_or_controls_than_outputs_are_handled() {
    for (plant, least) in [(missile(0.5, 106.0), 0.135_857), (missile(0.5, 0.0), 0.136_557)] {
        for plant in [plant.clone(), in_other_units(&plant), plant.dual()] {
            let design = synthesise(&plant, Options { back_off: 0.01, ..Options::default() }).unwrap();
            let (optimum, lower, gamma) = (design.gamma_optimum, design.lower, design.certified.gamma);
            assert!((optimum / least - 1.0).abs() < 1e-5, "{optimum} {least}");
            assert!(lower >= (1.0 - 1e-5) * optimum && is_least(&plant, optimum, lower), "{lower} {optimum}");
            assert!(gamma >= lower && gamma <= 1.01 * optimum, "{gamma} {optimum}");
        }
    }
}
