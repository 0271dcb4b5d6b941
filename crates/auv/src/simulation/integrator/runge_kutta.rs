//! Step of the explicit Runge-Kutta method of order 6 with an error estimate of order 5.
//!
//! Source: J. H. Verner, "Numerically optimal Runge-Kutta pairs with interpolants", Numerical Algorithms 53, 2010: the
//! efficient pair of orders 6 and 5.

/// Nodes c of the stages after the first.
const NODES: [f64; 8] = [0.06, 0.095_933_333_333_333_33, 0.143_9, 0.497_3, 0.972_5, 0.999_5, 1.0, 1.0];

/// Rows of A after the first.
const A1: [f64; 1] = [0.06];
const A2: [f64; 2] = [0.019_239_962_962_962_962, 0.076_693_370_370_370_37];
const A3: [f64; 3] = [0.035_975, 0.0, 0.107_925];
const A4: [f64; 4] = [1.318_683_415_233_148_4, 0.0, -5.042_058_063_628_562, 4.220_674_648_395_414];
const A5: [f64; 5] =
    [-41.872_591_664_327_516, 0.0, 159.432_562_163_137_5, -122.119_213_565_010_03, 5.531_743_066_200_054];
const A6: [f64; 6] = [
    -54.430_156_935_316_504,
    0.0,
    207.067_251_365_018_48,
    -158.610_813_784_59,
    6.991_816_585_950_242,
    -0.018_597_231_062_203_234,
];
const A7: [f64; 7] = [
    -54.663_741_787_281_98,
    0.0,
    207.952_806_255_389_36,
    -159.288_957_474_499_5,
    7.018_743_740_796_944,
    -0.018_338_785_905_045_722,
    -0.000_511_948_499_788_209_9,
];
/// Last row, the weights b of order 6: the last stage is the first of the next step.
const B: [f64; 8] = [
    0.034_389_578_683_570_36,
    0.0,
    0.0,
    0.258_262_455_563_350_3,
    0.420_937_118_967_353_7,
    4.405_396_469_669_31,
    -176.483_119_024_298_65,
    172.364_133_401_415_07,
];

/// Weights of order 6 minus those of order 5.
const ERROR: [f64; 9] = [
    -0.014_710_097_800_254_542,
    0.0,
    0.0,
    0.033_151_232_611_697_89,
    -0.048_531_106_335_602_48,
    3.598_817_244_670_423_4,
    -176.483_119_024_298_65,
    172.971_252_890_592_87,
    -0.056_861_139_440_475_696,
];

/// Step of the method.
pub(crate) struct Step<const N: usize> {
    /// State at the end.
    pub(crate) state: [f64; N],
    /// Rate at the end.
    pub(crate) rate: [f64; N],
    /// Estimated error of each state of the solution of order 5.
    pub(crate) error: [f64; N],
}

/// Takes a step of length h from a state and its rate; `f(t, x)` is the rate at a time t after its start.
pub(crate) fn step<const N: usize>(
    mut f: impl FnMut(f64, &[f64; N]) -> [f64; N],
    state: &[f64; N],
    rate: &[f64; N],
    h: f64,
) -> Step<N> {
    let mut k = [*rate; 9];
    let mut at = *state;
    let mut stage = |index: usize, combination: [f64; N]| {
        at = std::array::from_fn(|i| state[i] + h * combination[i]);
        f(NODES[index] * h, &at)
    };
    k[1] = stage(0, sum(&A1, &k));
    k[2] = stage(1, sum(&A2, &k));
    k[3] = stage(2, sum(&A3, &k));
    k[4] = stage(3, sum(&A4, &k));
    k[5] = stage(4, sum(&A5, &k));
    k[6] = stage(5, sum(&A6, &k));
    k[7] = stage(6, sum(&A7, &k));
    k[8] = stage(7, sum(&B, &k));
    Step { state: at, rate: k[8], error: sum(&ERROR, &k).map(|error| h * error) }
}

/// Returns the weighted sum of the first rates; the number of weights is a compile-time constant, and the loops are
/// unrolled.
#[inline(always)]
fn sum<const N: usize, const S: usize>(weights: &[f64; S], rates: &[[f64; N]; 9]) -> [f64; N] {
    let mut sum = [0.0; N];
    for (weight, rate) in weights.iter().zip(rates) {
        for (sum, rate) in sum.iter_mut().zip(rate) {
            *sum += weight * rate;
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Errors over a quarter turn of an oscillator fall at least with the sixth power of the step, and so does their
    /// estimate, that of one step of order 5.
    #[test]
    fn errors_have_the_expected_orders() {
        let quarter_turn = |steps: u32| {
            let h = std::f64::consts::FRAC_PI_2 / f64::from(steps);
            let f = |_: f64, x: &[f64; 2]| [x[1], -x[0]];
            let (mut at, mut estimate) = ([0.0, 1.0], 0.0_f64);
            for _ in 0..steps {
                let Step { state, error, .. } = step(f, &at, &f(0.0, &at), h);
                (at, estimate) = (state, estimate.max(error[0].abs().max(error[1].abs())));
            }
            ((at[0] - 1.0).abs().max(at[1].abs()), estimate)
        };
        let (coarse, fine) = (quarter_turn(4), quarter_turn(8));
        assert!(coarse.0 > 55.0 * fine.0, "{coarse:?} {fine:?}");
        assert!((55.0..75.0).contains(&(coarse.1 / fine.1)), "{coarse:?} {fine:?}");
        assert!(fine.0 < 1e-7, "{fine:?}");
    }

    /// The weights of each stage add up to its node, and those of the error to zero.
    #[test]
    fn tableau_is_consistent() {
        for (node, row) in NODES.into_iter().zip([&A1[..], &A2, &A3, &A4, &A5, &A6, &A7, &B]) {
            assert!((row.iter().sum::<f64>() - node).abs() < 1e-13, "{row:?}");
        }
        assert!(ERROR.iter().sum::<f64>().abs() < 1e-13);
    }
}
