//! Claims on the weights of section 3B: peak of the sensitivity, tracking error.

use crate::claims::{Claim, all_below};
use squid_lpv::matrix::largest;
use squid_report::sections::sensitivity::{Achieved, Both};
use squid_report::subject::Subject;

/// Returns the claims on the weight of the stepped output; none if no output steps.
pub fn claims(subject: &Subject) -> Vec<Claim> {
    let (Ok(output), Ok(Achieved { peaks, steady })) = (subject.output(), Achieved::of(subject)) else {
        return vec![];
    };
    let (weight, name) = (subject.inputs.design.tracked[output].weight, subject.step().name);
    vec![peak_claim(name, &peaks, weight.peak), steady_claim(name, &steady, weight.steady_error)]
}

fn peak_claim(name: &str, peaks: &Both, limit: f64) -> Claim {
    Claim {
        claim: "M_s = 2 in the weight gives a good robustness margin (section 3B).",
        criterion: format!(
            "the peak of |S| of {name} is below M_s = {limit} at each of the six speeds, for the loop as \
                implemented: sampled, with the lags of the actuators."
        ),
        finding: all_below(&peaks.flying, limit),
        because: format!(
            "The largest peak is {:.2} as implemented, and {:.2} in continuous time.",
            largest(0.0, peaks.flying.iter().copied()),
            largest(0.0, peaks.ideal.iter().copied())
        ),
    }
}

fn steady_claim(name: &str, steady: &Both, limit: f64) -> Claim {
    let percent = |v: &[f64]| 100.0 * largest(0.0, v.iter().copied());
    Claim {
        claim: "epsilon = 0.01 in the weight keeps the tracking error below 1 % (section 3B).",
        criterion: format!(
            "the error of {name} at zero frequency is below {} %, the epsilon of this design, at each of the six \
                speeds, for the loop as implemented.",
            100.0 * limit
        ),
        finding: all_below(&steady.flying, limit),
        because: format!(
            "The largest is {:.3} % as implemented, and {:.3} % in continuous time.",
            percent(&steady.flying),
            percent(&steady.ideal)
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::claims::Finding;

    #[test]
    fn claims_follow_the_numbers() {
        let both = |flying: &[f64], ideal: &[f64]| Both { flying: flying.into(), ideal: ideal.into() };
        assert_eq!(peak_claim("pitch", &both(&[1.2, 1.9], &[1.1, 1.8]), 2.0).finding, Finding::Confirmed);
        assert_eq!(steady_claim("pitch", &both(&[0.02], &[0.001]), 0.01).finding, Finding::NotConfirmed);
        // The sampled loop counts, and both loops are reported.
        let found = peak_claim("pitch", &both(&[2.5, 1.9], &[1.7, 1.2]), 2.0);
        assert_eq!(found.finding, Finding::Partly);
        insta::assert_snapshot!(found.because);
    }
}
