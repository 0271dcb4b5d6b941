//! mu of published problems, over frequency where they have one.
#![allow(clippy::unwrap_used)]

use lpv::matrix::Mat;
use lpv::mu::lower::lower_bound;
use lpv::mu::sweep::mu_over_frequency;
use lpv::mu::upper::upper_bound;
use lpv::mu::{Block, CMat, Structure};
use lpv::state_space::StateSpace;
use nalgebra::{Complex, dmatrix};

/// A real scalar that destabilises at one frequency alone: M = -(8/3) s/(s + 1)^3 is real at 1/sqrt(3) rad/s only,
/// and 1 there. (`(s + 1)^3 + (8/3) delta s` has roots at +-j/sqrt(3) for delta = -1.) Any grid of frequencies says
/// 0.
#[test]
fn an_isolated_peak_of_a_real_scalar_is_found_and_bounded() {
    let system = StateSpace {
        a: dmatrix![-3.0, -3.0, -1.0; 1.0, 0.0, 0.0; 0.0, 1.0, 0.0],
        b: dmatrix![1.0; 0.0; 0.0],
        c: dmatrix![0.0, -8.0 / 3.0, 0.0],
        d: dmatrix![0.0],
    };
    let found = mu_over_frequency(&system, &Structure::new(vec![Block::Real(1)]).unwrap()).unwrap();
    let lower = found.lower.unwrap();
    assert!((lower.value - 1.0).abs() < 1e-6, "{}", lower.value);
    assert!((lower.frequency.unwrap() - 1.0 / 3f64.sqrt()).abs() < 1e-5);
    assert!(found.upper.upper >= 1.0 - 1e-9 && found.upper.upper < 1.0 + 2e-4, "{}", found.upper.upper);
}

/// The spinning satellite of S. Skogestad, I. Postlethwaite, Multivariable Feedback Control, 2005, section 3.7.1: its
/// characteristic polynomial is `s^2 + (2 + d1 + d2) s + 1 + d1 + d2 + 101 d1 d2`, so the smallest real pair has `|d|
/// = 0.0995`, at zero frequency.
#[test]
fn the_spinning_satellite() {
    let (a, b, c) = (dmatrix![0.0, 10.0; -10.0, 0.0], Mat::identity(2, 2), dmatrix![1.0, 10.0; -10.0, 1.0]);
    // u = -(I + Delta) y: from the perturbation's output w to its input y, the sign in Delta.
    let closed = StateSpace { a: &a - &b * &c, b: -b, c, d: Mat::zeros(2, 2) };
    for block in [Block::Real(1), Block::Complex(1)] {
        let found = mu_over_frequency(&closed, &Structure::new(vec![block; 2]).unwrap()).unwrap();
        let expected = 10.049_875_621_120_89;
        let lower = found.lower.unwrap().value;
        assert!((lower / expected - 1.0).abs() < 1e-6, "{lower}");
        let upper = found.upper.upper;
        assert!(upper >= expected * (1.0 - 1e-9) && upper < expected * (1.0 + 2e-4), "{upper}");
    }
}

/// Fourteen real coefficients of a transport aircraft (G. Ferreres, A Practical Approach to Robustness Analysis,
/// 1999), on which a power iteration returns 0. Searching all 16384 corners gives a margin of 5.4281 at 0.6229 rad/s.
#[test]
fn fourteen_real_coefficients_of_an_aircraft() {
    let (system, structure) = aircraft();
    let begin = std::time::Instant::now();
    let found = mu_over_frequency(&system, &structure).unwrap();
    println!("{:?} {} pieces", begin.elapsed(), found.upper.pieces.len());
    let lower = found.lower.unwrap();
    println!("{} {:?} {:.1e} upper {}", lower.value, lower.frequency, lower.residual, found.upper.upper);
    assert!(lower.value > 0.184_225_93 * 0.99 && lower.value < 0.1845, "{}", lower.value);
    assert!(found.upper.upper >= 0.18422);
}

/// x = [beta p r phi] and the actuators; each coefficient c of A and B is `c (1 + 0.1 delta)`.
fn aircraft() -> (StateSpace, Structure) {
    let g = 0.146_418;
    let (alpha, tan): (f64, f64) = (8f64.to_radians(), 0.14);
    let nominal = [
        -0.082, 0.010_827, 0.060_268, 0.002, 0.0118, -0.84, -0.76, 0.74, 0.095, 0.06, 0.092, -0.23, -0.114,
        -0.151,
    ];
    let [yb, yp, yr, ydp, ydr, lb, lp, lr, ldp, ldr, nb, np, nr, ndr] = nominal;
    let a = dmatrix![
        yb, yp + alpha.sin(), yr - alpha.cos(), g;
        lb, lp, lr, 0.0;
        nb, np, nr, 0.0;
        0.0, 1.0, tan, 0.0
    ];
    let b = dmatrix![ydp, ydr; ldp, ldr; 0.0, ndr; 0.0, 0.0];
    let scale = -std::f64::consts::PI / 180.0 / g;
    let [cb, cp, cr] = [scale * yb, scale * yp, scale * yr];
    let c = dmatrix![cb, cp, cr, 0.0; 0.0, 1.0, 0.0, 0.0; 0.0, 0.0, 1.0, 0.0; 0.0, 0.0, 0.0, 1.0];
    let d = dmatrix![scale * ydp, scale * ydr; 0.0, 0.0; 0.0, 0.0; 0.0, 0.0];
    // Where each coefficient enters: the row of x', and the column of [A B]; the first row is also the first output.
    let places = [
        (0, 0),
        (0, 1),
        (0, 2),
        (0, 4),
        (0, 5),
        (1, 0),
        (1, 1),
        (1, 2),
        (1, 4),
        (1, 5),
        (2, 0),
        (2, 1),
        (2, 2),
        (2, 5),
    ];
    let k = dmatrix![-629.8858, 11.5254, 3.311, 9.4278; 285.9496, 0.3693, -2.6301, -0.5489];
    // Actuators in companion form: (-1.77 s + 399)/(s^2 + 48.2 s + 399) and (2.6 s^2 - 1185 s + 27350)/(s^3 + 77.7
    // s^2 + 3331 s + 27350).
    let mut aa = Mat::zeros(5, 5);
    aa.view_mut((0, 0), (2, 2)).copy_from(&dmatrix![-48.2, -399.0; 1.0, 0.0]);
    aa.view_mut((2, 2), (3, 3)).copy_from(&dmatrix![-77.7, -3331.0, -27350.0; 1.0, 0.0, 0.0; 0.0, 1.0, 0.0]);
    let ba = dmatrix![1.0, 0.0; 0.0, 0.0; 0.0, 1.0; 0.0, 0.0; 0.0, 0.0];
    let ca = dmatrix![-1.77, 399.0, 0.0, 0.0, 0.0; 0.0, 0.0, 2.6, -1185.0, 27350.0];
    // x' = A x + B u + E w, y = C x + D u + F w, z = Z [x; u], u = Ca xa, xa' = Aa xa + Ba v, v = -K y.
    let count = places.len();
    let (mut e, mut f, mut z) = (Mat::zeros(4, count), Mat::zeros(4, count), Mat::zeros(count, 6));
    for (i, (row, column)) in places.into_iter().enumerate() {
        e[(row, i)] = 1.0;
        if row == 0 {
            f[(0, i)] = scale;
        }
        z[(i, column)] = 0.1 * nominal[i];
    }
    let (zx, zu) = (z.columns(0, 4).into_owned(), z.columns(4, 2).into_owned());
    let mut whole = Mat::zeros(9, 9);
    whole.view_mut((0, 0), (4, 4)).copy_from(&a);
    whole.view_mut((0, 4), (4, 5)).copy_from(&(&b * &ca));
    whole.view_mut((4, 0), (5, 4)).copy_from(&(-&ba * &k * &c));
    whole.view_mut((4, 4), (5, 5)).copy_from(&(&aa - &ba * &k * &d * &ca));
    let mut input = Mat::zeros(9, count);
    input.view_mut((0, 0), (4, count)).copy_from(&e);
    input.view_mut((4, 0), (5, count)).copy_from(&(-&ba * &k * &f));
    let mut output = Mat::zeros(count, 9);
    output.view_mut((0, 0), (count, 4)).copy_from(&zx);
    output.view_mut((0, 4), (count, 5)).copy_from(&(&zu * &ca));
    let system = StateSpace { a: whole, b: input, c: output, d: Mat::zeros(count, count) };
    (system, Structure::new(vec![Block::Real(1); count]).unwrap())
}

/// The case that the manual of SLICOT's AB13MD prints: two real scalars, a full 2 x 2 block and two complex scalars.
#[test]
fn the_example_of_ab13md() {
    let (m, structure) = case("mu01_slicot_ab13md");
    let upper = upper_bound(&m, &structure).unwrap();
    assert!((upper.value / 41.747_534_08 - 1.0).abs() < 2e-5, "{}", upper.value);
    let lower = lower_bound(&m, &structure).unwrap().unwrap();
    println!("lower {} of {}", lower.value, upper.value);
    assert!(lower.value > 0.9 * upper.value && lower.value <= upper.value, "{}", lower.value);
}

/// Four complex scalars for which the bound by scalings is 1 and mu 0.87236 (A. Packard, J. C. Doyle, Automatica
/// 29(1), 1993; the latter by 400 starts of a local search).
#[test]
fn four_complex_scalars_with_a_gap() {
    let (m, structure) = case("mu04_packard_doyle_gap");
    let upper = upper_bound(&m, &structure).unwrap().value;
    let lower = lower_bound(&m, &structure).unwrap().unwrap().value;
    assert!((upper - 1.0).abs() < 2e-5, "{upper}");
    assert!(lower > 0.864 && lower < 0.87237, "{lower}");
}

/// Systems through which nothing passes, with states and without: mu is zero at every frequency, and no small number
/// spoils that.
#[test]
fn nothing_passes_through_zeros() {
    let structure = Structure::from_notation(&[(1, 0), (3, 3)]).unwrap();
    for n in [0, 2] {
        let system = StateSpace {
            a: -Mat::identity(n, n),
            b: Mat::zeros(n, 4),
            c: Mat::zeros(4, n),
            d: Mat::zeros(4, 4),
        };
        let found = mu_over_frequency(&system, &structure).unwrap();
        assert!(found.upper.upper < 1e-50 && found.lower.is_none(), "{}", found.upper.upper);
    }
}

/// A problem file of the published cases.
fn case(name: &str) -> (CMat, Structure) {
    let path = format!("{}/../../tests/cases/{name}.json", env!("CARGO_MANIFEST_DIR"));
    let file: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    let rows: Vec<Vec<(f64, f64)>> = serde_json::from_value(file["data"]["M"].clone()).unwrap();
    let blocks: Vec<(i64, i64)> = serde_json::from_value(file["data"]["blocks"].clone()).unwrap();
    let entry = |i: usize, j: usize| Complex::new(rows[i][j].0, rows[i][j].1);
    (CMat::from_fn(rows.len(), rows[0].len(), entry), Structure::from_notation(&blocks).unwrap())
}
