//! Proved claims as text, in terms of the vehicle.

use crate::certify::fit_residual::SAMPLES;
use crate::certify::limits::ClaimedStep;
use crate::inputs::design_file::DesignFile;
use squid_base::numbers::above;
use squid_base::numbers::decimals;
use squid_certificate::{LimitTheorem, Theorem};
use squid_scheduled::{ControllerDesign, Manoeuvre};

/// Terms of a claim: the range of speed, and the step with saturated commands.
#[derive(Debug, Clone, PartialEq)]
pub struct Terms {
    /// Lowest and highest speed \[m/s\].
    speeds: (f64, f64),
    /// Largest proved step.
    step: Option<ClaimedStep>,
    /// Flown step, in the unit of `step`, if it is larger than that.
    flown: Option<f64>,
}

impl Terms {
    /// Returns the terms of a frozen design, and of the manoeuvre that is flown.
    pub fn of(design: &ControllerDesign, theorem: &Theorem, manoeuvre: Option<&Manoeuvre>) -> Self {
        let step = ClaimedStep::of(design, theorem);
        let speeds = (design.scheduling.minimum, design.scheduling.maximum);
        Self { speeds, flown: step.as_ref().and_then(|step| step.exceeded_by(manoeuvre?)), step }
    }

    /// Returns the terms of a design file.
    pub fn of_file(file: &DesignFile, theorem: &Theorem) -> Self {
        let step = ClaimedStep::of_file(file, theorem);
        let flown = step.as_ref().and_then(|step| step.exceeded_by(&file.manoeuvre));
        Self { speeds: (file.speed_min, file.speed_max), step, flown }
    }
}

/// Returns the proved claims, one line each, in terms of the design if given.
pub fn lines(theorem: &Theorem, terms: Option<&Terms>) -> Vec<String> {
    let gain = if terms.is_some() { "gain of the weighted loop (gamma)" } else { "gain from w to z" };
    let motion = match (terms, theorem.parameters) {
        (Some(Terms { speeds: (least, most), .. }), _) => {
            format!(", for every trajectory of speed from {least} to {most} m/s")
        }
        (None, 0) => String::new(),
        (None, 1) => ", for every trajectory of the parameter".into(),
        (None, n) => format!(", for every trajectory of the {n} parameters"),
    };
    let ball = if terms.is_some() {
        "for every model in a ball around the fit"
    } else {
        "with the model error Delta"
    };
    let slow = theorem.bounded_rate.iter().flat_map(|slow| {
        let rate = match terms {
            Some(Terms { speeds: (least, most), .. }) => {
                format!("the speed changes by at most {:.3} m/s^2", slow.rate * 0.5 * (most - least))
            }
            None => format!("the parameter changes by at most {} per unit of time", slow.rate),
        };
        let with_error = slow
            .gamma_with_model_error
            .map(|gamma| format!("{gain} below {} {ball}, if {rate}", above(gamma)));
        [Some(format!("{gain} below {}, if {rate}", above(slow.gamma))), with_error].into_iter().flatten()
    });
    let claims = [
        theorem.gamma.map(|gamma| format!("{gain} below {}{motion}", above(gamma))),
        theorem.gamma_with_model_error.map(|gamma| format!("{gain} below {} {ball}", above(gamma))),
    ];
    claims.into_iter().flatten().chain(slow).chain(saturated(theorem, terms)).collect()
}

/// Describes the motion with saturated commands that is not proved, if any.
pub fn unproved(theorem: &Theorem, terms: &Terms) -> Option<String> {
    match theorem.limits {
        None => Some("nothing is proved about saturated commands".into()),
        Some(_) => beyond(terms.step.as_ref()?, terms.flown?),
    }
}

/// Claim with saturated commands.
fn saturated(theorem: &Theorem, terms: Option<&Terms>) -> Option<String> {
    let limits = theorem.limits?;
    let step = terms.and_then(|terms| terms.step.as_ref());
    let (step_text, held) = match step {
        Some(step) => (step.to_string(), "with a constant speed reference"),
        None => (format!("a step of up to {} of input {}", limits.size, limits.input), "with no other input"),
    };
    let from = if limits.everywhere { "every state" } else { "trim" };
    let cut = if limits.rates == 0 { "commands" } else { "commands and actuator rates" };
    Some(format!(
        "{step_text} from {from}, held for any time and removed, {held}: the loop returns to trim with saturated \
         {cut}"
    ))
}

/// Message that a flown step is larger than the proved one.
fn beyond(step: &ClaimedStep, flown: f64) -> Option<String> {
    let ClaimedStep { output, size, unit, .. } = step;
    let shown = decimals(flown, 2);
    Some(format!(
        "the simulated {} step, {} {unit}, is LARGER than the proved one, {size} {unit}: with saturated commands \
         nothing is proved about it",
        output,
        shown.trim_end_matches('0').trim_end_matches('.')
    ))
}

/// Returns a message if a manoeuvre flies a larger step than the proved one.
pub fn unproved_step(design: &ControllerDesign, theorem: &Theorem, manoeuvre: &Manoeuvre) -> Option<String> {
    let step = ClaimedStep::of(design, theorem)?;
    beyond(&step, step.exceeded_by(manoeuvre)?)
}

/// Returns every claim that the certificate of a frozen design proves.
pub fn all(design: &ControllerDesign, theorem: &Theorem) -> Vec<String> {
    std::iter::once(gain(theorem, design.scheduling.half_range)).chain(limits(design, theorem)).collect()
}

/// Returns the bound on the gain for every trajectory of speed, rounded up.
pub fn bound(theorem: &Theorem) -> String {
    theorem.gamma.map_or_else(|| "an unknown bound".into(), above)
}

/// Returns the claim about the gain; `half_range` is half the range of the scheduled speeds \[m/s\].
pub fn gain(theorem: &Theorem, half_range: f64) -> String {
    let covered = theorem.gamma_with_model_error.map_or_else(String::new, |gamma| {
        let gamma = above(gamma);
        format!(
            ",\nand below {gamma} for every model in a ball around the fit, which contains the true linearisations \
            and trims (computed at {SAMPLES} speeds)"
        )
    });
    let slow = theorem.bounded_rate.map_or_else(String::new, |slow| {
        let covered = slow
            .gamma_with_model_error
            .map_or_else(String::new, |gamma| format!(", {} in the ball", above(gamma)));
        format!(
            ",\nif the speed changes by at most {:.3} m/s^2: gain below {}{covered}",
            slow.rate * half_range,
            above(slow.gamma)
        )
    });
    format!("gain below {} for every trajectory of speed in the range{covered}{slow}", bound(theorem))
}

/// Returns the claim about saturated commands, if there is one.
pub fn limits(design: &ControllerDesign, theorem: &Theorem) -> Option<String> {
    let step = ClaimedStep::of(design, theorem)?;
    let (from, outcome) = match theorem.limits {
        Some(LimitTheorem { everywhere: true, .. }) => ("any state of the model", "ends in a loop that"),
        _ => ("trim", "keeps the loop in a region from which it"),
    };
    let cut = match theorem.limits {
        Some(LimitTheorem { rates: 0, .. }) => "with saturated commands",
        _ => "with saturated commands and actuator rates",
    };
    Some(format!(
        "{step} from {from}, held for any time and removed,\n{outcome} returns to trim {cut},\nfor any trajectory of \
         speed from {} to {} m/s with a constant speed reference, and every model in the ball",
        design.scheduling.minimum, design.scheduling.maximum
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::inputs::tests::shipped;

    /// The default manoeuvre of Squid has a step of 10 deg.
    #[test]
    fn warns_of_flown_step_above_proved_one() {
        let manoeuvre = shipped("squid", "design").design.manoeuvre;
        assert!(ClaimedStep::new("pitch", "rad", 10.1_f64.to_radians()).exceeded_by(&manoeuvre).is_none());
        let smaller = ClaimedStep::new("pitch", "rad", 7.55_f64.to_radians());
        insta::assert_snapshot!(beyond(&smaller, smaller.exceeded_by(&manoeuvre).unwrap()).unwrap());
    }
}
