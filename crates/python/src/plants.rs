//! Problems of general plants.

use crate::failure::{InputError, of_problem};
use crate::job;
use pyo3::{Py, PyAny, PyErr, PyResult, Python, pyfunction};
use serde_json::json;
use squid_lpv::bilinear::Bilinear;
use squid_lpv::matrix::{Mat, from_rows};
use squid_lpv::state_space::StateSpace;
use squid_lpv::synthesis::Options;
use squid_problem::discrete::POLES_AT_BOTH_ENDS;
use squid_problem::source::Source;

/// Synthesises a controller; returns the report, and controller and certificate if there is a proof.
#[pyfunction]
pub fn synth(
    python: Python<'_>,
    problem: String,
    back_off: f64,
    gamma_limit: Option<f64>,
    fastest_mode: Option<f64>,
    reduce: bool,
    progress: Option<Py<PyAny>>,
) -> PyResult<(String, Option<String>, Option<String>)> {
    let options = Options { back_off, gamma_limit, fastest_mode, ..Options::default() };
    let source = Source { name: "P".into(), text: problem };
    let report = job::run(python, progress, move |progress| {
        let _running = progress.begin("synth", "solving the matrix inequalities");
        squid_problem::synth::run(&source, options, reduce)
    })?
    .map_err(|error| of_problem(&error))?;
    Ok((text(&report)?, report.controller().map(|k| text(&k)).transpose()?, certificate(report.proved())?))
}

/// Bounds the gain of a closed loop; returns the report, and the certificate if there is a proof.
#[pyfunction]
pub fn gain(
    python: Python<'_>,
    problem: String,
    progress: Option<Py<PyAny>>,
) -> PyResult<(String, Option<String>)> {
    let source = Source { name: "P".into(), text: problem };
    let report = job::run(python, progress, move |progress| {
        let _running = progress.begin("gain", "solving the matrix inequalities");
        squid_problem::gain::run(&source)
    })?
    .map_err(|error| of_problem(&error))?;
    Ok((text(&report)?, certificate(report.proved())?))
}

/// Bounds mu of a matrix or a system; returns the report.
#[pyfunction]
pub fn mu(python: Python<'_>, problem: String) -> PyResult<String> {
    let source = Source { name: "M".into(), text: problem };
    let found = job::run(python, None, move |_| squid_problem::mu::run(&source))?;
    text(&found.map_err(|error| of_problem(&error))?)
}

/// Returns the H-infinity norm of a system, in discrete time if a sample time (s) is given, and the frequency of its
/// peak (rad/s).
#[pyfunction]
pub fn hinfnorm(
    python: Python<'_>,
    a: Vec<Vec<f64>>,
    b: Vec<Vec<f64>>,
    c: Vec<Vec<f64>>,
    d: Vec<Vec<f64>>,
    inputs: usize,
    sample_time: Option<f64>,
) -> PyResult<(f64, f64)> {
    let n = a.len();
    let matrix = |rows: &[Vec<f64>], columns: usize| -> PyResult<Mat> {
        from_rows(rows, columns)
            .ok_or_else(|| InputError::new_err("the rows of a matrix have different lengths"))
    };
    let system =
        StateSpace { a: matrix(&a, n)?, b: matrix(&b, inputs)?, c: matrix(&c, n)?, d: matrix(&d, inputs)? };
    let Some(sample_time) = sample_time else {
        let norm = job::run(python, None, move |_| system.hinf_norm())?;
        return Ok((norm.value, norm.frequency));
    };
    let transform = Bilinear::of(&system.a, sample_time);
    let (transform, system) = transform
        .and_then(|transform| Some((transform, transform.continuous(&system)?)))
        .ok_or_else(|| InputError::new_err(format!("P.A {POLES_AT_BOTH_ENDS}")))?;
    let norm = job::run(python, None, move |_| system.hinf_norm())?;
    Ok((norm.value, transform.frequency(norm.frequency)))
}

/// Verifies a certificate; returns the theorem as text, its gain, and the gain with model error.
#[pyfunction]
pub fn prove(python: Python<'_>, certificate: String) -> PyResult<String> {
    let source = Source { name: "certificate".into(), text: certificate };
    let theorem = job::run(python, None, move |_| squid_problem::check::prove(&source))?;
    let theorem = theorem.map_err(|error| of_problem(&error))?;
    text(&json!({
        "claim": theorem.to_string(),
        "gamma": theorem.gamma,
        "gamma_with_model_error": theorem.gamma_with_model_error,
        "gamma_at_rate": theorem.gamma_at_rate(),
    }))
}

fn text(value: &impl serde::Serialize) -> PyResult<String> {
    serde_json::to_string(value).map_err(|reason| InputError::new_err(reason.to_string()))
}

fn certificate(of: Option<&squid_certificate::Certificate>) -> PyResult<Option<String>> {
    let written = of.map(squid_certificate::Certificate::to_json).transpose();
    written.map_err(|reason| -> PyErr { InputError::new_err(reason.to_string()) })
}
