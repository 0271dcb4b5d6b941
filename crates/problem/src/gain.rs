//! `squid lpv gain`: from a problem file without controls to bounds on the gain of a finished loop.
//!
//! ```json
//! {"kind": "lpvgain", "data": {"P": {"A": [[..]], "Bt": .., "B1": .., "Ct": .., "C1": .., "Dtt": .., "Dt1": ..,
//!  "D1t": .., "D11": ..}, "blocks": [r_1, ..], "rate": ..}}
//! ```
//!
//! It is the synthesis for a plant on which nothing acts: its least gamma is that of the loop.

use crate::error::Error;
use crate::problem_file::{self, Problem};
use crate::report::Status;
use crate::source::Source;
use crate::synth;
use crate::words::{at_most, digits};
use certificate::{Certificate, Rows, Theorem};
use lpv::controller::Controller;
use lpv::mu::worst_case::{Perturbable, worst_case_gain};
use lpv::mu::{Block, Structure};
use lpv::partition::Group::{T, W, Z};
use lpv::plant::GeneralisedPlant;
use lpv::synthesis::Options;
use serde::Serialize;
use squid_design::certify::controller_rows;
use squid_design::certify::verify::text;
use squid_design::store::files::Files;
use std::path::Path;
use std::time::Instant;

/// The result, as `--json` prints it.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Report {
    /// `proved`: there is a bound for every trajectory of the parameters; `not_found`: none was found.
    pub status: &'static str,
    /// The least bound of the inequalities, symmetric and skew scalings; at a bounded rate that at seven values of the
    /// parameter, and not a bound.
    pub gamma: Option<f64>,
    /// The same with symmetric scalings alone.
    pub gamma_symmetric: Option<f64>,
    /// The gain is below this however fast the parameters move: proved in exact arithmetic.
    pub proved: Option<f64>,
    /// The bound on the parameter's rate in the problem.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rate: Option<f64>,
    /// The gain at that rate is below this: proved in exact arithmetic.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub proved_at_rate: Option<f64>,
    /// The gain for constant parameters is below this, at every frequency.
    pub constant_upper: Option<f64>,
    /// The gain for the worst constant parameters found.
    pub constant_lower: Option<f64>,
    /// Those parameters.
    pub constant_theta: Option<Vec<f64>>,
    /// Why there is no bound, and what is doubtful.
    pub reasons: Vec<String>,
    /// Wall-clock time.
    pub seconds: f64,
    /// What was proved.
    #[serde(skip)]
    pub theorem: Option<Theorem>,
    /// What shows it.
    #[serde(skip)]
    pub certificate: Option<Certificate>,
}

/// How near the proved bound is sought to the least one: the loop is there already, so that nothing is lost by it.
const BACK_OFF: f64 = 1e-3;

/// Bounds the gain of the loop of a file.
///
/// # Errors
/// Those of the file; that no bound is found is a [`Report`].
pub fn run(source: &Source) -> Result<Report, Error> {
    let problem = problem_file::finished(source)?;
    let started = Instant::now();
    let solved = synth::solve(&problem, Options { back_off: BACK_OFF, ..Options::default() }, false);
    let mut report = Report {
        status: "not_found",
        gamma: solved.gamma,
        gamma_symmetric: solved.gamma_symmetric,
        rate: problem.rate,
        reasons: solved.reason.into_iter().chain(solved.remarks).collect(),
        ..Report::default()
    };
    if let Some(certificate) = solved.certificate.filter(|_| solved.status == Status::Feasible) {
        report.prove(&problem, certificate);
    }
    report.constant(&problem.plant);
    report.seconds = started.elapsed().as_secs_f64();
    Ok(report)
}

impl Report {
    /// The certificate, if it proves.
    pub fn proved(&self) -> Option<&Certificate> {
        self.certificate.as_ref().filter(|_| self.theorem.is_some())
    }

    /// Proves the bound of the plant alone: the synthesis adds a controller that nothing connects to it.
    fn prove(&mut self, problem: &Problem, certificate: Certificate) {
        let (n, r) = (problem.plant.a().nrows(), problem.plant.dtt().nrows());
        let corner = |rows: &Rows, size: usize| rows[..size].iter().map(|row| row[..size].to_vec()).collect();
        let alone =
            match (&certificate.bounded_rate, Controller::new(vec![0; problem.plant.blocks.len()], &[])) {
                (None, Ok(none)) => Certificate {
                    controller_blocks: none.blocks.clone(),
                    controller: controller_rows(&none),
                    x: corner(&certificate.x, n),
                    s: corner(&certificate.s, r),
                    t: corner(&certificate.t, r),
                    ..certificate
                },
                _ => certificate,
            };
        match alone.prove() {
            Ok(theorem) => {
                self.status = "proved";
                self.proved = Some(theorem.gamma);
                self.proved_at_rate = theorem.bounded_rate.map(|slow| slow.gamma);
                self.theorem = Some(theorem);
            }
            Err(reason) => self.reasons.push(format!("a bound was computed, but does not prove: {reason}")),
        }
        self.certificate = Some(alone);
    }

    /// The worst-case gain for constant parameters.
    fn constant(&mut self, plant: &GeneralisedPlant) {
        let found = constant(plant).and_then(|whole| worst_case_gain(&whole).map_err(|why| why.to_string()));
        match found {
            Ok(gain) => {
                self.constant_upper = Some(gain.upper);
                self.constant_lower = Some(gain.worst.gain);
                let mut first = 0;
                let at = |repetitions: &usize| {
                    let theta = gain.worst.delta[(first, first)].re;
                    first += repetitions;
                    theta
                };
                self.constant_theta =
                    Some(plant.blocks.iter().filter(|repetitions| **repetitions > 0).map(at).collect());
            }
            Err(reason) => self.reasons.push(format!("for constant parameters: {reason}")),
        }
    }

    /// Writes `certificate.json` if there is a proof; that of an earlier run goes.
    ///
    /// # Errors
    /// [`StoreError::Unwritable`](squid_design::error::StoreError::Unwritable).
    pub fn save(&self, directory: &Path) -> Result<(), Error> {
        let mut files = Files::default();
        let path = directory.join("certificate.json");
        match self.proved() {
            Some(certificate) => files.add(path.clone(), text(certificate, &path)?),
            None => files.remove(path),
        }
        Ok(files.save(directory)?)
    }

    /// The text for a terminal.
    pub fn words(&self) -> String {
        let number = |v: Option<f64>| v.map_or_else(|| "unknown".into(), |v| format!("{v:.6}"));
        let mut out = format!("least bound           {}\n", number(self.gamma));
        out += &match self.rate {
            Some(rate) => format!("  with |theta'| <=    {rate}, at seven values of theta\n"),
            None => format!("  symmetric scalings  {}\n", number(self.gamma_symmetric)),
        };
        if self.rate.is_some() {
            out += &format!("proved at that rate   {}\n", at_most(self.proved_at_rate));
        }
        out += &format!("proved at any rate    {}\n", at_most(self.proved));
        out += &match (self.constant_lower, self.constant_upper) {
            (Some(lower), Some(_)) => {
                let least = digits(lower, f64::floor);
                format!("constant parameters   {least} to {}\n", at_most(self.constant_upper))
            }
            _ => "constant parameters   unknown\n".to_owned(),
        };
        if let Some(theorem) = &self.theorem {
            out += &format!("PROVED: {theorem}\n");
        }
        for reason in &self.reasons {
            out += &format!("remark: {reason}\n");
        }
        out + &format!("{:.2} s", self.seconds)
    }
}

/// The loop with constant parameters: each a real scalar, repeated.
fn constant(plant: &GeneralisedPlant) -> Result<Perturbable, String> {
    let blocks = plant.blocks.iter().filter(|repetitions| **repetitions > 0).map(|r| Block::Real(*r));
    let structure = Structure::new(blocks.collect()).map_err(|why| why.to_string())?;
    let system = plant.parts.state_space(&[T, Z], &[T, W]);
    Ok(Perturbable { system, structure, size: 1.0 })
}
