//! What `squid lpv synth` found: its report, on the terminal and in files.

use crate::error::Error;
use crate::words::{at_least, at_most};
use base::files::Files;
use certificate::{Certificate, Controller, EnergyTheorem, Rows, Theorem};
use lpv::regularise::is_zero;
use proof::claim::text;
use serde::Serialize;
use std::path::Path;

/// The outcomes.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Status {
    /// There is a controller, with a proved bound.
    Feasible,
    /// It is shown, in floating point, that there is none of the kind that is sought.
    Infeasible,
    /// There are controllers, but none of those computed keeps the limit on the fastest mode; whether another does is
    /// not known.
    TooFast,
    /// Nothing is known.
    #[default]
    NumericalFailure,
}

/// A bound of the gain while commands are cut off, from rest, proved in exact arithmetic.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct WithLimits {
    /// The bound.
    pub gamma: f64,
    /// The largest energy of w for which it holds; `null` for any.
    pub energy: Option<f64>,
}

/// A controller as in `controller.json`.
#[derive(Debug, Clone, Serialize)]
pub struct ControllerFile {
    /// Repetitions of each parameter in its channels.
    pub blocks: Vec<usize>,
    /// Its matrices.
    #[serde(flatten)]
    pub matrices: Controller,
    /// By it and what the limits cut off of u its states move faster, states x controls.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub anti_windup: Option<Rows>,
    /// How far each control can go either way.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub limits: Option<Vec<f64>>,
}

/// The result, as `--json` prints it.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Report {
    /// The outcome.
    pub status: Status,
    /// The lowest gamma found, with symmetric and skew scalings; absent beside `numerical_failure`. At a bounded rate:
    /// that of the inequalities at seven values of the parameter, and not a bound.
    pub gamma: Option<f64>,
    /// Whether `gamma` is shown, in floating point, to be the least within 0.1 %: without parameters of any controller,
    /// with them of the synthesis inequalities. Otherwise a better one may exist.
    pub least: bool,
    /// No controller of any order has a gain below this: proved in exact arithmetic for the plant as given. Absent
    /// where that is not proved, and for every plant with parameters or in discrete time.
    pub gamma_lower: Option<f64>,
    /// The lowest gamma found with symmetric scalings alone.
    pub gamma_symmetric: Option<f64>,
    /// The gamma at which the controller was built; of the plant with weight and noise added, where a remark names
    /// them.
    pub gamma_design: Option<f64>,
    /// How far that is above `gamma`, `gamma_design/gamma - 1`; more than was asked where nothing closer could be
    /// built.
    pub back_off: Option<f64>,
    /// The bound of the controller that was built, proved in exact arithmetic, however fast the parameters move;
    /// `null` where there is one at the rate alone.
    pub certified_gamma: Option<f64>,
    /// The bound on the parameter's rate in the problem.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rate: Option<f64>,
    /// The bound of the controller at that rate, proved in exact arithmetic: at most `certified_gamma`, which holds
    /// there, too.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub certified_gamma_at_rate: Option<f64>,
    /// What was proved of the loop with the limits of the problem.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub with_limits: Vec<WithLimits>,
    /// States of the controller.
    pub controller_states: Option<usize>,
    /// Why there is no controller.
    pub reason: Option<String>,
    /// What in the problem makes gains grow and numerics fail, with the remedy, whatever the outcome; then deviations
    /// from what was asked.
    pub remarks: Vec<String>,
    /// Wall-clock time.
    pub seconds: f64,
    /// What was proved.
    #[serde(skip)]
    pub theorem: Option<Theorem>,
    /// What there is none of, where `status` is infeasible.
    #[serde(skip)]
    pub infeasible: &'static str,
    /// Whether weight or noise was added for the design: gamma_design is then of the plant with it.
    #[serde(skip)]
    pub regularised: bool,
    /// The certificate, which contains the controller.
    #[serde(skip)]
    pub certificate: Option<Certificate>,
}

const NO_LEAST: &str = "the computed least gamma is zero up to rounding: the smaller the bound is to be, the \
    larger the gains, and no controller is near the least; give every control a weight and every measurement \
    noise";

/// A back-off this much larger than asked is not worth a remark.
const NEARLY: f64 = 1.001;

impl Report {
    /// Proves what was designed.
    pub fn prove(&mut self, certificate: Certificate) {
        match certificate.prove() {
            Ok(theorem) => {
                self.status = Status::Feasible;
                self.certified_gamma = theorem.gamma;
                self.certified_gamma_at_rate = self.rate.and(theorem.gamma_at_rate().or(theorem.gamma));
                let with_limits =
                    |claim: &EnergyTheorem| WithLimits { gamma: claim.gamma, energy: claim.beta };
                self.with_limits = theorem.energy.iter().map(with_limits).collect();
                self.theorem = Some(theorem);
            }
            Err(failure) => {
                self.reason =
                    Some(format!("a controller was computed, but its certificate does not prove: {failure}"));
            }
        }
        self.certificate = Some(certificate);
    }

    /// Takes back a gamma that no controller comes with, and remarks on one that is not shown to be the least.
    pub fn doubt_gamma(&mut self) {
        if self.status == Status::NumericalFailure {
            (self.gamma, self.gamma_symmetric, self.gamma_design, self.least) = (None, None, None, false);
        }
        let Some(bound) = self.certified_gamma.filter(|_| !self.least) else { return };
        let lower = self
            .gamma_lower
            .map_or_else(String::new, |lower| format!("; none has one below {}", at_least(lower)));
        self.remarks.push(format!(
            "a controller with a gain below {} was found; a better one may exist{lower}",
            at_most(Some(bound))
        ));
    }

    /// Computes the back-off, and remarks on it when it is more than asked.
    pub fn compare_back_off(&mut self, asked: f64) {
        let (Some(built), Some(least)) = (self.gamma_design, self.gamma) else { return };
        if self.certified_gamma.is_some_and(|bound| is_zero(least, bound)) {
            self.remarks.push(NO_LEAST.into());
            return;
        }
        self.back_off = Some(built / least - 1.0).filter(|b| b.is_finite());
        let far = |bound: &f64| self.rate.is_none() && *bound > (1.0 + NEARLY * asked) * least;
        if let Some(bound) = self.certified_gamma.filter(far) {
            self.remarks.push(format!(
                "the certified gamma is {:.1} % above the lowest gamma found where {:.1} % was asked: no controller \
                    nearer to it was found whose bound 16 digits prove",
                100.0 * (bound / least - 1.0),
                100.0 * asked
            ));
        }
        if let Some(back_off) = self.back_off.filter(|b| *b > 1.01 * asked && !self.regularised) {
            self.remarks.push(format!(
                "the controller was built {:.1} % above the lowest gamma found where {:.1} % was asked: nothing closer \
                    could be built",
                100.0 * back_off,
                100.0 * asked
            ));
        }
    }

    /// The certificate, if it proves.
    pub fn proved(&self) -> Option<&Certificate> {
        self.certificate.as_ref().filter(|_| self.theorem.is_some())
    }

    /// The controller that it is of.
    pub fn controller(&self) -> Option<ControllerFile> {
        self.proved().map(|proved| ControllerFile {
            blocks: proved.controller_blocks.clone(),
            matrices: proved.controller.clone(),
            anti_windup: proved.energy.as_ref().map(|energy| energy.e.clone()),
            limits: proved.energy.as_ref().map(|energy| energy.limits.clone()),
        })
    }

    /// Writes `report.json`, and `controller.json` and `certificate.json` if there is a controller.
    ///
    /// # Errors
    /// [`files::Error`](base::files::Error).
    pub fn save(&self, directory: &Path) -> Result<(), Error> {
        let mut files = Files::default();
        // Without a proof nothing is kept, and files of an earlier run are removed.
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

    /// The text for a terminal.
    pub fn words(&self) -> String {
        let number = |v: Option<f64>| v.map_or_else(|| "unknown".into(), |v| format!("{v:.6}"));
        let mut out = match self.status {
            Status::Feasible => "feasible\n".to_owned(),
            Status::Infeasible => format!("infeasible: {}\n", self.infeasible),
            Status::TooFast => {
                "too fast: no computed controller keeps the limit on the fastest mode\n".to_owned()
            }
            Status::NumericalFailure => {
                "numerical failure: no controller with a proved bound was found\n".to_owned()
            }
        };
        if let Some(reason) = &self.reason {
            out += &format!("  {reason}\n");
        }
        for remark in &self.remarks {
            out += &format!("  remark: {remark}\n");
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
            for WithLimits { gamma, energy } in &self.with_limits {
                // Rounded down.
                let up_to = |most| format!("w of an energy up to {:.4e}", (1.0 - 5e-5) * most);
                let w = energy.map_or_else(|| "any w".into(), up_to);
                out += &format!("  with limits         {} for {w}\n", at_most(Some(*gamma)));
            }
            out += &format!("  PROVED: {theorem}\n");
        }
        out + &format!("  {:.2} s\n", self.seconds)
    }

    /// 0 for a controller, 2 for none possible, 3 for a numerical failure, 4 for controllers that are all too fast.
    pub fn exit_code(&self) -> u8 {
        match self.status {
            Status::Feasible => 0,
            Status::Infeasible => 2,
            Status::NumericalFailure => 3,
            Status::TooFast => 4,
        }
    }
}
