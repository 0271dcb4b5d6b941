//! Steps of a reference under which a loop with saturated commands stays stable, for any motion of the parameters.
//!
//! The loop of plant, model error and controller with `phi = u - sat(u)` is
//!
//! ```text
//! (x', zt, u, z_D) = M (x, wt, phi, r) + (E w_D, 0, 0, 0),   wt = Theta zt,   w_D = Delta z_D
//! ```
//!
//! While a step r is held, x is measured from `x_e r` and u from `u_e r`, the equilibrium at Theta = 0. The conditions
//! for an alpha > 0 are that for all (x, wt, phi, w_D) and r up to the size d, with V = x'Xx,
//!
//! ```text
//! dV/dt + alpha V - alpha (r/d)^2 + zt'S zt - wt'S wt + 2 wt'T zt + 2 phi'U (u - phi - H x)
//!     + lambda (z_D'z_D - w_D'w_D) < 0,      d^2 x_e'X x_e < 1,      |H x| < limit where V < 4
//! ```
//!
//! Then V stays below 1 while a step is held, is below 4 when it is removed, and decays from there: the term of U is
//! not negative while `|H x|` is below the limit (J. M. Gomes da Silva Jr., S. Tarbouriech, IEEE Trans. Automatic
//! Control 50(1), 2005, lemma 1). In `Q = X^-1`, `Y = HQ`, `U^-1` and the inverse of the multiplier \[S -T; T -S\] the
//! inequalities are linear, also in d^2, because the form is definite if that of the inverse matrices on the transposed
//! loop is (C. Scherer, S. Weiland, "Linear matrix inequalities in control", 2015, lemma 4.9). There the gain G from
//! phi into the controller's states, which is part of M, is multiplied by U^-1 only: `G U^-1` can be an unknown, too.
//!
//! With H = 0 the term of U is never negative, and no equilibrium is needed: `x_e = 0`, `u_e = 0`. The inequality is
//! then homogeneous in V, the multipliers and d^2, so a result for one step holds for every step, from every state.
//! This requires a plant that is stable without its commands.
//!
//! For a state of the plant with a limited rate, such as that of an actuator, the rate is appended to u and its
//! saturated part to phi, which acts on this state only (F. Tyan, D. S. Bernstein, Int. J. Control 67(1), 1997).

use crate::anti_windup::saturated::{Transposed, Units, Unknowns};
use crate::error::SynthesisError;
use crate::lmi::{Affine, Program, SolverOptions, solver};
use crate::matrix::{Mat, block, diagonal, roots, solve, spectral_abscissa, to_rows};
use crate::system::{
    Controller, GeneralisedPlant, ModelError, StateSpace, channels, lyapunov, middle_of_gramians,
};
use nalgebra::DVector;

const STAGE: &str = "region of a loop with limits";

/// The tolerance of the largest step, relative to its square.
const ACCURACY: f64 = 1e-2;

/// alpha relative to the rate of the slowest mode, in the order tried: 2 is an upper bound.
const DECAYS: [f64; 3] = [1.5, 0.75, 0.25];

/// The fraction of the step found that is claimed, so that the inequalities hold with a margin.
const CLAIMED: f64 = 0.99;

/// The gain G from phi into the controller's states.
#[derive(Debug, Clone, Copy)]
pub enum Gain<'a> {
    /// A given gain.
    Given(&'a Mat),
    /// The gain of the largest step. The bound \[1/s\] on its entries, with the states in units of their sizes in the
    /// loop and phi in those of the limits, keeps G slow enough for a sampled controller.
    Sought(f64),
}

/// A loop with saturated commands.
#[derive(Debug, Clone, Copy)]
pub struct Limited<'a> {
    /// The plant.
    pub plant: &'a GeneralisedPlant,
    /// The states of the plant that are part of the loop; the others are weights.
    pub kept: &'a [usize],
    /// The controller of the loop.
    pub controller: &'a Controller,
    /// The model error to be tolerated.
    pub error: &'a ModelError,
    /// The squares of the channels' units: a symmetric matrix that commutes with Theta, channels of plant and
    /// controller square.
    pub units: &'a Mat,
    /// The gain G.
    pub gain: Gain<'a>,
    /// The limit of each command in both directions (the smaller one), then of the rate of each state of `rates`.
    pub limits: &'a [f64],
    /// The states of the plant with limited rates; all of them are in `kept`.
    pub rates: &'a [usize],
    /// The component of w that steps.
    pub input: usize,
    /// The largest step of interest, in units of w.
    pub largest: f64,
}

/// The proof that a loop stays stable under steps, with n states: those kept and the controller's.
#[derive(Debug, Clone, PartialEq)]
#[allow(missing_docs, reason = "the names are those of the equations above")]
pub struct Region {
    /// The step size d.
    pub size: f64,
    /// The decay alpha.
    pub decay: f64,
    pub x: Mat,
    pub s: Mat,
    pub t: Mat,
    /// Half of the diagonal of U.
    pub u: Vec<f64>,
    pub h: Mat,
    pub lambda: f64,
    /// The gain G.
    pub gain: Mat,
    /// The equilibrium x_e.
    pub x_held: Vec<f64>,
    /// The equilibrium u_e.
    pub u_held: Vec<f64>,
}

/// Computes the largest step of one component of w.
///
/// # Errors
/// Returns [`SynthesisError::Infeasible`] if no step is proved, for any size; [`SynthesisError::Numerical`].
pub fn largest_step(of: Limited<'_>) -> Result<Region, SynthesisError> {
    if let Some(j) = of.limits.iter().position(|limit| limit.is_nan() || *limit <= 0.0) {
        let diagnosis = format!("limit {j} is {}; it must be above 0", of.limits[j]);
        return Err(SynthesisError::numerical(STAGE, diagnosis));
    }
    fastest(&Flow::of(of, false)?)
}

/// Proves stability for every step from every state, with H = 0, for a given gain.
///
/// # Errors
/// Errors of [`largest_step`].
pub fn every_step(of: Limited<'_>) -> Result<Region, SynthesisError> {
    let flow = Flow::of(of, true)?;
    if flow.without_commands().is_none_or(|a| spectral_abscissa(&a) >= 0.0) {
        return Err(SynthesisError::Infeasible { stage: STAGE });
    }
    fastest(&flow)
}

/// Returns the largest step, at the fastest decay that allows it.
fn fastest(flow: &Flow<'_>) -> Result<Region, SynthesisError> {
    let slowest = -spectral_abscissa(&flow.part(0, 0));
    if slowest.is_nan() || slowest <= 0.0 {
        return Err(SynthesisError::numerical(STAGE, "the loop without limits is unstable"));
    }
    let mut best: Result<Region, SynthesisError> = Err(SynthesisError::Infeasible { stage: STAGE });
    for decay in DECAYS.map(|part| part * slowest) {
        let found = flow.search(decay);
        let better = match (&found, &best) {
            (Ok(found), Ok(known)) => found.size > (1.0 + ACCURACY) * known.size,
            (Ok(_), Err(_)) => true,
            (Err(_), _) => false,
        };
        if better {
            best = found;
        } else if best.is_ok() {
            break;
        }
    }
    best
}

/// The loop; its columns are x, wt, phi, step, its rows x', zt, u, z_D.
struct Flow<'a> {
    of: Limited<'a>,
    /// The matrix M, with G = 0 if it is an unknown, x and u from the equilibrium of a step, r in units of `unit`.
    m: Mat,
    /// The matrix E.
    e: Mat,
    rows: [usize; 4],
    columns: [usize; 4],
    x_held: Mat,
    u_held: Mat,
    /// The step at which a command is at half of its limit in equilibrium, at most the largest.
    unit: f64,
    /// `true` if H = 0.
    everywhere: bool,
}

impl<'a> Flow<'a> {
    fn of(of: Limited<'a>, everywhere: bool) -> Result<Self, SynthesisError> {
        let (p, k, kept) = (of.plant, of.controller, of.kept);
        let (nk, rk, all, r) = (k.a().nrows(), k.dtt().nrows(), of.limits.len(), p.dtt().nrows());
        let m = all - of.rates.len();
        let rows_of = |m: &Mat| m.select_rows(kept);
        let zero = Mat::zeros;
        let gain = match of.gain {
            Gain::Given(gain) => gain.clone(),
            Gain::Sought(_) => zero(nk, m),
        };
        let input = |m: &Mat| m.columns(of.input, 1).into_owned();
        let (c2, f) = (p.c2().select_columns(kept), of.error.f.select_columns(kept));
        let (error, y, nf) = (of.error, c2.nrows(), f.nrows());
        let n = kept.len();
        // y and u as functions of x, xk, wt, wk, phi, r.
        let y = block(&[&[&c2, &zero(y, nk), &p.d2t(), &zero(y, rk), &zero(y, all), &input(&p.d21())]]);
        let u = block(&[&[&zero(m, n), &k.cu(), &zero(m, r), &k.dut(), &zero(m, all), &zero(m, 1)]])
            + k.duy() * &y;
        let mut acting = u.clone();
        let unsaturated = acting.columns(n + nk + r + rk, m) - Mat::identity(m, m);
        acting.columns_mut(n + nk + r + rk, m).copy_from(&unsaturated);
        let of_plant = |a: &Mat, bt: &Mat, b1: &Mat, b2: &Mat| {
            let q = a.nrows();
            block(&[&[a, &zero(q, nk), bt, &zero(q, rk), &zero(q, all), b1]]) + b2 * &acting
        };
        let of_controller = |a: &Mat, by: &Mat, bt: &Mat, e: &Mat| {
            let q = a.nrows();
            block(&[&[&zero(q, n), a, &zero(q, r), bt, e, &zero(q, 1)]]) + by * &y
        };
        let a = p.a().select_columns(kept);
        let mut moved =
            of_plant(&rows_of(&a), &rows_of(&p.bt()), &rows_of(&input(&p.b1())), &rows_of(&p.b2()));
        let limited = of.rates.iter().filter_map(|state| kept.iter().position(|one| one == state));
        let limited: Vec<usize> = limited.collect();
        if limited.len() < of.rates.len() {
            return Err(SynthesisError::numerical(
                STAGE,
                "a state with a limited rate does not belong to the loop",
            ));
        }
        let rates = moved.select_rows(&limited);
        limited.iter().enumerate().for_each(|(j, &state)| moved[(state, n + nk + r + rk + m + j)] -= 1.0);
        let gain = block(&[&[&gain, &zero(nk, all - m)]]);
        let full = block(&[
            &[&moved],
            &[&of_controller(&k.a(), &k.by(), &k.bt(), &gain)],
            &[&of_plant(&p.ct().select_columns(kept), &p.dtt(), &input(&p.dt1()), &p.dt2())],
            &[&of_controller(&k.ct(), &k.dty(), &k.dtt(), &zero(rk, all))],
            &[&u],
            &[&rates],
            &[&of_plant(&f, &zero(nf, r), &input(&error.fw), &error.fu)],
        ]);
        let e = block(&[&[&rows_of(&of.error.e)], &[&zero(nk, of.error.e.ncols())]]);
        let (rows, columns) = ([n + nk, r + rk, all, nf], [n + nk, r + rk, all, 1]);
        let (x_held, u_held) = (zero(n + nk, 1), zero(all, 1));
        let mut flow = Self { of, m: full, e, rows, columns, x_held, u_held, unit: of.largest, everywhere };
        flow.hold()?;
        Ok(flow)
    }

    fn part(&self, row: usize, column: usize) -> Mat {
        let at = |sizes: &[usize; 4], index: usize| (sizes[..index].iter().sum::<usize>(), sizes[index]);
        let ((i, rows), (j, columns)) = (at(&self.rows, row), at(&self.columns, column));
        self.m.view((i, j), (rows, columns)).into_owned()
    }

    /// Returns the number of components of u and phi that are commands, not rates.
    fn commands(&self) -> usize {
        self.columns[2] - self.of.rates.len()
    }

    /// Measures x and u from the equilibrium of a step at Theta = 0, unless H = 0.
    fn hold(&mut self) -> Result<(), SynthesisError> {
        let held = solve(&self.part(0, 0), &-self.part(0, 3))
            .ok_or_else(|| SynthesisError::numerical(STAGE, "the loop has an integrator"))?;
        let commands = self.part(2, 0) * &held + self.part(2, 3);
        let share = |j: usize| 0.5 * self.of.limits[j] / commands[(j, 0)].abs();
        self.unit = (0..commands.nrows()).map(share).fold(self.of.largest / CLAIMED.powi(2), f64::min);
        let [n, _, _, _] = self.columns;
        let last = self.m.ncols() - 1;
        let mut step = self.m.columns(last, 1).into_owned();
        if !self.everywhere {
            step += self.m.columns(0, n) * &held;
            step.rows_mut(0, n).fill(0.0);
            let first = self.rows[0] + self.rows[1];
            step.rows_mut(first, self.rows[2]).fill(0.0);
            (self.x_held, self.u_held) = (held, commands);
        }
        self.m.columns_mut(last, 1).copy_from(&(step * self.unit));
        Ok(())
    }

    /// Returns A of the loop at Theta = 0 with all commands fully saturated, phi = u.
    fn without_commands(&self) -> Option<Mat> {
        let m = self.columns[2];
        let all = solve(&(Mat::identity(m, m) - self.part(2, 2)), &self.part(2, 0))?;
        Some(self.part(0, 0) + self.part(0, 2) * all)
    }

    /// Returns T and its inverse, in which the geometric mean of the gramians of the loop at Theta = 0 is the identity.
    fn coordinates(&self, units: &Mat, limits: &Mat) -> Result<(Mat, Mat), SynthesisError> {
        let (rooted, unrooted) = roots(units);
        let inverse = limits.map(|v| if v == 0.0 { 0.0 } else { 1.0 / v });
        let b = block(&[&[
            &(self.part(0, 1) * unrooted),
            &(self.part(0, 2) * limits),
            &(&self.x_held * self.unit),
        ]]);
        let c = block(&[&[&(rooted * self.part(1, 0))], &[&(inverse * self.part(2, 0))]]);
        let d = Mat::zeros(c.nrows(), b.ncols());
        let system = StateSpace { a: self.part(0, 0), b, c, d };
        let (x, _) = middle_of_gramians(&[&system]).ok_or_else(|| {
            SynthesisError::numerical(STAGE, "the mean of the Gramians is not positive definite")
        })?;
        let (inverse, state) = roots(&x);
        Ok((state, inverse))
    }

    /// Returns the largest rate of each controller state by phi of half the limits, in units of its size under white
    /// noise of unit size on the commands, in units of their limits, and on the step; empty for a given G.
    fn reach(&self, half: &Mat) -> Result<DVector<f64>, SynthesisError> {
        let Gain::Sought(largest) = self.of.gain else { return Ok(DVector::zeros(0)) };
        let nk = self.of.controller.a().nrows();
        let by_commands = (self.part(0, 2) * half * 2.0).remove_columns(self.commands(), self.of.rates.len());
        let pushed = block(&[&[&by_commands, &(&self.x_held * self.unit)]]);
        let gramian = lyapunov(&self.part(0, 0).transpose(), &(&pushed * pushed.transpose()))
            .ok_or_else(|| SynthesisError::numerical(STAGE, "the loop without limits is unstable"))?;
        Ok(gramian.diagonal().rows(gramian.nrows() - nk, nk).map(|v| 0.5 * largest * v.max(0.0).sqrt()))
    }

    /// Returns the largest step at a decay.
    fn search(&self, decay: f64) -> Result<Region, SynthesisError> {
        let half: Vec<f64> = self.of.limits.iter().map(|limit| 0.5 * limit).collect();
        let commands = diagonal(half.iter().copied());
        let coordinates = self.coordinates(self.of.units, &commands)?;
        let held = &coordinates.1 * &self.x_held * self.unit;
        let e = &coordinates.1 * &self.e;
        let units = Units {
            state: coordinates,
            channels: self.of.units,
            commands: &half,
            input: 1.0,
            output: 1.0,
            reach: self.reach(&commands)?,
        };
        let loop_ = Transposed::of(&self.m, self.rows, self.columns, units);
        let mut program = Program::default();
        let parameters = [&self.of.plant.blocks, &self.of.controller.blocks];
        let channels: Vec<usize> = parameters.iter().flat_map(|blocks| channels(blocks)).collect();
        let unknowns = Unknowns::of(&mut program, &loop_, &channels, self.commands(), self.everywhere);
        let [mu, size] = loop_.program(&mut program, &unknowns, &e, &held, decay);
        // For loops of about twenty states the general solver took up to 40 s per decay, and found no step if the first
        // solver had found none.
        let options = SolverOptions {
            floor: 1e-2,
            enough: ACCURACY,
            settles: true,
            quick: true,
            ..SolverOptions::within(ACCURACY)
        };
        let solution = solver::solve(&program, STAGE, options)?.feasible(STAGE)?;
        let value = |e: &Affine| e.value(&program, &solution.x)[(0, 0)];
        let (mu, size) = (value(&mu), value(&size));
        if size <= 0.0 {
            return Err(SynthesisError::numerical(STAGE, "the largest step found is not positive"));
        }
        let found = CLAIMED * self.unit * size.sqrt();
        let size = if self.everywhere { self.of.largest } else { found.min(self.of.largest) };
        let share = if self.everywhere { (found / size).powi(2) } else { 1.0 };
        let shown = unknowns
            .shown(&loop_, &program, &solution.x, share)
            .ok_or_else(|| SynthesisError::numerical(STAGE, "a matrix of the solution is singular"))?;
        Ok(Region {
            size,
            decay,
            lambda: share / mu,
            gain: match self.of.gain {
                Gain::Given(gain) => gain.clone(),
                Gain::Sought(_) => shown.gain,
            },
            x: shown.x,
            s: shown.s,
            t: shown.t,
            u: shown.u,
            h: shown.h,
            x_held: to_rows(&self.x_held).concat(),
            u_held: to_rows(&self.u_held).concat(),
        })
    }
}

impl Transposed {
    /// Adds the inequalities of a step; returns the unknowns 1/lambda and d^2.
    fn program(&self, program: &mut Program, of: &Unknowns, e: &Mat, held: &Mat, decay: f64) -> [Affine; 2] {
        let ([_, _, _, step], [x_dot, _, _, z_error]) = (&self.back, &self.select);
        let [mu, size] = [(); 2].map(|()| program.scalar());
        let e = e.transpose() * x_dot;
        let inequality = of.form(self)
            + of.q.congruence(x_dot).scaled(decay)
            + size.congruence(&(step / decay.sqrt()))
            + mu.times_identity(e.nrows()).congruence(&e)
            - mu.times_identity(z_error.nrows()).congruence(z_error);
        program.negative("decay", inequality);
        let one = Affine::constant(Mat::identity(1, 1));
        program.positive("step", of.q.clone() - size.between(held, &held.transpose()));
        program.positive("largest step", one.clone() - size.clone());
        of.out_of_reach(program, &one);
        program.minimise_trace(&size, -1.0);
        [mu, size]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::system::partition::Group::{U, W, X, Y, Z};
    use nalgebra::dmatrix;

    /// Returns the region of `x' = a x + u`, `u = k (r - x)`.
    fn found(a: f64, k: f64, limit: f64) -> Result<Region, SynthesisError> {
        let controller = Controller::new(vec![], &[(U, Y, dmatrix![k])]).unwrap();
        under(a, &controller, limit, Gain::Given(&Mat::zeros(0, 1)))
    }

    /// Returns the region of `x' = a x + u` under a controller of r - x.
    fn under(a: f64, controller: &Controller, limit: f64, gain: Gain<'_>) -> Result<Region, SynthesisError> {
        let one = dmatrix![1.0];
        let parts =
            [(X, X, dmatrix![a]), (X, U, one.clone()), (Z, X, one.clone()), (Y, X, -&one), (Y, W, one)];
        let plant = GeneralisedPlant::new(vec![], &parts).unwrap();
        let zero = dmatrix![0.0];
        let error = ModelError { e: zero.clone(), f: zero.clone(), fw: zero.clone(), fu: zero };
        let limited = Limited {
            plant: &plant,
            kept: &[0],
            controller,
            error: &error,
            units: &Mat::zeros(0, 0),
            gain,
            limits: &[limit],
            rates: &[],
            input: 0,
            largest: 100.0,
        };
        let region = largest_step(limited)?;
        let every = every_step(Limited { gain: Gain::Given(&region.gain), ..limited });
        Ok(every.unwrap_or(region))
    }

    /// A stable plant remains stable for every step, an unstable one only if its saturated command can still stabilise
    /// it: from |x| < 1; a step r, held at x = 2 r and removed, may take V to four times its value there.
    #[test]
    fn largest_steps_have_their_closed_forms() {
        let stable = found(-1.0, 1.0, 1.0).unwrap();
        assert_eq!((stable.size, stable.h[(0, 0)], stable.x_held[0]), (100.0, 0.0, 0.0));
        let unstable = found(1.0, 2.0, 1.0).unwrap();
        assert!((0.2..0.25).contains(&unstable.size), "{}", unstable.size);
        assert!((unstable.x_held[0] - 2.0).abs() < 1e-9 && (unstable.u_held[0] + 2.0).abs() < 1e-9);
        let twice = found(1.0, 2.0, 2.0).unwrap();
        assert!((twice.size / unstable.size - 2.0).abs() < 0.1, "{} {}", twice.size, unstable.size);
    }

    /// The computed gain for an unstable plant with a lag that winds up allows a larger step than none, stays below its
    /// bound, and allows the same step when given.
    #[test]
    fn the_computed_gain_allows_the_largest_step() {
        let lag =
            [(X, X, dmatrix![-0.1]), (X, Y, dmatrix![1.0]), (U, X, dmatrix![1.0]), (U, Y, dmatrix![3.0])];
        let controller = Controller::new(vec![], &lag).unwrap();
        let size = |gain: &Mat| under(1.0, &controller, 1.0, Gain::Given(gain)).unwrap().size;
        let none = size(&Mat::zeros(1, 1));
        let sought = under(1.0, &controller, 1.0, Gain::Sought(10.0)).unwrap();
        assert!(sought.size > 1.05 * none, "{} {none}", sought.size);
        let again = size(&sought.gain);
        assert!((again / sought.size - 1.0).abs() < 0.03, "{again} {}", sought.size);
        let little = under(1.0, &controller, 1.0, Gain::Sought(1e-3)).unwrap();
        assert!(little.gain.norm() < 1e-3 * sought.gain.norm().max(1.0), "{}", little.gain);
        assert!((little.size / none - 1.0).abs() < 0.03, "{} {none}", little.size);
    }

    /// Returns the region of `x' = x + T`, `T' = 10 (u - T)`, `u = 2 (r - x)`, the rate of T limited to `rate`.
    fn with_lag(rate: Option<f64>) -> Region {
        let (x, b, c) = (dmatrix![1.0, 1.0; 0.0, -10.0], dmatrix![0.0; 10.0], dmatrix![1.0, 0.0]);
        let parts = [(X, X, x), (X, U, b), (Z, X, c.clone()), (Y, X, -c), (Y, W, dmatrix![1.0])];
        let plant = GeneralisedPlant::new(vec![], &parts).unwrap();
        let controller = Controller::new(vec![], &[(U, Y, dmatrix![2.0])]).unwrap();
        let (zero, limits) = (dmatrix![0.0], [Some(1.0), rate]);
        let error = ModelError { e: Mat::zeros(2, 1), f: Mat::zeros(1, 2), fw: zero.clone(), fu: zero };
        let limited = Limited {
            plant: &plant,
            kept: &[0, 1],
            controller: &controller,
            error: &error,
            units: &Mat::zeros(0, 0),
            gain: Gain::Given(&Mat::zeros(0, 1)),
            limits: &limits.into_iter().flatten().collect::<Vec<_>>(),
            rates: if rate.is_some() { &[1] } else { &[] },
            input: 0,
            largest: 100.0,
        };
        assert!(every_step(limited).is_err(), "an unstable plant");
        largest_step(limited).unwrap()
    }

    /// A rate limit that is never reached has no effect; a lower one allows a smaller step only.
    #[test]
    fn a_lower_rate_limit_allows_a_smaller_step() {
        let [none, fast, slow, slower] =
            [None, Some(1e3), Some(2.0), Some(1.0)].map(|rate| with_lag(rate).size);
        assert!((fast / none - 1.0).abs() < 0.03, "{fast} {none}");
        let less = 1.0 - ACCURACY;
        assert!(slower < less * slow && slow < less * none, "{slower} {slow} {none}");
    }

    #[test]
    fn infeasible_problems_are_rejected() {
        let errors = [(0.5, 1.0), (2.0, -0.1)].map(|(k, limit)| found(1.0, k, limit).unwrap_err());
        for error in &errors {
            assert!(matches!(error, SynthesisError::Numerical { stage: STAGE, .. }), "{error}");
        }
        insta::assert_snapshot!(errors.map(|error| error.to_string()).join("\n"));
    }
}
