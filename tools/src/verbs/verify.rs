//! `squid verify`: proves the certificate of an FMU, or of a file.

use crate::cli::{Verify, inputs};
use crate::error::Error;
use crate::output::{answer, say};
use crate::verbs::design::no_faster;
use base::files;
use certificate::ConstantTheorem;
use proof::claim::parse;
use serde_json::json;
use squid_design::certify::constant::{check_inputs, rate_of};
use squid_design::certify::limits::ClaimedStep;
use squid_design::numbers::above;
use squid_package::verify::{named, verify, verify_source};

/// Proves a certificate; for the design of a vehicle if one is given.
///
/// # Errors
/// Those of the files, and why nothing is proved.
pub fn run(asked: &Verify) -> Result<(), Error> {
    let file = asked.file.as_deref();
    let vehicle = asked.vehicle.as_deref();
    let inputs = vehicle.map(|directory| inputs(directory, &asked.design, asked.bandwidth)).transpose()?;
    if let Some(file) = file
        && let Ok(text) = files::read(file)
        && let Ok(certificate) = parse(&text, &file.display().to_string())
        && certificate.constant().is_some()
    {
        let theorem = certificate.prove()?;
        let share = inputs.as_ref().map(|inputs| check_inputs(&certificate, inputs)).transpose()?;
        if let (Some(inputs), Some(share)) = (&inputs, share) {
            say(&format!(
                "{}: its plant and its balls are those of {}, for {:.1} % of the declared uncertainty and any \
                 trajectory of speed{}",
                file.display(),
                named(inputs),
                100.0 * share,
                no_faster(rate_of(&certificate, inputs))
            ));
        }
        theorem.constant.iter().for_each(|constant| say(&format!("PROVED: {}", line(constant))));
        if asked.verbose {
            say(&theorem.to_string());
        }
        let gamma = theorem.constant.as_ref().map(|constant| constant.gamma);
        return Ok(answer(
            &json!({ "status": "proved", "theorem": theorem.to_string(), "gamma": gamma, "share": share }),
        )?);
    }
    let verified = match (file, &asked.c) {
        (Some(file), _) => verify(file, inputs.as_ref())?,
        (None, Some(source)) => verify_source(source, inputs.as_ref())?,
        (None, None) => return Ok(()),
    };
    verified.about.iter().for_each(|line| say(line));
    let theorem = &verified.theorem;
    verified.lines.iter().for_each(|line| say(&format!("PROVED: {line}")));
    verified.unproved.iter().for_each(|line| say(line));
    if asked.verbose {
        theorem.sentences().iter().for_each(|sentence| say(sentence));
        if let Some(ClaimedStep { output, size, unit, .. }) = &verified.step {
            say(&format!("That step is one of the {output} reference, of up to {size} {unit}."));
        }
    }
    let step = |name: &str| verified.step.as_ref().filter(|step| step.output == name).map(|step| step.size);
    Ok(answer(&json!({
        "status": "proved",
        "theorem": theorem.to_string(),
        "claims": verified.lines,
        "gamma": theorem.gamma,
        "gamma_at_rate": theorem.gamma_at_rate(),
        "gamma_with_model_error": theorem.gamma_with_model_error,
        "pitch_step_deg": step("pitch"),
        "depth_step_m": step("depth"),
        "about": verified.about,
    }))?)
}

/// What is proved for constant coefficients, in a line.
fn line(theorem: &ConstantTheorem) -> String {
    let errors = if theorem.errors > 0 { " and every model in balls around it" } else { "" };
    let of = |count: usize| match count {
        1 => "1 parameter".to_owned(),
        n => format!("{n} parameters"),
    };
    let fast = (theorem.varying > 0).then(|| format!("every trajectory of {}", of(theorem.varying)));
    let slow = theorem.rates.iter().map(|rate| {
        format!("every trajectory of 1 parameter that changes by at most {rate} in a unit of time")
    });
    let still = (theorem.constant > 0).then(|| format!("every constant value of {}", of(theorem.constant)));
    let ranges: Vec<String> = fast.into_iter().chain(slow).chain(still).collect();
    format!("gain from w to z below {}, for {}{errors}", above(theorem.gamma), ranges.join(" and "))
}
