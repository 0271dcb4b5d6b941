//! Plants with a direct path from u to y: the loop with it equals the loop without it.

use crate::common;

use nalgebra::dmatrix;
use proptest::prelude::*;
use squid_lpv::controller::Controller;
use squid_lpv::direct_path::{around, reduce, synthesise};
use squid_lpv::matrix::{Mat, block};
use squid_lpv::parameter_grid::parameter_grid;
use squid_lpv::partition::Group::{T, U, W, X, Y, Z};
use squid_lpv::partition::{PLANT, Partitioned, Sizes};
use squid_lpv::plant::GeneralisedPlant;
use squid_lpv::state_space::StateSpace;
use squid_lpv::synthesis::{Design, Options};

/// Returns the loop of a plant with D22 and a controller by solving all its equations at once for x', xk', z, zt, zk,
/// wt, wk, u and y.
fn loop_with(p: &GeneralisedPlant, d22: &Mat, k: &Controller, theta: &[f64]) -> Option<StateSpace> {
    let s = p.sizes();
    let (nk, rk) = (k.a().nrows(), k.dtt().nrows());
    let zero = Mat::zeros;
    let expand = |blocks: &[usize]| {
        let each: Vec<f64> =
            blocks.iter().zip(theta).flat_map(|(&r, &t)| std::iter::repeat_n(t, r)).collect();
        Mat::from_diagonal(&nalgebra::DVector::from_vec(each))
    };
    // zt, zk, u, y as functions of themselves, and of x, xk, w.
    let inner = block(&[
        &[&(&p.dtt() * expand(&p.blocks)), &zero(s.t, rk), &p.dt2(), &zero(s.t, s.y)],
        &[&zero(rk, s.t), &(&k.dtt() * expand(&k.blocks)), &zero(rk, s.u), &k.dty()],
        &[&zero(s.u, s.t), &(&k.dut() * expand(&k.blocks)), &zero(s.u, s.u), &k.duy()],
        &[&(&p.d2t() * expand(&p.blocks)), &zero(s.y, rk), d22, &zero(s.y, s.y)],
    ]);
    let from = block(&[
        &[&p.ct(), &zero(s.t, nk), &p.dt1()],
        &[&zero(rk, s.x), &k.ct(), &zero(rk, s.w)],
        &[&zero(s.u, s.x), &k.cu(), &zero(s.u, s.w)],
        &[&p.c2(), &zero(s.y, nk), &p.d21()],
    ]);
    let solved = (Mat::identity(inner.nrows(), inner.nrows()) - inner).lu().solve(&from)?;
    let own = block(&[
        &[&p.a(), &zero(s.x, nk), &p.b1()],
        &[&zero(nk, s.x), &k.a(), &zero(nk, s.w)],
        &[&p.c1(), &zero(s.z, nk), &p.d11()],
    ]);
    let through = block(&[
        &[&(&p.bt() * expand(&p.blocks)), &zero(s.x, rk), &p.b2(), &zero(s.x, s.y)],
        &[&zero(nk, s.t), &(&k.bt() * expand(&k.blocks)), &zero(nk, s.u), &k.by()],
        &[&(&p.d1t() * expand(&p.blocks)), &zero(s.z, rk), &p.d12(), &zero(s.z, s.y)],
    ]);
    let whole = own + through * solved;
    let n = s.x + nk;
    let part = |i, j, a, b| whole.view((i, j), (a, b)).into_owned();
    Some(StateSpace {
        a: part(0, 0, n, n),
        b: part(0, n, n, s.w),
        c: part(n, 0, s.z, n),
        d: part(n, n, s.z, s.w),
    })
}

fn apart(one: &StateSpace, other: &StateSpace) -> f64 {
    let far = |a: &Mat, b: &Mat| (a - b).amax() / (1.0 + a.amax());
    far(&one.a, &other.a).max(far(&one.b, &other.b)).max(far(&one.c, &other.c)).max(far(&one.d, &other.d))
}

fn matrix(rows: usize, cols: usize) -> impl Strategy<Value = Mat> {
    prop::collection::vec(-1.0..1.0, rows * cols).prop_map(move |v| Mat::from_vec(rows, cols, v))
}

const BLOCKS: [usize; 2] = [2, 1];

prop_compose! {
    /// Three states, two parameters in three channels, two w, z, y, and u, with a bounded loop through the parameters.
    fn random_plant()(whole in matrix(3 + 3 + 2 + 2, 3 + 3 + 2 + 2)) -> GeneralisedPlant {
        let sizes = Sizes { x: 3, t: 3, w: 2, u: 2, z: 2, y: 2 };
        let mut parts = Partitioned::of(whole, PLANT, sizes);
        parts.block_mut(T, T).scale_mut(0.2);
        parts.block_mut(Y, U).fill(0.0);
        GeneralisedPlant { parts, blocks: BLOCKS.to_vec() }
    }
}

proptest! {
    #[test]
    fn the_loop_with_a_direct_path_equals_the_loop_without(
        plant in random_plant(),
        whole in matrix(2 + 2 + 3, 2 + 2 + 3),
        d22 in matrix(2, 2),
        thetas in prop::collection::vec(prop::collection::vec(-1.0..1.0, 2), 4),
    ) {
        let k = Controller::from_matrix(&whole, 2, 2, 2, BLOCKS.to_vec());
        let Some(with) = around(&k, &d22) else { return Err(TestCaseError::reject("singular")) };
        // Rounding grows with the numbers.
        prop_assume!(with.matrix().amax() < 1e3);
        for theta in &thetas {
            let pair = (loop_with(&plant, &d22, &with, theta), loop_with(&plant, &Mat::zeros(2, 2), &k, theta));
            let (Some(with), Some(without)) = pair else { continue };
            prop_assume!(without.a.amax() < 1e3);
            prop_assert!(apart(&without, &with) < 1e-6, "{:e}", apart(&without, &with));
            prop_assert!(apart(&without, &plant.close(&k).frozen(theta).unwrap()) < 1e-6);
        }
        let again = around(&with, &-&d22).unwrap();
        prop_assert!((again.matrix() - k.matrix()).amax() < 1e-8 * with.matrix().amax().powi(2));
    }
}

fn assert_keeps_its_bound(plant: &GeneralisedPlant, d22: &Mat, design: &Design) {
    for theta in parameter_grid(plant.blocks.len()) {
        let frozen = loop_with(plant, d22, &design.controller, &theta).unwrap();
        assert!(frozen.poles().iter().all(|pole| pole.re < 0.0), "{theta:?}");
        assert!(frozen.hinf_norm().value < design.certified.gamma, "{theta:?}");
        assert!(design.controller.frozen(&theta).is_ok());
    }
}

const CASES: [&str; 4] = [
    "lpv05_one_param_lossless",
    "lpv03_lpvtools_grid2lft",
    "hs04_active_suspension",
    "compleib/compleib_AC15",
];

#[test]
fn a_direct_path_changes_neither_gamma_nor_bound() {
    for name in CASES {
        let plant = common::plant(&common::case(name));
        let without = squid_lpv::synthesis::synthesise(&plant, Options::default()).unwrap();
        let d22 =
            Mat::from_fn(plant.sizes().y, plant.sizes().u, |i, j| 0.3 + 0.5 * i as f64 - 0.2 * j as f64);
        let design = synthesise(&plant, &d22, Options::default()).unwrap();
        assert_eq!(design.gamma_optimum, without.gamma_optimum);
        assert!(design.certified.gamma <= 1.01 * without.certified.gamma, "{name}");
        assert_keeps_its_bound(&plant, &d22, &design);
        let reduced = reduce(&plant, &d22, &design, None);
        assert_keeps_its_bound(&plant, &d22, &reduced);
        // The limit on the modes applies to the controller that is returned.
        let fastest = design.controller.fastest_mode(&parameter_grid(plant.blocks.len()));
        let limited =
            synthesise(&plant, &d22, Options { fastest_mode: Some(1.001 * fastest), ..Options::default() });
        assert_eq!(limited.unwrap().controller, design.controller);
    }
}

/// D22 is minus the inverse of the controller's direct path: the unchanged controller would cause a division by zero.
#[test]
fn a_controller_that_is_singular_with_a_direct_path_is_changed() {
    let blocks = [
        (X, X, dmatrix![-1.0, 0.0; 1.0, 0.2]),
        (X, W, dmatrix![1.0, 0.0; 0.0, 0.0]),
        (X, U, dmatrix![1.0; 0.0]),
        (Z, X, dmatrix![0.0, 1.0; 0.0, 0.0]),
        (Z, W, dmatrix![0.0, 0.0; 0.0, 0.5]),
        (Z, U, dmatrix![0.0; 1.0]),
        (Y, X, dmatrix![0.0, 1.0]),
        (Y, W, dmatrix![0.0, 1.0]),
    ];
    let plant = GeneralisedPlant::new(vec![], &blocks).unwrap();
    let without = squid_lpv::synthesis::synthesise(&plant, Options::default()).unwrap();
    let d22 = dmatrix![-1.0 / without.controller.duy()[(0, 0)]];
    assert!(around(&without.controller, &d22).is_none());
    let design = synthesise(&plant, &d22, Options::default()).unwrap();
    assert!(design.certified.gamma <= 1.01 * without.certified.gamma);
    assert_keeps_its_bound(&plant, &d22, &design);
}

/// `I + Duy D22` is singular at one parameter value and changes its sign there: no small change helps.
#[test]
fn a_controller_that_is_singular_within_the_box_gets_lags() {
    let plant = common::plant(&common::case("lpv01_lpvtools_lft_tutorial"));
    let without = squid_lpv::synthesis::synthesise(&plant, Options::default()).unwrap();
    let direct = |theta: f64| without.controller.frozen(&[theta]).unwrap().d[(0, 0)];
    assert!((direct(-1.0) / direct(1.0) - 1.0).abs() > 0.05, "{} {}", direct(-1.0), direct(1.0));
    let d22 = dmatrix![-1.0 / direct(0.5)];
    let design = synthesise(&plant, &d22, Options::default()).unwrap();
    assert!(design.certified.gamma <= 1.2 * without.certified.gamma, "{}", design.certified.gamma);
    assert_keeps_its_bound(&plant, &d22, &design);
}
