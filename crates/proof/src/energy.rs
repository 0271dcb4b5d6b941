//! The claim `energy` of a certificate: anti-windup for a controller with limits, and the gain of its loop with
//! saturated commands.

use certificate::{Certificate, Claim, Energy, EnergyBound};
use lpv::analysis::GainBound;
use lpv::anti_windup::energy::{EnergyBound as Found, Limited, with_anti_windup};
use lpv::controller::Controller;
use lpv::error::SynthesisError;
use lpv::matrix::to_rows;
use lpv::plant::GeneralisedPlant;

const STAGE: &str = "gain of a loop with limits";

/// The claim `energy` of a certificate, with the bounds that could be proved.
///
/// # Errors
/// The errors of [`with_anti_windup`]; [`SynthesisError::Numerical`] if no bound could be proved.
pub fn energy(
    plant: &GeneralisedPlant,
    controller: &Controller,
    of: &GainBound,
    certificate: &Certificate,
    limits: &[f64],
) -> Result<Energy, SynthesisError> {
    let found = with_anti_windup(Limited { plant, controller, gamma: of.gamma, units: &of.s, limits })?;
    let mut energy = Energy { limits: limits.to_vec(), e: to_rows(&found.gain), bounds: vec![] };
    let mut failure = None;
    let gain = certificate.claims.iter().filter(|claim| matches!(claim, Claim::Gain(_)));
    for bound in found.bounds.iter().map(bound) {
        let alone = Claim::Energy(Energy { bounds: vec![bound.clone()], ..energy.clone() });
        let claims = gain.clone().cloned().chain([alone]).collect();
        match (Certificate { claims, ..certificate.clone() }).prove() {
            Ok(_) => energy.bounds.push(bound),
            Err(reason) => failure = Some(reason),
        }
    }
    match failure.filter(|_| energy.bounds.is_empty()) {
        Some(reason) => Err(SynthesisError::numerical(STAGE, reason.to_string())),
        None => Ok(energy),
    }
}

fn bound(bound: &Found) -> EnergyBound {
    EnergyBound {
        gamma: bound.gamma,
        // With H = 0 beta has no effect.
        beta: if bound.beta.is_finite() { bound.beta } else { 1.0 },
        x: to_rows(&bound.x),
        s: to_rows(&bound.s),
        t: to_rows(&bound.t),
        u: bound.u.clone(),
        h: to_rows(&bound.h),
    }
}
