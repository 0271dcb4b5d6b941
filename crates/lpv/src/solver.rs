//! The semidefinite solver. No other file knows clarabel.
//!
//! P. J. Goulart, Y. Chen, "Clarabel: an interior-point solver for conic programs with quadratic objectives",
//! arXiv:2405.12762, 2024. A solver's word is not taken for proof: every inequality is evaluated at the point
//! returned and its least eigenvalue reported.

use crate::error::SynthesisError;
use crate::lmi::Program;
use crate::matrix::{Mat, least_eigenvalue};
use clarabel::algebra::CscMatrix;
use clarabel::solver::{
    DefaultSettingsBuilder, DefaultSolver, IPSolver, SolverStatus, SupportedConeT,
    SupportedConeT::PSDTriangleConeT,
};
use std::panic::{AssertUnwindSafe, catch_unwind};

/// A point that the solver returned, and what the inequalities are worth there.
#[derive(Debug, Clone)]
pub struct Solution {
    /// The unknowns of the program.
    pub x: Vec<f64>,
    /// The least eigenvalue over all inequalities: the point satisfies them strictly if it is positive.
    pub margin: f64,
    /// The inequality with that eigenvalue.
    pub tightest: &'static str,
    /// Whether the solver itself claims optimality at full accuracy.
    pub solved: bool,
    /// Interior-point iterations.
    pub iterations: u32,
}

/// Solves `program`.
///
/// # Errors
/// [`SynthesisError::Infeasible`] when the solver holds a certificate that no point exists;
/// [`SynthesisError::Numerical`] when it stopped for any other reason.
pub fn solve(program: &Program, stage: &'static str) -> Result<Solution, SynthesisError> {
    solve_until(program, stage, |_| false)
}

/// As [`solve`], content with a point that is `enough`, be it optimal or not: no other way of running is then tried.
///
/// # Errors
/// As [`solve`].
pub fn solve_until(
    program: &Program,
    stage: &'static str,
    enough: impl Fn(&[f64]) -> bool,
) -> Result<Solution, SynthesisError> {
    blas_symbols::link();
    let unknowns = program.unknowns();
    let mut columns: Vec<Vec<(usize, f64)>> = vec![Vec::new(); unknowns];
    let (mut rhs, mut cones) = (Vec::new(), Vec::new());
    for inequality in &program.inequalities {
        let (constant, parts) = program.coefficients(&inequality.expression);
        let top = rhs.len();
        for (k, part) in parts {
            let entries = triangle(&part).enumerate().filter(|(_, v)| *v != 0.0);
            columns[k].extend(entries.map(|(i, v)| (top + i, -v)));
        }
        rhs.extend(triangle(&constant));
        cones.push(PSDTriangleConeT(constant.nrows()));
    }
    let mut objective = vec![0.0; unknowns];
    for &(k, c) in &program.objective {
        objective[k] += c;
    }
    let a = sparse(&columns, rhs.len());
    let mut best: Option<Solution> = None;
    let mut failure = None;
    for attempt in ATTEMPTS {
        match attempt.run((&a, &rhs, &objective, &cones), program, stage) {
            Ok(found) if found.solved || enough(&found.x) => return Ok(found),
            Err(infeasible @ SynthesisError::Infeasible { .. }) => return Err(infeasible),
            Ok(found) if best.as_ref().is_none_or(|b| found.margin > b.margin) => best = Some(found),
            Ok(_) => {}
            Err(other) => failure = Some(other),
        }
    }
    best.ok_or_else(|| failure.unwrap_or_else(|| numerical(stage, "the solver was not run".into())))
}

/// One way of running the solver.
struct Attempt {
    /// clarabel's name of the factorisation.
    factorisation: &'static str,
    /// Whether clarabel rescales the program first.
    equilibrate: bool,
}

/// In this order until one is solved: each gets stuck on programs that another solves.
const ATTEMPTS: [Attempt; 3] = [
    Attempt { factorisation: "faer", equilibrate: true },
    Attempt { factorisation: "faer", equilibrate: false },
    Attempt { factorisation: "qdldl", equilibrate: true },
];

/// Below so many rows the threads of a factorisation cost more than they save. 0 threads are as many as there are.
const ONE_THREAD: usize = 1000;

/// The constraint matrix, its right-hand side, the objective and the cones.
type Data<'a> = (&'a CscMatrix<f64>, &'a [f64], &'a [f64], &'a [SupportedConeT<f64>]);

impl Attempt {
    fn run(
        &self,
        (a, rhs, objective, cones): Data<'_>,
        program: &Program,
        stage: &'static str,
    ) -> Result<Solution, SynthesisError> {
        let unknowns = program.unknowns();
        let settings = DefaultSettingsBuilder::default()
            .verbose(false)
            .max_iter(200)
            .direct_solve_method(self.factorisation.into())
            .equilibrate_enable(self.equilibrate)
            .max_threads(if rhs.len() < ONE_THREAD { 1 } else { 0 })
            // The coupling [X I; I Y] looks sparse and is not: taking it apart doubles the time.
            .chordal_decomposition_enable(false)
            .build()
            .map_err(|e| numerical(stage, e.to_string()))?;
        let quadratic = CscMatrix::zeros((unknowns, unknowns));
        let mut solver = DefaultSolver::new(&quadratic, objective, a, rhs, cones, settings)
            .map_err(|e| numerical(stage, e.to_string()))?;
        // clarabel panics when a decomposition of one of its scalings does not converge.
        if catch_unwind(AssertUnwindSafe(|| solver.solve())).is_err() {
            return Err(numerical(stage, "a decomposition inside the solver did not converge".into()));
        }
        let found = &solver.solution;
        match found.status {
            SolverStatus::PrimalInfeasible => Err(SynthesisError::Infeasible { stage }),
            SolverStatus::Solved
            | SolverStatus::AlmostSolved
            | SolverStatus::InsufficientProgress
            | SolverStatus::NumericalError
            | SolverStatus::MaxIterations
                if found.x.iter().all(|v| v.is_finite()) =>
            {
                let (margin, tightest) = margin(program, &found.x);
                let solved = found.status == SolverStatus::Solved;
                Ok(Solution { x: found.x.clone(), margin, tightest, solved, iterations: found.iterations })
            }
            status => Err(numerical(stage, format!("the solver stopped with '{status:?}'"))),
        }
    }
}

/// The least eigenvalue over all inequalities at `x`, and whose it is.
pub fn margin(program: &Program, x: &[f64]) -> (f64, &'static str) {
    program
        .inequalities
        .iter()
        .map(|i| (least_eigenvalue(&i.expression.value(program, x)), i.name))
        .fold((f64::INFINITY, "none"), |least, next| if next.0 < least.0 { next } else { least })
}

fn numerical(stage: &'static str, diagnosis: String) -> SynthesisError {
    SynthesisError::Numerical { stage, diagnosis }
}

/// The upper triangle by columns, off-diagonal entries times sqrt(2), as clarabel's cone wants it.
fn triangle(m: &Mat) -> impl Iterator<Item = f64> + '_ {
    (0..m.ncols()).flat_map(move |j| {
        (0..=j).map(move |i| if i == j { m[(i, j)] } else { std::f64::consts::SQRT_2 * m[(i, j)] })
    })
}

fn sparse(columns: &[Vec<(usize, f64)>], rows: usize) -> CscMatrix<f64> {
    let (mut starts, mut places, mut values) = (vec![0], Vec::new(), Vec::new());
    for column in columns {
        places.extend(column.iter().map(|(i, _)| *i));
        values.extend(column.iter().map(|(_, v)| *v));
        starts.push(places.len());
    }
    CscMatrix::new(rows, columns.len(), starts, places, values)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lmi::{Affine, symmetric};
    use nalgebra::dmatrix;

    /// The bounded-real lemma of 1/(s^2 + 0.2 s + 1) has a norm in closed form.
    #[test]
    fn bounded_real_lemma_meets_the_closed_form() {
        let (a, b, c) = (dmatrix![0.0, 1.0; -1.0, -0.2], dmatrix![0.0; 1.0], dmatrix![1.0, 0.0]);
        let mut program = Program::new();
        let x = program.symmetric(2);
        let gamma = program.scalar();
        let brl = symmetric(&[
            vec![x.after(&a.transpose()) + x.times(&a), x.times(&b), Affine::constant(c.transpose())],
            vec![-gamma.clone(), Affine::zeros(1, 1)],
            vec![-gamma.clone()],
        ]);
        program.positive("X", x);
        program.negative("bounded real", brl);
        program.minimise_trace(&gamma, 1.0);
        let solution = solve(&program, "test").unwrap();
        let found = gamma.value(&program, &solution.x)[(0, 0)];
        assert!((found - 1.0 / (0.2 * 0.99f64.sqrt())).abs() < 1e-5 * found, "{found}");
    }

    #[test]
    fn infeasible_is_told_from_failure() {
        let mut program = Program::new();
        let x = program.symmetric(2);
        program.positive("X", x.clone());
        program.negative("X", x + Affine::constant(Mat::identity(2, 2)));
        assert_eq!(solve(&program, "test").err(), Some(SynthesisError::Infeasible { stage: "test" }));
    }
}
