//! A step of the explicit Runge-Kutta method of order 5 with an error estimate of order 4.
//!
//! Source: J. R. Dormand, P. J. Prince, "A family of embedded Runge-Kutta formulae", J. Computational and Applied
//! Mathematics 6(1), 1980, table 2.

/// Nodes c of the stages after the first.
const NODES: [f64; 6] = [1.0 / 5.0, 3.0 / 10.0, 4.0 / 5.0, 8.0 / 9.0, 1.0, 1.0];

/// Rows of A after the first. The last row has the weights b of order 5: the last stage is the first of the next step.
const A: [&[f64]; 6] = [
    &[1.0 / 5.0],
    &[3.0 / 40.0, 9.0 / 40.0],
    &[44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0],
    &[19372.0 / 6561.0, -25360.0 / 2187.0, 64448.0 / 6561.0, -212.0 / 729.0],
    &[9017.0 / 3168.0, -355.0 / 33.0, 46732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18656.0],
    &[35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0],
];

/// The weights of order 5 less those of order 4.
const ERROR: [f64; 7] = [
    71.0 / 57600.0,
    0.0,
    -71.0 / 16695.0,
    71.0 / 1920.0,
    -17253.0 / 339_200.0,
    22.0 / 525.0,
    -1.0 / 40.0,
];

/// A step.
pub(crate) struct Step<const N: usize> {
    /// The state at its end.
    pub(crate) state: [f64; N],
    /// The rate there.
    pub(crate) rate: [f64; N],
    /// The estimated error of each state of the solution of order 4.
    pub(crate) error: [f64; N],
}

/// Takes a step of the length h from a state with a rate, `f(t, x)` being the rate at a time t after its start.
pub(crate) fn step<const N: usize>(
    mut f: impl FnMut(f64, &[f64; N]) -> [f64; N],
    state: &[f64; N],
    rate: &[f64; N],
    h: f64,
) -> Step<N> {
    let mut k = [*rate; 7];
    let mut at = *state;
    for (stage, (node, row)) in NODES.into_iter().zip(A).enumerate() {
        at = std::array::from_fn(|i| state[i] + h * row.iter().zip(&k).map(|(a, k)| a * k[i]).sum::<f64>());
        k[stage + 1] = f(node * h, &at);
    }
    let error = std::array::from_fn(|i| h * ERROR.iter().zip(&k).map(|(e, k)| e * k[i]).sum::<f64>());
    Step { state: at, rate: k[6], error }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of a quarter of a turn of an oscillator: the errors fall with the fifth, and the fourth power of the step.
    #[test]
    fn errors_fall_as_the_orders_say() {
        let turn = |steps: u32| {
            let h = std::f64::consts::FRAC_PI_2 / f64::from(steps);
            let f = |_: f64, x: &[f64; 2]| [x[1], -x[0]];
            let (mut at, mut estimate) = ([0.0, 1.0], 0.0_f64);
            for _ in 0..steps {
                let Step { state, error, .. } = step(f, &at, &f(0.0, &at), h);
                (at, estimate) = (state, estimate.max(error[0].abs().max(error[1].abs())));
            }
            ((at[0] - 1.0).abs().max(at[1].abs()), estimate)
        };
        let (coarse, fine) = (turn(8), turn(16));
        assert!((30.0..40.0).contains(&(coarse.0 / fine.0)), "{coarse:?} {fine:?}");
        assert!((28.0..36.0).contains(&(coarse.1 / fine.1)), "{coarse:?} {fine:?}");
        assert!(fine.0 < 1e-6, "{fine:?}");
    }

    /// The weights of each stage add up to its node, and those of the error to nothing.
    #[test]
    fn the_tableau_is_consistent() {
        for (node, row) in NODES.into_iter().zip(A) {
            assert!((row.iter().sum::<f64>() - node).abs() < 1e-14, "{row:?}");
        }
        assert!(ERROR.iter().sum::<f64>().abs() < 1e-16);
    }
}
