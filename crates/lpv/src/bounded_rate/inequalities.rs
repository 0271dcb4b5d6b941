//! The synthesis inequalities at values of the parameter, for both signs of its rate.
//!
//! ```text
//! N' [ A'X + XA + r X'  XB1  C1' ; * -gamma I  D11' ; * * -gamma I ] N < 0,    N spans ker [C2 D21 0]
//! ```
//!
//! the same for the transposed plant with Y and -r Y', and `[X I; I Y] > 0`, for r = nu and r = -nu. X and Y, or one of
//! them with the other constant, are polynomials in theta. Nothing is proved between the values: the closed loop is
//! analysed instead.

use crate::analysis::bounded_real::{Multipliers, bounded_real_compact};
use crate::error::SynthesisError;
use crate::lmi::{Affine, Program, SolverOptions, solver, symmetric};
use crate::matrix::{Mat, symmetric_part};
use crate::synthesis::inequalities::{coupling, unmeasured};
use crate::system::{GeneralisedPlant, LoopError, MatrixPolynomial};

/// The choice of the Lyapunov matrices that depend on the parameter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Varying {
    /// X, of the observer.
    X,
    /// Y, of the state feedback.
    Y,
    /// Both. The exact controller then contains the parameter's rate; this term is left out, so the gain follows only
    /// from the analysis of the closed loop.
    Both,
}

/// A plant at some values of its parameter, and the bound of the rate.
#[derive(Debug, Clone)]
pub(crate) struct Grid {
    /// The values of theta, and the plant frozen at each.
    pub(crate) points: Vec<(f64, GeneralisedPlant)>,
    /// nu, in the plant's unit of time.
    pub(crate) rate: f64,
    pub(crate) varying: Varying,
    /// The order of the varying matrix.
    pub(crate) order: usize,
}

/// A solution: X and Y.
#[derive(Debug, Clone)]
pub(crate) struct Pair {
    pub(crate) x: MatrixPolynomial,
    pub(crate) y: MatrixPolynomial,
}

const STAGE: &str = "synthesis at a bounded rate";

/// The largest size of X and Y, as a multiple of their least.
const LARGEST_GROWTH: f64 = 10.0;

/// Tolerances of sizes and separation, and of the margin.
const SCALE_TOLERANCE: f64 = 1e-2;
const MARGIN_TOLERANCE: f64 = 0.3;

struct Unknowns {
    x: Vec<Affine>,
    y: Vec<Affine>,
}

fn affine_at(coefficients: &[Affine], theta: f64) -> Affine {
    Affine::weighted(coefficients, |k| theta.powi(k as i32))
}

fn slope_at(coefficients: &[Affine], theta: f64) -> Affine {
    Affine::weighted(coefficients, |k| if k == 0 { 0.0 } else { k as f64 * theta.powi(k as i32 - 1) })
}

impl Grid {
    fn unknowns(&self, program: &mut Program) -> Unknowns {
        let n = self.points.first().map_or(0, |(_, plant)| plant.sizes().x);
        let mut family = |varies: bool| -> Vec<Affine> {
            (0..=if varies { self.order } else { 0 }).map(|_| program.symmetric(n)).collect()
        };
        Unknowns { x: family(self.varying != Varying::Y), y: family(self.varying != Varying::X) }
    }

    /// Adds all inequalities except the coupling of X and Y; each holds with a `margin`, a 1 x 1 expression.
    fn impose(&self, program: &mut Program, unknowns: &Unknowns, gamma: &Affine, margin: Option<&Affine>) {
        for (theta, plant) in &self.points {
            let sides = [(plant.clone(), &unknowns.x), (plant.dual(), &unknowns.y)];
            for (side, coefficients) in sides {
                let matrix = affine_at(coefficients, *theta);
                let signs: &[f64] =
                    if coefficients.len() > 1 && self.rate > 0.0 { &[1.0, -1.0] } else { &[0.0] };
                for sign in signs {
                    let drift = slope_at(coefficients, *theta).scaled(sign * self.rate);
                    let inequality = projected(&side, gamma, &matrix, &drift);
                    let size = inequality.shape().0;
                    program.negative(
                        STAGE,
                        match margin {
                            Some(margin) => inequality + margin.times_identity(size),
                            None => inequality,
                        },
                    );
                }
            }
        }
    }

    /// Adds `[X cI; cI Y] > 0` at each point.
    fn couple(&self, program: &mut Program, unknowns: &Unknowns, c: f64) {
        for (theta, _) in &self.points {
            let (x, y) = (affine_at(&unknowns.x, *theta), affine_at(&unknowns.y, *theta));
            program.positive("[X I; I Y]", coupling(&x, &y, c));
        }
    }

    fn read(unknowns: &Unknowns, program: &Program, point: &[f64]) -> Pair {
        let value = |family: &[Affine]| MatrixPolynomial {
            coefficients: family.iter().map(|e| symmetric_part(&e.value(program, point))).collect(),
        };
        Pair { x: value(&unknowns.x), y: value(&unknowns.y) }
    }

    /// Returns the least gamma, to an accuracy relative to itself plus 1.
    pub(crate) fn least(&self, accuracy: f64) -> Result<f64, SynthesisError> {
        let mut program = Program::default();
        let unknowns = self.unknowns(&mut program);
        let gamma = program.scalar();
        self.impose(&mut program, &unknowns, &gamma, None);
        self.couple(&mut program, &unknowns, 1.0);
        program.minimise_trace(&gamma, 1.0);
        let search = SolverOptions { settles: true, ..SolverOptions::within(accuracy) };
        let solution = solver::solve(&program, STAGE, search)?;
        if solution.margin <= 0.0 {
            return Err(SynthesisError::numerical(STAGE, "the inequalities are violated at the gamma found"));
        }
        Ok(gamma.value(&program, &solution.x)[(0, 0)])
    }

    /// Returns a well-centred point at a gamma above the least: X and Y are minimised; then, within ten times that
    /// size, the separation of X and Y^-1 is maximised; then, with half of it kept, the margin.
    pub(crate) fn centre(&self, gamma: f64) -> Result<Pair, SynthesisError> {
        let level = Affine::number(gamma);
        let mut program = Program::default();
        let unknowns = self.unknowns(&mut program);
        self.impose(&mut program, &unknowns, &level, None);
        self.couple(&mut program, &unknowns, 1.0);
        program.minimise_trace(&unknowns.x[0], 1.0);
        program.minimise_trace(&unknowns.y[0], 1.0);
        let solution = solver::solve(&program, STAGE, SolverOptions::within(SCALE_TOLERANCE))?;
        let small = Self::read(&unknowns, &program, &solution.x);

        let (separated, separation) = self.maximise(&level, &small, None)?;
        let kept = 1.0 + 0.5 * (separation - 1.0).max(0.0);
        Ok(self.maximise(&level, &small, Some(kept)).map_or(separated, |(clear, _)| clear))
    }

    /// Maximises the separation c in `[X cI; cI Y]`, or the margin at a given separation.
    fn maximise(
        &self,
        level: &Affine,
        small: &Pair,
        separation: Option<f64>,
    ) -> Result<(Pair, f64), SynthesisError> {
        let mut program = Program::default();
        let unknowns = self.unknowns(&mut program);
        let value = program.scalar();
        self.impose(&mut program, &unknowns, level, separation.map(|_| &value));
        let n = small.x.coefficients.first().map_or(0, Mat::nrows);
        for (theta, _) in &self.points {
            let (x, y) = (affine_at(&unknowns.x, *theta), affine_at(&unknowns.y, *theta));
            for (e, least) in [(&x, small.x.evaluate(*theta)), (&y, small.y.evaluate(*theta))] {
                program.positive("upper bound", Affine::constant(least * LARGEST_GROWTH) - e.clone());
            }
            let between = match separation {
                Some(kept) => Affine::constant(Mat::identity(n, n) * kept),
                None => value.times_identity(n),
            };
            program.positive("[X cI; cI Y]", symmetric(&[vec![x, between], vec![y]]));
        }
        program.minimise_trace(&value, -1.0);
        let search = match separation {
            None => SolverOptions::within(SCALE_TOLERANCE),
            Some(_) => SolverOptions { floor: 1e-9, ..SolverOptions::within(MARGIN_TOLERANCE) },
        };
        let solution = solver::solve(&program, STAGE, search)?;
        if solution.margin <= 0.0 {
            return Err(SynthesisError::numerical(
                STAGE,
                "no point in the interior of the inequalities was found",
            ));
        }
        let reached = value.value(&program, &solution.x)[(0, 0)];
        Ok((Self::read(&unknowns, &program, &solution.x), reached))
    }
}

/// Returns the bounded-real inequality of a frozen plant, its control eliminated, `drift` added to its first block.
fn projected(plant: &GeneralisedPlant, gamma: &Affine, x: &Affine, drift: &Affine) -> Affine {
    let open = plant.open();
    let (zero, none) = (Affine::zeros(1, 1), Affine::zeros(0, 0));
    let m = Multipliers { gamma: gamma.clone(), x: x.clone(), s: none.clone(), t: none, lambda: zero };
    let full = bounded_real_compact(&open, &LoopError::none(&open), &m);
    let (n, all) = (x.shape().0, full.shape().0);
    let first = Mat::from_fn(n, all, |i, j| if i == j { 1.0 } else { 0.0 });
    (full + drift.congruence(&first)).congruence(&unmeasured(plant))
}
