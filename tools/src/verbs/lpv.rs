//! Verbs of `squid lpv`: options, output and exit codes.

use crate::error::Error;
use crate::output::{answer, say};
use crate::progress::show;
use clap::{Args, Subcommand};
use serde::Serialize;
use serde_json::{Value, json};
use squid_base::files::check_directory;
use squid_base::progress::Progress;
use squid_lpv::synthesis::Options;
use squid_problem::check::check as proved;
use squid_problem::error::Error as ProblemError;
use squid_problem::source::Source;
use squid_problem::{gain, mu, sampled, synth};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Verbs of `squid lpv`.
#[derive(Debug, Subcommand)]
pub enum LpvVerb {
    /// Design a scheduled controller near the least gamma, and prove its gain bound
    ///
    /// Reads a generalised plant: {"data": {"P": {"A": .., "Bt": .., ..}, "blocks": [r_1, ..]}}, or without parameters
    /// {"data": {"A": .., "B1": .., ..}}; matrices are lists of rows, wt = blkdiag(theta_i I_ri) zt, |theta_i| <= 1.
    /// Weights are part of the plant and must be proper: E is rejected unless it is the identity. D22 may be omitted if
    /// zero. "rate" next to "blocks" bounds |theta'| of a plant with one parameter: the controller is then designed
    /// with Lyapunov matrices that depend on theta, and its gain is proved both for that rate and (a larger bound) for
    /// any rate. "dt", the sample time in s, makes the plant, the controller and the proof discrete-time.
    ///
    /// With --json, `gamma` is the lowest gamma found; `least` is true if it is shown, in floating point, to be the
    /// least within 0.1 %: without parameters, of all controllers, by Riccati equations with 32 digits; with
    /// parameters, of the synthesis inequalities. Otherwise a better controller may exist: for larger plants the search
    /// is repeated less often in other coordinates. `gamma_lower`, without
    /// parameters and "dt", is a lower bound of the gain of every controller, proved in exact arithmetic; null if none
    /// is proved.
    ///
    /// Exit codes, and `status` with --json: 0, feasible: a controller with a proved bound; 2, infeasible: it is shown,
    /// in floating point, that no controller exists, or none within --gamma-limit (with parameters: none that a
    /// quadratic Lyapunov function common to all their values, with these scalings, certifies; another may exist); 3,
    /// numerical_failure: inconclusive; 4, too_fast: there are controllers, but none computed satisfies --fastest-mode,
    /// which proves nothing about others; 1, error: a file is wrong; 64: the command line is wrong. `reason` says why
    /// there is no controller, `findings` what in the problem makes gains grow without limit (a control without a
    /// weight, a measurement without noise), and other deviations from the request.
    Synth(Synth),
    /// Verify a certificate, and check that it belongs to the plant in a problem file
    ///
    /// Exit codes, and `status` with --json: 0, proved; 1, not_proved: the certificate fails, or belongs to another
    /// plant; 1, error: a file is wrong; 64: the command line is wrong.
    Check {
        /// Problem file
        problem: PathBuf,
        /// Certificate written by `squid lpv synth`
        certificate: PathBuf,
    },
    /// Bound the structured singular value mu from both sides, for a matrix, or for a system over all frequencies
    ///
    /// Reads {"data": {"M": [[[re, im], ..], ..], "blocks": [..]}}, where real entries may be plain numbers, or
    /// {"data": {"P": {"A": .., "B": .., "C": .., "D": ..}, "blocks": [..]}}: z = M w, w = Delta z, and A stable.
    /// `blocks` in the usual notation: [-r, 0] a real scalar repeated r times, [r, 0] a complex one, [p, q] a full
    /// complex block of p rows and q columns. "dt", the sample time in s, makes P a system in discrete time: mu is then
    /// taken over the unit circle, and frequencies extend to pi/dt.
    ///
    /// For a system the upper bound holds at every frequency from 0 to infinity, not on a grid. The lower bound comes
    /// with the perturbation that attains it: it makes I - M Delta singular.
    ///
    /// With --json it prints `upper`, `lower` (0 if no perturbation was found), `frequency` (where the upper bound is
    /// largest, rad/s; null for a matrix, the string "infinity" for infinite frequency), `lower_frequency` (where Delta
    /// puts a pole on the axis), `delta` (rows of [re, im]; null if there is none), `residual` (of det(I - M Delta) =
    /// 0), `intervals`, `seconds`, `reason`.
    ///
    /// Exit codes, and `status` with --json: 0, bounded; 1, error: a file is wrong, the system is unstable without any
    /// perturbation, or the intervals do not close; 64: the command line is wrong.
    Mu {
        /// Problem file
        problem: PathBuf,
    },
    /// Bound the gain of a sampled loop from both sides, including its behaviour between samples
    ///
    /// Reads {"data": {"P": {..}, "blocks": [], "K": {"A": .., "B": .., "C": .., "D": ..}, "sample_time": T}}: a plant
    /// as in `synth`, without parameters and without D22, and a discrete-time controller u = K y with zero-order hold.
    /// "delay" delays the commands by a number of samples, at most 10. w is any function of finite energy; its
    /// components that reach y directly (D21), or all of them with "held": true, are held between samples.
    ///
    /// With --json it prints `lower` and `upper` (null for an unstable loop), `seconds`, `reason`.
    ///
    /// Exit codes, and `status` with --json: 0, bounded; 2, unstable; 1, error: a file is wrong; 64: the command line
    /// is wrong.
    Sampled {
        /// Problem file
        problem: PathBuf,
    },
    /// Bound the gain of a closed loop for parameters that change arbitrarily fast, at a bounded rate, or are constant
    ///
    /// Reads a plant as in `synth`, without controls and measurements: {"data": {"P": {"A": .., "Bt": .., "B1": ..,
    /// "Ct": .., "C1": .., "Dtt": .., "Dt1": .., "D1t": .., "D11": ..}, "blocks": [r_1, ..]}}; wt = blkdiag(theta_i
    /// I_ri) zt, |theta_i| <= 1. "rate" next to "blocks" bounds |theta'| of a single parameter; "dt" is the sample time
    /// of a discrete-time loop.
    ///
    /// The bound for every trajectory of the parameters uses a constant Lyapunov matrix with symmetric and skew
    /// scalings and is proved in exact arithmetic; the bound for a limited rate uses a Lyapunov matrix that is
    /// polynomial in theta, is proved likewise, and may exist without the former. The bound for constant parameters is
    /// the worst-case gain over all frequencies, from both sides; see `mu`.
    ///
    /// With --json it prints `gamma` and `gamma_symmetric` (the lowest bounds found for parameters that change
    /// arbitrarily fast), `least` (true if `gamma` is shown to be the least of the inequalities within 0.1 %),
    /// `proved`, `rate`, `proved_at_rate` (at most `proved`), `constant_upper`, `constant_lower`, `constant_theta` (the
    /// worst parameters found), `reasons`, `seconds`.
    ///
    /// Exit codes, and `status` with --json: 0, proved; 3, not_found: no bound was found, which proves nothing; 1,
    /// error: a file is wrong; 64: the command line is wrong.
    Gain {
        /// Problem file
        problem: PathBuf,
        /// Write certificate.json to this directory
        #[arg(long, value_name = "DIR")]
        out: Option<PathBuf>,
    },
}

/// Options of `squid lpv synth`.
#[derive(Debug, Args)]
pub struct Synth {
    /// Problem file
    problem: PathBuf,
    /// Write report.json, controller.json and certificate.json to this directory
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Back off by this fraction from the lowest gamma found when building the controller
    #[arg(long, value_name = "FRACTION", default_value_t = 0.1, allow_negative_numbers = true)]
    back_off: f64,
    /// Report the problem as infeasible if it is shown that no gamma is below this
    #[arg(long, value_name = "GAMMA", allow_negative_numbers = true)]
    gamma_limit: Option<f64>,
    /// Allow no mode of the controller faster than this, rad/s; also after --reduce
    ///
    /// Checked for the controller frozen at the points of a parameter grid: 11 values each for one or two parameters, 7
    /// for three, 5 for four, 3 for five and six, and the vertices only for more. It is not checked between the points.
    #[arg(long, value_name = "RAD/S", allow_negative_numbers = true)]
    fastest_mode: Option<f64>,
    /// Remove controller states and channels while the bound stays within 2 %
    #[arg(long)]
    reduce: bool,
    /// Tune a controller of fixed structure instead: `static`, u = D y, or a number of states, with constant matrices
    ///
    /// Minimises the H-infinity norm over frozen parameters, from 16 starts, and then the proved gain. The search is
    /// local: `gamma` is the bound of the controller found, and exit code 3 proves nothing. Not available with `rate`,
    /// `dt` or `D22`.
    #[arg(long, value_name = "STATES", value_parser = structure,
        conflicts_with_all = ["back_off", "gamma_limit", "fastest_mode", "reduce"])]
    structure: Option<usize>,
}

/// Runs a verb.
///
/// # Errors
/// Errors of the files and options.
pub fn run(verb: &LpvVerb) -> Result<ExitCode, Error> {
    match verb {
        LpvVerb::Synth(options) => synth(options),
        LpvVerb::Check { problem, certificate } => check(problem, certificate),
        LpvVerb::Mu { problem } => mu(problem),
        LpvVerb::Sampled { problem } => sampled(problem),
        LpvVerb::Gain { problem, out } => gain(problem, out.as_deref()),
    }
}

/// Prints bounds as text and JSON; if there are none, the reason as JSON.
fn print_bounds<Report: Serialize>(
    outcome: Result<Report, ProblemError>,
    to_text: impl Fn(&Report) -> String,
    refused: impl Fn(&ProblemError) -> Report,
) -> Result<Report, Error> {
    match outcome {
        Ok(report) => {
            say(&to_text(&report));
            answer(&report)?;
            Ok(report)
        }
        Err(error) => {
            let mut without = json!(refused(&error));
            let error = Error::from(error);
            if let (Some(all), Value::Object(more)) = (without.as_object_mut(), error.answer()) {
                all.extend(more);
            }
            answer(&without)?;
            Err(error)
        }
    }
}

fn mu(problem: &Path) -> Result<ExitCode, Error> {
    let outcome = Source::read(problem).and_then(|source| mu::run(&source));
    print_bounds(outcome, mu::Report::text, mu::Report::refused)?;
    Ok(ExitCode::SUCCESS)
}

fn gain(problem: &Path, out: Option<&Path>) -> Result<ExitCode, Error> {
    out.map_or(Ok(()), check_directory)?;
    let report = gain::run(&Source::read(problem)?)?;
    if let Some(directory) = out {
        report.save(directory)?;
    }
    say(&report.text());
    answer(&report)?;
    Ok(ExitCode::from(if report.theorem.is_some() { 0 } else { NOT_FOUND }))
}

/// Exit code if no bound was found.
const NOT_FOUND: u8 = 3;

fn sampled(problem: &Path) -> Result<ExitCode, Error> {
    let outcome = Source::read(problem).and_then(|source| sampled::run(&source));
    let report = print_bounds(outcome, sampled::Report::text, sampled::Report::refused)?;
    Ok(ExitCode::from(if report.upper.is_some() { 0 } else { UNSTABLE }))
}

/// Exit code for an unstable sampled loop.
const UNSTABLE: u8 = 2;

fn check(problem: &Path, certificate: &Path) -> Result<ExitCode, Error> {
    let theorem = proved(&Source::read(problem)?, &Source::read(certificate)?)?;
    say(&format!("PROVED: {theorem}"));
    let mut found = json!({ "status": "proved", "gamma": theorem.gamma, "reason": null });
    theorem.gamma_at_rate().iter().for_each(|gamma| found["gamma_at_rate"] = json!(gamma));
    theorem.gamma_with_model_error.iter().for_each(|gamma| found["gamma_with_model_error"] = json!(gamma));
    answer(&found)?;
    Ok(ExitCode::SUCCESS)
}

fn synth(synth: &Synth) -> Result<ExitCode, Error> {
    let options = options(synth)?;
    synth.out.as_deref().map_or(Ok(()), check_directory)?;
    let progress = Progress::new(&show);
    let solve = || {
        let source = Source::read(&synth.problem)?;
        match synth.structure {
            Some(states) => synth::run_structured(&source, states),
            None => synth::run(&source, options, synth.reduce),
        }
    };
    let what = if synth.structure.is_some() { "tuning gains" } else { "solving the matrix inequalities" };
    let report = progress.timed("synth", what, solve).0?;
    if let Some(directory) = &synth.out {
        report.save(directory)?;
    }
    say(report.text().trim_end());
    answer(&report)?;
    Ok(ExitCode::from(report.exit_code()))
}

/// Parses the number of states of a fixed structure.
fn structure(text: &str) -> Result<usize, String> {
    let states = if text == "static" { Ok(0) } else { text.parse() };
    states
        .ok()
        .filter(|states| *states <= MOST_STATES)
        .ok_or_else(|| format!("it must be 'static' or a number of states from 0 to {MOST_STATES}"))
}

/// Largest number of states of a fixed structure: the number of gains grows with its square.
const MOST_STATES: usize = 20;

fn options(synth: &Synth) -> Result<Options, Error> {
    for (name, value) in [("--gamma-limit", synth.gamma_limit), ("--fastest-mode", synth.fastest_mode)] {
        if let Some(v) = value.filter(|v| !(v.is_finite() && *v > 0.0)) {
            return Err(Error::Argument { name, found: v.to_string(), allowed: "above 0".into() });
        }
    }
    if !(1e-3..=1.0).contains(&synth.back_off) {
        let found = synth.back_off.to_string();
        return Err(Error::Argument { name: "--back-off", found, allowed: "from 0.001 to 1".into() });
    }
    Ok(Options {
        back_off: synth.back_off,
        gamma_limit: synth.gamma_limit,
        fastest_mode: synth.fastest_mode,
        ..Options::default()
    })
}
