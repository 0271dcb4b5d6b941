//! The inequality for constant parameters at single frequencies, without X, which has most of the unknowns.
//!
//! With the response `xi = [(x, f); u]` at `s = j omega` of the states to `u = (wt, v, w_D, w)`, the terms of X vanish,
//! and the inequality is that of a Hermitian matrix, `xi* M xi < 0` with the symmetric M of [`Multipliers::form`]. As
//! a real one it is `[Re H, -Im H; Im H, Re H]`, the sum of `U' M U` over `U = [Re xi, -Im xi]` and `[Im xi, Re xi]`.

use crate::lmi::{Affine, LowRank, Program, symmetric};
use crate::matrix::{Mat, block};
use crate::robust::constant::constant_loop::ConstantLoop;
use crate::robust::constant::filtered::Filtered;
use crate::system::StateSpace;
use nalgebra::Complex;

/// The response of the states and inputs at a frequency, as the one or two U of the real inequality.
#[derive(Debug, Clone)]
pub(super) struct Response {
    halves: Vec<Mat>,
}

/// The unknown multipliers, and gamma.
pub(super) struct Unknowns {
    pub(super) gamma: Affine,
    pub(super) s: Affine,
    pub(super) t: Affine,
    pub(super) lambdas: Vec<Affine>,
}

/// The values of the multipliers.
#[derive(Debug, Clone)]
pub(super) struct Multipliers {
    pub(super) gamma: f64,
    pub(super) s: Mat,
    pub(super) t: Mat,
    pub(super) lambdas: Vec<f64>,
}

impl Response {
    /// Returns the response at omega, rad/s; at infinity only the inputs remain. `None` at a pole.
    pub(super) fn new(filtered: &Filtered, omega: f64) -> Option<Self> {
        let (n, all) = (filtered.states, filtered.dynamics.ncols());
        let (m, k) = (all - n, filtered.loop_states);
        let inputs = Mat::identity(m, m);
        if omega.is_infinite() {
            return Some(Self { halves: vec![block(&[&[&Mat::zeros(n, m)], &[&inputs]])] });
        }
        let s = Complex::new(0.0, omega);
        let view = |i: usize, j: usize, rows: usize, cols: usize| {
            filtered.dynamics.view((i, j), (rows, cols)).into_owned()
        };
        let system = StateSpace {
            a: view(0, 0, k, k),
            b: view(0, n, k, m),
            c: Mat::identity(k, k),
            d: Mat::zeros(k, m),
        };
        let x = system.response(s)?;
        let complex = |m: Mat| m.map(|v| Complex::new(v, 0.0));
        let mut filters = complex(view(k, 0, n - k, k)) * &x + complex(view(k, n, n - k, m));
        for (i, mut row) in filters.row_iter_mut().enumerate() {
            row /= s - filtered.dynamics[(k + i, k + i)];
        }
        let part = |of: fn(&Complex<f64>) -> f64, u: &Mat| {
            block(&[&[&x.map(|v| of(&v))], &[&filters.map(|v| of(&v))], &[u]])
        };
        let (re, im) = (part(|v| v.re, &inputs), part(|v| v.im, &Mat::zeros(m, m)));
        let halves =
            if omega == 0.0 { vec![re] } else { vec![block(&[&[&re, &-&im]]), block(&[&[&im, &re]])] };
        Some(Self { halves })
    }

    /// Returns minus the real inequality with the form M, without the rows z.
    pub(super) fn value(&self, form: &Mat) -> Mat {
        let m = self.halves[0].ncols();
        -self.halves.iter().fold(Mat::zeros(m, m), |sum, u| sum + u.transpose() * (form * u))
    }
}

impl Unknowns {
    pub(super) fn new(program: &mut Program, of: &ConstantLoop, filtered: &Filtered) -> Self {
        Self {
            gamma: program.scalar(),
            s: program.symmetric_commuting(&filtered.channels),
            t: program.skew_commuting(&filtered.channels),
            lambdas: of.errors.iter().map(|_| program.scalar()).collect(),
        }
    }

    /// Returns a starting point: identities.
    pub(super) fn first(&self, program: &Program, filtered: &Filtered) -> Vec<f64> {
        let mut point = vec![0.0; program.unknowns()];
        let one = Mat::identity(1, 1);
        program.set(&mut point, &self.gamma, &one);
        self.lambdas.iter().for_each(|lambda| program.set(&mut point, lambda, &one));
        program.set(&mut point, &self.s, &Mat::identity(filtered.channels.len(), filtered.channels.len()));
        point
    }

    /// Returns the matrices that must be positive: S of each parameter and each rate, and every lambda.
    pub(super) fn signs(&self, of: &ConstantLoop, filtered: &Filtered) -> Vec<Affine> {
        let unit = Mat::identity(filtered.channels.len(), filtered.channels.len());
        let channels_of = |parameter: usize| -> Vec<usize> {
            (0..filtered.channels.len()).filter(|c| filtered.channels[*c] == parameter).collect()
        };
        let each =
            (0..2 * of.filters.len()).map(|p| self.s.congruence(&unit.select_columns(&channels_of(p))));
        each.chain(self.lambdas.iter().cloned()).filter(|e| e.shape().0 > 0).collect()
    }

    /// Returns the inequality at a frequency, with the margin `clear (|x|^2 + |f|^2 + |u|^2)`, rows (u | z), as
    /// positive.
    pub(super) fn at(&self, program: &Program, response: &Response, f: &Filtered, clear: f64) -> LowRank {
        let (all, z) = (f.dynamics.ncols(), f.output.nrows());
        let last = Mat::identity(all, all).rows(all - f.inputs, f.inputs).into_owned();
        let u = &response.halves[0];
        let (m, count) = (u.ncols(), response.halves.len());
        let (into, from) = (&f.into * u, &f.from * u);
        let skew = self.t.between(&from.transpose(), &into);
        let mut upper = self.s.congruence(&from) - self.s.congruence(&into) - skew.t() - skew
            + self.gamma.times_identity(f.inputs).congruence(&(&last * u));
        for (lambda, (into, from)) in self.lambdas.iter().zip(&f.errors) {
            upper = upper - lambda.times_identity(into.nrows()).congruence(&(into * u))
                + lambda.times_identity(from.nrows()).congruence(&(from * u));
        }
        let z_part = Mat::from_fn(z, count * z, |i, j| f64::from(i == j));
        let lower = self.gamma.times_identity(z).congruence(&z_part);
        let half =
            LowRank::new(program, &symmetric(&[vec![upper, Affine::zeros(m, count * z)], vec![lower]]));
        let outputs = response
            .halves
            .iter()
            .fold(Mat::zeros(0, m), |above, u| block(&[&[&above], &[&(&f.output * u)]]));
        let raised = response.halves.iter().fold(Mat::zeros(m, m), |sum, u| sum - u.transpose() * u * clear);
        let constant =
            block(&[&[&raised, &outputs.transpose()], &[&outputs, &Mat::zeros(count * z, count * z)]]);
        if count == 1 {
            return LowRank::real(half, &constant);
        }
        // Real and imaginary parts of u, then those of z.
        let rotation = [(0, m / 2), (m, z)].into_iter().flat_map(|(at, size)| {
            (0..2 * size).map(move |i| if i < size { (at + i + size, -1.0) } else { (at + i - size, 1.0) })
        });
        LowRank::hermitian(half, &constant, rotation.collect())
    }

    pub(super) fn values(&self, program: &Program, point: &[f64]) -> Multipliers {
        let value = |e: &Affine| e.value(program, point);
        Multipliers {
            gamma: value(&self.gamma)[(0, 0)],
            s: value(&self.s),
            t: value(&self.t),
            lambdas: self.lambdas.iter().map(|l| value(l)[(0, 0)]).collect(),
        }
    }
}

impl Multipliers {
    /// Returns the symmetric matrix of the form of (x, f, u), without X.
    pub(super) fn form(&self, f: &Filtered) -> Mat {
        let all = f.dynamics.ncols();
        let square = |m: &Mat, s: &Mat| m.transpose() * s * m;
        let skew = f.from.transpose() * &self.t * &f.into;
        let mut form = square(&f.into, &self.s) - square(&f.from, &self.s)
            + skew.transpose()
            + skew
            + f.output.transpose() * &f.output / self.gamma;
        for (lambda, (into, from)) in self.lambdas.iter().zip(&f.errors) {
            form += (into.transpose() * into - from.transpose() * from) * *lambda;
        }
        for i in all - f.inputs..all {
            form[(i, i)] -= self.gamma;
        }
        form
    }
}
