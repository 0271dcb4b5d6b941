//! A primal-dual interior-point method for linear matrix inequalities with low-rank data.
//!
//! ```text
//! minimise c'x   subject to  F(x) = F_0 + sum x_i F_i = Z >= 0
//! maximise -tr(F_0 X)   subject to  tr(F_i X) = c_i,  X >= 0
//! ```
//!
//! Each step solves the Newton equations of `X Z = mu I` for dx only, one equation per unknown regardless of the size
//! of the matrices: `sum_j tr(F_i X F_j Z^-1) dx_j = tr(F_i (mu Z^-1 - X R Z^-1)) - c_i` with `R = F(x) - Z`. With
//! [`LowRank`] data an entry of that matrix costs a few multiplications. A general conic solver instead factorises a
//! matrix with one row per entry of each inequality.
//!
//! Direction: C. Helmberg, F. Rendl, R. J. Vanderbei, H. Wolkowicz, SIAM J. Optimization 6(2), 1996, and M. Kojima,
//! S. Shindoh, S. Hara, 7(1), 1997; predictor and corrector: S. Mehrotra, SIAM J. Optimization 2(4), 1992; starting
//! point: B. Borchers, Optimization Methods and Software 11, 1999, eq. 19.

mod multipliers;
mod step;

use crate::lmi::{LowRank, SolverOptions};
use crate::matrix::{Mat, least_eigenvalue, symmetric_part};
use crate::stop;
use std::collections::VecDeque;

/// The result of [`minimise`].
#[derive(Debug, Clone)]
pub(crate) struct Minimum {
    /// The best point found that satisfies all inequalities strictly.
    pub(crate) x: Vec<f64>,
    /// The largest possible excess of its objective over the least, relative to the objective plus the floor of the
    /// search; the tolerance if the objective has settled.
    pub(crate) gap: f64,
    /// The multipliers of the last steps, one matrix per inequality: the last are closest to the optimum, the first
    /// have the largest margin.
    pub(crate) multipliers: Vec<Vec<Mat>>,
}

/// The number of steps whose multipliers are kept.
const KEPT_MULTIPLIERS: usize = 2;

/// The largest number of steps; more make no progress.
const MOST_STEPS: u32 = 100;

/// The initial level of the multipliers at a known point, relative to the level of the best fit: an excess is removed
/// in a few steps, too low a level leads to short steps.
const WARM_START_FACTOR: f64 = 1e6;

/// The objective has settled if it fell by this factor less than the tolerance in [`SETTLED_STEPS`] steps and the
/// multipliers, though not feasible enough for a bound, indicate that it is near the least.
const SETTLED: f64 = 20.0;
const SETTLED_STEPS: usize = 3;

/// The level mu at a point of the right size, for an objective of about 1, and the least slack there relative to its
/// inequality.
const FIRST_LEVEL: f64 = 0.01;
const LEAST_SLACK: f64 = 1e-3;

/// Factor by which the level is raised once it reaches the tolerance: if it was too low, the residual of the slacks
/// decreases no faster than the slacks, and the inequalities are never satisfied.
const LEVEL_RAISE: f64 = 10.0;

/// Step length below which the method is taken as stuck.
const SHORTEST_STEP: f64 = 1e-4;

/// Minimises `objective` with the options `search`. `None` if no strictly feasible point is found.
pub(crate) fn minimise(
    inequalities: &[LowRank],
    objective: &[f64],
    search: SolverOptions<'_>,
) -> Option<Minimum> {
    let mut state = search
        .start
        .and_then(|x| State::warm(inequalities, objective, x))
        .or_else(|| State::near(inequalities, objective, search.near?.0))
        .unwrap_or_else(|| State::cold(inequalities, objective));
    let mut best: Option<(f64, Vec<f64>)> = None;
    let mut multipliers = VecDeque::new();
    let mut values = VecDeque::new();
    let mut settled = false;
    let mut bound = f64::NEG_INFINITY;
    let gap = |value: f64, bound: f64| (value - bound) / (search.floor + value.abs());
    for _ in 0..MOST_STEPS {
        stop::check();
        let value = state.value();
        let distance = state.rows() * state.mu() / (search.floor + value.abs());
        let is_close = distance < search.tolerance;
        if is_close && !state.feasible && search.near.is_some() {
            state.cones.iter_mut().for_each(|c| c.x *= LEVEL_RAISE);
        }
        if state.feasible {
            bound = bound.max(state.bound());
            if search.near.is_some_and(|(_, most)| value - state.rows() * state.mu() > most) {
                return None;
            }
            if is_close && search.near.is_some() {
                best = Some((value, state.x.clone()));
                break;
            }
            // The remaining gap of the bound is rounding, not the distance from the optimum.
            if is_close && gap(value, bound) >= search.tolerance {
                bound = bound.max(state.correct().unwrap_or(f64::NEG_INFINITY));
            }
            if best.as_ref().is_none_or(|(known, _)| value < *known) {
                best = Some((value, state.x.clone()));
            }
            values.push_back(value);
            if values.len() > SETTLED_STEPS {
                let fell = values.pop_front().map_or(f64::INFINITY, |first| gap(first, value).abs());
                settled = search.settles && distance.max(SETTLED * fell) < search.tolerance;
            }
            if settled {
                break;
            }
            multipliers.push_back(state.cones.iter().map(|c| c.x.clone()).collect());
            if multipliers.len() > KEPT_MULTIPLIERS {
                multipliers.pop_front();
            }
            if best.as_ref().is_some_and(|(value, _)| gap(*value, bound) < search.tolerance) {
                break;
            }
        }
        match state.advance() {
            Some(length) if length > SHORTEST_STEP => {}
            _ => break,
        }
    }
    let reached = |value: f64| if settled { search.tolerance } else { gap(value, bound) };
    best.map(|(value, x)| Minimum { x, gap: reached(value), multipliers: multipliers.into() })
}

/// One inequality at the current point.
struct Cone<'a> {
    data: &'a LowRank,
    /// The multiplier X.
    x: Mat,
    /// The slack Z.
    z: Mat,
}

struct State<'a> {
    cones: Vec<Cone<'a>>,
    objective: &'a [f64],
    x: Vec<f64>,
    /// `true` if every slack equals the value of its inequality.
    feasible: bool,
}

impl<'a> State<'a> {
    /// Starts with multipliers in the direction of the central path, at the level that fits the objective best.
    fn warm(inequalities: &'a [LowRank], objective: &'a [f64], x: &[f64]) -> Option<Self> {
        let mut cones = Vec::with_capacity(inequalities.len());
        let mut slope = vec![0.0; objective.len()];
        for data in inequalities {
            let z = data.constant() + data.linear(x);
            let inverse = symmetric_part(&z.clone().cholesky()?.inverse());
            data.add_inner_products(&inverse, 1.0, &mut slope);
            cones.push(Cone { data, x: inverse, z });
        }
        let product: f64 = slope.iter().zip(objective).map(|(s, c)| s * c).sum();
        let square: f64 = slope.iter().map(|s| s * s).sum();
        let mu = WARM_START_FACTOR * if product > 0.0 { product / square } else { 1.0 };
        cones.iter_mut().for_each(|c| c.x *= mu);
        Some(Self { cones, objective, x: x.to_vec(), feasible: true })
    }

    /// Starts at a point that may violate inequalities: their slacks are raised until they are positive.
    fn near(inequalities: &'a [LowRank], objective: &'a [f64], x: &[f64]) -> Option<Self> {
        let cone = |data: &'a LowRank| {
            let value = data.constant() + data.linear(x);
            let (least, floor) = (least_eigenvalue(&value), LEAST_SLACK * value.norm());
            let raise = if least < floor { floor - 2.0 * least.min(0.0) } else { 0.0 };
            let z = &value + Mat::identity(value.nrows(), value.nrows()) * raise;
            let inverse = symmetric_part(&z.clone().cholesky()?.inverse());
            Some(Cone { data, x: inverse * FIRST_LEVEL, z })
        };
        let cones = inequalities.iter().map(cone).collect::<Option<_>>()?;
        Some(Self { cones, objective, x: x.to_vec(), feasible: false })
    }

    fn cold(inequalities: &'a [LowRank], objective: &'a [f64]) -> Self {
        let cones = inequalities
            .iter()
            .map(|data| {
                let n = data.size() as f64;
                let norms = data.norms(objective.len());
                let largest = norms.iter().copied().fold(data.constant().norm(), f64::max);
                let ratio = norms.iter().zip(objective).map(|(norm, c)| (1.0 + c.abs()) / (1.0 + norm));
                let x = 10.0 * n * ratio.fold(0.0, f64::max);
                let z = 10.0 * (1.0 + largest);
                let unit = Mat::identity(data.size(), data.size());
                Cone { data, x: &unit * x, z: unit * z }
            })
            .collect();
        Self { cones, objective, x: vec![0.0; objective.len()], feasible: false }
    }

    fn rows(&self) -> f64 {
        self.cones.iter().map(|c| c.data.size()).sum::<usize>() as f64
    }

    /// Returns `tr(X Z)` over the number of rows.
    fn mu(&self) -> f64 {
        self.cones.iter().map(|c| c.x.dot(&c.z)).sum::<f64>() / self.rows()
    }

    /// Returns the objective at the current point.
    fn value(&self) -> f64 {
        self.x.iter().zip(self.objective).map(|(x, c)| x * c).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::SynthesisError;
    use crate::lmi::program::{Affine, Program, symmetric};
    use crate::lmi::solver::solve;
    use crate::system::StateSpace;
    use proptest::prelude::*;

    /// Returns the bounded-real lemma of a system, and its unknowns X and gamma.
    fn bounded_real(s: &StateSpace) -> (Program, Affine, Affine) {
        let mut program = Program::default();
        let x = program.symmetric(s.a.nrows());
        let gamma = program.scalar();
        let (lyapunov, constant) = (x.times(&s.a), |m: &Mat| Affine::constant(m.transpose()));
        let inequality = symmetric(&[
            vec![lyapunov.t() + lyapunov, x.times(&s.b), constant(&s.c)],
            vec![-gamma.times_identity(s.b.ncols()), constant(&s.d)],
            vec![-gamma.times_identity(s.c.nrows())],
        ]);
        program.positive("X", x.clone());
        program.negative("bounded real", inequality);
        program.minimise_trace(&gamma, 1.0);
        (program, x, gamma)
    }

    fn data(program: &Program) -> Vec<LowRank> {
        program.inequalities.iter().map(|i| LowRank::new(program, &i.expression)).collect()
    }

    /// Returns a stable system: its slowest mode is at least 0.3 from the axis.
    fn stable() -> impl Strategy<Value = StateSpace> {
        (1usize..6, 1usize..3, 1usize..3).prop_flat_map(|(n, m, p)| {
            let matrix = |r: usize, c: usize| {
                prop::collection::vec(-1.0..1.0f64, r * c).prop_map(move |v| Mat::from_vec(r, c, v))
            };
            (matrix(n, n), matrix(n, m), matrix(p, n), matrix(p, m)).prop_map(|(a, b, c, d)| {
                let n = a.nrows();
                let shift = crate::matrix::spectral_abscissa(&a) + 0.3;
                StateSpace { a: a - Mat::identity(n, n) * shift, b, c, d }
            })
        })
    }

    proptest! {
        /// The least gamma of the bounded-real lemma is the H-infinity norm, found independently by bisection; the
        /// reported gap covers the difference.
        #[test]
        fn the_least_gamma_is_the_norm(system in stable()) {
            let (program, x, gamma) = bounded_real(&system);
            let norm = system.hinf_norm().value;
            let above = |stop: &Minimum| gamma.value(&program, &stop.x)[(0, 0)] - norm;
            // The bisection's own accuracy.
            let rounding = 1e-9 * (1.0 + norm);
            let stop = minimise(&data(&program), &program.costs(), SolverOptions::fine()).unwrap();
            prop_assert!(stop.gap < 1e-4, "{}", stop.gap);
            prop_assert!((-rounding..stop.gap * (1.0 + norm) + rounding).contains(&above(&stop)));
            prop_assert!(least_eigenvalue(&x.value(&program, &stop.x)) > 0.0);
            // A search from an early point gives the same result.
            let early = minimise(&data(&program), &program.costs(), SolverOptions::within(0.3)).unwrap();
            let search = SolverOptions { start: Some(&early.x), ..SolverOptions::within(1e-5) };
            let again = minimise(&data(&program), &program.costs(), search).unwrap();
            prop_assert!(again.gap < 1e-4, "{}", again.gap);
            prop_assert!((-rounding..again.gap * (1.0 + norm) + rounding).contains(&above(&again)));
        }

        /// No point exists, and none is reported, if an unstable mode is observable and gamma is limited. (The general
        /// solver proves this in all but one in some thousand cases.)
        #[test]
        fn no_point_is_reported_for_an_unstable_system(system in stable()) {
            let n = system.a.nrows();
            let unit = Mat::identity(n, n);
            let (b, c, d) = (unit.clone(), unit.clone(), Mat::zeros(n, n));
            let unstable = StateSpace { a: &system.a + unit * 0.8, b, c, d };
            let (mut program, _, gamma) = bounded_real(&unstable);
            program.positive("limit", Affine::number(10.0) - gamma);
            prop_assert!(minimise(&data(&program), &program.costs(), SolverOptions::fine()).is_none());
            match solve(&program, "test", SolverOptions::fine()) {
                Ok(claimed) => prop_assert!(claimed.margin <= 0.0, "{}", claimed.margin),
                Err(SynthesisError::Infeasible { .. } | SynthesisError::Numerical { .. }) => {}
                Err(other) => prop_assert!(false, "{other}"),
            }
        }
    }
}
