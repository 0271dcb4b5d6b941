//! LFTs against direct evaluation: a published case, an analytic case, and random ones.

use crate::common;

use nalgebra::dmatrix;
use proptest::prelude::*;
use squid_lpv::lft::Lft;
use squid_lpv::matrix::Mat;
use squid_lpv::polynomial::MatrixPolynomial;

/// `[[3 + del + eta, del/eta], [7 + rho, rho + del eta]]` of RobustAndOptimalControl.jl's tests, del = 2 +- 1, eta =
/// 6 +- 1, rho = -1 +- 1.
#[test]
fn a_rational_matrix_equals_its_formula() {
    let case = common::case("lft01_evaluation");
    let (del, eta, rho) =
        (Lft::parameter(0, 2.0, 1.0), Lft::parameter(1, 6.0, 1.0), Lft::parameter(2, -1.0, 1.0));
    // 1/(6 + theta) = 1/6 - theta/(1 + theta/6)/36.
    let reciprocal = Lft {
        constant: dmatrix![1.0 / 6.0],
        left: dmatrix![-1.0 / 6.0],
        inner: dmatrix![-1.0 / 6.0],
        right: dmatrix![1.0 / 6.0],
        channels: vec![1],
    };
    let number = |v: f64| Lft::constant(dmatrix![v]);
    let whole = number(3.0)
        .add(&del)
        .add(&eta)
        .concatenated(&del.multiply(&reciprocal))
        .stacked(&number(7.0).add(&rho).concatenated(&rho.add(&del.multiply(&eta))));
    let atol = case["expected"]["eval_atol"].as_f64().unwrap();
    for theta in [[0.0, 0.0, 0.0], [1.0, -1.0, 0.3], [-0.7, 0.9, -1.0]] {
        let (d, e, r) = (2.0 + theta[0], 6.0 + theta[1], -1.0 + theta[2]);
        let direct = dmatrix![3.0 + d + e, d / e; 7.0 + r, r + d * e];
        assert!((whole.evaluate(&theta).unwrap() - direct).amax() < atol);
    }
}

#[test]
fn the_product_and_sum_have_the_published_matrix() {
    let case = common::case("lft01_evaluation");
    let (del, eta, rho) =
        (Lft::parameter(0, 2.0, 1.0), Lft::parameter(1, 6.0, 1.0), Lft::parameter(2, -1.0, 1.0));
    let lft = del.multiply(&eta).add(&rho);
    let found = squid_lpv::matrix::block(&[&[&lft.inner, &lft.right], &[&lft.left, &lft.constant]]);
    assert_eq!(found, common::matrix(&case["expected"]["LFT_of_del_eta_plus_rho"]));
}

#[test]
fn a_second_order_polynomial_has_the_least_size() {
    let case = common::case("lft02_poly2_minimal");
    let coefficients = ["A0", "A1", "A2"].iter().map(|k| common::matrix(&case["data"][*k])).collect();
    let polynomial = MatrixPolynomial { coefficients };
    let lft = Lft::from_polynomial(&polynomial, 1e-10);
    assert_eq!(lft.size() as u64, case["expected"]["r_min"].as_u64().unwrap());
    let atol = case["expected"]["eval_atol"].as_f64().unwrap();
    for i in -10..=10 {
        let rho = f64::from(i) / 10.0;
        assert!((lft.evaluate(&[rho]).unwrap() - polynomial.evaluate(rho)).amax() < atol);
    }
}

#[test]
fn a_singular_loop_is_rejected() {
    let lft = Lft {
        constant: dmatrix![0.0],
        left: dmatrix![1.0],
        inner: dmatrix![1.0],
        right: dmatrix![1.0],
        channels: vec![0],
    };
    assert!(lft.evaluate(&[1.0]).is_err());
}

fn coefficients() -> impl Strategy<Value = Vec<Mat>> {
    (1..4usize, 1..5usize, 1..5usize).prop_flat_map(|(order, rows, cols)| {
        prop::collection::vec(
            prop::collection::vec(-2.0..2.0f64, rows * cols).prop_map(move |v| Mat::from_vec(rows, cols, v)),
            order + 1,
        )
    })
}

proptest! {
    #[test]
    fn a_polynomial_and_its_lft_agree(coefficients in coefficients(), rho in -1.0..1.0f64) {
        let polynomial = MatrixPolynomial { coefficients };
        let lft = Lft::from_polynomial(&polynomial, 1e-12);
        prop_assert!((lft.evaluate(&[rho]).unwrap() - polynomial.evaluate(rho)).amax() < 1e-10);
    }

    #[test]
    fn the_algebra_of_lfts_is_that_of_matrices(
        a in coefficients(), b in coefficients(), rho in -1.0..1.0f64, sigma in -1.0..1.0f64,
    ) {
        let p = Lft::from_polynomial(&MatrixPolynomial { coefficients: a }, 1e-12);
        let mut q = Lft::from_polynomial(&MatrixPolynomial { coefficients: b }, 1e-12);
        q.channels.iter_mut().for_each(|c| *c = 1);
        let theta = [rho, sigma];
        let (x, y) = (p.evaluate(&theta).unwrap(), q.evaluate(&theta).unwrap());
        if x.ncols() == y.nrows() {
            prop_assert!((p.multiply(&q).evaluate(&theta).unwrap() - &x * &y).amax() < 1e-8);
        }
        if x.shape() == y.shape() {
            prop_assert!((p.add(&q).evaluate(&theta).unwrap() - (&x + &y)).amax() < 1e-9);
        }
        if x.nrows() == y.nrows() {
            let expected = squid_lpv::matrix::block(&[&[&x, &y]]);
            prop_assert!((p.concatenated(&q).evaluate(&theta).unwrap() - expected).amax() < 1e-9);
        }
        if x.ncols() == y.ncols() {
            let expected = squid_lpv::matrix::block(&[&[&x], &[&y]]);
            prop_assert!((p.stacked(&q).evaluate(&theta).unwrap() - expected).amax() < 1e-9);
        }
    }
}
