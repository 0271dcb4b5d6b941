//! The gain of a loop with saturated commands for w of bounded energy, and the best anti-windup gain for it.
//!
//! The loop of plant and controller with `phi = u - sat(u)`, which is subtracted at the plant's input and adds `G phi`
//! to the rates of the controller's states, is
//!
//! ```text
//! (x', zt, u, z) = M (x, wt, phi, w),   wt = Theta zt
//! ```
//!
//! The conditions are that for all (x, wt, phi, w), with V = x'Xx,
//!
//! ```text
//! dV/dt + z'z/gamma - gamma w'w + zt'S zt - wt'S wt + 2 wt'T zt + 2 phi'U (u - phi - H x) < 0
//! |H x| < limit where V <= gamma beta
//! ```
//!
//! Then from rest V stays within gamma times the energy of w, as long as that is at most beta, and the L2 gain from w
//! to z is below gamma, because the term of U is not negative while `|H x|` is below the limit (J. M. Gomes da Silva
//! Jr., S. Tarbouriech, IEEE Trans. Automatic Control 50(1), 2005, lemma 1; the gain for bounded energy: T. Hu, A. R.
//! Teel, L. Zaccarian, "Stability and performance for saturated systems via quadratic and nonquadratic Lyapunov
//! functions", IEEE Trans. Automatic Control 51(11), 2006). Divided by gamma, the inequalities of the inverse matrices
//! (`saturated.rs`) are linear in gamma^2 and 1/beta. The energy is maximised at a given gain; with H = 0 the sector
//! condition holds everywhere, any energy is allowed, and the gain is minimised. This requires a stable plant.

use crate::anti_windup::saturated::{Shown, Transposed, Units, Unknowns, with_phi};
use crate::error::SynthesisError;
use crate::lmi::{Affine, Program, SolverOptions, solver};
use crate::matrix::{Mat, block, diagonal, eigenvalues, roots, solve, spectral_abscissa};
use crate::system::{
    ClosedLoop, Controller, GeneralisedPlant, StateSpace, commuting_part, lyapunov, middle_of_gramians,
};
use nalgebra::DVector;

const STAGE: &str = "gain of a loop with limits";

/// The gains at which the largest energy is computed, in units of that without limits.
const GAINS: [f64; 3] = [1.25, 2.0, 5.0];

/// The gain for which the anti-windup gain is designed: at half of the performance, saturation matters and the loop
/// still works as designed.
const OF_GAIN: f64 = 2.0;

/// The relative tolerance of the optimum, so that the inequalities hold with a margin.
const ACCURACY: f64 = 1e-2;

/// The fraction of an energy, or of 1/gamma, that is claimed.
const CLAIMED: f64 = 0.99;

/// A loop with saturated commands.
#[derive(Debug, Clone, Copy)]
pub struct Limited<'a> {
    /// The plant.
    pub plant: &'a GeneralisedPlant,
    /// Its controller.
    pub controller: &'a Controller,
    /// A bound of the gain without limits.
    pub gamma: f64,
    /// S of that bound, channels of plant and controller square: the units of the channels.
    pub units: &'a Mat,
    /// The limit of each command in both directions; for unequal limits, the smaller one.
    pub limits: &'a [f64],
}

/// A bound of the gain, with n states: the plant's, then the controller's.
#[derive(Debug, Clone, PartialEq)]
#[allow(missing_docs, reason = "the names are those of the equations above")]
pub struct EnergyBound {
    pub gamma: f64,
    /// The largest energy; infinite with H = 0.
    pub beta: f64,
    pub x: Mat,
    pub s: Mat,
    pub t: Mat,
    /// Half of the diagonal of U.
    pub u: Vec<f64>,
    pub h: Mat,
}

/// An anti-windup gain and the bounds that hold with it, ascending.
#[derive(Debug, Clone, PartialEq)]
pub struct Bounds {
    /// G, nk x m.
    pub gain: Mat,
    /// At least one.
    pub bounds: Vec<EnergyBound>,
}

/// Computes the gain G of the largest energy at twice the gain without limits, and the bounds with it at several gains.
///
/// The entries of G are below the rate of the loop's fastest mode, with states in units of their sizes in the loop and
/// phi in those of the limits: larger ones are too fast for a sampled controller and allow hardly more energy.
///
/// # Errors
/// [`SynthesisError::Infeasible`] if nothing is found; [`SynthesisError::Numerical`], also if a limit is not positive.
pub fn with_anti_windup(of: Limited<'_>) -> Result<Bounds, SynthesisError> {
    let flow = Flow::of(of, None)?;
    let every = flow.least_gain();
    let sought = match every {
        Ok((ref bound, ref gain)) if bound.gamma <= OF_GAIN * of.gamma => Ok(gain.clone()),
        ref every => {
            let at = |factor: f64| flow.largest_energy(factor).map(|(_, gain)| gain);
            at(OF_GAIN).or_else(|_| every.clone().map(|(_, gain)| gain)).or_else(|_| at(GAINS[2]))
        }
    };
    of_gain(of, &sought?)
}

/// The bounds that hold with a gain G, nk x m.
///
/// # Errors
/// As [`with_anti_windup`].
pub fn of_gain(of: Limited<'_>, gain: &Mat) -> Result<Bounds, SynthesisError> {
    let flow = Flow::of(of, Some(gain))?;
    let every = flow.least_gain();
    let most = every.as_ref().map_or(f64::INFINITY, |(bound, _)| bound.gamma);
    let mut bounds = vec![];
    let mut why = None;
    for factor in GAINS.into_iter().filter(|factor| factor * of.gamma < most) {
        match flow.largest_energy(factor) {
            Ok((bound, _)) => bounds.push(bound),
            Err(reason) => why = Some(reason),
        }
    }
    bounds.extend(every.map(|(bound, _)| bound));
    match why.filter(|_| bounds.is_empty()) {
        Some(reason) => Err(reason),
        None => Ok(Bounds { gain: gain.clone(), bounds }),
    }
}

/// The loop with phi appended to w, and u appended to z.
struct Flow<'a> {
    of: Limited<'a>,
    closed: ClosedLoop,
    /// The numbers of components of w, z and phi.
    sizes: [usize; 3],
    /// The energy of w at which a command reaches its limit, without limits; the unit of beta.
    energy: f64,
    /// |lambda| of the fastest mode, if G is to be computed.
    fastest: Option<f64>,
}

impl<'a> Flow<'a> {
    fn of(of: Limited<'a>, gain: Option<&Mat>) -> Result<Self, SynthesisError> {
        if let Some(j) = of.limits.iter().position(|limit| limit.is_nan() || *limit <= 0.0) {
            let found = of.limits[j];
            let diagnosis = format!("the limit of command {j} is {found}, must be above 0");
            return Err(SynthesisError::numerical(STAGE, diagnosis));
        }
        let (p, k, m) = (of.plant, of.controller, of.limits.len());
        let none = Mat::zeros(k.a().nrows(), m);
        let closed = with_phi(p, k, gain.unwrap_or(&none))?;
        let (w, z) = (p.b1().ncols(), p.c1().nrows());
        let mut flow = Self { of, closed, sizes: [w, z, m], energy: 1.0, fastest: None };
        let fastest = eigenvalues(&flow.closed.a()).iter().map(|mode| mode.norm()).fold(0.0, f64::max);
        flow.fastest = gain.is_none().then_some(fastest);
        flow.energy = flow.unit()?;
        Ok(flow)
    }

    fn b1(&self) -> Mat {
        self.closed.b1().columns(0, self.sizes[0]).into_owned()
    }

    fn commands(&self) -> Mat {
        self.closed.c1().rows(self.sizes[1], self.sizes[2]).into_owned()
    }

    /// The squares of the channels' units at the energy.
    fn channels(&self) -> Mat {
        self.of.units / (self.of.gamma * self.energy)
    }

    /// See [`Flow::energy`].
    fn unit(&self) -> Result<f64, SynthesisError> {
        let (b1, k) = (self.b1(), self.commands());
        let reached = lyapunov(&self.closed.a().transpose(), &(&b1 * b1.transpose())).ok_or_else(unstable)?;
        let sizes = (&k * reached * k.transpose()).diagonal();
        let each = sizes.iter().zip(self.of.limits).map(|(size, limit)| limit * limit / size);
        Ok(each.filter(|energy| energy.is_finite() && *energy > 0.0).fold(f64::INFINITY, f64::min))
            .map(|least| if least.is_finite() { least } else { 1.0 })
    }

    /// T and its inverse, in which the geometric mean of the gramians of the loop at Theta = 0 is the identity, and the
    /// size of each state.
    fn coordinates(&self, output: f64) -> Result<(Mat, Mat, DVector<f64>), SynthesisError> {
        let [w, z, m] = self.sizes;
        let (root, unroot) = roots(&self.channels());
        let limits = diagonal(self.of.limits.iter().copied());
        let pushed =
            block(&[&[&(self.closed.b1().columns(w, m) * &limits), &(self.b1() * self.energy.sqrt())]]);
        let b = block(&[&[&(self.closed.bt() * unroot), &pushed]]);
        let seen = self
            .commands()
            .row_iter()
            .zip(self.of.limits)
            .map(|(row, limit)| row / *limit)
            .collect::<Vec<_>>();
        let seen =
            if seen.is_empty() { Mat::zeros(0, self.closed.a().nrows()) } else { Mat::from_rows(&seen) };
        let c = block(&[&[&(root * self.closed.ct())], &[&seen], &[&(self.closed.c1().rows(0, z) / output)]]);
        let sizes = lyapunov(&self.closed.a().transpose(), &(&pushed * pushed.transpose()));
        let sizes = sizes.ok_or_else(unstable)?.diagonal().map(|v| v.max(0.0).sqrt());
        let d = Mat::zeros(c.nrows(), b.ncols());
        let (x, _) =
            middle_of_gramians(&[&StateSpace { a: self.closed.a(), b, c, d }]).ok_or_else(unstable)?;
        let (inverse, state) = roots(&x);
        Ok((state, inverse, sizes))
    }

    /// The scaled loop: w in units of the root of the energy, z of gamma times that, u and phi of the limits.
    fn transposed(&self) -> Result<Transposed, SynthesisError> {
        let [w, z, m] = self.sizes;
        let (n, r) = (self.closed.a().nrows(), self.closed.dtt().nrows());
        let input = self.energy.sqrt();
        let output = self.of.gamma * input;
        let (state, inverse, sizes) = self.coordinates(output)?;
        // From columns x, wt, w, phi and rows x', zt, z, u.
        let swapped = |first: usize, a: usize, b: usize| {
            (0..first).chain(first + a..first + a + b).chain(first..first + a).collect::<Vec<_>>()
        };
        let matrix = self.closed.parts.matrix();
        let matrix = matrix.select_rows(&swapped(n + r, z, m)).select_columns(&swapped(n + r, w, m));
        let nk = self.of.controller.a().nrows();
        let reach =
            self.fastest.map_or_else(|| DVector::zeros(0), |fastest| sizes.rows(n - nk, nk) * fastest);
        let (state, channels) = ((state, inverse), &self.channels());
        let units = Units { state, channels, commands: self.of.limits, input, output, reach };
        Ok(Transposed::of(&matrix, [n, r, m, z], [n, r, m, w], units))
    }

    /// The largest energy at `factor` times the gain without limits, and G.
    fn largest_energy(&self, factor: f64) -> Result<(EnergyBound, Mat), SynthesisError> {
        let search = Search::of(self, Some(factor))?;
        let (least, shown) = search.solve(|_| factor * self.of.gamma * self.energy)?;
        let beta = CLAIMED * self.energy / least;
        Ok(self.bound(factor * self.of.gamma, beta, shown))
    }

    /// The least gain with H = 0, and G.
    fn least_gain(&self) -> Result<(EnergyBound, Mat), SynthesisError> {
        if !self.is_stable_saturated() {
            return Err(SynthesisError::Infeasible { stage: STAGE });
        }
        let search = Search::of(self, None)?;
        let gamma = |square: f64| self.of.gamma * square.sqrt() / CLAIMED;
        let (least, shown) = search.solve(|square| gamma(square) * self.energy)?;
        Ok(self.bound(gamma(least), f64::INFINITY, shown))
    }

    /// The bound that was found, with rounding between different parameters removed from its scalings.
    fn bound(&self, gamma: f64, beta: f64, shown: Shown) -> (EnergyBound, Mat) {
        let Shown { x, s, t, u, h, gain } = shown;
        let [s, t] = [s, t].map(|m| commuting_part(&m, &self.closed.channels));
        (EnergyBound { gamma, beta, x, s, t, u, h }, gain)
    }

    /// Whether the loop is stable at Theta = 0 with all commands fully saturated, phi = u; if G is to be computed, the
    /// plant.
    fn is_stable_saturated(&self) -> bool {
        let [w, z, m] = self.sizes;
        let direct = self.closed.d11().view((z, w), (m, m)).into_owned();
        let a = match self.fastest {
            Some(_) => Some(self.of.plant.a()),
            None => solve(&(Mat::identity(m, m) - direct), &self.commands())
                .map(|all| self.closed.a() + self.closed.b1().columns(w, m) * all),
        };
        a.is_some_and(|a| spectral_abscissa(&a) < 0.0)
    }
}

fn unstable() -> SynthesisError {
    SynthesisError::numerical(STAGE, "the loop without limits is not stable at Theta = 0")
}

/// A program with its unknowns.
struct Search {
    loop_: Transposed,
    program: Program,
    unknowns: Unknowns,
    /// 1/beta in units of the energy, or the square of gamma in units of that without limits.
    least: Affine,
}

impl Search {
    /// The least 1/beta at a gain, in units of that without limits; or with H = 0 the least gain.
    fn of(flow: &Flow<'_>, gain: Option<f64>) -> Result<Self, SynthesisError> {
        let loop_ = flow.transposed()?;
        let mut program = Program::default();
        let fed = loop_.select[2].nrows();
        let unknowns = Unknowns::of(&mut program, &loop_, &flow.closed.channels, fed, gain.is_none());
        let least = program.scalar();
        let square = match gain {
            Some(gain) => Affine::number(gain * gain),
            None => least.clone(),
        };
        let ([_, _, _, w], [_, _, _, z]) = (&loop_.back, &loop_.select);
        let inequality = unknowns.form(&loop_) + Affine::constant(w.transpose() * w)
            - square.times_identity(z.nrows()).congruence(z);
        program.negative("performance", inequality);
        program.positive("X", unknowns.q.clone());
        unknowns.out_of_reach(&mut program, &least);
        program.minimise_trace(&least, 1.0);
        Ok(Self { loop_, program, unknowns, least })
    }

    /// The least value, and the matrices that prove it, times `share` of that value.
    fn solve(&self, share: impl Fn(f64) -> f64) -> Result<(f64, Shown), SynthesisError> {
        let options =
            SolverOptions { floor: 1e-6, enough: ACCURACY, settles: true, ..SolverOptions::within(ACCURACY) };
        let solution = solver::solve(&self.program, STAGE, options)?.feasible(STAGE)?;
        let least = self.least.value(&self.program, &solution.x)[(0, 0)];
        if least <= 0.0 {
            return Err(SynthesisError::numerical(STAGE, "the least value found is not positive"));
        }
        let shown = self.unknowns.shown(&self.loop_, &self.program, &solution.x, share(least));
        let shown =
            shown.ok_or_else(|| SynthesisError::numerical(STAGE, "a matrix of the solution is singular"))?;
        Ok((least, shown))
    }
}
