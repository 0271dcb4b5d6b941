//! The claim `limits` of a certificate: the largest step of a reference for which the loop, with saturated commands
//! and anti-windup, stays in a region from which it returns to trim.

use crate::ball::ball_of;
use crate::claim::Proof;
use crate::error::ProofError;
use certificate::{Claim, Limits, Rows};
use lpv::anti_windup::region::{Gain, Limited, Region, every_step, largest_step};
use lpv::controller::Controller;
use lpv::error::SynthesisError;
use lpv::matrix::{Mat, from_rows, to_rows};
use lpv::model_error::ModelError;
use lpv::plant::GeneralisedPlant;
use std::collections::BTreeMap;

/// The wanted step, and the limits of the loop.
#[derive(Debug, Clone)]
pub struct Step<'a> {
    /// The index in w of the reference that steps.
    pub input: usize,
    /// An upper limit of the claimed step.
    pub largest: f64,
    /// The step that should at least be proved.
    pub wanted: f64,
    /// The anti-windup gain of the quickest recovery, states x commands.
    pub quickest: &'a Rows,
    /// Bound on the entries of a computed anti-windup gain \[1/s\]; `None` to keep the quickest.
    pub fastest: Option<f64>,
    /// The range of each command to either side.
    pub commands: Vec<f64>,
    /// The rate limits, by state of the plant.
    pub rates: BTreeMap<usize, f64>,
    /// The number of states of the model: while the trim is constant, only their rows of Delta are used.
    pub states: usize,
}

/// Adds the claim for the largest step found to a proof that covers a model error, and proves all of it.
///
/// The anti-windup gain is that of the quickest recovery. If the wanted step is not proved with it, the gain of the
/// largest step replaces it, provided that step is larger. If possible, the claim is then made for every initial state.
/// `None` for a proof without model error.
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
    let Step { input, largest, wanted, states, mut commands, rates, .. } = step;
    let kept = certificate.moving_states();
    let (n, m) = (plant.a().nrows(), commands.len());
    commands.extend(rates.values());
    let limits = commands;
    let rates: Vec<usize> = rates.into_keys().collect();
    let shapeless = || ProofError::Ball { reach: None };
    let matrix = |rows: &Rows, columns: usize| from_rows(rows, columns).ok_or_else(shapeless);
    let all = ball_of(ball, n, plant.b1().ncols(), m).ok_or_else(shapeless)?;
    let rows_of_delta = all.e.ncols();
    let error = ModelError { e: all.e.columns(0, states).into_owned(), ..all };
    let quickest: Mat = matrix(step.quickest, m)?;
    let units = matrix(&robust.s, robust.s.len())?;
    let limited = Limited {
        plant,
        kept: &kept,
        controller,
        error: &error,
        units: &units,
        gain: Gain::Given(&quickest),
        limits: &limits,
        rates: &rates,
        input,
        largest,
    };
    let found = search(&limited, wanted, step.fastest)?;
    let delta_rows = (states < rows_of_delta).then_some(states);
    let mut certificate = certificate.clone();
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

/// The largest step with the given gain. If that is below `wanted`, the largest with a computed gain, whose entries are
/// at most `fastest` where there is such a bound, replaces it if it is larger. With the gain found, a claim for every
/// initial state is preferred.
fn search(limited: &Limited<'_>, wanted: f64, fastest: Option<f64>) -> Result<Region, SynthesisError> {
    let with = |gain| Limited { gain, ..*limited };
    let mut found = largest_step(with(limited.gain));
    if !found.as_ref().is_ok_and(|found| found.size >= wanted)
        && let Some(fastest) = fastest
        && let Ok(other) = largest_step(with(Gain::Sought(fastest)))
        && !found.as_ref().is_ok_and(|found| found.size >= other.size)
    {
        found = Ok(other);
    }
    let found = found?;
    Ok(if found.size < limited.largest {
        every_step(Limited { gain: Gain::Given(&found.gain), ..*limited }).unwrap_or(found)
    } else {
        found
    })
}
