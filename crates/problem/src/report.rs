//! The report of `squid lpv synth`, on the terminal and in files.

use crate::error::Error;
use crate::findings;
use serde::Serialize;
use squid_base::files::Files;
use squid_base::numbers::at_most;
use squid_certificate::{Certificate, Controller, Theorem};
use squid_finding::Finding;
use squid_lpv::regularise::is_zero;
use squid_proof::claim::text;
use std::path::Path;

/// The outcome of a synthesis.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Status {
    /// A controller with a proved bound was found.
    Feasible,
    /// Proof, in floating point, that no such controller exists.
    Infeasible,
    /// No computed controller meets the limit on the fastest mode; another one may.
    TooFast,
    /// The search failed numerically; nothing is known.
    #[default]
    NumericalFailure,
}

/// The content of `controller.json`.
#[derive(Debug, Clone, Serialize)]
pub struct ControllerFile {
    /// Repetitions of each parameter in its channels.
    pub blocks: Vec<usize>,
    /// Matrices of the controller.
    #[serde(flatten)]
    pub matrices: Controller,
}

/// The result, as `--json` prints it.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Report {
    /// Outcome.
    pub status: Status,
    /// Lowest gamma found with symmetric and skew scalings; absent after a numerical failure. For a bounded rate it
    /// is that of the inequalities at seven values of the parameter, and not a bound.
    pub gamma: Option<f64>,
    /// `true` if `gamma` is shown, in floating point, to be the infimum within 0.1 %: over all controllers for a plant
    /// without parameters, otherwise of the synthesis inequalities. If `false`, a lower gamma may exist.
    pub least: bool,
    /// Lower bound of the gain for controllers of any order, proved in exact arithmetic for the given plant. Absent if
    /// it is not proved, and for plants with parameters or in discrete time.
    pub gamma_lower: Option<f64>,
    /// Lowest gamma found with symmetric scalings only.
    pub gamma_symmetric: Option<f64>,
    /// Gamma at which the controller was built, of the plant with added weight and noise if a finding names them.
    pub gamma_design: Option<f64>,
    /// `gamma_design/gamma - 1`; more than requested if no controller closer to `gamma` could be built.
    pub back_off: Option<f64>,
    /// Bound of the controller for an arbitrary rate, proved in exact arithmetic; `null` if there is a bound for the
    /// given rate only.
    pub certified_gamma: Option<f64>,
    /// Rate bound of the problem.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rate: Option<f64>,
    /// Bound of the controller for that rate, proved in exact arithmetic; at most `certified_gamma`, which also holds
    /// for that rate.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub certified_gamma_at_rate: Option<f64>,
    /// Number of states of the controller.
    pub controller_states: Option<usize>,
    /// Reason why there is no controller.
    pub reason: Option<String>,
    /// Features of the problem that cause large gains or numerical failure, with remedies, then deviations from the
    /// request.
    pub findings: Vec<Finding>,
    /// Wall-clock time.
    pub seconds: f64,
    /// The proved theorem.
    #[serde(skip)]
    pub theorem: Option<Theorem>,
    /// Statement of infeasibility, if `status` is infeasible.
    #[serde(skip)]
    pub infeasible: &'static str,
    /// `true` if weight or noise was added to the plant for the design; `gamma_design` is then that of the changed
    /// plant.
    #[serde(skip)]
    pub regularised: bool,
    /// Certificate, which contains the controller.
    #[serde(skip)]
    pub certificate: Option<Certificate>,
}

/// Largest fraction of a proved lower bound by which rounding may put the gamma of a search below it.
const ROUNDING: f64 = 1e-4;

/// Factor on the requested back-off up to which there is no finding.
const TOLERANCE: f64 = 1.001;

impl Report {
    /// Proves the certificate of a design.
    pub fn prove(&mut self, certificate: Certificate) {
        match certificate.prove() {
            Ok(theorem) => {
                self.status = Status::Feasible;
                self.certified_gamma = theorem.gamma;
                self.certified_gamma_at_rate = self.rate.and(theorem.gamma_at_rate().or(theorem.gamma));
                self.theorem = Some(theorem);
            }
            Err(failure) => {
                self.reason = Some(format!("a controller was computed, but its proof fails: {failure}"));
            }
        }
        self.certificate = Some(certificate);
    }

    /// Removes gamma after a numerical failure or if the proved lower bound contradicts it, and adds a finding if it
    /// is not shown to be the least.
    pub fn doubt_gamma(&mut self) {
        self.respect_lower_bound();
        if self.status == Status::NumericalFailure {
            (self.gamma, self.gamma_symmetric, self.gamma_design, self.least) = (None, None, None, false);
        }
        let Some(bound) = self.certified_gamma.filter(|_| !self.least) else { return };
        self.findings.push(findings::better_may_exist(bound, self.gamma_lower));
    }

    /// Makes gamma consistent with its proved lower bound: raises a gamma that is below it by rounding, and removes one
    /// that is further below.
    fn respect_lower_bound(&mut self) {
        let Some(lower) = self.gamma_lower else { return };
        let raised = |gamma: f64| (gamma >= (1.0 - ROUNDING) * lower).then_some(gamma.max(lower));
        let found = self.gamma;
        self.gamma = found.and_then(raised);
        self.gamma_symmetric = self.gamma_symmetric.and_then(raised);
        if let (Some(found), None) = (found, self.gamma) {
            self.least = false;
            self.findings.push(findings::gamma_below_lower_bound(found, lower));
        }
    }

    /// Computes the back-off, and adds a finding if it is larger than requested.
    pub fn compare_back_off(&mut self, requested: f64) {
        let (Some(built), Some(least)) = (self.gamma_design, self.gamma) else { return };
        if self.certified_gamma.is_some_and(|bound| is_zero(least, bound)) {
            self.findings.push(findings::gamma_is_zero(least));
            return;
        }
        self.back_off = Some(built / least - 1.0).filter(|b| b.is_finite());
        let far = |bound: &f64| self.rate.is_none() && *bound > (1.0 + TOLERANCE * requested) * least;
        if let Some(bound) = self.certified_gamma.filter(far) {
            self.findings.push(findings::bound_far_above(bound / least - 1.0, requested));
        }
        if let Some(back_off) = self.back_off.filter(|b| *b > 1.01 * requested && !self.regularised) {
            self.findings.push(findings::large_back_off(back_off, requested));
        }
    }

    /// Returns the certificate, if it is proved.
    pub fn proved(&self) -> Option<&Certificate> {
        self.certificate.as_ref().filter(|_| self.theorem.is_some())
    }

    /// Returns the controller of the proved certificate.
    pub fn controller(&self) -> Option<ControllerFile> {
        self.proved().map(|proved| ControllerFile {
            blocks: proved.controller_blocks.clone(),
            matrices: proved.controller.clone(),
        })
    }

    /// Writes `report.json`, and `controller.json` and `certificate.json` if there is a controller.
    ///
    /// # Errors
    /// [`files::Error`](squid_base::files::Error).
    pub fn save(&self, directory: &Path) -> Result<(), Error> {
        let mut files = Files::default();
        // Files of an earlier run would contradict a failed proof.
        let [path, controller] = ["certificate.json", "controller.json"].map(|name| directory.join(name));
        if let Some(certificate) = self.proved() {
            files.add(path.clone(), text(certificate, &path)?);
            files.add_json(controller, &self.controller())?;
        } else {
            files.remove(path);
            files.remove(controller);
        }
        files.add_json(directory.join("report.json"), self)?;
        Ok(files.save(directory)?)
    }

    /// Returns the text for a terminal.
    pub fn text(&self) -> String {
        let number = |v: Option<f64>| v.map_or_else(|| "unknown".into(), |v| format!("{v:.6}"));
        let mut out = match self.status {
            Status::Feasible => "feasible\n".to_owned(),
            Status::Infeasible => format!("infeasible: {}\n", self.infeasible),
            Status::TooFast => {
                "too fast: no computed controller satisfies the limit on the fastest mode\n".to_owned()
            }
            Status::NumericalFailure => {
                "numerical failure: no controller with a proved bound was found\n".to_owned()
            }
        };
        if let Some(reason) = &self.reason {
            out += &format!("  {reason}\n");
        }
        for found in &self.findings {
            out += &format!("  note: {found}\n");
        }
        if self.gamma.is_some() {
            let gamma = number(self.gamma);
            out += &match (self.rate, self.least) {
                (Some(rate), _) => {
                    format!("  gamma on a grid     {gamma}, at seven values of theta, |theta'| <= {rate}\n")
                }
                (None, true) => format!("  least gamma         {gamma}\n"),
                (None, false) => format!("  lowest gamma found  {gamma}\n"),
            };
            if self.rate.is_none() {
                out += &format!("  symmetric scalings  {}\n", number(self.gamma_symmetric));
            }
        }
        if let (Some(built), Some(back_off)) = (self.gamma_design, self.back_off) {
            out += &format!("  built at            {built:.6}, {:.1} % above it\n", 100.0 * back_off);
        }
        if let Some(theorem) = &self.theorem {
            if self.certified_gamma_at_rate.is_some() {
                out += &format!("  certified at rate   {}\n", at_most(self.certified_gamma_at_rate));
            }
            out += &format!("  certified gamma     {}\n", at_most(self.certified_gamma));
            out += &format!("  PROVED: {theorem}\n");
        }
        out + &format!("  {:.2} s\n", self.seconds)
    }

    /// Returns 0 if feasible, 2 if infeasible, 3 after a numerical failure, 4 if all controllers are too fast.
    pub fn exit_code(&self) -> u8 {
        match self.status {
            Status::Feasible => 0,
            Status::Infeasible => 2,
            Status::NumericalFailure => 3,
            Status::TooFast => 4,
        }
    }
}
