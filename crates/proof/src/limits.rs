//! Claim `limits` of a certificate: largest step of a reference for which the loop, with saturated commands and
//! anti-windup, stays in a region from which it returns to trim.

use crate::ball::ball_of;
use crate::claim::Proof;
use crate::error::ProofError;
use squid_certificate::{Claim, Limits, Rows};
use squid_lpv::anti_windup::region::{Gain, Limited, Region, every_step, largest_step};
use squid_lpv::controller::Controller;
use squid_lpv::error::SynthesisError;
use squid_lpv::matrix::{Mat, from_rows, to_rows};
use squid_lpv::model_error::ModelError;
use squid_lpv::plant::GeneralisedPlant;
use std::collections::BTreeMap;

/// Required step, and the limits of the loop.
#[derive(Debug, Clone)]
pub struct Step<'a> {
    /// Index in w of the reference that steps.
    pub input: usize,
    /// Upper limit of the claimed step.
    pub largest: f64,
    /// Smallest step that should be proved.
    pub required: f64,
    /// Anti-windup gains, states x commands: the first with which the required step is proved is used.
    pub gains: &'a [Rows],
    /// Bound on the entries of a computed anti-windup gain \[1/s\]; `None` to try only the given ones.
    pub fastest: Option<f64>,
    /// Range of each command on either side.
    pub commands: Vec<f64>,
    /// Rate limits, by state of the plant.
    pub rates: BTreeMap<usize, f64>,
    /// Number of states of the model: while the trim is constant, only their rows of Delta are used.
    pub states: usize,
}

/// Stage in the errors of a search.
const STAGE: &str = "limits";

/// Adds the claim for the largest step found to a proof that covers a model error, or replaces an existing one, and
/// proves the certificate.
///
/// The anti-windup gain is the first with which the required step is proved. If there is none, it is that of the
/// largest step, among the given gains and a computed one. If possible, the claim is then made for every initial state.
/// Returns `None` for a proof without model error.
///
/// # Errors
/// [`ProofError::Synthesis`] if no step is found; [`ProofError::Unproved`].
pub fn with_limits(
    proof: &Proof,
    plant: &GeneralisedPlant,
    controller: &Controller,
    step: Step<'_>,
) -> Result<Option<Proof>, ProofError> {
    let certificate = &proof.certificate;
    let Some((ball, robust)) = certificate.model_error().zip(certificate.robust_gain()) else {
        return Ok(None);
    };
    let Step { input, largest, required, states, mut commands, rates, .. } = step;
    let kept = certificate.moving_states();
    let (n, m) = (plant.a().nrows(), commands.len());
    commands.extend(rates.values());
    let limits = commands;
    let rates: Vec<usize> = rates.into_keys().collect();
    let wrong_shape = || ProofError::Ball { reach: None };
    let matrix = |rows: &Rows, columns: usize| from_rows(rows, columns).ok_or_else(wrong_shape);
    let all = ball_of(ball, n, plant.b1().ncols(), m).ok_or_else(wrong_shape)?;
    let rows_of_delta = all.e.ncols();
    let error = ModelError { e: all.e.columns(0, states).into_owned(), ..all };
    let given = step.gains.iter().map(|gain| matrix(gain, m)).collect::<Result<Vec<Mat>, _>>()?;
    let gains: Vec<Gain> = given.iter().map(Gain::Given).chain(step.fastest.map(Gain::Sought)).collect();
    let Some(first) = gains.first() else { return Ok(None) };
    let units = matrix(&robust.s, robust.s.len())?;
    let limited = Limited {
        plant,
        kept: &kept,
        controller,
        error: &error,
        units: &units,
        gain: *first,
        limits: &limits,
        rates: &rates,
        input,
        largest,
    };
    let found = search(&limited, required, &gains)?;
    let delta_rows = (states < rows_of_delta).then_some(states);
    let mut certificate = certificate.clone();
    certificate.claims.retain(|claim| !matches!(claim, Claim::Limits(_)));
    certificate.claims.push(Claim::Limits(Limits {
        input,
        size: found.size,
        limits,
        rates,
        e: to_rows(&found.gain),
        decay: found.decay,
        beta: 1.0,
        x_held: found.x_held,
        u_held: found.u_held,
        delta_rows,
        lambda: found.lambda,
        x: to_rows(&found.x),
        s: to_rows(&found.s),
        t: to_rows(&found.t),
        u: found.u,
        h: to_rows(&found.h),
    }));
    let theorem = certificate.prove()?;
    Ok(Some(Proof { certificate, theorem, ..proof.clone() }))
}

/// Returns the largest step with the first of the gains for which it is at least `required`; if there is none, with the
/// gain of the largest step. If that step is below the upper limit, a claim for every initial state with the same gain
/// is preferred.
fn search(limited: &Limited<'_>, required: f64, gains: &[Gain<'_>]) -> Result<Region, SynthesisError> {
    let mut found: Result<Region, SynthesisError> = Err(SynthesisError::Infeasible { stage: STAGE });
    for gain in gains {
        let next = largest_step(Limited { gain: *gain, ..*limited });
        if found.is_err()
            || next.as_ref().is_ok_and(|next| found.as_ref().is_ok_and(|found| next.size > found.size))
        {
            found = next;
        }
        if found.as_ref().is_ok_and(|found| found.size >= required) {
            break;
        }
    }
    let found = found?;
    Ok(if found.size < limited.largest {
        every_step(Limited { gain: Gain::Given(&found.gain), ..*limited }).unwrap_or(found)
    } else {
        found
    })
}
