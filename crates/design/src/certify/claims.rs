//! What is proved, in the words of the vehicle.

use crate::certify::ball::SAMPLES;
use crate::certify::limits::ClaimedStep;
use crate::numbers::above;
use certificate::{LimitTheorem, Theorem};
use scheduled::ControllerDesign;

/// Everything that the certificate of a frozen design proves, a claim each.
pub fn all(design: &ControllerDesign, theorem: &Theorem) -> Vec<String> {
    std::iter::once(gain(theorem, design.scheduling.half_range)).chain(limits(design, theorem)).collect()
}

/// The bound of the gain for every trajectory of speed, rounded up.
pub fn bound(theorem: &Theorem) -> String {
    theorem.gamma.map_or_else(|| "an unknown number".into(), above)
}

/// The claim about the gain; `half_range` is that of the scheduled speeds \[m/s\].
pub fn gain(theorem: &Theorem, half_range: f64) -> String {
    let covered = theorem.gamma_with_model_error.map_or_else(String::new, |gamma| {
        let gamma = above(gamma);
        format!(
            ",\nand below {gamma} for every model in a ball around the fit, which contains the true linearisations and \
            trims by a computation at {SAMPLES} speeds"
        )
    });
    let slow = theorem.bounded_rate.map_or_else(String::new, |slow| {
        let covered = slow
            .gamma_with_model_error
            .map_or_else(String::new, |gamma| format!(", {} in the ball", above(gamma)));
        format!(
            ",\nwhere the speed changes by at most {:.3} m/s^2: gain below {}{covered}",
            slow.rate * half_range,
            above(slow.gamma)
        )
    });
    format!("gain below {} for every trajectory of speed in the range{covered}{slow}", bound(theorem))
}

/// The claim about commands at their limits, if there is one.
pub fn limits(design: &ControllerDesign, theorem: &Theorem) -> Option<String> {
    let step = ClaimedStep::of(design, theorem)?;
    let (from, kept) = match theorem.limits {
        Some(LimitTheorem { everywhere: true, .. }) => ("every state of the model", "leaves a loop that"),
        _ => ("trim", "keeps the loop in a region from which it"),
    };
    let cut = match theorem.limits {
        Some(LimitTheorem { rates: 0, .. }) => "with saturated commands",
        _ => "with saturated commands and actuator rates",
    };
    Some(format!(
        "{step} from {from}, held for any time and taken back,\n\
         {kept} returns to trim {cut},\n\
         for any trajectory of speed from {} to {} m/s with its reference held, and every model in the ball",
        design.scheduling.minimum, design.scheduling.maximum
    ))
}
