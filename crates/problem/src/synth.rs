//! `squid lpv synth`: gamma, controller and certificate for a problem file.

use crate::error::Error;
use crate::findings;
use crate::problem_file;
use crate::problem_file::Problem;
use crate::report::{Report, Status};
use crate::source::Source;
use squid_certificate::Certificate;
use squid_finding::Finding;
use squid_lpv::bounded_rate::SlowOptions;
use squid_lpv::direct_path::{self, synthesise};
use squid_lpv::error::SynthesisError;
use squid_lpv::parameter_grid::parameter_grid;
use squid_lpv::plant::GeneralisedPlant;
use squid_lpv::regularity::irregularities;
use squid_lpv::structured::{STARTS, Structure, tune};
use squid_lpv::synthesis::{
    Design, DualMultipliers, Options, ScalingClass, is_least, least_gamma, multipliers,
};
use squid_proof::claim::{direct_path_rows, nominal, without_claims};
use squid_proof::rate::rate;
use std::time::Instant;

/// Solves the problem of a file.
///
/// # Errors
/// Errors of the file; a problem without a solution has a [`Report`].
pub fn run(source: &Source, options: Options, reduce: bool) -> Result<Report, Error> {
    let problem = problem_file::problem(source)?;
    if problem.rate.is_some() {
        check_options_with_rate(source, options, reduce)?;
    }
    Ok(solve(&problem, options, reduce))
}

/// Tunes a controller with constant matrices and `states` states for the problem of a file; with none it is static
/// output feedback. The search is local.
///
/// # Errors
/// Errors of the file; [`Error::Problem`] for keys that such a controller does not support: `rate`, `dt` and `D22`.
pub fn run_structured(source: &Source, states: usize) -> Result<Report, Error> {
    let problem = problem_file::problem(source)?;
    let refused = [
        ("rate", problem.rate.is_some()),
        ("dt", problem.discrete.is_some()),
        ("D22", problem.d22.amax() > 0.0),
    ];
    if let Some((name, _)) = refused.iter().find(|(_, given)| *given) {
        let reason = "cannot be combined with --structure; remove one of the two";
        return Err(source.wrong(name, reason));
    }
    let started = Instant::now();
    let structure = Structure::full(&problem.plant, states);
    let mut report = Report::default();
    match tune(&problem.plant, &structure, &vec![0.0; structure.gains()], STARTS) {
        Ok(found) => {
            feasible(&problem, &found.design, &mut report);
            if !report.least {
                report.findings.push(findings::local_search());
            }
        }
        Err(error) => report.reason = Some(error.to_string()),
    }
    report.seconds = started.elapsed().as_secs_f64();
    Ok(report)
}

/// Solves a problem.
pub fn solve(problem: &Problem, options: Options, reduce: bool) -> Report {
    let started = Instant::now();
    let findings = irregularities(&problem.plant).iter().map(Finding::from).collect();
    let mut report = Report { findings, rate: problem.rate, ..Report::default() };
    match problem.rate {
        Some(rate) => {
            let slow = SlowOptions { back_off: options.back_off, ..SlowOptions::at(rate) };
            at_bounded_rate(problem, slow, options, &mut report);
        }
        None => at_any_rate(problem, design(problem, options, reduce), options, &mut report),
    }
    report.compare_back_off(options.back_off);
    report.seconds = started.elapsed().as_secs_f64();
    report
}

/// Rejects options that a synthesis for a bounded rate does not support.
fn check_options_with_rate(source: &Source, options: Options, reduce: bool) -> Result<(), Error> {
    let given = [
        ("--gamma-limit", options.gamma_limit.is_some()),
        ("--fastest-mode", options.fastest_mode.is_some()),
        ("--reduce", reduce),
    ];
    given.into_iter().find(|(_, given)| *given).map_or(Ok(()), |(name, _)| {
        let reason = format!("cannot be combined with {name}; remove one of the two");
        Err(source.wrong("rate", reason))
    })
}

/// Reports a design for an arbitrary rate, or the reason why there is none.
fn at_any_rate(
    problem: &Problem,
    found: Result<Design, SynthesisError>,
    options: Options,
    report: &mut Report,
) {
    match found {
        Ok(design) => feasible(problem, &design, report),
        Err(error) => without_controller(problem, options, &error, report),
    }
    if let Some(both) = report.gamma {
        match symmetric(&problem.plant, both) {
            Ok(least) => {
                report.gamma_symmetric = Some(least);
                // Symmetric scalings are a special case of both.
                report.gamma = Some(both.min(least));
            }
            Err(reason) => report.findings.push(findings::symmetric_unknown(&reason)),
        }
    }
    report.doubt_gamma();
}

/// Designs and proves a controller for a parameter with a bounded rate; if that search fails, for any rate.
fn at_bounded_rate(problem: &Problem, slow: SlowOptions, options: Options, report: &mut Report) {
    let found = match squid_lpv::bounded_rate::synthesise(&problem.plant, slow) {
        Ok(found) => found,
        Err(error) => {
            if let (SynthesisError::Numerical { .. }, found @ Ok(_)) =
                (&error, design(problem, options, false))
            {
                report.findings.push(findings::for_any_rate(report.rate.take(), &error));
                return at_any_rate(problem, found, options, report);
            }
            // Lyapunov matrices of a higher order may exist in all other cases.
            let none = matches!(
                error,
                SynthesisError::NotStabilisable { .. } | SynthesisError::NotDetectable { .. }
            );
            report.status = if none { Status::Infeasible } else { Status::NumericalFailure };
            report.infeasible = NOT_STABILISED;
            report.reason = Some(error.to_string());
            return;
        }
    };
    report.gamma = Some(found.least.gamma);
    report.gamma_design = Some(found.gamma_design);
    report.controller_states = Some(found.controller.a().nrows());
    let at_rate = rate(&found.bound, None);
    let Some(fast) = found.fast else {
        report.findings.push(findings::for_this_rate_only(slow.rate));
        let certificate = without_claims(&problem.plant, &found.controller);
        report.prove(Certificate { claims: vec![at_rate], ..certificate });
        return;
    };
    let mut certificate = nominal(&problem.plant, &found.controller, &fast);
    // A bound for any rate also holds for this rate.
    if found.bound.gamma < fast.gamma {
        certificate.claims.push(at_rate);
    }
    report.prove(certificate);
}

/// Synthesises a controller, and removes states and channels if `reduce`. A controller that is too fast with all states
/// may meet the limit with fewer.
fn design(problem: &Problem, options: Options, reduce: bool) -> Result<Design, SynthesisError> {
    let Problem { plant, d22, .. } = problem;
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

/// Computes the least gamma with symmetric scalings only; `both` is the least gamma with symmetric and skew scalings.
pub(crate) fn symmetric(plant: &GeneralisedPlant, both: f64) -> Result<f64, SynthesisError> {
    if plant.blocks.is_empty() {
        return Ok(both);
    }
    let (_, least) = least_gamma(plant, ScalingClass::Symmetric)?;
    if least.gamma > both && least.lower < UNKNOWN_BELOW * least.gamma {
        let diagnosis = format!("the search stopped at {:.4e}", least.gamma);
        return Err(SynthesisError::numerical("symmetric scalings", diagnosis));
    }
    Ok(least.gamma)
}

const NOT_STABILISED: &str = "no controller stabilises the plant";

/// Fraction of gamma below which a lower estimate leaves gamma unknown.
const UNKNOWN_BELOW: f64 = 0.5;

/// Proves a design.
fn feasible(problem: &Problem, design: &Design, report: &mut Report) {
    report.gamma = Some(design.gamma_optimum);
    report.gamma_lower = proved_lower(problem, &multipliers(&problem.plant, design));
    report.least = is_least(&problem.plant, design.gamma_optimum, design.lower);
    report.gamma_design = Some(design.gamma_design);
    report.controller_states = Some(design.controller.a().nrows());
    if let Some(added) = &design.regularisation {
        report.regularised = true;
        report.findings.push(findings::regularised(added));
    }
    match certificate(problem, design) {
        Some(certificate) => report.prove(certificate),
        None => report.reason = Some(NOT_BACK.into()),
    }
}

/// Returns the certificate of a design for the given plant.
fn certificate(problem: &Problem, design: &Design) -> Option<Certificate> {
    let (mut certificate, d22) = match &problem.discrete {
        None => (nominal(&problem.plant, &design.controller, &design.certified), &problem.d22),
        Some(given) => {
            let controller = given.controller(&design.controller)?;
            (nominal(&given.plant, &controller, &design.certified), &given.d22)
        }
    };
    certificate.discrete = problem.discrete.is_some();
    certificate.plant.d22 = direct_path_rows(d22);
    Some(certificate)
}

const NOT_BACK: &str = "a controller was computed, but the bilinear transform cannot map one of its modes to \
    discrete time; change the back-off";

/// Returns the lower bound that the multipliers prove. `None` in discrete time, since the proof is for the
/// continuous-time plant.
fn proved_lower(problem: &Problem, multipliers: &[DualMultipliers]) -> Option<f64> {
    if problem.discrete.is_none() {
        squid_proof::claim::lower_bound(&problem.plant, multipliers)
    } else {
        None
    }
}

fn without_controller(problem: &Problem, options: Options, error: &SynthesisError, report: &mut Report) {
    report.status = match error {
        SynthesisError::TooFast { .. } => Status::TooFast,
        other if other.is_infeasible() => Status::Infeasible,
        _ => Status::NumericalFailure,
    };
    match error {
        SynthesisError::AboveLimit { optimum, lower, .. } => {
            report.gamma = Some(*optimum);
            report.least = is_least(&problem.plant, *optimum, *lower);
        }
        SynthesisError::TooFast { .. } => {
            if let Ok((_, found)) = least_gamma(&problem.plant, options.scalings) {
                report.gamma = Some(found.gamma);
                report.gamma_lower = proved_lower(problem, &found.multipliers);
                report.least = is_least(&problem.plant, found.gamma, found.lower);
            }
        }
        _ => {}
    }
    report.infeasible = match (error, problem.plant.blocks.is_empty()) {
        (SynthesisError::AboveLimit { .. }, true) => "no controller has a gain below the limit",
        (SynthesisError::AboveLimit { .. }, false) => {
            "no controller with a common quadratic Lyapunov function and these scalings has a gain below the limit"
        }
        (SynthesisError::NotStabilisable { .. } | SynthesisError::NotDetectable { .. }, _) => NOT_STABILISED,
        _ => "no common quadratic Lyapunov function with these scalings exists",
    };
    report.reason = Some(error.to_string());
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::{Value, json};

    /// Solves one of the cases with known answers, with its data changed.
    fn solved(name: &str, change: impl FnOnce(&mut Value)) -> Result<Report, Error> {
        let path = format!("{}/../../tests/cases/{name}.json", env!("CARGO_MANIFEST_DIR"));
        let mut case: Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
        change(&mut case["data"]);
        let text = json!({ "data": case["data"] }).to_string();
        run(&Source { name: "case".into(), text }, Options::default(), false)
    }

    fn zero(matrix: &mut Value) {
        for row in matrix.as_array_mut().unwrap() {
            row.as_array_mut().unwrap().fill(json!(0.0));
        }
    }

    /// The search at a rate finds no controller without noise; the bound of the controller for any rate holds.
    #[test]
    fn falls_back_to_controller_for_any_rate() {
        let found = |rate: Option<f64>| {
            solved("lpv05_one_param_lossless", |data| {
                zero(&mut data["P"]["D21"]);
                rate.into_iter().for_each(|rate| data["rate"] = json!(rate));
            })
            .unwrap()
        };
        let (at_rate, at_any) = (found(Some(1.0)), found(None));
        assert_eq!((at_rate.status, at_rate.rate), (Status::Feasible, None));
        assert!(at_rate.certified_gamma.is_some() && at_rate.certified_gamma == at_any.certified_gamma);
        assert_eq!(at_rate.findings.len(), at_any.findings.len() + 1);
        assert!(at_rate.findings.iter().any(|one| one.kind == "for_any_rate" && one.value == Some(1.0)));
    }

    /// z is zero with every controller, or w has no effect.
    #[test]
    fn refuses_zero_performance_channels() {
        for (keys, blamed) in [(["C1", "D11", "D12"], "'C1'"), (["B1", "D11", "D21"], "'B1'")] {
            let found =
                solved("compleib/compleib_NN2", |data| keys.iter().for_each(|key| zero(&mut data[*key])));
            let error = found.unwrap_err().to_string();
            assert!(error.contains(blamed), "{error}");
        }
    }

    /// COMPleib's EB1: the gamma of the search is not below its proved lower bound.
    #[test]
    fn gamma_is_at_least_its_lower_bound() {
        let found = solved("compleib/compleib_EB1", |_| {}).unwrap();
        assert!(found.gamma.unwrap() >= found.gamma_lower.unwrap() && found.least, "{found:?}");
        let mut wrong = Report { gamma: Some(2.3835), ..found };
        wrong.doubt_gamma();
        assert_eq!((wrong.gamma, wrong.least), (None, false));
    }
}
