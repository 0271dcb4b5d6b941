//! The section `limits` of the certificate: how large a step of a reference may be for the loop, with its commands cut
//! off at their limits and its anti-windup, to stay in a region from which it comes back.

use crate::ball::ball_of;
use crate::claim::Proof;
use crate::error::ProofError;
use certificate::{Certificate, Limits, Rows};
use lpv::anti_windup::region::{Gain, Limited, every_step, largest_step};
use lpv::controller::Controller;
use lpv::matrix::{Mat, from_rows, to_rows};
use lpv::model_error::ModelError;
use lpv::plant::GeneralisedPlant;
use std::collections::BTreeMap;

/// The step that is asked for, and what limits the loop.
#[derive(Debug, Clone)]
pub struct Step<'a> {
    /// The place in w of the reference that steps.
    pub input: usize,
    /// The largest step that is claimed.
    pub largest: f64,
    /// The step that is to be proved at least.
    pub wanted: f64,
    /// The gain of the quickest recovery, states x commands.
    pub quick: &'a Rows,
    /// Bound on a gain that is sought \[1/s\].
    pub fastest: f64,
    /// How far each command can go either way.
    pub commands: Vec<f64>,
    /// The states of the plant whose rates are limited, and how far these can go.
    pub rates: BTreeMap<usize, f64>,
    /// The states of the model: of Delta only their rows count while the trim stands still.
    pub states: usize,
}

/// Adds the claim for the largest step found to a proof that covers a model error, and proves all of it.
///
/// The gain is that of the quickest recovery; where the step that is wanted is not proved with it, the gain of the
/// largest step takes its place, if that is larger. Where the claim can be made with that gain it is one about every
/// state. `None` for a proof without model error.
///
/// # Errors
/// [`ProofError::Synthesis`] where no step is found; [`ProofError::Unproved`].
pub fn with_limits(
    proof: &Proof,
    (plant, controller): (&GeneralisedPlant, &Controller),
    step: Step<'_>,
) -> Result<Option<Proof>, ProofError> {
    let certificate = &proof.certificate;
    let Some(ball) = certificate.residual.as_ref() else { return Ok(None) };
    let Step { input, largest, wanted, states, mut commands, rates, .. } = step;
    let kept = certificate.moving_states();
    let (n, m) = (plant.a().nrows(), commands.len());
    commands.extend(rates.values());
    let limits = commands;
    let rates: Vec<usize> = rates.into_keys().collect();
    let shapeless = || ProofError::Ball { reach: None };
    let matrix = |rows: &Rows, columns: usize| from_rows(rows, columns).ok_or_else(shapeless);
    let all = ball_of(ball, (n, plant.b1().ncols(), m)).ok_or_else(shapeless)?;
    let rows_of_delta = all.e.ncols();
    let error = ModelError { e: all.e.columns(0, states).into_owned(), ..all };
    let quick: Mat = matrix(step.quick, m)?;
    let units = matrix(&ball.s, ball.s.len())?;
    let of = |gain| Limited {
        plant,
        kept: &kept,
        controller,
        error: &error,
        units: &units,
        gain,
        limits: &limits,
        rates: &rates,
        input,
        largest,
    };
    let mut found = largest_step(of(Gain::Given(&quick)));
    if !found.as_ref().is_ok_and(|found| found.size >= wanted)
        && let Ok(other) = largest_step(of(Gain::Sought(step.fastest)))
        && !found.as_ref().is_ok_and(|found| found.size >= other.size)
    {
        found = Ok(other);
    }
    let found = found?;
    let found =
        if found.size < largest { every_step(of(Gain::Given(&found.gain))).unwrap_or(found) } else { found };
    let section = Limits {
        input,
        size: found.size,
        limits,
        rates,
        e: to_rows(&found.gain),
        decay: found.decay,
        beta: 1.0,
        x_held: found.x_held,
        u_held: found.u_held,
        delta_rows: (states < rows_of_delta).then_some(states),
        lambda: found.lambda,
        x: to_rows(&found.x),
        s: to_rows(&found.s),
        t: to_rows(&found.t),
        u: found.u,
        h: to_rows(&found.h),
    };
    let certificate = Certificate { limits: Some(section), ..certificate.clone() };
    let theorem = certificate.prove()?;
    Ok(Some(Proof { certificate, theorem, ..proof.clone() }))
}
