//! Discretisation preserves the frozen frequency response, and ticks compute what the matrices define.
use nalgebra::{Complex, DMatrix, DVector};
use proptest::prelude::*;
use squid_scheduled::{Lft, LftController, LftMatrices, Matrix, Rows};

type ComplexMatrix = DMatrix<Complex<f64>>;

fn dense(matrix: &Matrix) -> DMatrix<f64> {
    DMatrix::from_fn(matrix.rows(), matrix.columns(), |row, column| matrix.row(row)[column])
}

/// Returns the matrices A, B, C, D of the LFT with the loop through Theta closed.
fn close(lft: &Lft, theta: &[f64]) -> Option<[DMatrix<f64>; 4]> {
    let diagonal: Vec<f64> =
        lft.blocks.iter().zip(theta).flat_map(|(&count, &theta)| vec![theta; count]).collect();
    let theta = DMatrix::from_diagonal(&DVector::from_vec(diagonal));
    let r = theta.nrows();
    let through = DMatrix::identity(r, r) - dense(&lft.dtt) * &theta;
    let inverse = through.clone().try_inverse()?;
    if inverse.norm() * through.norm() > 1e2 {
        return None;
    }
    let gain = theta * inverse;
    let upper =
        |direct: &Matrix, out: &Matrix, input: &Matrix| dense(direct) + dense(out) * &gain * dense(input);
    Some([
        upper(&lft.a, &lft.bt, &lft.ct),
        upper(&lft.by, &lft.bt, &lft.dty),
        upper(&lft.cu, &lft.dut, &lft.ct),
        upper(&lft.duy, &lft.dut, &lft.dty),
    ])
}

/// C (s I - A)^-1 B + D, and the magnitude of its terms.
fn response([a, b, c, d]: &[DMatrix<f64>; 4], s: Complex<f64>) -> Option<(ComplexMatrix, f64)> {
    let complex = |matrix: &DMatrix<f64>| matrix.map(|entry| Complex::new(entry, 0.0));
    let pencil = ComplexMatrix::identity(a.nrows(), a.nrows()) * s - complex(a);
    let inverse = pencil.clone().try_inverse()?;
    if inverse.norm() * pencil.norm() > 1e3 {
        return None;
    }
    let size = c.norm() * inverse.norm() * b.norm() + d.norm();
    Some((complex(c) * inverse * complex(b) + complex(d), size))
}

#[derive(Debug, Clone)]
struct Case {
    lft: Lft,
    theta: Vec<f64>,
    sample_time: f64,
    angle: f64,
}

fn rows(height: usize, width: usize) -> impl Strategy<Value = Rows> {
    prop::collection::vec(prop::collection::vec(-1.0..1.0f64, width), height)
}

fn case() -> impl Strategy<Value = Case> {
    let sizes = (0usize..7, 1usize..4, 1usize..4, prop::collection::vec(0usize..4, 0..3));
    sizes.prop_flat_map(|(n, p, m, blocks)| {
        let r: usize = blocks.iter().sum();
        let theta = prop::collection::vec(-1.0..1.0f64, blocks.len());
        let states = (rows(n, n), rows(n, p), rows(n, r), rows(m, n), rows(m, p));
        let channels = (rows(m, r), rows(r, n), rows(r, p), rows(r, r));
        (states, channels, theta, 0.001..0.5f64, 0.01..3.0f64).prop_map(
            move |((a, by, bt, cu, duy), (dut, ct, dty, dtt), theta, sample_time, angle)| {
                let blocks = blocks.clone();
                let matrices = LftMatrices { blocks, a, by, bt, cu, duy, dut, ct, dty, dtt };
                Case { lft: Lft::from_rows(&matrices, p, m).unwrap(), theta, sample_time, angle }
            },
        )
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    /// K_d(e^{jwT}, theta) = K_c(j (2/T) tan(wT/2), theta), with `angle` = wT.
    #[test]
    fn keeps_frozen_frequency_response(case in case()) {
        let discrete = case.lft.discretise(case.sample_time).unwrap();
        let s = Complex::new(0.0, 2.0 / case.sample_time * (0.5 * case.angle).tan());
        let z = Complex::from_polar(1.0, case.angle);
        let continuous = close(&case.lft, &case.theta).and_then(|closed| response(&closed, s));
        let sampled = close(&discrete, &case.theta).and_then(|closed| response(&closed, z));
        prop_assume!(continuous.is_some() && sampled.is_some());
        let ((continuous, size), (sampled, _)) = (continuous.unwrap(), sampled.unwrap());
        // Too few digits are left for a comparison if the terms cancel.
        prop_assume!(continuous.norm() >= 0.1 * size);
        let error = (&sampled - &continuous).norm();
        prop_assert!(error <= 1e-10 * continuous.norm(), "{error:e}");
    }

    /// Checks that each tick gives u = C x + D y and x+ = A x + B y of the closed LFT, with another Theta at every
    /// tick.
    #[test]
    fn ticks_match_closed_matrices(case in case(), ys in prop::collection::vec(-1.0..1.0f64, 3 * 10)) {
        let discrete = case.lft.discretise(case.sample_time).unwrap();
        let sizes = discrete.sizes();
        let mut controller = LftController::new(discrete.clone());
        let mut state = DVector::zeros(sizes.states);
        for (tick, y) in ys.chunks(3).enumerate() {
            let theta: Vec<f64> = case.theta.iter().map(|theta| theta * (tick as f64).cos()).collect();
            let closed = close(&discrete, &theta);
            prop_assume!(closed.is_some());
            let [a, b, c, d] = closed.unwrap();
            let y = DVector::from_column_slice(&y[..sizes.inputs]);
            let mut u = vec![0.0; sizes.outputs];
            controller.output(y.as_slice(), &theta, &mut u).unwrap();
            controller.update();
            let expected = &c * &state + &d * &y;
            prop_assert!((DVector::from_vec(u) - &expected).norm() <= 1e-10 * (1.0 + expected.norm()));
            state = &a * &state + &b * &y;
            let error = (DVector::from_column_slice(controller.state()) - &state).norm();
            prop_assert!(error <= 1e-10 * (1.0 + state.norm()));
        }
    }
}

/// Compares with responses computed without this code; see `source` of the case.
#[test]
fn reproduces_published_responses() {
    let path = format!("{}/../../tests/cases/dis01_tustin_frozen.json", env!("CARGO_MANIFEST_DIR"));
    let case: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    let number = |value: &serde_json::Value| value.as_f64().unwrap();
    let (data, expected) = (&case["data"], &case["expected"]);
    let sample_time = number(&data["sample_time"]);
    let matrices = serde_json::from_value(data["controller"].clone()).unwrap();
    let discrete = Lft::from_rows(&matrices, 1, 1).unwrap().discretise(sample_time).unwrap();
    let responses = expected["responses"].as_array().unwrap();
    assert!(!responses.is_empty());
    for point in responses {
        let closed = close(&discrete, &[number(&point["theta"])]).unwrap();
        let z = Complex::from_polar(1.0, number(&point["omega"]) * sample_time);
        let found = response(&closed, z).unwrap().0[(0, 0)];
        let expected_response = Complex::new(number(&point["K"][0]), number(&point["K"][1]));
        assert!(
            (found - expected_response).norm() <= number(&expected["rtol"]) * expected_response.norm(),
            "{point}: {found}"
        );
    }
}

#[test]
fn rejects_pole_at_two_over_t() {
    let one = |entry: f64| vec![vec![entry]];
    let matrices = LftMatrices {
        blocks: vec![],
        a: one(4.0),
        by: one(1.0),
        bt: vec![vec![]],
        cu: one(1.0),
        duy: one(0.0),
        dut: vec![vec![]],
        ct: vec![],
        dty: vec![],
        dtt: vec![],
    };
    let lft = Lft::from_rows(&matrices, 1, 1).unwrap();
    assert!(lft.discretise(0.25).is_ok());
    assert!(matches!(lft.discretise(0.5), Err(squid_scheduled::DesignError::TooFast { .. })));
}
