//! Syntheses with the names of MATLAB and python-control: H2, mu, and the weighted plant of mixed sensitivity.

use crate::failure::{InputError, NumericalError, of_problem, of_synthesis};
use crate::job;
use pyo3::{Py, PyAny, PyResult, Python, pyfunction};
use squid_lpv::controller::Controller;
use squid_lpv::h2;
use squid_lpv::matrix::{Mat, from_rows, to_rows};
use squid_lpv::mixed_sensitivity::{self, Weights};
use squid_lpv::mu::Structure;
use squid_lpv::mu::synthesis::{MuOptions, MuSynthesisError};
use squid_lpv::state_space::StateSpace;
use squid_problem::problem_file::{Problem, problem};
use squid_problem::source::Source;

type Rows = Vec<Vec<f64>>;

/// Matrices A, B, C, D and the number of inputs.
type System = (Rows, Rows, Rows, Rows, usize);

/// Returns the plant from `[w; u]` to `[W1 e; W2 u; W3 y; e]`: A, B, C, D.
#[pyfunction]
pub fn augw(
    g: System,
    w1: Option<System>,
    w2: Option<System>,
    w3: Option<System>,
) -> PyResult<(Rows, Rows, Rows, Rows)> {
    let weight = |given: Option<System>| given.map(state_space).transpose();
    let weights = Weights { error: weight(w1)?, control: weight(w2)?, output: weight(w3)? };
    let plant = mixed_sensitivity::augw(&state_space(g)?, &weights)
        .map_err(|reason| InputError::new_err(reason.to_string()))?;
    Ok((to_rows(&plant.a), to_rows(&plant.b), to_rows(&plant.c), to_rows(&plant.d)))
}

/// Synthesises an H2 controller; returns its A, B, C, D, and the H2 norm of the loop.
#[pyfunction]
pub fn h2syn(python: Python<'_>, problem: String) -> PyResult<(Rows, Rows, Rows, Rows, f64)> {
    let Problem { plant, d22, discrete, .. } = read(problem)?;
    if discrete.is_some() {
        return Err(InputError::new_err("P is in discrete time; h2syn supports continuous time only"));
    }
    let found = job::run(python, None, move |_| h2::synthesise(&plant, &d22))?;
    let found = found.map_err(|reason| of_synthesis(&reason, reason.to_string()))?;
    let (a, b, c, d) = rows(&found.controller);
    Ok((a, b, c, d, found.norm))
}

/// Runs D-K iteration; returns A, B, C, D of the controller, the upper bound of mu of its loop and of each iteration.
#[pyfunction]
pub fn musyn(
    python: Python<'_>,
    problem: String,
    blocks: Vec<(i64, i64)>,
    iterations: usize,
    order: usize,
    progress: Option<Py<PyAny>>,
) -> PyResult<(Rows, Rows, Rows, Rows, f64, Vec<f64>)> {
    let Problem { plant, d22, discrete, .. } = read(problem)?;
    let structure = Structure::from_notation(&blocks)
        .map_err(|reason| InputError::new_err(format!("blocks: {reason}")))?;
    let expected = (structure.rows(), structure.cols());
    let (w, z) = (plant.sizes().w, plant.sizes().z);
    if expected != (w, z) {
        return Err(InputError::new_err(format!(
            "blocks have {} rows and {} columns, but P has {w} disturbances w and {z} outputs z besides controls and \
             measurements; each w and each z belongs to one block, and a requirement on the gain is a full block",
            expected.0, expected.1
        )));
    }
    let options = MuOptions { iterations, order, ..MuOptions::default() };
    let found = job::run(python, progress, move |progress| {
        let _running = progress.begin("musyn", "iterating between controller and scalings");
        squid_lpv::mu::synthesis::musyn(&plant, &d22, &structure, options)
    })?;
    let found = found.map_err(|error| match &error {
        MuSynthesisError::Synthesis(reason) => of_synthesis(reason, error.to_string()),
        MuSynthesisError::Mu(_) => NumericalError::new_err(error.to_string()),
    })?;
    let controller = match discrete {
        None => found.controller,
        Some(given) => given.controller(&found.controller).ok_or_else(|| {
            NumericalError::new_err("the bilinear transform cannot map a mode of the controller")
        })?,
    };
    let (a, b, c, d) = rows(&controller);
    Ok((a, b, c, d, found.mu, found.history))
}

fn read(text: String) -> PyResult<Problem> {
    problem(&Source { name: "P".into(), text }).map_err(|error| of_problem(&error))
}

fn rows(k: &Controller) -> (Rows, Rows, Rows, Rows) {
    (to_rows(&k.a()), to_rows(&k.by()), to_rows(&k.cu()), to_rows(&k.duy()))
}

fn state_space((a, b, c, d, inputs): System) -> PyResult<StateSpace> {
    let n = a.len();
    let matrix = |rows: &[Vec<f64>], columns: usize| -> PyResult<Mat> {
        from_rows(rows, columns)
            .ok_or_else(|| InputError::new_err("the rows of a matrix have different lengths"))
    };
    Ok(StateSpace { a: matrix(&a, n)?, b: matrix(&b, inputs)?, c: matrix(&c, n)?, d: matrix(&d, inputs)? })
}
