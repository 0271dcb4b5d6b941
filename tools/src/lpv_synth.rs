//! `squid lpv synth`: from a problem file to gamma, controller and certificate.

use crate::certify::{nominal, rows_with_blocks};
use crate::error::Error;
use crate::output::write_json;
use crate::{output, problem_file};
use certificate::{Certificate, Theorem};
use lpv::error::SynthesisError;
use lpv::plant::GeneralisedPlant;
use lpv::synthesis::{Design, Options, Scalings, least_gamma, synthesise};
use serde::Serialize;
use std::path::Path;
use std::time::Instant;

/// The three outcomes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Status {
    /// There is a controller, with a proved bound.
    Feasible,
    /// There is provably none.
    Infeasible,
    /// Nothing is known.
    NumericalFailure,
}

/// What was found; `--json` prints it.
#[derive(Debug, Clone, Serialize)]
pub struct Report {
    /// The outcome.
    pub status: Status,
    /// The least gamma, whose inequalities hold strictly by their eigenvalues: symmetric and skew scalings.
    pub gamma: Option<f64>,
    /// The same with symmetric scalings alone.
    pub gamma_symmetric: Option<f64>,
    /// The bound of the controller that was built, proved in exact arithmetic.
    pub certified_gamma: Option<f64>,
    /// States of the controller.
    pub controller_states: Option<usize>,
    /// Why there is no controller.
    pub reason: Option<String>,
    /// Wall-clock time.
    pub seconds: f64,
    /// What was proved.
    #[serde(skip)]
    pub theorem: Option<Theorem>,
    /// The certificate, which holds the controller.
    #[serde(skip)]
    pub certificate: Option<Certificate>,
}

/// Solves the problem of a file.
///
/// # Errors
/// Only those of the file; that a problem has no solution is a [`Report`].
pub fn run(path: &Path, options: Options, reduce: bool) -> Result<Report, Error> {
    let plant = problem_file::plant(path)?;
    let started = Instant::now();
    let mut report = Report {
        status: Status::NumericalFailure,
        gamma: None,
        gamma_symmetric: None,
        certified_gamma: None,
        controller_states: None,
        reason: None,
        seconds: 0.0,
        theorem: None,
        certificate: None,
    };
    match synthesise(&plant, options) {
        Ok(design) => feasible(&plant, design, reduce, &mut report),
        Err(error) => without_controller(&plant, options, &error, &mut report),
    }
    report.gamma_symmetric = match (plant.blocks.is_empty(), report.gamma) {
        (true, gamma) => gamma,
        (false, Some(_)) => least_gamma(&plant, Scalings::Symmetric).ok().map(|(_, found)| found.gamma),
        (false, None) => None,
    };
    // A solution with symmetric scalings is one with both.
    if let (Some(both), Some(symmetric)) = (report.gamma, report.gamma_symmetric) {
        report.gamma = Some(both.min(symmetric));
    }
    report.seconds = started.elapsed().as_secs_f64();
    Ok(report)
}

fn feasible(plant: &GeneralisedPlant, mut design: Design, reduce: bool, report: &mut Report) {
    report.gamma = Some(design.gamma_optimum);
    if reduce {
        design = lpv::reduce::reduce(plant, &design);
    }
    report.controller_states = Some(design.controller.a.nrows());
    let certificate = nominal(plant, &design.controller, &design.certified);
    match certificate.prove() {
        Ok(theorem) => {
            report.status = Status::Feasible;
            report.certified_gamma = Some(theorem.gamma);
            report.theorem = Some(theorem);
        }
        Err(failure) => {
            report.reason =
                Some(format!("a controller was found, but its certificate does not prove: {failure}"));
        }
    }
    report.certificate = Some(certificate);
}

fn without_controller(
    plant: &GeneralisedPlant,
    options: Options,
    error: &SynthesisError,
    report: &mut Report,
) {
    if error.is_infeasible() {
        report.status = Status::Infeasible;
    }
    report.gamma = match error {
        SynthesisError::AboveLimit { optimum, .. } => Some(*optimum),
        other if other.is_infeasible() => None,
        _ => least_gamma(plant, options.scalings).ok().map(|(_, found)| found.gamma),
    };
    report.reason = Some(error.to_string());
}

impl Report {
    /// Writes `report.json`, and `controller.json` and `certificate.json` if there is a controller.
    ///
    /// # Errors
    /// [`Error::Unwritable`].
    pub fn save(&self, directory: &Path) -> Result<(), Error> {
        write_json(&directory.join("report.json"), self)?;
        // What does not prove is not kept, and what an earlier run left must not stand beside this verdict.
        let proved = self.certificate.as_ref().filter(|_| self.theorem.is_some());
        let Some(certificate) = proved else {
            for name in ["controller.json", "certificate.json"] {
                output::remove(&directory.join(name))?;
            }
            return Ok(());
        };
        write_json(&directory.join("controller.json"), &rows_with_blocks(certificate))?;
        let path = directory.join("certificate.json");
        let text = certificate.to_json();
        let text = text.map_err(|reason| Error::Certificate { file: path.display().to_string(), reason })?;
        output::write(&path, text.as_bytes())
    }

    /// For people.
    pub fn words(&self) -> String {
        let number = |v: Option<f64>| v.map_or_else(|| "unknown".into(), |v| format!("{v:.6}"));
        let mut out = match self.status {
            Status::Feasible => "feasible\n".to_owned(),
            Status::Infeasible => "infeasible: there is no such controller\n".to_owned(),
            Status::NumericalFailure => "numerical failure: nothing is known\n".to_owned(),
        };
        if let Some(reason) = &self.reason {
            out += &format!("  {reason}\n");
        }
        if self.gamma.is_some() {
            out += &format!(
                "  least gamma         {}\n  symmetric scalings  {}\n",
                number(self.gamma),
                number(self.gamma_symmetric)
            );
        }
        if let Some(theorem) = &self.theorem {
            out += &format!("  certified gamma     {}\n  PROVED: {theorem}\n", number(self.certified_gamma));
        }
        out + &format!("  {:.2} s\n", self.seconds)
    }

    /// 0 for a controller, 2 for none possible, 3 for a numerical failure.
    pub fn exit_code(&self) -> u8 {
        match self.status {
            Status::Feasible => 0,
            Status::Infeasible => 2,
            Status::NumericalFailure => 3,
        }
    }
}
