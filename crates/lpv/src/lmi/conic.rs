//! The general conic solver. Clarabel is used only here and in `structured::quadratic_program`.
//!
//! P. J. Goulart, Y. Chen, "Clarabel: an interior-point solver for conic programs with quadratic objectives",
//! arXiv:2405.12762, 2024.

use crate::error::SynthesisError;
use crate::lmi::Program;
use crate::matrix::{Mat, least_eigenvalue, on_one_thread};
use crate::stop;
use clarabel::algebra::CscMatrix;
use clarabel::solver::{
    DefaultSettingsBuilder, DefaultSolver, IPSolver, SolverStatus, SupportedConeT,
    SupportedConeT::PSDTriangleConeT,
};
use std::panic::{AssertUnwindSafe, catch_unwind};

/// A program in the form `minimise c'x subject to b - A x in a product of cones`.
pub(crate) struct ConicProgram {
    a: CscMatrix<f64>,
    rhs: Vec<f64>,
    objective: Vec<f64>,
    cones: Vec<SupportedConeT<f64>>,
    /// The size of each inequality's matrix.
    sizes: Vec<usize>,
}

/// The result of the solver.
pub(crate) enum Verdict {
    /// A point reported as optimal.
    Solved(Vec<f64>),
    /// A point at which the solver stopped without a claim of optimality.
    Stopped(Vec<f64>),
    /// No point satisfies the inequalities; the certificate was verified.
    Infeasible,
}

impl ConicProgram {
    pub(crate) fn new(program: &Program) -> Self {
        squid_blas_symbols::link();
        let mut columns: Vec<Vec<(usize, f64)>> = vec![Vec::new(); program.unknowns()];
        let (mut rhs, mut cones, mut sizes) = (Vec::new(), Vec::new(), Vec::new());
        for inequality in &program.inequalities {
            let (constant, parts) = program.coefficients(&inequality.expression);
            let top = rhs.len();
            for (k, part) in parts {
                let entries = triangle(&part).enumerate().filter(|(_, v)| *v != 0.0);
                columns[k].extend(entries.map(|(i, v)| (top + i, -v)));
            }
            rhs.extend(triangle(&constant));
            cones.push(PSDTriangleConeT(constant.nrows()));
            sizes.push(constant.nrows());
        }
        let a = sparse(&columns, rhs.len());
        Self { a, rhs, objective: program.costs(), cones, sizes }
    }

    /// Runs the solver with one of [`WAYS`].
    ///
    /// # Errors
    /// Returns [`SynthesisError::Numerical`] if it returns no point.
    pub(crate) fn run(&self, way: &Way, stage: &'static str) -> Result<Verdict, SynthesisError> {
        let unknowns = self.objective.len();
        let settings = DefaultSettingsBuilder::default()
            .verbose(false)
            .max_iter(200)
            .direct_solve_method(way.factorisation.into())
            .equilibrate_enable(way.equilibrate)
            .max_threads(1)
            // The coupling [X I; I Y] looks sparse but is not: decomposing it doubles the time.
            .chordal_decomposition_enable(false)
            .build()
            .map_err(|e| SynthesisError::numerical(stage, e.to_string()))?;
        let quadratic = CscMatrix::zeros((unknowns, unknowns));
        on_one_thread();
        let mut solver =
            DefaultSolver::new(&quadratic, &self.objective, &self.a, &self.rhs, &self.cones, settings)
                .map_err(|e| SynthesisError::numerical(stage, e.to_string()))?;
        solver.set_termination_callback(|_| stop::is_requested());
        // Clarabel panics if a decomposition of one of its scalings does not converge.
        if catch_unwind(AssertUnwindSafe(|| solver.solve())).is_err() {
            return Err(SynthesisError::numerical(
                stage,
                "a decomposition inside the solver did not converge",
            ));
        }
        stop::check();
        let solution = &solver.solution;
        let finite = solution.x.iter().all(|v| v.is_finite());
        match solution.status {
            SolverStatus::PrimalInfeasible | SolverStatus::AlmostPrimalInfeasible
                if self.refutes(&solution.z) =>
            {
                Ok(Verdict::Infeasible)
            }
            SolverStatus::PrimalInfeasible | SolverStatus::AlmostPrimalInfeasible => Err(
                SynthesisError::numerical(stage, "the solver's certificate of infeasibility does not hold"),
            ),
            SolverStatus::Solved if finite => Ok(Verdict::Solved(solution.x.clone())),
            SolverStatus::AlmostSolved
            | SolverStatus::InsufficientProgress
            | SolverStatus::NumericalError
            | SolverStatus::MaxIterations
                if finite =>
            {
                Ok(Verdict::Stopped(solution.x.clone()))
            }
            status => Err(SynthesisError::numerical(stage, format!("the solver stopped with '{status:?}'"))),
        }
    }

    /// Returns `true` if z proves that no point of reasonable size satisfies the inequalities. With z moved into the
    /// cones, `0 <= z'(b - A x) = z'b - (A'z)'x` requires an x whose absolute entries sum to at least
    /// `-z'b / max |A'z|`.
    fn refutes(&self, z: &[f64]) -> bool {
        let mut z = z.to_vec();
        let mut top = 0;
        for &n in &self.sizes {
            let below = (-least_eigenvalue(&full(&z[top..], n))).max(0.0);
            for k in 0..n {
                z[top + k * (k + 3) / 2] += below;
            }
            top += n * (n + 1) / 2;
        }
        let value: f64 = z.iter().zip(&self.rhs).map(|(z, b)| z * b).sum();
        let mut slope: f64 = 0.0;
        for column in 0..self.objective.len() {
            let entries = self.a.colptr[column]..self.a.colptr[column + 1];
            let sum: f64 = entries.map(|e| self.a.nzval[e] * z[self.a.rowval[e]]).sum();
            slope = slope.max(sum.abs());
        }
        value < 0.0 && -value >= SENSIBLE_SIZE * slope
    }
}

/// A certificate of infeasibility is accepted if every point that it does not exclude has unknowns whose absolute
/// values sum to more than this, in coordinates in which the plant is balanced.
const SENSIBLE_SIZE: f64 = 1e4;

/// Settings of the solver.
pub(crate) struct Way {
    /// Clarabel's name of the factorisation.
    factorisation: &'static str,
    /// `true` if clarabel rescales the program first.
    equilibrate: bool,
}

/// Settings in the order in which they are tried: each fails on programs that another solves.
pub(crate) const WAYS: [Way; 3] = [
    Way { factorisation: "faer", equilibrate: true },
    Way { factorisation: "faer", equilibrate: false },
    Way { factorisation: "qdldl", equilibrate: true },
];

/// Returns the upper triangle by columns with off-diagonal entries times sqrt(2), the format of clarabel's cone.
fn triangle(m: &Mat) -> impl Iterator<Item = f64> + '_ {
    (0..m.ncols()).flat_map(move |j| {
        (0..=j).map(move |i| if i == j { m[(i, j)] } else { std::f64::consts::SQRT_2 * m[(i, j)] })
    })
}

fn sparse(columns: &[Vec<(usize, f64)>], rows: usize) -> CscMatrix<f64> {
    let (mut starts, mut row_indices, mut values) = (vec![0], Vec::new(), Vec::new());
    for column in columns {
        row_indices.extend(column.iter().map(|(i, _)| *i));
        values.extend(column.iter().map(|(_, v)| *v));
        starts.push(row_indices.len());
    }
    CscMatrix::new(rows, columns.len(), starts, row_indices, values)
}

/// Returns the symmetric n x n matrix from the format of [`triangle`].
fn full(triangle: &[f64], n: usize) -> Mat {
    Mat::from_fn(n, n, |i, j| {
        let (i, j) = (i.min(j), i.max(j));
        let value = triangle[j * (j + 1) / 2 + i];
        if i == j { value } else { value / std::f64::consts::SQRT_2 }
    })
}
