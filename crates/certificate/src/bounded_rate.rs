//! The inequality of a bounded rate on an interval of the parameter, formed exactly.
//!
//! With `xi = (x, wt, w_D, w)` and the multiplier N of the interval, the form
//!
//! ```text
//! 2 x'X(theta) x' +- rate x' dX/dtheta x + z'z/gamma - gamma w'w + lambda (z_D'z_D - w_D'w_D)
//!     + 2 (N xi)'(wt - theta zt)
//! ```
//!
//! (in the first term, x' is the closed loop's row of x', in terms of xi) is a polynomial in theta. It is that of the
//! loop, or, where the Lyapunov matrix is the inverse of `X(theta)`, of the transposed loop, in which w and z, and w_D
//! and z_D, change places. On `[a, b]` a
//! polynomial is a mean, with weights above 0, of its Bernstein coefficients there: if each is negative definite, so
//! is the form at each theta of the interval. Coefficient i of a polynomial of degree D is its polar form at `a, D - i
//! times, and b, i times`, that of `theta^k` the k-th elementary symmetric function of these arguments by the
//! binomial coefficient: G. Farin, "Curves and Surfaces for CAGD", 5th ed. 2002, chapters 4 and 6.

use crate::certificate::{Rows, Slow};
use crate::closed_loop::ClosedLoop;
use crate::exact::dyadic::Dyadic;
use crate::exact::matrix::Matrix;
use crate::inequality::{Blocked, starts};

/// The inequality of a claim, before theta and N are put in.
pub(crate) struct SlowInequality {
    /// Rows x', zt, z_D, z of the loop and columns x, wt, w_D, w, times `scale`.
    rows: [Matrix; 4],
    /// Sizes of x, wt, w_D, w, z_D, z.
    sizes: [usize; 6],
    scale: Dyadic,
    gamma: Dyadic,
    lambda: Dyadic,
    rate: Dyadic,
    /// `X_k`.
    lyapunov: Vec<Matrix>,
    /// `X_k [A Bt E B1]`.
    driven: Vec<Matrix>,
}

impl SlowInequality {
    pub(crate) fn new(closed: &ClosedLoop, slow: &Slow, rate: f64, lambda: Option<f64>) -> Self {
        let (n, r, w, z) = (closed.states, closed.channels, closed.inputs, closed.output.rows);
        let (d, f) = closed.delta.as_ref().map_or((0, 0), |(error, e)| (e.cols, error.rows));
        let mut whole = Matrix::zeros(n + r + f + z, n + r + d + w);
        whole.place(0, 0, &spread(&closed.state, n + r, d));
        whole.place(n, 0, &spread(&closed.channel, n + r, d));
        if let Some((error, e)) = &closed.delta {
            whole.place(0, n + r, e);
            whole.place(n + r, 0, &spread(error, n + r, d));
        }
        whole.place(n + r + f, 0, &spread(&closed.output, n + r, d));
        let sizes = if slow.inverse { [n, r, f, z, d, w] } else { [n, r, d, w, f, z] };
        let whole = if slow.inverse { whole.transpose() } else { whole };
        let [_, _, _, _, f, z] = sizes;
        let rows =
            [(0, n), (n, r), (n + r, f), (n + r + f, z)].map(|(at, size)| whole.row_range(at, at + size));
        let lyapunov: Vec<Matrix> = slow.x.iter().map(|m| Matrix::from_rows(m, n)).collect();
        Self {
            driven: lyapunov.iter().map(|x| x.times(&rows[0])).collect(),
            rows,
            sizes,
            scale: closed.scale.clone(),
            gamma: Dyadic::from_f64(slow.gamma),
            lambda: Dyadic::from_f64(lambda.unwrap_or(0.0)),
            rate: Dyadic::from_f64(rate),
            lyapunov,
        }
    }

    /// The Bernstein coefficients on `[a, b]`, for both signs of the rate, each times a positive number; z and z_D
    /// have rows of their own (Schur complements). All must be negative definite.
    ///
    /// ```text
    ///            x            wt       w_D        w
    /// x     [ X A +- r X'/2   X Bt     X E        X B1      ]
    /// w_D   [                         -lambda/2             ]
    /// w     [                                    -gamma/2   ]   + [N 0]'([0 I 0 0 0] - theta [Ct Dtt 0 Dt1 0]),
    /// z_D   [ lambda (F_x     F_t      0          F_w) -lambda/2 ]
    /// z     [ C1              D1t      0          D11  -gamma/2  ]   and its transpose
    /// ```
    pub(crate) fn coefficients(&self, a: f64, b: f64, n: &Rows) -> Vec<Blocked> {
        let degree = (self.lyapunov.len() - 1).max(1);
        let (from, to) = (Dyadic::from_f64(a), Dyadic::from_f64(b));
        let multiplier = Matrix::from_rows(n, self.rows[0].cols).transpose();
        let through = multiplier.times(&self.rows[1]);
        // At a rate of 0, or for a constant X, the two signs are one.
        let still = self.rate.is_zero() || self.lyapunov.len() == 1;
        let rates = if still { vec![self.rate.clone()] } else { vec![self.rate.clone(), -&self.rate] };
        let mut found = Vec::new();
        for i in 0..=degree {
            let arguments: Vec<Dyadic> =
                (0..degree).map(|k| if k < i { to.clone() } else { from.clone() }).collect();
            let powers = polar_powers(&arguments);
            found.extend(rates.iter().map(|rate| self.coefficient(&powers, rate, (&multiplier, &through))));
        }
        found
    }

    /// The matrix with `powers[k]` in place of `theta^k`, N' and N' times the row of zt given.
    fn coefficient(&self, powers: &[Dyadic], rate: &Dyadic, (n, through): (&Matrix, &Matrix)) -> Blocked {
        let names = ["x", "wt", "w_Delta", "w", "z_Delta", "z"];
        let blocks: Vec<(&'static str, usize)> = names.into_iter().zip(self.sizes).collect();
        let (starts, all) = starts(&blocks);
        let [_, _, z_error, z] = &self.rows;
        let one = &powers[0];
        let unit = &self.scale * one;
        let mut half = Matrix::zeros(all, all);
        half.place(0, 0, &through.scaled(&-&powers[1]));
        half.add(0, starts[1], &n.scaled(&unit));
        half.add(0, 0, &weighted(&self.driven, powers));
        half.place(starts[4], 0, &z_error.scaled(&(&self.lambda * one)));
        half.place(starts[5], 0, &z.scaled(one));

        let mut diagonal = Matrix::zeros(all, all);
        let drift = rate * &self.scale;
        let slopes: Vec<Dyadic> =
            (1..powers.len()).map(|k| &(&drift * &powers[k - 1]) * &Dyadic::from_f64(k as f64)).collect();
        if self.lyapunov.len() > 1 {
            diagonal.place(0, 0, &weighted(&self.lyapunov[1..], &slopes));
        }
        let constant = |value: &Dyadic| -&(value * &unit);
        let (gamma, lambda) = (constant(&self.gamma), constant(&self.lambda));
        for (block, value) in [(2, &lambda), (3, &gamma), (4, &lambda), (5, &gamma)] {
            diagonal.place(starts[block], starts[block], &Matrix::scalar(self.sizes[block], value));
        }
        Blocked { matrix: half.plus(&half.transpose()).plus(&diagonal), blocks, scale: unit }
    }
}

/// `sum_k weights[k] m_k`.
fn weighted(matrices: &[Matrix], weights: &[Dyadic]) -> Matrix {
    let zero = Matrix::zeros(matrices[0].rows, matrices[0].cols);
    matrices.iter().zip(weights).fold(zero, |sum, (m, weight)| sum.plus(&m.scaled(weight)))
}

/// The matrix with `gap` columns of zeros before column `at`.
fn spread(m: &Matrix, at: usize, gap: usize) -> Matrix {
    let mut out = Matrix::zeros(m.rows, m.cols + gap);
    out.place(0, 0, &m.column_range(0, at));
    out.place(0, at + gap, &m.column_range(at, m.cols));
    out
}

/// The polar forms of `theta^k` at D arguments, k = 0 .. D, each times D!: a whole number times a symmetric function.
fn polar_powers(arguments: &[Dyadic]) -> Vec<Dyadic> {
    let degree = arguments.len();
    let mut symmetric = vec![Dyadic::default(); degree + 1];
    symmetric[0] = Dyadic::from_f64(1.0);
    for argument in arguments {
        for k in (1..=degree).rev() {
            symmetric[k] = &symmetric[k] + &(&symmetric[k - 1] * argument);
        }
    }
    let factorial = |n: usize| (1..=n).product::<usize>();
    // D!/binomial(D, k).
    let weight = |k: usize| Dyadic::from_f64((factorial(k) * factorial(degree - k)) as f64);
    symmetric.iter().enumerate().map(|(k, e)| e * &weight(k)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `theta^2` on [1, 3] has the Bernstein coefficients 1, 3, 9: t^2 of 1 + 2 t + ...
    #[test]
    fn the_coefficients_of_a_square() {
        let at = |arguments: [f64; 2]| {
            let powers = polar_powers(&arguments.map(Dyadic::from_f64));
            [0, 1, 2].map(|k| powers[k].to_f64() / 2.0)
        };
        assert_eq!(at([1.0, 1.0]), [1.0, 1.0, 1.0]);
        assert_eq!(at([3.0, 1.0]), [1.0, 2.0, 3.0]);
        assert_eq!(at([3.0, 3.0]), [1.0, 3.0, 9.0]);
    }
}
