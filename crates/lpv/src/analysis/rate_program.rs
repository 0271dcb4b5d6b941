//! The inequality of the gain at a bounded rate, at samples of a system, in well-conditioned coordinates.

use crate::analysis::lyapunov_polynomial::LyapunovPolynomial;
use crate::error::{RateError, SynthesisError};
use crate::lmi::{Affine, Program, SolverOptions, solver, symmetric};
use crate::matrix::{Mat, roots, scaled_largest_eigenvalue, symmetric_part};
use crate::system::{StateSpace, middle_of_gramians};

pub(crate) const STAGE: &str = "gain at a bounded rate";

const INEQUALITY_NAME: &str = "bounded real with rate";

/// The number of searches for gamma, each in the coordinates of the last solution.
const MOST_RESTARTS: usize = 4;

/// The Lyapunov functions and the first samples of the inequality.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RateOptions {
    /// The order d of X(theta).
    pub order: usize,
    /// The stride of the samples at which the inequality is imposed first, with the last one; it is then added where it
    /// fails.
    pub stride: usize,
    /// The tolerance of gamma, relative to itself plus 1 in units of an estimate of it.
    pub accuracy: f64,
}

impl Default for RateOptions {
    fn default() -> Self {
        Self { order: 2, stride: 4, accuracy: 2e-4 }
    }
}

/// The gamma at the start of a search from a known gain, relative to it.
const START_FACTOR: f64 = 1.01;

/// The largest growth of X(theta), and the tolerance, in the search for the largest margin.
const LARGEST_GROWTH: f64 = 10.0;
const MARGIN_TOLERANCE: f64 = 0.3;

/// The objective of a search.
#[derive(Clone, Copy)]
pub(crate) enum RateAim {
    /// The least gamma.
    Least,
    /// Any X(theta) with `A'X + XA +- nu dX/dtheta < -I`, B and C left out.
    Stability,
    /// The X(theta) of largest margin at the gamma of the start: the largest t such that the inequality holds by t
    /// times the identity, with X(theta) between that and a few times the identity, in the coordinates of the start.
    Margin,
}

/// A gamma with its X(theta).
pub(crate) struct RateSolution {
    pub(crate) gamma: f64,
    pub(crate) lyapunov: LyapunovPolynomial,
}

/// The start of a search: X is the identity in its coordinates, and gamma 1 in its units.
pub(crate) struct Start {
    pub(crate) x: Mat,
    pub(crate) gamma: f64,
    /// `true` if the constant X is known to prove the gain for any rate.
    pub(crate) shows: bool,
}

/// Samples of a system, stable and of one shape, and the class of Lyapunov functions.
pub(crate) struct Grid<'a> {
    pub(crate) samples: &'a [(f64, StateSpace)],
    rate: f64,
    options: RateOptions,
    centre: f64,
    half_range: f64,
}

impl<'a> Grid<'a> {
    pub(crate) fn new(samples: &'a [(f64, StateSpace)], rate: f64, options: RateOptions) -> Self {
        let (first, last) = (samples[0].0, samples[samples.len() - 1].0);
        let half_range = if last > first { 0.5 * (last - first) } else { 1.0 };
        let order = if rate.is_infinite() || samples.len() == 1 { 0 } else { options.order };
        let options = RateOptions { order, ..options };
        Self { samples, rate, options, centre: 0.5 * (first + last), half_range }
    }

    fn polynomial(&self, coefficients: Vec<Mat>) -> LyapunovPolynomial {
        LyapunovPolynomial { centre: self.centre, half_range: self.half_range, coefficients }
    }

    /// Returns a first estimate.
    pub(crate) fn start(&self) -> Result<Start, RateError> {
        let systems: Vec<&StateSpace> = self.samples.iter().map(|(_, s)| s).collect();
        let (x, hankel) = middle_of_gramians(&systems).ok_or_else(|| {
            SynthesisError::numerical(
                STAGE,
                "the mean of the Gramians of the samples is not positive definite",
            )
        })?;
        let frozen = systems.iter().map(|s| s.hinf_norm().value).fold(0.0, f64::max);
        Ok(Start { x, gamma: frozen.max(hankel), shows: false })
    }

    /// Returns a gamma close to the least at some samples, with a solution that is strict there: searched from `base`
    /// and, if the solver gets stuck, again from the solution. `base` becomes that solution. From a start that proves a
    /// gain there is one search only: if it gets stuck, the cause is rounding.
    pub(crate) fn least(&self, points: &[usize], base: &mut Start) -> Result<RateSolution, RateError> {
        let mut best: Option<RateSolution> = None;
        let mut failure = None;
        for _ in 0..MOST_RESTARTS {
            let shows = base.shows;
            let (found, gap) = match self.search(points, base, RateAim::Least) {
                Ok(found) => found,
                Err(e) => {
                    failure = Some(e);
                    break;
                }
            };
            let mean = points.iter().map(|&i| found.lyapunov.value(self.samples[i].0)).sum::<Mat>();
            *base = Start { x: mean / points.len() as f64, gamma: found.gamma, shows: false };
            let (miss, theta) = self.worst(points, &found);
            if miss >= 0.0 {
                failure = Some(missed(found.gamma, theta, miss));
            } else if best.as_ref().is_none_or(|known| found.gamma < known.gamma) {
                best = Some(found);
            }
            if shows || (gap <= self.options.accuracy && miss < 0.0) {
                break;
            }
        }
        let missed = || missed(f64::INFINITY, self.centre, f64::INFINITY);
        best.ok_or_else(|| failure.unwrap_or_else(missed))
    }

    /// Solves the program of an objective at some samples; returns the gap as well.
    pub(crate) fn search(
        &self,
        points: &[usize],
        base: &Start,
        aim: RateAim,
    ) -> Result<(RateSolution, f64), RateError> {
        // The matrix `state` is X^-1/2, so that X becomes the identity.
        let (inverse, state) = roots(&base.x);
        let unit = match aim {
            RateAim::Least | RateAim::Margin => base.gamma,
            RateAim::Stability => 1.0,
        };
        let root = unit.sqrt();
        let scaled = |s: &StateSpace| StateSpace {
            a: &inverse * &s.a * &state,
            b: &inverse * &s.b / root,
            c: &s.c * &state / root,
            d: &s.d / unit,
        };
        let mut systems: Vec<StateSpace> = points.iter().map(|&i| scaled(&self.samples[i].1)).collect();
        let time_scale = mean_time_scale(&systems);
        for s in &mut systems {
            s.a /= time_scale;
            s.b /= time_scale.sqrt();
            s.c /= time_scale.sqrt();
        }
        if matches!(aim, RateAim::Stability) {
            systems.iter_mut().for_each(|s| *s = without_signals(s));
        }
        let mut program = Program::default();
        let unknowns = self.unknowns(&mut program, &systems, time_scale);
        let level = match aim {
            RateAim::Least => program.scalar(),
            _ => Affine::number(1.0),
        };
        let margin = matches!(aim, RateAim::Margin).then(|| program.scalar());
        for (&i, system) in points.iter().zip(&systems) {
            let sample = Sample { theta: self.samples[i].0, system, time_scale };
            self.impose(&mut program, aim, sample, &unknowns, &level);
        }
        if let Some(margin) = &margin {
            self.maximise_margin(&mut program, points, &unknowns, margin);
        }
        if matches!(aim, RateAim::Least) {
            program.minimise_trace(&level, 1.0);
        }
        let read = |x: &[f64]| {
            let back = |e: &Affine| symmetric_part(&(inverse.transpose() * e.value(&program, x) * &inverse));
            let lyapunov = self.polynomial(unknowns.iter().map(back).collect());
            RateSolution { gamma: level.value(&program, x)[(0, 0)] * unit, lyapunov }
        };
        let start = (base.shows && matches!(aim, RateAim::Least)).then(|| {
            let mut start = vec![0.0; program.unknowns()];
            program.set(&mut start, &unknowns[0], &Mat::identity(base.x.nrows(), base.x.nrows()));
            program.set(&mut start, &level, &Mat::from_element(1, 1, START_FACTOR));
            start
        });
        let search = match aim {
            RateAim::Least => SolverOptions {
                // Any point better than the known one is accepted.
                enough: if base.shows { f64::INFINITY } else { self.options.accuracy },
                start: start.as_deref(),
                quick: base.shows,
                settles: base.shows,
                ..SolverOptions::within(self.options.accuracy)
            },
            RateAim::Margin => SolverOptions { floor: 1e-9, ..SolverOptions::within(MARGIN_TOLERANCE) },
            // Any feasible point is accepted.
            RateAim::Stability => SolverOptions::within(f64::INFINITY),
        };
        let solution = solver::solve(&program, STAGE, search)?;
        Ok((read(&solution.x), solution.gap))
    }

    /// Tightens the inequalities, and those of X at some samples, by a margin to be maximised.
    fn maximise_margin(&self, program: &mut Program, points: &[usize], unknowns: &[Affine], margin: &Affine) {
        program.tighten(INEQUALITY_NAME, margin);
        let shape = self.polynomial(vec![]);
        for &i in points {
            let x = Affine::weighted(unknowns, |k| shape.power(self.samples[i].0, k));
            let n = x.shape().0;
            program.positive("floor", x.clone() - margin.times_identity(n));
            program.positive("upper bound", Affine::constant(Mat::identity(n, n) * LARGEST_GROWTH) - x);
        }
        program.minimise_trace(margin, -1.0);
    }

    /// Adds `X_0, ..., X_d`. At high rates all but the first must be small; they are scaled relative to the first.
    fn unknowns(&self, program: &mut Program, systems: &[StateSpace], time_scale: f64) -> Vec<Affine> {
        let n = systems.first().map_or(0, |s| s.a.nrows());
        let fastest = systems.iter().map(|s| s.a.norm()).fold(0.0, f64::max);
        let small = (fastest * time_scale * self.half_range / self.rate).min(1.0);
        (0..=self.options.order)
            .map(|k| program.symmetric(n).scaled(if k == 0 { 1.0 } else { small }))
            .collect()
    }

    /// Imposes the inequality at one sample, with both signs of the rate.
    ///
    /// X(theta) > 0 need not be imposed: the mean of the two gives `A'X + XA < 0`, and A is stable.
    fn impose(
        &self,
        program: &mut Program,
        aim: RateAim,
        Sample { theta, system, time_scale }: Sample<'_>,
        unknowns: &[Affine],
        level: &Affine,
    ) {
        let n = system.a.nrows();
        let shape = self.polynomial(vec![]);
        let x = Affine::weighted(unknowns, |k| shape.power(theta, k));
        for rate in self.rates() {
            let drift = Affine::weighted(unknowns, |k| {
                if k == 0 { 0.0 } else { rate / time_scale * shape.power_slope(theta, k) }
            });
            let inequality = bounded_real(system, &x, drift, level);
            program.negative(
                INEQUALITY_NAME,
                match aim {
                    RateAim::Stability => inequality + Affine::constant(Mat::identity(n, n)),
                    _ => inequality,
                },
            );
        }
    }

    /// Returns the extremes of the rate; one if they make no difference.
    fn rates(&self) -> Vec<f64> {
        if self.options.order == 0 || self.rate == 0.0 { vec![0.0] } else { vec![self.rate, -self.rate] }
    }

    /// Returns the largest eigenvalue over some samples, and its parameter value.
    fn worst(&self, points: &[usize], found: &RateSolution) -> (f64, f64) {
        let values = points.iter().map(|&i| (self.eigenvalue(i, found), self.samples[i].0));
        values
            .fold((f64::NEG_INFINITY, self.centre), |worst, next| if next.0 > worst.0 { next } else { worst })
    }

    /// Returns the largest eigenvalue of the inequality and of -X at a sample, scaled to unit diagonals.
    pub(crate) fn eigenvalue(&self, sample: usize, found: &RateSolution) -> f64 {
        let (theta, system) = &self.samples[sample];
        let x = found.lyapunov.value(*theta);
        let slope = found.lyapunov.slope(*theta);
        let level = Affine::number(found.gamma);
        let values = self.rates().into_iter().map(|rate| {
            let drift = Affine::constant(&slope * rate);
            bounded_real(system, &Affine::constant(x.clone()), drift, &level).value(&Program::default(), &[])
        });
        values.chain([-&x]).map(|m| scaled_largest_eigenvalue(&m)).fold(f64::NEG_INFINITY, f64::max)
    }
}

/// Returns the system with neither inputs nor outputs.
pub(crate) fn without_signals(s: &StateSpace) -> StateSpace {
    let n = s.a.nrows();
    StateSpace { a: s.a.clone(), b: Mat::zeros(n, 0), c: Mat::zeros(0, n), d: Mat::zeros(0, 0) }
}

/// Returns the geometric mean of |lambda| over the modes of all systems, which are stable, rad/s.
fn mean_time_scale(systems: &[StateSpace]) -> f64 {
    let modes: Vec<f64> = systems.iter().flat_map(StateSpace::poles).map(|p| p.norm().ln()).collect();
    (modes.iter().sum::<f64>() / modes.len().max(1) as f64).exp()
}

/// A sample, scaled in time.
struct Sample<'a> {
    theta: f64,
    system: &'a StateSpace,
    time_scale: f64,
}

/// Returns `[A'X + XA + drift, XB, C'; *, -gamma I, D'; *, *, -gamma I]`.
fn bounded_real(s: &StateSpace, x: &Affine, drift: Affine, gamma: &Affine) -> Affine {
    let lyapunov = x.times(&s.a);
    let constant = |m: &Mat| Affine::constant(m.transpose());
    symmetric(&[
        vec![lyapunov.t() + lyapunov + drift, x.times(&s.b), constant(&s.c)],
        vec![-gamma.times_identity(s.b.ncols()), constant(&s.d)],
        vec![-gamma.times_identity(s.c.nrows())],
    ])
}

/// Returns the numerical error for a solution that violates the inequality.
pub(crate) fn missed(gamma: f64, theta: f64, by: f64) -> RateError {
    let diagnosis = format!("at gamma = {gamma:.4} the inequality is violated by {by:.1e}, theta = {theta}");
    SynthesisError::numerical(STAGE, diagnosis).into()
}
