//! Multipliers that prove the gain of a closed loop at a bounded rate, between all values of the parameter.
//!
//! The form, on an interval of theta,
//!
//! ```text
//! q(xi) = 2 x'X(theta) x' +- nu x' dX/dtheta x + z'z/gamma - gamma w'w + lambda (z_D'z_D - w_D'w_D)
//!         + 2 (N xi)'(wt - theta zt),          xi = (x, wt, w_D, w)
//! ```
//!
//! with a constant N is a polynomial in theta, and negative if its Bernstein coefficients on the interval are. With
//! `v = wt - m zt` and m the midpoint, N is chosen so that at m the cross terms of v vanish and `-v'M v` remains; away
//! from m the form then differs from the inequality of the frozen loop only to second order in the interval's length,
//! so halving succeeds if that inequality holds strictly. The crate `certificate` proves this without rounding; here it
//! is in floating point.

use crate::analysis::lyapunov_polynomial::LyapunovPolynomial;
use crate::matrix::{Mat, block, diagonal_blocks, eigenvalues, scaled_largest_eigenvalue, symmetric_part};
use crate::system::{ClosedLoop, Group, LoopError};

/// A gain of a loop at a bounded rate, with its proof.
#[derive(Debug, Clone, PartialEq)]
pub struct SlowBound {
    /// nu, the bound on `|theta'|`.
    pub rate: f64,
    /// The bound of the L2 gain.
    pub gamma: f64,
    /// The multiplier of the model error; 0 if there is none.
    pub lambda: f64,
    /// `true` if the Lyapunov matrix is the inverse of X(theta), with the inequality of the transposed loop.
    pub inverse: bool,
    /// Coefficients `X_0, X_1, ...`.
    pub lyapunov: Vec<Mat>,
    /// Ends of the intervals, ascending from -1 to 1.
    pub breakpoints: Vec<f64>,
    /// N of each interval, channels x (states, channels, rows of Delta, inputs).
    pub multipliers: Vec<Mat>,
}

/// The shortest interval, relative to the whole range; if it does not suffice, the inequality of the frozen loop fails.
const SHORTEST: f64 = 1.0 / 1024.0;

/// Trial sizes of M, relative to one that balances the channels with the other terms at the midpoint.
const SIZES: [f64; 6] = [0.3, 1.0, 0.1, 3.0, 0.03, 0.003];

/// Trial numbers of digits of N, so that a certificate is short.
const DIGITS: [usize; 3] = [4, 6, 9];

/// The number of values of theta at which the inequality of the frozen loop is checked first.
const FROZEN: usize = 9;

/// The eigenvalue, scaled to unit diagonals, below which a coefficient is negative despite rounding.
const CLEARLY_NEGATIVE: f64 = -1e-9;

/// A claimed gain of a loop at a bounded rate, with a Lyapunov matrix.
#[derive(Debug, Clone, Copy)]
pub struct Claim<'a> {
    /// A loop with one parameter.
    pub closed: &'a ClosedLoop,
    /// The model error of the loop.
    pub error: &'a LoopError,
    /// `true` if the Lyapunov matrix is the inverse of X(theta), with the inequality of the transposed loop.
    pub inverse: bool,
    /// Coefficients `X_0, X_1, ...` of `X(theta) = X_0 + theta X_1 + ...`.
    pub lyapunov: &'a [Mat],
    /// nu, the bound on `|theta'|`.
    pub rate: f64,
    /// The gain.
    pub gamma: f64,
    /// The multiplier of the model error.
    pub lambda: f64,
}

/// Finds intervals and multipliers that prove a claim. `None` if an interval of 1/1024 of the range is too long: the
/// claim is false, or too nearly false for floating point.
pub fn intervals(claim: Claim<'_>) -> Option<SlowBound> {
    let form = Form::new(claim)?;
    let step = 2.0 / (FROZEN - 1) as f64;
    if !(0..FROZEN).all(|i| form.holds_at(step * i as f64 - 1.0).unwrap_or(false)) {
        return None;
    }
    let mut waiting = vec![(-1.0, 1.0)];
    let (mut breakpoints, mut multipliers) = (vec![-1.0], vec![]);
    while let Some((from, to)) = waiting.pop() {
        if let Some(n) = form.multiplier(from, to) {
            breakpoints.push(to);
            multipliers.push(n);
        } else if to - from > 2.0 * SHORTEST {
            let middle = 0.5 * (from + to);
            waiting.extend([(middle, to), (from, middle)]);
        } else {
            return None;
        }
    }
    Some(SlowBound {
        rate: claim.rate,
        gamma: claim.gamma,
        lambda: claim.lambda,
        inverse: claim.inverse,
        lyapunov: claim.lyapunov.to_vec(),
        breakpoints,
        multipliers,
    })
}

/// A claim in coordinates in which X(0) is the identity.
struct Form {
    lyapunov: LyapunovPolynomial,
    rate: f64,
    /// The selection of x, and x', zt and wt as functions of xi.
    x: Mat,
    x_dot: Mat,
    zt: Mat,
    wt: Mat,
    /// The terms that do not depend on theta: z, w, z_D and w_D.
    constant: Mat,
    /// x, w_D and w, stacked, as functions of xi.
    rest: Mat,
    /// The map from the given coordinates to these.
    back: Mat,
}

impl Form {
    fn new(claim: Claim<'_>) -> Option<Self> {
        let Claim { closed, error, inverse, lyapunov, rate, gamma, lambda } = claim;
        let root = lyapunov.first()?.clone().cholesky()?.l().transpose();
        let root_inverse = root.clone().try_inverse()?;
        let rows = |f: &dyn Fn(Group) -> Mat| [f(Group::X), f(Group::T), f(Group::W)];
        let line = |group: Group, delta: &Mat| {
            let [x, t, w] = rows(&|column| closed.parts.block(group, column));
            block(&[&[&x, &t, delta, &w]])
        };
        let (r, f, d) = (closed.channels.len(), error.fx.nrows(), error.e.ncols());
        let of_error = block(&[&[&error.fx, &error.ft, &Mat::zeros(f, d), &error.fw]]);
        let z = closed.c1().nrows();
        let full = block(&[
            &[&line(Group::X, &error.e)],
            &[&line(Group::T, &Mat::zeros(r, d))],
            &[&of_error],
            &[&line(Group::Z, &Mat::zeros(z, d))],
        ]);
        let (n, w) = (root.nrows(), closed.b1().ncols());
        let (full, d, w, f, z) = if inverse { (full.transpose(), f, z, d, w) } else { (full, d, w, f, z) };
        let eye = Mat::identity;
        let left = diagonal_blocks(&[&root, &eye(r + f + z, r + f + z)]);
        let back = diagonal_blocks(&[&root, &eye(r + d + w, r + d + w)]);
        let right = diagonal_blocks(&[&root_inverse, &eye(r + d + w, r + d + w)]);
        let full = left * full * right;
        let all = n + r + d + w;
        let pick =
            |at: usize, size: usize| Mat::from_fn(size, all, |i, j| if j == at + i { 1.0 } else { 0.0 });
        let row = |at: usize, size: usize| full.rows(at, size).into_owned();
        let (z_error, z) = (row(n + r, f), row(n + r + f, z));
        let (w_error, w) = (pick(n + r, d), pick(n + r + d, w));
        let constant = z.transpose() * &z / gamma - w.transpose() * &w * gamma
            + (z_error.transpose() * &z_error - w_error.transpose() * &w_error) * lambda;
        let coefficients = lyapunov
            .iter()
            .map(|x| symmetric_part(&(root_inverse.transpose() * x * &root_inverse)))
            .collect();
        Some(Self {
            lyapunov: LyapunovPolynomial { centre: 0.0, half_range: 1.0, coefficients },
            rate,
            x: pick(0, n),
            x_dot: row(0, n),
            zt: row(n, r),
            wt: pick(n, r),
            constant,
            rest: block(&[&[&pick(0, n)], &[&w_error], &[&w]]),
            back,
        })
    }

    /// Returns the form without N, for given X and `+-nu dX/dtheta`.
    fn without_multiplier(&self, x: &Mat, drift: &Mat) -> Mat {
        let half = self.x.transpose() * x * &self.x_dot;
        &half + half.transpose() + self.x.transpose() * drift * &self.x + &self.constant
    }

    /// Returns the form at theta in coordinates `(x, w_D, w, v)`, `v = wt - theta zt`, with `+-nu dX/dtheta` for a
    /// given rate; and the coordinates, `(x, w_D, w, v) = C xi`.
    fn at(&self, theta: f64, rate: f64) -> Option<(Mat, Mat)> {
        let coordinates = block(&[&[&self.rest], &[&(&self.wt - &self.zt * theta)]]);
        let t = coordinates.clone().try_inverse()?;
        let form = self.without_multiplier(&self.lyapunov.value(theta), &(self.lyapunov.slope(theta) * rate));
        Some((t.transpose() * form * &t, coordinates))
    }

    /// Returns `true` if the inequality of the frozen loop, in which v = 0, holds at theta for both signs of the rate.
    fn holds_at(&self, theta: f64) -> Option<bool> {
        let k = self.rest.nrows();
        let mut holds = true;
        for rate in [self.rate, -self.rate] {
            let frozen = self.at(theta, rate)?.0.view((0, 0), (k, k)).into_owned();
            holds &= scaled_largest_eigenvalue(&frozen) < CLEARLY_NEGATIVE;
        }
        Some(holds)
    }

    /// Returns N of an interval in the given coordinates, if there is one, with as few digits as suffice.
    fn multiplier(&self, from: f64, to: f64) -> Option<Mat> {
        let middle = 0.5 * (from + to);
        let r = self.wt.nrows();
        let (inner, coordinates) = self.at(middle, 0.0)?;
        let k = inner.nrows() - r;
        let kept = -inner.view((0, 0), (k, k)).into_owned();
        let cross = inner.view((k, 0), (r, k)).into_owned();
        let inner_v = inner.view((k, k), (r, r)).into_owned();
        let zt = &self.zt * coordinates.clone().try_inverse()?;
        let seen = zt.columns(0, k).into_owned();
        let direct = symmetric_part(&(&seen * kept.cholesky()?.solve(&seen.transpose())));
        let weight = weight(direct, &zt.columns(k, r).into_owned())?;
        let of_size =
            |size: &f64| block(&[&[&-&cross, &(-(&inner_v + &weight * *size) * 0.5)]]) * &coordinates;
        let n = SIZES.iter().map(of_size).find(|n| self.worst(from, to, n) < CLEARLY_NEGATIVE)? * &self.back;
        let inverse = self.back.clone().try_inverse()?;
        let short = DIGITS.iter().map(|digits| n.map(|entry| rounded(entry, *digits)));
        Some(
            short.into_iter().find(|n| self.worst(from, to, &(n * &inverse)) < CLEARLY_NEGATIVE).unwrap_or(n),
        )
    }

    /// Returns the largest eigenvalue of the Bernstein coefficients, scaled to unit diagonals.
    fn worst(&self, from: f64, to: f64, n: &Mat) -> f64 {
        let count = self.lyapunov.coefficients.len();
        let degree = (count - 1).max(1);
        let mut worst = f64::NEG_INFINITY;
        for i in 0..=degree {
            let powers = polar_powers(degree, i, from, to);
            let x = self.lyapunov.weighted(|k| powers[k]);
            let slope = self.lyapunov.weighted(|k| if k == 0 { 0.0 } else { k as f64 * powers[k - 1] });
            let half = n.transpose() * (&self.wt - &self.zt * powers[1]);
            for rate in [self.rate, -self.rate] {
                let form = self.without_multiplier(&x, &(&slope * rate)) + &half + half.transpose();
                worst = worst.max(scaled_largest_eigenvalue(&form));
            }
        }
        worst
    }
}

/// Rounds a number to that many significant decimal digits.
fn rounded(value: f64, digits: usize) -> f64 {
    format!("{value:.*e}", digits - 1).parse().unwrap_or(value)
}

/// Returns M, the inverse of `W = G + k^2 D W D'`, where G is the path to zt from all inputs but the channels and D
/// that from the channels, so that a step of k through the channels does not grow in the metric M. k is 1.5, or less if
/// the channels amplify more.
fn weight(direct: Mat, channels: &Mat) -> Option<Mat> {
    let r = direct.nrows();
    let radius = eigenvalues(channels).iter().map(|v| v.norm()).fold(0.0, f64::max);
    let mut step = channels * (LONGEST_STEP.min(0.9 / radius.max(f64::MIN_POSITIVE)));
    let mut sum = direct;
    for _ in 0..MOST_DOUBLINGS {
        sum = symmetric_part(&(&sum + &step * &sum * step.transpose()));
        step = &step * &step;
    }
    let floor = NEGLIGIBLE_WEIGHT * sum.trace().max(f64::MIN_POSITIVE) / r.max(1) as f64;
    let inverse = (sum + Mat::identity(r, r) * floor).cholesky()?.inverse();
    inverse.iter().all(|v| v.is_finite()).then_some(inverse)
}

/// The largest k of [`weight`], the number of doublings of its sum, and the floor of its eigenvalues.
const LONGEST_STEP: f64 = 1.5;
const MOST_DOUBLINGS: usize = 8;
const NEGLIGIBLE_WEIGHT: f64 = 1e-9;

/// Returns the polar forms of `theta^k`, k = 0 .. degree, at `degree - i` times `from` and i times `to`.
fn polar_powers(degree: usize, i: usize, from: f64, to: f64) -> Vec<f64> {
    let mut symmetric = vec![0.0; degree + 1];
    symmetric[0] = 1.0;
    for step in 0..degree {
        let argument = if step < i { to } else { from };
        for k in (1..=degree).rev() {
            symmetric[k] += symmetric[k - 1] * argument;
        }
    }
    let binomial = |k: usize| (0..k).fold(1.0, |b, j| b * (degree - j) as f64 / (j + 1) as f64);
    symmetric.iter().enumerate().map(|(k, e)| e / binomial(k)).collect()
}
