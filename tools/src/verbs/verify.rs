//! `squid verify`: proves the certificate of an FMU, or of a file.

use crate::cli::{Verify, Which};
use crate::error::Error;
use crate::output::{answer, say};
use crate::verbs::design::no_faster;
use serde_json::{Value, json};
use squid_base::files;
use squid_base::numbers::above;
use squid_certificate::ConstantTheorem;
use squid_design::certify::constant::{check_inputs, rate_of};
use squid_design::certify::limits::ClaimedStep;
use squid_design::inputs::Inputs;
use squid_package::axes::{prefixed, unproved};
use squid_package::page::Given;
use squid_package::verify::{Verification, Verified, named, verify, verify_source};
use squid_proof::claim::parse;

/// Proves a certificate, for the design of a vehicle if one is given.
///
/// # Errors
/// Errors of the files, and the reason if nothing is proved.
pub fn run(options: &Verify) -> Result<(), Error> {
    let file = options.file.as_deref();
    let files = options.vehicle.clone().map(|vehicle| {
        let (design, axis, bandwidth) = (options.design.clone(), options.axis.clone(), options.bandwidth);
        let which = Which { vehicle, design, axis, bandwidth, out: None };
        Ok::<_, Error>((which.read()?.axes, which.report_of("VEHICLE_DIR")))
    });
    let files = files.transpose()?;
    let all: Vec<&Inputs> =
        files.iter().flat_map(|(axes, _)| axes.iter().map(|(inputs, _)| inputs)).collect();
    let given = files.as_ref().map(|(_, report)| Given { inputs: &all, report });
    // Only one axis is allowed here.
    let one = || match &all[..] {
        [] => Ok(None),
        [one] => Ok(Some(*one)),
        _ => Inputs::read(&all[0].directory, &options.design).map(|_| None),
    };
    if let Some(file) = file
        && let Ok(text) = files::read(file)
        && let Ok(certificate) = parse(&text, &file.display().to_string())
        && certificate.constant().is_some()
    {
        let theorem = certificate.prove()?;
        let inputs = one()?;
        let share = inputs.map(|inputs| check_inputs(&certificate, inputs)).transpose()?;
        if let (Some(inputs), Some(share)) = (inputs, share) {
            say(&format!(
                "{}: its plant and its balls of models are those of {}, for {:.1} % of the declared uncertainty and \
                 any trajectory of speed{}",
                file.display(),
                named(inputs),
                100.0 * share,
                no_faster(rate_of(&certificate, inputs))
            ));
        }
        theorem.constant.iter().for_each(|constant| say(&format!("PROVED: {}", constant_claim(constant))));
        if options.verbose {
            say(&theorem.to_string());
        }
        let gamma = theorem.constant.as_ref().map(|constant| constant.gamma);
        return Ok(answer(
            &json!({ "status": "proved", "theorem": theorem.to_string(), "gamma": gamma, "share": share }),
        )?);
    }
    let found: Verification = match (file, &options.c) {
        (Some(file), _) => verify(file, given)?,
        (None, Some(source)) => verify_source(source, one()?)?.into(),
        (None, None) => return Ok(()),
    };
    let Verification { axes, coupling, about, contents } = &found;
    for axis in axes {
        let say = |line: &str| say(&prefixed(axes.len(), &axis.axis, line));
        axis.about.iter().for_each(|line| say(line));
        axis.lines.iter().for_each(|line| say(&format!("PROVED: {line}")));
        axis.unproved.iter().for_each(|line| say(line));
        if options.verbose {
            axis.theorem.sentences().iter().for_each(|sentence| say(sentence));
            if let Some(ClaimedStep { output, size, unit, .. }) = &axis.step {
                say(&format!("This step is a step of the {output} reference of up to {size} {unit}."));
            }
        }
    }
    coupling.iter().for_each(|claim| say(&format!("PROVED: {claim}")));
    unproved(axes.len(), coupling.is_some()).into_iter().for_each(say);
    about.iter().chain(&contents.lines()).for_each(|line| say(line));
    let mut answered = to_json(&axes[0]);
    answered["identical"] = json!(contents.identical);
    answered["not_examined"] = json!(contents.unexamined);
    if axes.len() > 1 {
        let named = |axis: &Verified| {
            let mut found = to_json(axis);
            found["axis"] = json!(axis.axis);
            found
        };
        answered["axes"] = axes.iter().map(named).collect();
        answered["coupling"] = json!(coupling);
    }
    Ok(answer(&answered)?)
}

/// Returns the verification of an axis as JSON.
fn to_json(axis: &Verified) -> Value {
    let theorem = &axis.theorem;
    let step = |name: &str| axis.step.as_ref().filter(|step| step.output == name).map(|step| step.size);
    json!({
        "status": "proved",
        "theorem": theorem.to_string(),
        "claims": axis.lines,
        "gamma": theorem.gamma,
        "gamma_at_rate": theorem.gamma_at_rate(),
        "gamma_with_model_error": theorem.gamma_with_model_error,
        "pitch_step_deg": step("pitch"),
        "depth_step_m": step("depth"),
        "about": axis.about,
    })
}

/// Returns the theorem for constant coefficients in one line.
fn constant_claim(theorem: &ConstantTheorem) -> String {
    let errors = if theorem.errors > 0 { " and every model in balls around it" } else { "" };
    let of = |count: usize| match count {
        1 => "1 parameter".to_owned(),
        n => format!("{n} parameters"),
    };
    let fast = (theorem.varying > 0).then(|| format!("every trajectory of {}", of(theorem.varying)));
    let slow = theorem.rates.iter().map(|rate| {
        format!("every trajectory of 1 parameter that changes by at most {rate} per unit of time")
    });
    let still = (theorem.constant > 0).then(|| format!("every constant value of {}", of(theorem.constant)));
    let ranges: Vec<String> = fast.into_iter().chain(slow).chain(still).collect();
    format!("gain from w to z below {}, for {}{errors}", above(theorem.gamma), ranges.join(" and "))
}
