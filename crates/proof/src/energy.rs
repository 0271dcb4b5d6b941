//! The section `energy` of the certificate: anti-windup for a controller with limits, and the gain of its loop with
//! saturated commands.

use certificate::{Certificate, Energy, EnergyClaim};
use lpv::analysis::GainBound;
use lpv::anti_windup::energy::{EnergyBound, Limited, with_anti_windup};
use lpv::controller::Controller;
use lpv::error::SynthesisError;
use lpv::matrix::to_rows;
use lpv::plant::GeneralisedPlant;

const STAGE: &str = "gain of a loop with limits";

/// The section `energy` of a certificate, with the claims that could be proved.
///
/// # Errors
/// The errors of [`with_anti_windup`]; [`SynthesisError::Numerical`] if no claim could be proved.
pub fn energy(
    plant: &GeneralisedPlant,
    controller: &Controller,
    bound: &GainBound,
    certificate: &Certificate,
    limits: &[f64],
) -> Result<Energy, SynthesisError> {
    let found = with_anti_windup(Limited { plant, controller, gamma: bound.gamma, units: &bound.s, limits })?;
    let mut energy = Energy { limits: limits.to_vec(), e: to_rows(&found.gain), claims: vec![] };
    let mut failure = None;
    for claim in found.bounds.iter().map(claim) {
        let alone = Energy { claims: vec![claim.clone()], ..energy.clone() };
        match (Certificate { energy: Some(alone), bounded_rate: None, ..certificate.clone() }).prove() {
            Ok(_) => energy.claims.push(claim),
            Err(reason) => failure = Some(reason),
        }
    }
    match failure.filter(|_| energy.claims.is_empty()) {
        Some(reason) => Err(SynthesisError::numerical(STAGE, reason.to_string())),
        None => Ok(energy),
    }
}

fn claim(bound: &EnergyBound) -> EnergyClaim {
    EnergyClaim {
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
