//! Gain for a parameter with a bounded rate, with or without the model error: exact inequality on each interval of the
//! parameter.
//!
//! With `xi = (x, wt, w_D, w)` and the multiplier N of the interval, the form
//!
//! ```text
//! 2 x'X(theta) x' +- rate x' dX/dtheta x + z'z/gamma - gamma w'w + lambda (z_D'z_D - w_D'w_D)
//!     + 2 (N xi)'(wt - theta zt)
//! ```
//!
//! (in the first term, x' is the closed loop's row of x', in terms of xi) is a polynomial in theta. It is that of the
//! loop, or, if the Lyapunov matrix is the inverse of `X(theta)`, that of the transposed loop, in which w and z, and
//! w_D and z_D, are exchanged. On `[a, b]` a polynomial is an average, with non-negative weights, of its Bernstein
//! coefficients: if each is negative definite, so is the form at each theta of the interval. Coefficient i of a
//! polynomial of degree D is its polar form at `a, D - i times, and b, i times`, that of `theta^k` the k-th elementary
//! symmetric function of these arguments by the binomial coefficient: G. Farin, "Curves and Surfaces for CAGD", 5th ed.
//! 2002, chapters 4 and 6.

use super::proved::Provable;
use crate::closed_loop::ClosedLoop;
use crate::error::ClaimName;
use crate::error::Failure;
use crate::exact::dyadic::Dyadic;
use crate::exact::matrix::Matrix;
use crate::inequality::{Blocked, starts};
use crate::plant::Rows;
use crate::shape::{check_length, check_matrix, check_number, columns};
use crate::strict::given;
use crate::structure::{Sign, definite, positive, single_block, symmetric};
use crate::system::Loop;
use serde::{Deserialize, Serialize};
use std::fmt;

/// Claim for the only parameter theta, Lipschitz continuous with `|theta'(t)| <= rate` almost everywhere, with the
/// matrices that prove it; with `lambda`, for the plant with the model error of the certificate.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rate {
    /// Rate bound in units of theta per unit of time, at least 0.
    pub rate: f64,
    /// Bound on the gain.
    pub gamma: f64,
    /// Multiplier of Delta.
    #[serde(default, deserialize_with = "given", skip_serializing_if = "Option::is_none")]
    pub lambda: Option<f64>,
    /// `true` if the Lyapunov matrix is the inverse of X(theta); the inequality is then that of the transposed loop.
    pub inverse: bool,
    /// Lyapunov matrix, or its inverse, `X(theta) = X[0] + theta X[1] + ...`.
    #[serde(rename = "X")]
    pub x: Vec<Rows>,
    /// Breakpoints of theta, ascending from -1 to 1.
    pub breakpoints: Vec<f64>,
    /// Multiplier of `wt - theta zt` for each interval between two breakpoints, (r + rk) x (states, channels, rows of
    /// Delta, inputs); for the transposed loop (r + rk) x (states, channels, columns of Delta, outputs).
    #[serde(rename = "N")]
    pub n: Vec<Rows>,
}

/// Proved claim about a parameter with a bounded rate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RateTheorem {
    /// Bound on `|theta'|` almost everywhere.
    pub rate: f64,
    /// Upper bound on the L2 gain from w to z.
    pub gamma: f64,
    /// Upper bound on this gain with the model error, if the file claims it.
    pub gamma_with_model_error: Option<f64>,
}

impl RateTheorem {
    /// Creates the theorem of the proved claims without and with the model error.
    pub(crate) fn of(claim: &Rate, robust: Option<&Rate>) -> Self {
        Self { rate: claim.rate, gamma: claim.gamma, gamma_with_model_error: robust.map(|claim| claim.gamma) }
    }
}

impl fmt::Display for RateTheorem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "For a parameter that changes by at most {} per unit of time, the gain is below {}",
            self.rate, self.gamma
        )?;
        match self.gamma_with_model_error {
            Some(gamma) => write!(f, ", and with the same Delta below {gamma}."),
            None => f.write_str("; nothing is proved about any other plant."),
        }
    }
}

/// Largest order of X(theta): higher orders bring no benefit, and their binomial coefficients would not be exact.
const MOST_ORDER: usize = 8;

impl Provable for Rate {
    fn name(&self) -> ClaimName {
        match self.lambda {
            None => ClaimName::Rate,
            Some(_) => ClaimName::RobustRate,
        }
    }

    fn check(&self, path: &str, system: Loop<'_>) -> Result<(), Failure> {
        let at = |name: &str| format!("{path}.{name}");
        let (s, parameters) = (system.sizes(), system.parameters());
        if parameters != 1 {
            let reason = format!("requires 1 parameter, but blocks and controller_blocks have {parameters}");
            return Err(Failure::malformed(path, reason));
        }
        if let Some(lambda) = self.lambda {
            check_number(&at("lambda"), lambda)?;
        }
        check_number(&at("rate"), self.rate)?;
        check_number(&at("gamma"), self.gamma)?;
        let most = MOST_ORDER + 1;
        check_length(&at("X"), self.x.len(), (1..=most).contains(&self.x.len()), &format!("1 to {most}"))?;
        let matrices = self.x.iter().enumerate();
        matrices
            .into_iter()
            .try_for_each(|(k, x)| check_matrix(&at(&format!("X[{k}]")), x, s.states(), s.states()))?;
        let points = &self.breakpoints;
        let ascending = points.windows(2).all(|ends| ends[0] < ends[1]);
        if points.first() != Some(&-1.0) || points.last() != Some(&1.0) || !ascending {
            return Err(Failure::malformed(at("breakpoints"), "must increase from -1 to 1"));
        }
        let intervals = points.len() - 1;
        let each = format!("{intervals}, one for each interval");
        check_length(&at("N"), self.n.len(), self.n.len() == intervals, &each)?;
        let error = self.lambda.and(system.errors.first());
        let inner = s.states().0 + s.channels().0;
        let all = if self.inverse {
            let size = inner + error.map_or(0, |error| error.f.len()) + s.z;
            (size, "states, channels, columns of Delta and outputs z")
        } else {
            let size = inner + error.map_or(0, |error| columns(&error.e)) + s.w;
            (size, "states, channels, rows of Delta and inputs w")
        };
        let mut multipliers = self.n.iter().enumerate();
        multipliers.try_for_each(|(i, n)| check_matrix(&at(&format!("N[{i}]")), n, s.channels(), all))
    }

    fn prove(&self, system: Loop<'_>) -> Result<(), Failure> {
        let claim = self.name();
        if self.rate < 0.0 {
            let reason = format!("the rate is {:e}; it must be at least 0", self.rate);
            return Err(Failure::condition(claim, "rate", reason));
        }
        positive(claim, "gamma", self.gamma)?;
        self.lambda.map_or(Ok(()), |lambda| positive(claim, "lambda", lambda))?;
        for (k, x) in self.x.iter().enumerate() {
            symmetric(claim, &format!("X[{k}]"), x)?;
        }
        let closed = ClosedLoop::new(system, if self.lambda.is_some() { system.errors } else { &[] })?;
        definite(claim, "X[0]", Sign::Positive, &single_block("x", &Matrix::square(&self.x[0])))?;
        let inequality = RateInequality::new(&closed, self);
        for (i, (ends, n)) in self.breakpoints.windows(2).zip(&self.n).enumerate() {
            let matrix =
                format!("a Bernstein coefficient of the inequality between breakpoints {i} and {}", i + 1);
            for coefficient in inequality.coefficients(ends[0], ends[1], n) {
                definite(claim, &matrix, Sign::Negative, &coefficient)?;
            }
        }
        Ok(())
    }
}

/// Inequality of a claim, before theta and N are inserted.
struct RateInequality {
    /// Rows x', zt, z_D, z of the loop with the columns x, wt, w_D, w, times `scale`.
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

impl RateInequality {
    fn new(closed: &ClosedLoop, claim: &Rate) -> Self {
        let (n, r, w, z) = (closed.states, closed.channels, closed.inputs, closed.output.rows);
        let (d, f) = closed.delta.as_ref().map_or((0, 0), |(error, e)| (e.cols, error.rows));
        let mut matrix = Matrix::zeros(n + r + f + z, n + r + d + w);
        matrix.place(0, 0, &insert_columns(&closed.state, n + r, d));
        matrix.place(n, 0, &insert_columns(&closed.channel, n + r, d));
        if let Some((error, e)) = &closed.delta {
            matrix.place(0, n + r, e);
            matrix.place(n + r, 0, &insert_columns(error, n + r, d));
        }
        matrix.place(n + r + f, 0, &insert_columns(&closed.output, n + r, d));
        let sizes = if claim.inverse { [n, r, f, z, d, w] } else { [n, r, d, w, f, z] };
        let matrix = if claim.inverse { matrix.transpose() } else { matrix };
        let [_, _, _, _, f, z] = sizes;
        let rows =
            [(0, n), (n, r), (n + r, f), (n + r + f, z)].map(|(at, size)| matrix.row_range(at, at + size));
        let lyapunov: Vec<Matrix> = claim.x.iter().map(|m| Matrix::from_rows(m, n)).collect();
        Self {
            driven: lyapunov.iter().map(|x| x.times(&rows[0])).collect(),
            rows,
            sizes,
            scale: closed.scale.clone(),
            gamma: Dyadic::from_f64(claim.gamma),
            lambda: Dyadic::from_f64(claim.lambda.unwrap_or(0.0)),
            rate: Dyadic::from_f64(claim.rate),
            lyapunov,
        }
    }

    /// Returns the Bernstein coefficients on `[a, b]`, for both signs of the rate, each times a positive number; z and
    /// z_D have rows of their own (Schur complements). All must be negative definite.
    ///
    /// ```text
    ///            x            wt       w_D        w
    /// x     [ X A +- r X'/2   X Bt     X E        X B1      ]
    /// w_D   [                         -lambda/2             ]
    /// w     [                                    -gamma/2   ]   + [N 0]'([0 I 0 0 0] - theta [Ct Dtt 0 Dt1 0]),
    /// z_D   [ lambda (F_x     F_t      0          F_w) -lambda/2 ]
    /// z     [ C1              D1t      0          D11  -gamma/2  ]   and its transpose
    /// ```
    fn coefficients(&self, a: f64, b: f64, n: &Rows) -> Vec<Blocked> {
        let degree = (self.lyapunov.len() - 1).max(1);
        let (from, to) = (Dyadic::from_f64(a), Dyadic::from_f64(b));
        let multiplier = Matrix::from_rows(n, self.rows[0].cols).transpose();
        let through = multiplier.times(&self.rows[1]);
        // Both signs give the same matrix for a rate of 0 or a constant X.
        let one_sign = self.rate.is_zero() || self.lyapunov.len() == 1;
        let rates = if one_sign { vec![self.rate.clone()] } else { vec![self.rate.clone(), -&self.rate] };
        let mut found = Vec::new();
        for i in 0..=degree {
            let arguments: Vec<Dyadic> =
                (0..degree).map(|k| if k < i { to.clone() } else { from.clone() }).collect();
            let powers = polar_powers(&arguments);
            found.extend(rates.iter().map(|rate| self.coefficient(&powers, rate, (&multiplier, &through))));
        }
        found
    }

    /// Returns the matrix with `powers[k]` in place of `theta^k`; `n` is N', `through` is N' times the row of zt.
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

/// Returns `sum_k weights[k] m_k`.
fn weighted(matrices: &[Matrix], weights: &[Dyadic]) -> Matrix {
    let zero = Matrix::zeros(matrices[0].rows, matrices[0].cols);
    matrices.iter().zip(weights).fold(zero, |sum, (m, weight)| sum.plus(&m.scaled(weight)))
}

/// Returns the matrix with `gap` columns of zeros inserted before column `at`.
fn insert_columns(m: &Matrix, at: usize, gap: usize) -> Matrix {
    let mut out = Matrix::zeros(m.rows, m.cols + gap);
    out.place(0, 0, &m.column_range(0, at));
    out.place(0, at + gap, &m.column_range(at, m.cols));
    out
}

/// Returns the polar forms of `theta^k` at D arguments, k = 0 .. D, each times D!: an integer times a symmetric
/// function.
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
    // This is D!/binomial(D, k).
    let weight = |k: usize| Dyadic::from_f64((factorial(k) * factorial(degree - k)) as f64);
    symmetric.iter().enumerate().map(|(k, e)| e * &weight(k)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks that `theta^2` on [1, 3] has the Bernstein coefficients 1, 3, 9.
    #[test]
    fn gives_bernstein_coefficients_of_square() {
        let at = |arguments: [f64; 2]| {
            let powers = polar_powers(&arguments.map(Dyadic::from_f64));
            [0, 1, 2].map(|k| powers[k].to_f64() / 2.0)
        };
        assert_eq!(at([1.0, 1.0]), [1.0, 1.0, 1.0]);
        assert_eq!(at([3.0, 1.0]), [1.0, 2.0, 3.0]);
        assert_eq!(at([3.0, 3.0]), [1.0, 3.0, 9.0]);
    }
}
