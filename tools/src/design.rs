//! The design, stage by stage: load, trim, linearise, fit, to LFT, augment, synthesise, check, freeze.

use crate::certify::{Proof, certify};
use crate::check::{Checks, check};
use crate::error::Error;
use crate::freeze::{Frozen, freeze};
use crate::frequency;
use crate::inputs::Inputs;
use crate::model::Model;
use crate::model_ball::SAMPLES;
use crate::output::{above, decimals};
use crate::problem::augment;
use crate::robust::{Robust, robust};
use crate::stages::Stages;
use auv::Status;
use lpv::error::SynthesisError;
use lpv::plant::GeneralisedPlant;
use lpv::regularity::findings;
use lpv::synthesis::{Design, Options, synthesise};

/// A design with all that was found on the way.
#[derive(Debug, Clone)]
pub struct Finished {
    /// The vehicle's LPV model.
    pub model: Model,
    /// The generalised plant.
    pub plant: GeneralisedPlant,
    /// The controller and its gammas.
    pub design: Design,
    /// What the checks found.
    pub checks: Checks,
    /// The certificate, or why there is none.
    pub proof: Result<Proof, String>,
    /// What the FMUs carry.
    pub frozen: Frozen,
    /// How the controller came to bear more of the declared uncertainty, if that was asked for.
    pub robust: Option<Robust>,
}

/// Runs all stages.
///
/// # Errors
/// The first stage that fails; no controller leaves here that did not pass the checks.
pub fn run(inputs: &Inputs, stages: &Stages) -> Result<Finished, Error> {
    run_with(inputs, stages, false)
}

/// The same, with a robust controller in place of the nominal one where that is asked for; see [`crate::robust`].
///
/// # Errors
/// As [`run`], and those of [`robust`].
pub fn run_with(inputs: &Inputs, stages: &Stages, with_robust: bool) -> Result<Finished, Error> {
    stages.done("vehicle", &vehicle_line(inputs));
    stages.done("design", &format!("{}.toml: {}", inputs.design.name, inputs.design.description));
    let model = Model::new(inputs)?;
    stages.done("trim", &trim_line(&model));
    stages.done("linearise", &linearise_line(&model));
    stages.done("fit", &fit_line(inputs, &model));
    stages.done("LFT", &lft_line(&model));
    let plant = augment(inputs, model.lft.clone())?;
    stages.done("augment", &augment_line(inputs, &plant));
    let nominal = synthesis_stage(inputs, &plant, stages)?;
    let robust = with_robust.then(|| robust(inputs, &model, &plant, &nominal, stages)).transpose()?;
    let design = robust.as_ref().map_or(nominal, |found| found.design.clone());
    let running = stages.begin("check", "the closed loop against the fit and the true linearisations");
    let checks = check(inputs, &plant, &design.controller, design.certified.gamma)?;
    drop(running);
    stages.done("check", &check_line(&checks, design.certified.gamma));
    if let Some(words) = checks.remark(inputs.design.sample_time) {
        stages.done("", &words);
    }
    let proof = certificate_stage(inputs, &model, &plant, &design, stages);
    let frozen = freeze(inputs, &model, &design, proof.is_ok())?;
    Ok(Finished { model, plant, design, checks, proof, frozen, robust })
}

fn synthesis_stage(inputs: &Inputs, plant: &GeneralisedPlant, stages: &Stages) -> Result<Design, Error> {
    let running = stages.begin("synthesise", "solving the matrix inequalities");
    let options = Options { back_off: inputs.design.back_off, ..Options::default() };
    let design = synthesise(plant, options).map_err(|reason| no_controller(inputs, plant, reason))?;
    let seconds = running.seconds();
    drop(running);
    stages.done("synthesise", &synthesis_line(&design, inputs.design.back_off, seconds));
    stages.done(
        "bound",
        &format!(
            "the finished loop has a gain below {} for any course of speed in the range\n\
             (by eigenvalues in floating point, the nearest at {:.1e})",
            above(design.certified.gamma),
            design.certified.largest_eigenvalue
        ),
    );
    Ok(design)
}

/// The gammas, how near to each other they could be had, and what was added to the plant for it.
fn synthesis_line(design: &Design, asked: f64, seconds: f64) -> String {
    let (how, remark) = match &design.regularisation {
        Some(added) => (", of the plant with weight and noise added", format!("\nremark: {added}")),
        None if back_off(design) > 1.01 * asked => {
            (", more than asked: closer none could be built", String::new())
        }
        None => ("", String::new()),
    };
    format!(
        "gamma {:.4} at the least, built at {:.4} ({:.1} % back-off{how}), {seconds:.1} s{remark}",
        design.gamma_optimum,
        design.gamma_design,
        100.0 * back_off(design)
    )
}

/// Where the synthesis failed without a proof that there is no controller, the remarks say what about the problem may be the cause.
fn no_controller(inputs: &Inputs, plant: &GeneralisedPlant, reason: SynthesisError) -> Error {
    let unexplained = matches!(reason, SynthesisError::Numerical { .. } | SynthesisError::TooFast { .. });
    let found = if unexplained { findings(plant) } else { vec![] };
    let mut remarks: Vec<String> = found.iter().map(ToString::to_string).collect();
    if !remarks.is_empty() {
        let actuators = inputs.vehicle.actuators.iter().enumerate();
        let names: Vec<String> = actuators.map(|(j, a)| format!("u{} is {}", j + 1, a.name)).collect();
        remarks.push(format!(
            "{}; their weight is 'control.weight' of {}.toml, {}",
            names.join(", "),
            inputs.design.name,
            inputs.design.control_weight
        ));
    }
    Error::NoController { reason, remarks }
}

/// How far above the least gamma the controller was built, relative.
pub fn back_off(design: &Design) -> f64 {
    design.gamma_design / design.gamma_optimum - 1.0
}

/// Certifies; a proof that fails is told and kept as a reason, so that the design can be looked at all the same.
fn certificate_stage(
    inputs: &Inputs,
    model: &Model,
    plant: &GeneralisedPlant,
    design: &Design,
    stages: &Stages,
) -> Result<Proof, String> {
    let running = stages.begin("certify", "covering the fit's residual and proving in exact arithmetic");
    let proof = certify(inputs, model, plant, design).map_err(|e| e.to_string());
    let seconds = running.seconds();
    drop(running);
    match &proof {
        Ok(proof) => stages.done("certify", &proof_line(proof, seconds)),
        Err(reason) => stages.done("certify", &format!("NOT PROVED: {reason}")),
    }
    proof
}

fn proof_line(proof: &Proof, seconds: f64) -> String {
    let covered = proof.theorem.gamma_with_model_error.map_or_else(String::new, |gamma| {
        let gamma = above(gamma);
        format!("\nand below {gamma} for every model in a ball around the fit, which holds the true linearisations by a \
             computation at {SAMPLES} speeds")
    });
    format!(
        "PROVED in exact arithmetic ({seconds:.1} s): gain below {} for every course of speed in the range,{covered}",
        above(proof.theorem.gamma)
    )
}

fn vehicle_line(inputs: &Inputs) -> String {
    let v = &inputs.vehicle;
    let names: Vec<&str> = v.actuators.iter().map(|a| a.name.as_str()).collect();
    let standing = match v.status {
        Status::Surrogate => "SURROGATE coefficients, not the real vehicle's",
        Status::Published => "published coefficients",
        Status::Measured => "measured coefficients",
    };
    format!("{} ({standing}); actuators: {}", v.name, names.join(", "))
}

fn trim_line(model: &Model) -> String {
    let (first, last) = (&model.grid[0].1.trim, &model.grid[model.grid.len() - 1].1.trim);
    format!(
        "level at {} speeds, {:.2} to {:.2} m/s, {:.0} m deep; incidence {} to {} deg",
        model.grid.len(),
        first.speed,
        last.speed,
        first.depth,
        decimals(first.incidence.to_degrees(), 2),
        decimals(last.incidence.to_degrees(), 2)
    )
}

fn linearise_line(model: &Model) -> String {
    let slowest =
        |i: usize| model.grid[i].1.eigenvalues().iter().map(|e| e.re).fold(f64::NEG_INFINITY, f64::max);
    let worst = (0..model.grid.len()).map(slowest).fold(f64::NEG_INFINITY, f64::max);
    let verdict = if worst < 0.0 { "stable at every speed" } else { "UNSTABLE without control" };
    format!("x = [u w q theta]; {verdict} (largest real part {worst:+.3} rad/s)")
}

fn fit_line(inputs: &Inputs, model: &Model) -> String {
    let each: Vec<String> = model
        .residuals
        .iter()
        .map(|r| format!("order {}: {:.2} %", r.order, 100.0 * r.relative_to_variation))
        .collect();
    let errors = frequency::errors(inputs, model);
    let responses = |of: &dyn Fn(&frequency::Errors) -> f64| -> String {
        let each = errors.iter().map(|e| format!("order {}: {:.2} %", e.order, 100.0 * of(e)));
        each.collect::<Vec<_>>().join(", ")
    };
    let most = frequency::pitching_actuator(inputs, model);
    format!(
        "order {} in rho; rms residual of A against its variation over speed: {}\n\
         largest error of the frequency response, in the scales of the design: {}\n\
         and from {} to pitch alone: {}",
        inputs.design.order,
        each.join(", "),
        responses(&|e| e.scaled),
        inputs.vehicle.actuators[most].name,
        responses(&|e| e.channels[(1, most)])
    )
}

fn lft_line(model: &Model) -> String {
    format!(
        "{} channels of rho; differs from the polynomial by {:.1e} at most",
        model.lft.size(),
        model.lft_error
    )
}

fn augment_line(inputs: &Inputs, plant: &GeneralisedPlant) -> String {
    let s = plant.sizes();
    let tracked: Vec<String> = inputs
        .design
        .tracked
        .iter()
        .map(|t| format!("{} (w_b {} rad/s)", t.output.name(), t.weight.bandwidth))
        .collect();
    format!(
        "tracks {}; {} states, {} inputs w, {} outputs z, {} measurements, {} controls",
        tracked.join(" and "),
        s.x,
        s.w,
        s.z,
        s.y,
        s.u
    )
}

fn check_line(c: &Checks, bound: f64) -> String {
    format!(
        "{} speeds: stable with the fit, with the true linearisations, and sampled with the actuators' lags;\n\
         largest frozen gain {:.4} and {:.4}, bound {}; fastest mode of the controller {:.0} rad/s",
        c.speeds,
        c.gain_fit,
        c.gain_truth,
        above(bound),
        c.fastest_controller_mode
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[test]
    fn what_was_added_for_the_design_is_told() {
        let cases = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/cases"));
        let line = |name: &str| {
            let problem = crate::problem_file::problem(&cases.join(name)).unwrap();
            let design = synthesise(&problem.plant, Options::default()).unwrap();
            synthesis_line(&design, Options::default().back_off, 1.0)
        };
        let singular = line("singular/five_states_one_control.json");
        assert!(
            singular.contains("\nremark: no controller could be computed for the plant as it is"),
            "{singular}"
        );
        assert!(singular.contains("u1 (weight)") && !singular.contains("closer none"), "{singular}");
        assert!(line("compleib/compleib_NN2.json").ends_with("(10.0 % back-off), 1.0 s"));
    }

    /// The plant of Squid with its weight on the control taken out: a failure without proof comes with remarks, a proof without.
    #[test]
    fn a_failure_that_proves_nothing_comes_with_remarks() {
        let vehicle = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../vehicles/squid"));
        let inputs = Inputs::read(vehicle, "design", None).unwrap();
        let mut plant = augment(&inputs, Model::new(&inputs).unwrap().lft).unwrap();
        let failed = || SynthesisError::Numerical { stage: "test", diagnosis: "made up".into() };
        let words = |plant: &GeneralisedPlant, reason| no_controller(&inputs, plant, reason).to_string();
        assert_eq!(words(&plant, failed()), failed().to_string());

        plant.d12.fill(0.0);
        plant.dt2.fill(0.0);
        let found = words(&plant, failed());
        assert!(found.starts_with(&failed().to_string()), "{found}");
        for part in [
            "\n  remark: no performance output weighs u1",
            "weighs u2",
            "'control.weight' of design.toml, 0.5",
        ] {
            assert!(found.contains(part), "{part}: {found}");
        }
        assert!(words(&plant, SynthesisError::TooFast { ratio: 2.0 }).contains("remark"));
        let proved = SynthesisError::NotQuadraticallyStabilisable;
        assert_eq!(words(&plant, proved.clone()), proved.to_string());
    }
}
