//! Theorem of the certificate, and its limits.

use crate::error::Error;
use crate::page::Part;
use crate::subject::Subject;
use squid_certificate::Theorem;
use squid_design::certify::limits::ClaimedStep;

/// Returns the text on the scope of the theorem, and on other proofs of it.
fn reach(theorem: &Theorem, certified: bool) -> &'static str {
    match (theorem.gamma_with_model_error, certified) {
        (Some(_), true) => {
            "The second sentence covers the true linearisations and the slope of their trims, from which the fitted \
                model differs slightly. `squid verify` proves the certificate in the FMU again."
        }
        (Some(_), false) => {
            "The second sentence covers the true linearisations and the slope of their trims, from which the fitted \
                model differs slightly."
        }
        (None, _) => {
            "The proof applies to the fitted model only: nothing is proved about the true linearisations, and the \
                 controller counts as uncertified."
        }
    }
}

/// Returns the section on the proved bound and its limits.
///
/// # Errors
/// None; a failed proof is reported.
pub fn theorem(subject: &Subject) -> Result<Vec<Part>, Error> {
    let apart = !subject.inputs.design.measured.is_empty();
    let text = match subject.proof() {
        Ok(theorem) => vec![
            format!("Proved again for this page, in exact rational arithmetic: {theorem}"),
            format!(
                "w contains the references (in units of their scales){} the disturbances at the actuators{}, z \
                    the tracking errors weighted by W_e and the commands weighted by W_u. The parameter is the \
                    speed. {}",
                if apart { "," } else { " and" },
                if apart { " and the noise of the sensors" } else { "" },
                reach(theorem, subject.stored.controller.gamma.certified)
            ),
        ],
        Err(reason) => vec![format!("NOT PROVED: {reason}")],
    };
    let design = &subject.stored.controller;
    let step = subject.proof().as_ref().ok().and_then(|theorem| ClaimedStep::of(design, theorem)).map(|step| {
        let ClaimedStep { output, size, unit, .. } = step;
        format!(
            "The step with saturated commands is a step of the {} reference from trim, of up to {size} {unit} in \
                 either direction, at a constant {}.",
            output,
            subject.speed_reference()
        )
    });
    let lags = if subject.inputs.design.lags { "" } else { "the lags of the actuators, " };
    let rates = if subject.inputs.vehicle.actuators.iter().any(|a| a.rate.is_some()) {
        "other saturation, of commands and of rates of actuators"
    } else {
        "other saturation"
    };
    let limits = format!(
        "The proof does not cover {rates}, sampling (proved separately in `sampled_certificate.json`), {lags}or the \
            nonlinearity of the vehicle away from trim; the simulations on this page include all of these, but they \
            are not proofs."
    );
    Ok(text.into_iter().chain(step).chain([limits]).map(Part::Text).collect())
}
