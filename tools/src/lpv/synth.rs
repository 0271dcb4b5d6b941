//! `squid lpv synth`: from a problem file to gamma, controller and certificate.

use crate::error::Error;
use crate::lpv::problem_file;
use crate::lpv::problem_file::Problem;
use certificate::{Certificate, Multipliers, Theorem, lower_bound};
use lpv::direct_path::{self, synthesise};
use lpv::error::SynthesisError;
use lpv::matrix::to_rows;
use lpv::parameter_grid::parameter_grid;
use lpv::plant::GeneralisedPlant;
use lpv::regularise::is_nothing;
use lpv::regularity::findings;
use lpv::synthesis::{Design, DualMultipliers, Options, ScalingClass, least_gamma};
use serde::Serialize;
use squid_design::certify;
use squid_design::certify::verify::text;
use squid_design::certify::{lft_matrices, nominal};
use squid_design::store::files::Files;
use std::path::Path;
use std::time::Instant;

/// The outcomes.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Status {
    /// There is a controller, with a proved bound.
    Feasible,
    /// There is provably none.
    Infeasible,
    /// There are controllers, but none of those computed keeps the limit on the fastest mode; whether another does is
    /// not known.
    TooFast,
    /// Nothing is known.
    #[default]
    NumericalFailure,
}

/// The result, as `--json` prints it.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Report {
    /// The outcome.
    pub status: Status,
    /// The least gamma, whose inequalities hold strictly by their eigenvalues: symmetric and skew scalings.
    pub gamma: Option<f64>,
    /// No controller of any order has a gain below this: proved in exact arithmetic for the plant as given. Absent
    /// where that is not proved, and for every plant with parameters.
    pub gamma_lower: Option<f64>,
    /// The solver's estimate from below of the least gamma: not a bound, and never shown as one.
    #[serde(skip)]
    pub lower_estimate: f64,
    /// The same with symmetric scalings alone.
    pub gamma_symmetric: Option<f64>,
    /// The gamma at which the controller was built; of the plant with weight and noise added, where a remark names
    /// them.
    pub gamma_design: Option<f64>,
    /// How far that is above the least, `gamma_design/gamma - 1`; more than was asked where nothing closer could be
    /// built.
    pub back_off: Option<f64>,
    /// The bound of the controller that was built, proved in exact arithmetic.
    pub certified_gamma: Option<f64>,
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
    /// Whether weight or noise was added for the design: gamma_design is then of the plant with it.
    #[serde(skip)]
    pub regularised: bool,
    /// Number of remarks about the problem, which come first.
    #[serde(skip)]
    pub of_problem: usize,
    /// The certificate, which contains the controller.
    #[serde(skip)]
    pub certificate: Option<Certificate>,
}

/// Solves the problem of a file.
///
/// # Errors
/// Only those of the file; that a problem has no solution is a [`Report`].
pub fn run(path: &Path, options: Options, reduce: bool) -> Result<Report, Error> {
    let problem = problem_file::problem(path)?;
    let plant = &problem.plant;
    let started = Instant::now();
    let remarks: Vec<String> = findings(plant).iter().map(ToString::to_string).collect();
    let mut report = Report { of_problem: remarks.len(), remarks, ..Report::default() };
    match design(&problem, options, reduce) {
        Ok(design) => feasible(&problem, &design, &mut report),
        Err(error) => without_controller(plant, options, &error, &mut report),
    }
    symmetric(plant, &mut report);
    report.doubt_gamma();
    report.compare_back_off(options.back_off);
    report.seconds = started.elapsed().as_secs_f64();
    Ok(report)
}

/// Synthesises, and removes states if `reduce`. A controller that is too fast with all states may keep the limit with
/// fewer.
fn design(problem: &Problem, options: Options, reduce: bool) -> Result<Design, SynthesisError> {
    let Problem { plant, d22 } = problem;
    let full = synthesise(plant, d22, options);
    if !reduce {
        return full;
    }
    let fewer = |design: &Design| direct_path::reduce(plant, d22, design, options.fastest_mode);
    let (Err(SynthesisError::TooFast { .. }), Some(limit)) = (&full, options.fastest_mode) else {
        return full.map(|design| fewer(&design));
    };
    let reduced = fewer(&synthesise(plant, d22, Options { fastest_mode: None, ..options })?);
    let fastest = reduced.controller.fastest_mode(&parameter_grid(plant.blocks.len()));
    if fastest <= limit { Ok(reduced) } else { full }
}

/// The least gamma with symmetric scalings alone, where there is one with both.
fn symmetric(plant: &GeneralisedPlant, report: &mut Report) {
    let Some(both) = report.gamma else { return };
    if plant.blocks.is_empty() {
        report.gamma_symmetric = Some(both);
        return;
    }
    match least_gamma(plant, ScalingClass::Symmetric) {
        Ok((_, least)) if least.gamma > both && least.lower_estimate() < UNKNOWN_BELOW * least.gamma => {
            report.remarks.push(format!(
                "the least gamma with symmetric scalings alone is not known: the search stopped at {:.4e}",
                least.gamma
            ));
        }
        Ok((_, least)) => {
            report.gamma_symmetric = Some(least.gamma);
            // A solution with symmetric scalings is one with both.
            report.gamma = Some(both.min(least.gamma));
        }
        Err(reason) => {
            report
                .remarks
                .push(format!("the least gamma with symmetric scalings alone is not known: {reason}"));
        }
    }
}

/// A lower estimate below this fraction of gamma leaves gamma unknown.
const UNKNOWN_BELOW: f64 = 0.5;

/// Proves a design.
fn feasible(problem: &Problem, design: &Design, report: &mut Report) {
    report.gamma = Some(design.gamma_optimum);
    report.gamma_lower = proved_lower(&problem.plant, &design.multipliers);
    report.lower_estimate = design.lower_estimate;
    report.gamma_design = Some(design.gamma_design);
    report.controller_states = Some(design.controller.a().nrows());
    if let Some(added) = &design.regularisation {
        report.regularised = true;
        report.remarks.push(added.to_string());
    }
    let mut certificate = nominal(&problem.plant, &design.controller, &design.certified);
    certificate.plant.d22 = certify::direct_path(&problem.d22);
    match certificate.prove() {
        Ok(theorem) => {
            report.status = Status::Feasible;
            report.certified_gamma = Some(theorem.gamma);
            report.theorem = Some(theorem);
        }
        Err(failure) => {
            report.reason =
                Some(format!("a controller was computed, but its certificate does not prove: {failure}"));
        }
    }
    report.certificate = Some(certificate);
}

/// The lower bound proved by the first multipliers that prove one; better ones may violate an inequality by rounding.
fn proved_lower(plant: &GeneralisedPlant, multipliers: &[DualMultipliers]) -> Option<f64> {
    let rows = certify::plant_rows(plant);
    multipliers.iter().find_map(|m| {
        let guess = Multipliers {
            primal: to_rows(&m.primal),
            dual: to_rows(&m.dual),
            coupling: (to_rows(&m.coupling.0), to_rows(&m.coupling.1)),
        };
        lower_bound(&rows, &guess)
    })
}

const NO_LEAST: &str = "the computed least gamma is zero up to rounding: the smaller the bound is to be, the \
    larger the gains, and no controller is near the least; give every control a weight and every measurement \
    noise";

/// The relative gap between gamma and its lower estimate above which a remark is made.
const DOUBTFUL_GAP: f64 = 1e-2;

fn without_controller(
    plant: &GeneralisedPlant,
    options: Options,
    error: &SynthesisError,
    report: &mut Report,
) {
    report.status = match error {
        SynthesisError::TooFast { .. } => Status::TooFast,
        other if other.is_infeasible() => Status::Infeasible,
        _ => Status::NumericalFailure,
    };
    match error {
        SynthesisError::AboveLimit { optimum, .. } => report.gamma = Some(*optimum),
        other if other.is_infeasible() => {}
        _ => {
            if let Ok((_, least)) = least_gamma(plant, options.scalings) {
                report.gamma = Some(least.gamma);
                report.gamma_lower = proved_lower(plant, &least.multipliers);
                report.lower_estimate = least.lower_estimate();
            }
        }
    }
    report.reason = Some(error.to_string());
}

impl Report {
    /// Remarks on a gamma that may be too high.
    fn doubt_gamma(&mut self) {
        let Some(gamma) = self.gamma.filter(|_| self.status != Status::Infeasible) else { return };
        let clear = |lower: f64| gamma - lower <= DOUBTFUL_GAP * gamma;
        if clear(self.lower_estimate) || self.gamma_lower.is_some_and(clear) {
            return;
        }
        let proved =
            self.gamma_lower.map_or_else(String::new, |lower| format!(", though it is at least {lower}"));
        self.remarks.push(format!(
            "how far the least gamma may be below the computed one is not known{proved}: the problem is badly \
                conditioned, check units and weights"
        ));
    }

    /// Computes the back-off, and remarks on it when it is more than asked.
    fn compare_back_off(&mut self, asked: f64) {
        let (Some(built), Some(least)) = (self.gamma_design, self.gamma) else { return };
        if self.certified_gamma.is_some_and(|bound| is_nothing(least, bound)) {
            self.remarks.push(NO_LEAST.into());
            return;
        }
        self.back_off = Some(built / least - 1.0).filter(|b| b.is_finite());
        if let Some(back_off) = self.back_off.filter(|b| *b > 1.01 * asked && !self.regularised) {
            self.remarks.push(format!(
                "the controller was built {:.1} % above the least gamma where {:.1} % was asked: nothing closer \
                    could be built",
                100.0 * back_off,
                100.0 * asked
            ));
        }
    }

    /// Writes `report.json`, and `controller.json` and `certificate.json` if there is a controller.
    ///
    /// # Errors
    /// [`StoreError::Unwritable`](squid_design::error::StoreError::Unwritable).
    pub fn save(&self, directory: &Path) -> Result<(), Error> {
        let mut files = Files::default();
        // Without a proof nothing is kept, and files of an earlier run are removed.
        let proved = self.certificate.as_ref().filter(|_| self.theorem.is_some());
        let [path, controller] = ["certificate.json", "controller.json"].map(|name| directory.join(name));
        if let Some(certificate) = proved {
            files.add(path.clone(), text(certificate, &path)?);
            let (blocks, rows) = (certificate.controller_blocks.clone(), certificate.controller.clone());
            files.add_json(controller, &lft_matrices(blocks, rows))?;
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
            Status::Infeasible => "infeasible: there is no such controller\n".to_owned(),
            Status::TooFast => {
                "too fast: no computed controller keeps the limit on the fastest mode\n".to_owned()
            }
            Status::NumericalFailure => "numerical failure: nothing is known\n".to_owned(),
        };
        if let Some(reason) = &self.reason {
            out += &format!("  {reason}\n");
        }
        // Remarks on the problem are of interest where there is no controller and no proof of infeasibility.
        let unexplained = matches!(self.status, Status::TooFast | Status::NumericalFailure);
        for remark in self.remarks.iter().skip(if unexplained { 0 } else { self.of_problem }) {
            out += &format!("  remark: {remark}\n");
        }
        if self.gamma.is_some() {
            out += &format!(
                "  least gamma         {}\n  symmetric scalings  {}\n",
                number(self.gamma),
                number(self.gamma_symmetric)
            );
        }
        if let (Some(built), Some(back_off)) = (self.gamma_design, self.back_off) {
            out += &format!("  built at            {built:.6}, {:.1} % above the least\n", 100.0 * back_off);
        }
        if let Some(theorem) = &self.theorem {
            out += &format!("  certified gamma     {}\n  PROVED: {theorem}\n", number(self.certified_gamma));
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
