//! The gain of a finished loop for every course of some parameters and every constant value of others.
//!
//! ```text
//! x' = A x + Bt wt + B1 w + E w_D,   zt = Ct x + ...,   z_D = Fx x + ...,   z = C1 x + ...
//! wt = Theta zt,   w_D = Delta(t) z_D,  |Delta(t)| <= 1
//! ```
//!
//! A parameter that may take any course has multipliers S > 0 and T, constant over frequency. A constant one has them on
//! its channels and on these filtered by `1/(s + a)`: with `psi = [I; I/(s + a)]`, a constant delta gives
//!
//! ```text
//! (psi zt)'S (psi zt) - (psi wt)'S (psi wt) + 2 (psi wt)'T (psi zt),   S = S',  T = -T'
//! ```
//!
//! an integral `(1 - delta^2) (psi zt)'S (psi zt) >= 0` for `S > 0`. That asks no more than `psi~ S psi > 0` on the imaginary
//! axis would: with such an S, `S + [0 Y; Y -2aY] > 0` for some Y by the KYP lemma, and that matrix does the same, with `-Y` and
//! `Y` added to X on the states of the filters. Then the loop is
//! stable with a gain below gamma where one inequality with a symmetric X, which may be indefinite, holds: A.
//! Megretski, A. Rantzer, IEEE Trans. Automatic Control 42(6), 1997, theorem 1, with the multipliers of section VI.B.

use crate::error::SynthesisError;
use crate::lmi::interior_point::minimise;
use crate::lmi::low_rank::LowRank;
use crate::lmi::program::{Affine, Program, symmetric};
use crate::lmi::solver::margin;
use crate::lmi::solver_options::SolverOptions;
use crate::matrix::{Mat, block, diagonal_blocks, skew_part, spectral_abscissa, symmetric_part};
use crate::robust::bound::balanced;
use crate::system::lyapunov::{lyapunov, middle_of_gramians};
use crate::system::model_error::LoopError;
use crate::system::plant::ClosedLoop;
use crate::system::state_space::StateSpace;

const STAGE: &str = "analysis for constant parameters";

/// A finished loop, and what is known of the course of its parameters.
#[derive(Debug, Clone)]
pub struct ConstantLoop {
    /// The loop.
    pub closed: ClosedLoop,
    /// For each parameter the `a` of its filter `1/(s + a)`, rad/s: such a parameter must be constant. `None` for one
    /// that may take any course.
    pub poles: Vec<Option<f64>>,
    /// Model errors, each with a Delta(t) of its own.
    pub errors: Vec<LoopError>,
}

/// A bound on the gain, and what shows it.
///
/// Channels are those of the loop, then the filtered ones of each parameter with a filter, in the order of the
/// parameters; states are those of the loop, then those of the filters of zt, then of wt.
#[derive(Debug, Clone, PartialEq)]
pub struct ConstantBound {
    /// The bound.
    pub gamma: f64,
    /// States, square; in general indefinite.
    pub x: Mat,
    /// Channels, square.
    pub s: Mat,
    /// Channels, square.
    pub t: Mat,
    /// The multiplier of each model error.
    pub lambdas: Vec<f64>,
    /// A Lyapunov matrix of the loop's A.
    pub lyapunov: Mat,
    /// The largest eigenvalue of all inequalities, scaled to unit diagonals: negative.
    pub largest_eigenvalue: f64,
}

impl ConstantLoop {
    /// A bound within `tolerance`, relative, of the least that these multipliers show; `guess` is the order of magnitude of
    /// gamma. The closer a bound, the less clearly its inequalities hold.
    ///
    /// # Errors
    /// [`SynthesisError::Numerical`] when none was found: there may be none.
    pub fn bound(&self, guess: f64, tolerance: f64) -> Result<ConstantBound, SynthesisError> {
        let failed = |why: &str| SynthesisError::numerical(STAGE, why.to_owned());
        if spectral_abscissa(&self.closed.a()) >= 0.0 {
            return Err(failed("the loop is unstable where all parameters are 0"));
        }
        let balancing = balanced(&self.closed, guess).map(|s| if s > 0.0 { 1.0 / s.sqrt() } else { 0.0 });
        let filtered = Filtered::new(self, guess, &balancing);
        let filtered = filtered
            .balanced(self.closed.a().nrows())
            .ok_or_else(|| failed("the loop could not be balanced"))?;
        let mut program = Program::new();
        let unknowns = Unknowns::new(&mut program, self, &filtered);
        unknowns.pose(&mut program, self, &filtered);
        program.minimise_trace(&unknowns.gamma, 1.0);
        let data: Vec<LowRank> =
            program.inequalities.iter().map(|i| LowRank::new(&program, &i.expression)).collect();
        let search = SolverOptions::within(tolerance);
        let found = minimise(&data, &program.costs(), search).ok_or_else(|| failed("no bound was found"))?;
        let mut bound = unknowns.bound(&program, &found.x, &filtered, guess);
        bound.lyapunov = self.lyapunov(&filtered).ok_or_else(|| failed("no Lyapunov matrix was found"))?;
        bound.largest_eigenvalue = -margin(&program, &found.x);
        if bound.largest_eigenvalue < 0.0 {
            return Ok(bound);
        }
        Err(failed(&format!(
            "at gamma = {:.4e} an eigenvalue of the inequalities has the wrong sign, {:.1e}",
            bound.gamma, bound.largest_eigenvalue
        )))
    }

    /// In coordinates in which the loop is balanced, `A'Y + YA = -I`.
    fn lyapunov(&self, filtered: &Filtered) -> Option<Mat> {
        let n = self.closed.a().nrows();
        let back = filtered.back.view((0, 0), (n, n)).into_owned();
        let to = back.clone().try_inverse()?;
        let y = lyapunov(&(&back * self.closed.a() * to), &Mat::identity(n, n))?;
        Some(symmetric_part(&(back.transpose() * y * back)))
    }

    /// The channels of each parameter that has a filter, and its pole.
    fn dynamic(&self) -> impl Iterator<Item = (Vec<usize>, f64)> + '_ {
        self.poles.iter().enumerate().filter_map(|(parameter, pole)| {
            let own = |c: &usize| self.closed.channels[*c] == parameter;
            pole.map(|pole| ((0..self.closed.channels.len()).filter(own).collect(), pole))
        })
    }
}

/// The loop with its filters, as maps from `(x, f | wt, w_D, w)`: f are the states of the filters, and `x~ = back x`.
struct Filtered {
    /// To x' and f'.
    dynamics: Mat,
    /// To the channels zt and wt with what is filtered of them.
    into: Mat,
    from: Mat,
    /// To z_D and w_D of each model error.
    errors: Vec<(Mat, Mat)>,
    /// To z.
    output: Mat,
    /// Sizes of (x, f) and w.
    states: usize,
    inputs: usize,
    /// The parameter of each channel, the filtered ones last.
    channels: Vec<usize>,
    /// The scaling of the channels, diagonal, and the inverse of that of the states.
    scale: Mat,
    back: Mat,
}

impl Filtered {
    /// With `zt = scale zt~`, `wt = scale wt~`, and w and z in units in which a gain of `unit` is 1.
    fn new(of: &ConstantLoop, unit: f64, scale: &Mat) -> Self {
        let inverse = scale.map(|s| if s > 0.0 { 1.0 / s } else { 0.0 });
        let n = of.closed.a().nrows();
        let identity = Mat::identity(n, n);
        let l = of.closed.in_coordinates((&identity, &identity), (scale, &inverse)).in_units_of(unit);
        let errors: Vec<LoopError> = of
            .errors
            .iter()
            .map(|e| e.in_coordinates((&identity, &identity), scale).in_units_of(unit))
            .collect();
        let (r, w) = (l.channels.len(), l.b1().ncols());
        let own: Vec<usize> = of.dynamic().flat_map(|(own, _)| own).collect();
        let rates: Vec<f64> = of.dynamic().flat_map(|(own, pole)| vec![pole; own.len()]).collect();
        let k = own.len();
        let deltas: usize = errors.iter().map(|e| e.e.ncols()).sum();
        let zeros = Mat::zeros;
        let place = |rows: usize, at: usize| {
            Mat::from_fn(rows, n + 2 * k + r + deltas + w, |i, j| f64::from(j == at + i))
        };
        let (filters, wt) = (n, n + 2 * k);
        let zt = block(&[&[&l.ct(), &zeros(r, 2 * k), &l.dtt(), &zeros(r, deltas), &l.dt1()]]);
        let all_e = errors.iter().fold(zeros(n, 0), |all, e| block(&[&[&all, &e.e]]));
        let moved = block(&[&[&l.a(), &zeros(n, 2 * k), &l.bt(), &all_e, &l.b1()]]);
        let decay = Mat::from_diagonal(&nalgebra::DVector::from_vec(rates));
        let filter_z = zt.select_rows(&own) - &decay * place(k, filters);
        let filter_w = place(r, wt).select_rows(&own) - &decay * place(k, filters + k);
        let mut at = wt + r;
        let errors = errors.iter().map(|e| {
            let rows = e.fx.nrows();
            let into = block(&[&[&e.fx, &zeros(rows, 2 * k), &e.ft, &zeros(rows, deltas), &e.fw]]);
            let from = place(e.e.ncols(), at);
            at += e.e.ncols();
            (into, from)
        });
        let both = scale.select_rows(&own).select_columns(&own);
        let filter_units = inverse.select_rows(&own).select_columns(&own);
        Self {
            dynamics: block(&[&[&moved], &[&filter_z], &[&filter_w]]),
            into: block(&[&[&zt], &[&place(k, filters)]]),
            from: block(&[&[&place(r, wt)], &[&place(k, filters + k)]]),
            errors: errors.collect(),
            output: block(&[&[
                &l.c1(),
                &zeros(l.c1().nrows(), 2 * k),
                &l.d1t(),
                &zeros(l.c1().nrows(), deltas),
                &l.d11(),
            ]]),
            states: n + 2 * k,
            inputs: w,
            channels: l.channels.iter().copied().chain(own.iter().map(|c| l.channels[*c])).collect(),
            scale: diagonal_blocks(&[scale, &both]),
            back: diagonal_blocks(&[&identity, &filter_units, &filter_units]),
        }
    }

    /// In coordinates of the loop's own states in which its gramians are equal and diagonal: the first `own` states.
    fn balanced(mut self, own: usize) -> Option<Self> {
        let (n, m) = (self.states, self.dynamics.ncols() - self.states);
        let all = block(&[&[&self.into], &[&self.output]]);
        let whole = StateSpace {
            a: self.dynamics.view((0, 0), (own, own)).into_owned(),
            b: self.dynamics.view((0, n), (own, m)).into_owned(),
            c: all.columns(0, own).into_owned(),
            d: all.columns(n, m).into_owned(),
        };
        let (x, _) = middle_of_gramians(&[&whole])?;
        let back = diagonal_blocks(&[&x.cholesky()?.l().transpose(), &Mat::identity(n - own, n - own)]);
        let to = diagonal_blocks(&[&back.clone().try_inverse()?, &Mat::identity(m, m)]);
        self.dynamics = &back * self.dynamics * &to;
        for map in [&mut self.into, &mut self.from, &mut self.output] {
            *map = &*map * &to;
        }
        self.errors = self.errors.iter().map(|(into, from)| (into * &to, from * &to)).collect();
        self.back = back * self.back;
        Some(self)
    }
}

/// The unknowns of the inequalities, or their values.
struct Unknowns {
    gamma: Affine,
    x: Affine,
    s: Affine,
    t: Affine,
    lambdas: Vec<Affine>,
}

impl Unknowns {
    fn new(program: &mut Program, of: &ConstantLoop, filtered: &Filtered) -> Self {
        Self {
            gamma: program.scalar(),
            x: program.symmetric(filtered.states),
            s: program.symmetric_commuting(&filtered.channels),
            t: program.skew_commuting(&filtered.channels),
            lambdas: of.errors.iter().map(|_| program.scalar()).collect(),
        }
    }

    fn pose(&self, program: &mut Program, of: &ConstantLoop, filtered: &Filtered) {
        self.inequalities(of, filtered).into_iter().for_each(|e| program.positive("constant", e));
    }

    /// What must be positive definite: the main inequality with its sign changed, and the multipliers.
    fn inequalities(&self, of: &ConstantLoop, filtered: &Filtered) -> Vec<Affine> {
        let mut all = vec![-self.main(filtered)];
        let unit = Mat::identity(filtered.channels.len(), filtered.channels.len());
        for parameter in 0..of.poles.len() {
            let own: Vec<usize> =
                (0..filtered.channels.len()).filter(|c| filtered.channels[*c] == parameter).collect();
            all.push(self.s.congruence(&unit.select_columns(&own)));
        }
        all.extend(self.lambdas.iter().cloned());
        all.retain(|e| e.shape().0 > 0);
        all
    }

    /// Rows (x, f | wt, w_D, w | z): the dissipation inequality, with `z'z/gamma` by its Schur complement.
    fn main(&self, f: &Filtered) -> Affine {
        let all = f.dynamics.ncols();
        let first = Mat::identity(all, all).rows(0, f.states).into_owned();
        let last = Mat::identity(all, all).rows(all - f.inputs, f.inputs).into_owned();
        let lyapunov = self.x.between(&first.transpose(), &f.dynamics);
        let skew = self.t.between(&f.from.transpose(), &f.into);
        let mut upper = lyapunov.t() + lyapunov + self.s.congruence(&f.into) - self.s.congruence(&f.from)
            + skew.t()
            + skew
            - self.gamma.times_identity(f.inputs).congruence(&last);
        for (lambda, (into, from)) in self.lambdas.iter().zip(&f.errors) {
            upper = upper + lambda.times_identity(into.nrows()).congruence(into)
                - lambda.times_identity(from.nrows()).congruence(from);
        }
        let z = f.output.nrows();
        symmetric(&[vec![upper, Affine::constant(f.output.transpose())], vec![-self.gamma.times_identity(z)]])
    }

    /// The bound at a point, in the loop's own coordinates and units.
    fn bound(&self, program: &Program, point: &[f64], f: &Filtered, unit: f64) -> ConstantBound {
        let value = |e: &Affine| e.value(program, point);
        let inverse = f.scale.map(|s| if s > 0.0 { 1.0 / s } else { 0.0 });
        let rescaled = |m: Mat| &inverse * m * &inverse;
        ConstantBound {
            gamma: unit * value(&self.gamma)[(0, 0)],
            x: symmetric_part(&(f.back.transpose() * value(&self.x) * &f.back)),
            s: symmetric_part(&rescaled(value(&self.s))),
            t: skew_part(&rescaled(value(&self.t))),
            lambdas: self.lambdas.iter().map(|l| value(l)[(0, 0)]).collect(),
            lyapunov: Mat::zeros(0, 0),
            largest_eigenvalue: f64::NAN,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::system::partition::Group::{T, W, X, Z};
    use crate::system::partition::{LOOP, Partitioned};
    use nalgebra::dmatrix;

    const DAMPING: f64 = 0.1;

    /// `x'' + 2 zeta x' + (1 + size delta) x = w`, `z = x'`.
    fn oscillator(size: f64, pole: Option<f64>) -> ConstantLoop {
        let blocks = [
            (X, X, dmatrix![0.0, 1.0; -1.0, -2.0 * DAMPING]),
            (X, T, dmatrix![0.0; -1.0]),
            (X, W, dmatrix![0.0; 1.0]),
            (T, X, dmatrix![size, 0.0]),
            (Z, X, dmatrix![0.0, 1.0]),
        ];
        let parts = Partitioned::new(LOOP, &blocks).unwrap();
        ConstantLoop { closed: ClosedLoop { parts, channels: vec![0] }, poles: vec![pole], errors: vec![] }
    }

    /// The gain from force to velocity is 1/(2 zeta) whatever the stiffness, as long as it is constant and positive. A
    /// stiffness that may jump makes the loop unstable long before: as `zd = x` and `wd = delta size x`, the gain from wd to zd
    /// is `1/(2 zeta sqrt(1 - zeta^2))`, about 5.
    #[test]
    fn a_constant_stiffness_does_not_change_the_gain_from_force_to_velocity() {
        let exact = 1.0 / (2.0 * DAMPING);
        for (size, conservatism) in [(0.25, 1.1), (0.6, 1.2), (0.9, 1.3)] {
            let found = oscillator(size, Some(1.0)).bound(exact, 0.01).unwrap();
            assert!(found.largest_eigenvalue < 0.0);
            assert!(found.gamma > exact && found.gamma < conservatism * exact, "{size}: {}", found.gamma);
            assert!(oscillator(size, None).bound(exact, 0.01).is_err(), "{size}");
        }
        // Below the limit of the small-gain theorem both are bounds.
        let jumping = oscillator(0.15, None).bound(exact, 0.01).unwrap().gamma;
        let constant = oscillator(0.15, Some(1.0)).bound(exact, 0.01).unwrap().gamma;
        assert!(
            exact < constant && constant < 1.1 * exact && jumping > 1.2 * constant,
            "{constant} {jumping}"
        );
    }

    #[test]
    fn an_unstable_loop_has_no_bound() {
        let mut loop_ = oscillator(0.1, Some(1.0));
        loop_.closed.parts.block_mut(X, X).copy_from(&dmatrix![0.0, 1.0; -1.0, 0.2]);
        let found = loop_.bound(5.0, 0.01).unwrap_err().to_string();
        assert!(found.contains("unstable where all parameters are 0"), "{found}");
    }
}
