//! `squid lpv gain`: bounds on the gain of the closed loop of a problem file without controls.
//!
//! ```json
//! {"kind": "lpvgain", "data": {"P": {"A": [[..]], "Bt": .., "B1": .., "Ct": .., "C1": .., "Dtt": .., "Dt1": ..,
//!  "D1t": .., "D11": ..}, "blocks": [r_1, ..], "rate": ..}}
//! ```
//!
//! For an arbitrary rate of the parameters the bound is the least gamma of a synthesis for a plant without controls.
//! For a bounded rate the loop is analysed directly.

use crate::error::Error;
use crate::problem_file::{self, Problem};
use crate::source::Source;
use crate::synth::symmetric;
use serde::Serialize;
use squid_base::files::Files;
use squid_base::numbers::{at_most, digits};
use squid_certificate::{Certificate, Claim, Theorem};
use squid_lpv::analysis::GainBound;
use squid_lpv::bounded_rate::finished;
use squid_lpv::controller::Controller;
use squid_lpv::direct_path::synthesise;
use squid_lpv::error::SynthesisError;
use squid_lpv::matrix::Mat;
use squid_lpv::mu::worst_case::{Perturbable, worst_case_gain};
use squid_lpv::mu::{Block, Structure};
use squid_lpv::partition::Group::{T, W, Z};
use squid_lpv::plant::GeneralisedPlant;
use squid_lpv::synthesis::{Options, is_least};
use squid_proof::claim::{nominal, text, without_claims};
use squid_proof::rate::rate as at_rate;
use std::path::Path;
use std::time::Instant;

/// The result, as `--json` prints it.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Report {
    /// `proved`: there is a bound for an arbitrary or the given rate of the parameters; `not_found`: none was found.
    pub status: &'static str,
    /// Lowest bound found for an arbitrary rate, with symmetric and skew scalings, in floating point.
    pub gamma: Option<f64>,
    /// `true` if `gamma` is shown, in floating point, to be the infimum of the inequalities within 0.1 %.
    pub least: bool,
    /// Lowest bound found with symmetric scalings only.
    pub gamma_symmetric: Option<f64>,
    /// Bound of the gain for an arbitrary rate, proved in exact arithmetic; `null` if none was found.
    pub proved: Option<f64>,
    /// Rate bound of the problem.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rate: Option<f64>,
    /// Bound of the gain for that rate, proved in exact arithmetic; at most `proved`, which holds for every rate.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub proved_at_rate: Option<f64>,
    /// Upper bound of the gain for constant parameters, over all frequencies.
    pub constant_upper: Option<f64>,
    /// Gain for the worst constant parameters found.
    pub constant_lower: Option<f64>,
    /// Worst constant parameters found.
    pub constant_theta: Option<Vec<f64>>,
    /// Reasons why a bound is missing or uncertain.
    pub reasons: Vec<String>,
    /// Wall-clock time.
    pub seconds: f64,
    /// The proved theorem.
    #[serde(skip)]
    pub theorem: Option<Theorem>,
    /// Certificate of the theorem.
    #[serde(skip)]
    pub certificate: Option<Certificate>,
}

/// Back-off of the proved bound from the least one; it can be small, since there is no controller to build.
const BACK_OFF: f64 = 1e-3;

/// Bounds the gain of the loop of a file.
///
/// # Errors
/// The errors of the file; a loop without a bound has a [`Report`].
pub fn run(source: &Source) -> Result<Report, Error> {
    let problem = problem_file::finished(source)?;
    let started = Instant::now();
    let mut report = Report { status: "not_found", rate: problem.rate, ..Report::default() };
    match Controller::new(vec![0; problem.plant.blocks.len()], &[]) {
        Ok(none) => report.bound(&problem, &none),
        Err(shape) => report.reasons.push(shape.to_string()),
    }
    report.constant(&problem.plant);
    report.seconds = started.elapsed().as_secs_f64();
    Ok(report)
}

impl Report {
    /// Returns the certificate, if it is proved.
    pub fn proved(&self) -> Option<&Certificate> {
        self.certificate.as_ref().filter(|_| self.theorem.is_some())
    }

    /// Proves bounds for an arbitrary rate and for the rate of the problem.
    fn bound(&mut self, problem: &Problem, none: &Controller) {
        // The proof of a discrete-time loop is for the given plant, not for its bilinear transform.
        let plant = problem.discrete.as_ref().map_or(&problem.plant, |given| &given.plant);
        let fast = self.any_rate(problem);
        let mut certificate =
            fast.as_ref().map_or_else(|| without_claims(plant, none), |bound| nominal(plant, none, bound));
        certificate.discrete = problem.discrete.is_some();
        if let Some(rate) = problem.rate {
            match finished(&problem.plant.open(), rate) {
                // A bound for any rate also holds for this rate.
                Ok(slow) if fast.is_some_and(|fast| fast.gamma <= slow.gamma) => {}
                Ok(slow) => certificate.claims.push(at_rate(&slow, None)),
                Err(reason) => self.reasons.push(format!("no bound was found for the given rate: {reason}")),
            }
        }
        self.prove(certificate);
    }

    /// Bounds the gain of the loop for an arbitrary rate.
    fn any_rate(&mut self, problem: &Problem) -> Option<GainBound> {
        let Problem { plant, d22, .. } = problem;
        let design = match synthesise(plant, d22, Options { back_off: BACK_OFF, ..Options::default() }) {
            Ok(design) => design,
            Err(error) => {
                self.reasons.push(no_bound(&error, "these scalings"));
                return None;
            }
        };
        let both = design.gamma_optimum;
        match symmetric(plant, both) {
            Ok(least) => (self.gamma, self.gamma_symmetric) = (Some(both.min(least)), Some(least)),
            Err(reason) => {
                self.gamma = Some(both);
                self.reasons.push(no_bound(&reason, "symmetric scalings only"));
            }
        }
        self.least = self.gamma.is_some_and(|gamma| is_least(plant, gamma, design.lower));
        // The synthesis adds an unconnected controller; the blocks of the plant come first.
        let (n, r) = (plant.a().nrows(), plant.dtt().nrows());
        let corner = |m: &Mat, size: usize| m.view((0, 0), (size, size)).into_owned();
        let found = design.certified;
        let (x, s, t) = (corner(&found.x, n), corner(&found.s, r), corner(&found.t, r));
        Some(GainBound { x, s, t, ..found })
    }

    /// Proves all claims of a certificate or, if that fails, the first that can be proved alone.
    fn prove(&mut self, full: Certificate) {
        let mut tried = vec![];
        if let [_, _, ..] = full.claims.as_slice() {
            let alone = |claim: &Claim| Certificate { claims: vec![claim.clone()], ..full.clone() };
            tried.extend(full.claims.iter().map(alone));
        }
        tried.insert(0, full);
        for certificate in tried.into_iter().filter(|c| !c.claims.is_empty()) {
            match certificate.prove() {
                Ok(theorem) => {
                    self.status = "proved";
                    self.proved = theorem.gamma;
                    self.proved_at_rate = self.rate.and(theorem.gamma_at_rate().or(theorem.gamma));
                    self.theorem = Some(theorem);
                    self.certificate = Some(certificate);
                    return;
                }
                Err(reason) => {
                    self.reasons.push(format!("a bound was computed, but its proof fails: {reason}"));
                }
            }
        }
    }

    /// Bounds the worst-case gain for constant parameters.
    fn constant(&mut self, plant: &GeneralisedPlant) {
        let found =
            constant(plant).and_then(|system| worst_case_gain(&system).map_err(|why| why.to_string()));
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

    /// Writes `certificate.json` if there is a proof, otherwise removes the file of an earlier run.
    ///
    /// # Errors
    /// [`files::Error`](squid_base::files::Error).
    pub fn save(&self, directory: &Path) -> Result<(), Error> {
        let mut files = Files::default();
        let path = directory.join("certificate.json");
        match self.proved() {
            Some(certificate) => files.add(path.clone(), text(certificate, &path)?),
            None => files.remove(path),
        }
        Ok(files.save(directory)?)
    }

    /// Returns the text for a terminal.
    pub fn text(&self) -> String {
        let number = |v: Option<f64>| v.map_or_else(|| "unknown".into(), |v| format!("{v:.6}"));
        let mut out = String::new();
        if let Some(rate) = self.rate {
            let known = at_most(self.proved_at_rate);
            out += &format!("proved at the rate    {known} for |theta'| <= {rate}\n");
        }
        out += &format!("proved at any rate    {}\n", at_most(self.proved));
        let name = if self.least { "least bound       " } else { "lowest bound found" };
        out += &format!("  {name}  {}\n", number(self.gamma));
        out += &format!("  symmetric scalings  {}\n", number(self.gamma_symmetric));
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

/// Returns the reason for a missing bound for an arbitrary rate, in terms of the loop instead of the synthesis.
fn no_bound(error: &SynthesisError, scalings: &str) -> String {
    match error {
        SynthesisError::NotStabilisable { re, im } | SynthesisError::NotDetectable { re, im } => {
            format!("the loop is unstable: it has a mode at {re:.4} {im:+.4}i")
        }
        other if other.is_infeasible() => {
            format!(
                "no constant Lyapunov matrix with {scalings} bounds the gain for parameters that change arbitrarily \
                    fast"
            )
        }
        _ => "no bound was found for parameters that change arbitrarily fast: the search failed numerically"
            .into(),
    }
}

/// Returns the loop with constant parameters as repeated real scalars.
fn constant(plant: &GeneralisedPlant) -> Result<Perturbable, String> {
    let blocks = plant.blocks.iter().filter(|repetitions| **repetitions > 0).map(|r| Block::Real(*r));
    let structure = Structure::new(blocks.collect()).map_err(|why| why.to_string())?;
    let system = plant.parts.state_space(&[T, Z], &[T, W]);
    Ok(Perturbable { system, structure, size: 1.0 })
}
