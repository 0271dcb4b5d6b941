//! Claims on Fig. 3 and 4: polynomials in speed of order 1 and 2.

use crate::claims::{Claim, MUCH, compared, much_smaller};
use squid_design::fit::frequency;
use squid_report::subject::Subject;

/// Returns the claims on the entries of A and on the frequency response.
pub fn claims(subject: &Subject) -> Vec<Claim> {
    vec![entries(subject), responses(subject)]
}

fn entries(subject: &Subject) -> Claim {
    let residual = |order: usize| {
        let residual = subject.model.residuals.iter().find(|r| r.order == order);
        residual.map_or(f64::NAN, |r| 100.0 * r.relative_to_variation)
    };
    let (first, second) = (residual(1), residual(2));
    Claim {
        claim: "a second-order polynomial approximates the entries of A much better than a first-order one (Fig. 3).",
        criterion: format!(
            "the rms residual of A over the grid of speeds, relative to the variation of A; 'much' means at least \
                {MUCH} times smaller."
        ),
        finding: much_smaller(first, second),
        because: format!("The residual is {}.", compared(first, second)),
    }
}

fn responses(subject: &Subject) -> Claim {
    let (input, actuator) = subject.turning_actuator();
    let errors =
        frequency::errors(&subject.inputs.vehicle.actuators, &subject.inputs.design.tracked, &subject.model);
    let error = |order: usize, of: &dyn Fn(&frequency::Errors) -> f64| {
        errors.iter().find(|e| e.order == order).map_or(f64::NAN, |e| 100.0 * of(e))
    };
    let shown = |e: &frequency::Errors| e.of_angle(input);
    let scaled = |e: &frequency::Errors| e.scaled;
    let (first, second) = (error(1, &shown), error(2, &shown));
    Claim {
        claim: "the frequency response of the second-order model is a better approximation than that of the \
            first-order one (Fig. 4).",
        criterion: format!(
            "the largest relative error |G_fit - G|/|G| from {} to pitch, as in the figure, over all speeds of the \
                grid and 0.01 to 10 rad/s: confirmed if at least {MUCH} times smaller, partly confirmed if smaller.",
            actuator.name
        ),
        finding: much_smaller(first, second),
        because: format!(
            "The largest error is {}. From all actuators to the tracked outputs, in the scales of the design and as \
                the largest singular value, it is {}.",
            compared(first, second),
            compared(error(1, &scaled), error(2, &scaled))
        ),
    }
}
