//! Gain of a sampled loop for every trajectory of the parameters that is constant between ticks.

use crate::claim::{Proof, direct_path_rows, nominal};
use crate::error::ProofError;
use crate::same_plant;
use squid_certificate::{Certificate, Plant};
use squid_lpv::analysis::bounded_gain::{balanced_start, bounded_gain};
use squid_lpv::analysis::{AtTicks, GainBound, given_loop};
use squid_lpv::controller::Controller;
use squid_lpv::direct_path::around;
use squid_lpv::error::SynthesisError;
use squid_lpv::model_error::LoopError;
use squid_lpv::plant::ClosedLoop;

const STAGE: &str = "analysis of the sampled loop";

/// Bounds the gain of the loop of a sampled plant and a controller, starting from a bound in continuous time if one is
/// given, and proves it. See [`squid_lpv::analysis::at_ticks`].
///
/// # Errors
/// [`ProofError::Unproved`] with the first failed check; [`ProofError::Synthesis`] if no bound is found.
pub fn sampled(
    AtTicks { plant, d22 }: &AtTicks,
    controller: &Controller,
    continuous: Option<&GainBound>,
) -> Result<Proof, ProofError> {
    let inner = around(controller, &-d22).ok_or_else(|| {
        SynthesisError::numerical(
            STAGE,
            "the loop is not well posed, because of the direct paths of plant and controller",
        )
    })?;
    let closed = plant.close(&inner);
    let bound = match continuous {
        Some(continuous) => bound(&closed, continuous)?,
        None => given_loop(&closed).map_err(|part| SynthesisError::numerical(STAGE, describe_range(part)))?,
    };
    let mut certificate = nominal(plant, controller, &bound);
    certificate.plant.d22 = direct_path_rows(d22);
    let theorem = certificate.prove()?;
    Ok(Proof { certificate, theorem, model_error: None })
}

/// Describes the part of the parameter range for which a bound was found.
fn describe_range(part: f64) -> String {
    let percent = (100.0 * part).floor();
    format!("a bound was found only for the inner {percent:.0} % of the speed range")
}

/// Checks that the plant of a certificate is the given sampled one. Returns `None` if the certificate is not that of a
/// sampled plant, which has every output z twice.
///
/// # Errors
/// Same as [`same_plant::check`].
pub fn check(certificate: &Certificate, AtTicks { plant, d22 }: &AtTicks) -> Result<Option<()>, ProofError> {
    if certificate.plant.c1.len() != plant.sizes().z {
        return Ok(None);
    }
    same_plant::check_direct_path(&certificate.plant, d22)?;
    let without = Plant { d22: vec![], ..certificate.plant.clone() };
    same_plant::check(&without, &certificate.blocks, plant).map(Some)
}

/// Factors on the bound of the design from which a bound of the sampled loop is searched.
const START_FACTORS: [f64; 3] = [1.0, 2.0, 8.0];

/// Searches a bound of the loop from that of the design. With delayed commands the loop has further states, and the
/// Lyapunov matrix of the design does not fit.
fn bound(closed: &ClosedLoop, certified: &GainBound) -> Result<GainBound, SynthesisError> {
    let from = |factor: &f64| {
        let raised = GainBound { gamma: factor * certified.gamma, ..certified.clone() };
        let start = if certified.x.nrows() == closed.a().nrows() {
            raised
        } else {
            balanced_start(closed, &raised).ok_or_else(|| {
                SynthesisError::numerical(STAGE, "the loop is unstable in the middle of the speed range")
            })?
        };
        bounded_gain(closed, &LoopError::none(closed), &start)
    };
    let [first, further @ ..] = &START_FACTORS;
    further.iter().fold(from(first), |found, factor| found.or_else(|_| from(factor)))
}
