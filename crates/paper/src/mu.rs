//! Claims on Fig. 7: bounds on mu for robust stability.

use crate::claims::{Claim, hardest_below, stays_stable, worst};
use squid_report::subject::{MuBounds, Subject};

/// Returns the claims on the bounds of the section on mu at all six speeds, if they exist.
pub fn claims(subject: &Subject) -> Vec<Claim> {
    let of = |bounds: &Vec<MuBounds>| {
        vec![stability_claim(bounds), speed_claim(subject.inputs.design.scheduling().0, bounds)]
    };
    subject.mu.get().map_or_else(Vec::new, of)
}

fn stability_claim(bounds: &[MuBounds]) -> Claim {
    // A vehicle that is unstable in the sampled loop counts, whatever is guaranteed in continuous time.
    let upper = |b: &MuBounds| if b.vehicle >= 1.0 { f64::NAN } else { b.guaranteed };
    let pairs: Vec<(f64, f64)> = bounds.iter().map(|b| (upper(b), b.vehicle)).collect();
    let at = |of: &dyn Fn(&MuBounds) -> bool| -> String {
        let speeds: Vec<String> =
            bounds.iter().filter(|b| of(b)).map(|b| format!("{:.2}", b.speed)).collect();
        if speeds.is_empty() { "no speed".into() } else { format!("{} m/s", speeds.join(", ")) }
    };
    let most = bounds.iter().map(|b| b.guaranteed).fold(0.0, f64::max);
    Claim {
        claim: "mu peaks at 0.268, so that 373 % of the modelled uncertainty is tolerated (section 4, Fig. 7).",
        criterion: "robust stability: refuted at a speed if a vehicle within the declared uncertainty, trimmed \
            again, has an unstable loop as implemented; confirmed if none was found and mu of the model in \
            continuous time is guaranteed to be below 1 at every frequency; otherwise undecided. There is no \
            guarantee for the loop as implemented. The value 0.268 itself cannot be compared, because the paper does \
            not state its uncertainty."
            .into(),
        finding: stays_stable(&pairs),
        because: format!(
            "Vehicle within the declared uncertainty found unstable as implemented: {}; model shown to be stable for \
                the full uncertainty in continuous time: {}. The guaranteed bound there is at most {most:.3}, a \
                margin of {:.0} %.",
            at(&|b| b.vehicle >= 1.0),
            at(&|b| b.guaranteed < 1.0),
            100.0 / most
        ),
    }
}

fn speed_claim(centre: f64, bounds: &[MuBounds]) -> Claim {
    let of = |value: &dyn Fn(&MuBounds) -> f64| -> Vec<(f64, f64)> {
        bounds.iter().map(|b| (b.speed, value(b))).collect()
    };
    // A speed at which no unstable vehicle was found tolerates more than the others.
    let measures = [of(&|b| b.guaranteed), of(&|b| if b.vehicle.is_nan() { 0.0 } else { b.vehicle })];
    let speed_text = |measure: &[(f64, f64)]| match worst(measure) {
        Some(at) => format!("at {at:.2} m/s"),
        None => "at no single speed".into(),
    };
    Claim {
        claim: "mu is largest at low speed, 1 m/s: it is more difficult to control the vehicle at low speed \
            than at high speed (section 4, Fig. 7).",
        criterion: format!(
            "the speed, of six, at which the guaranteed bound of the model in continuous time is largest, and that \
                at which a vehicle was found unstable, as implemented, with the smallest errors: confirmed if both \
                are below the middle of the range, {centre:.2} m/s, partly confirmed if one is."
        ),
        finding: hardest_below(centre, &measures),
        because: format!(
            "The bound is largest {}; the vehicle is unstable with the smallest errors {}.",
            speed_text(&measures[0]),
            speed_text(&measures[1])
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::claims::Finding;

    fn at(speed: f64, guaranteed: f64, vehicle: f64) -> MuBounds {
        MuBounds { speed, guaranteed, vehicle }
    }

    #[test]
    fn stability_claim_follows_flown_vehicles() {
        let good = stability_claim(&[at(0.5, 0.3, 0.2), at(1.0, 0.5, f64::NAN)]);
        assert_eq!(good.finding, Finding::Confirmed);
        insta::assert_snapshot!(good.because);
        assert_eq!(stability_claim(&[at(0.5, 0.3, 0.2), at(1.0, 1.5, 1.4)]).finding, Finding::Partly);
        // A guarantee in continuous time does not outweigh a vehicle that is unstable in the sampled loop; the model
        // alone refutes nothing.
        assert_eq!(stability_claim(&[at(1.0, 0.9, 1.1)]).finding, Finding::NotConfirmed);
        assert_eq!(stability_claim(&[at(1.0, 1.5, f64::NAN)]).finding, Finding::Unknown);
    }

    #[test]
    fn speed_claim_follows_bounds() {
        let (low, high) = ([at(1.0, 2.0, 1.9), at(2.0, 1.0, 0.9)], [at(1.0, 1.0, 0.9), at(2.0, 2.0, 1.9)]);
        assert_eq!(speed_claim(1.5, &low).finding, Finding::Confirmed);
        assert_eq!(speed_claim(1.5, &high).finding, Finding::NotConfirmed);
        assert_eq!(speed_claim(1.5, &[at(1.0, 2.0, 0.5), at(2.0, 1.0, 0.9)]).finding, Finding::Partly);
    }
}
