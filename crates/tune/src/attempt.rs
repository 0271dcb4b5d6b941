//! Design with some keys changed, evaluated at few speeds and without proof.

use crate::knob::Knob;
use squid_base::progress::Progress;
use squid_design::augment::augment;
use squid_design::certify::lft_matrices;
use squid_design::error::Error;
use squid_design::fit::Model;
use squid_design::inputs::Inputs;
use squid_design::inputs::design_file::{DesignFile, Sense};
use squid_design::store::freeze::{controller, gamma};
use squid_design::synthesise::robust::search;
use squid_design::synthesise::{synthesise, synthesise_quickly};
use squid_design::verdict::Verdict;
use squid_design::verdict::found::Effort;
use squid_design::verdict::row::Row;
use squid_scheduled::ControllerDesign;

/// Returns the numbers of speeds at which an attempt is evaluated.
fn effort(design: &DesignFile) -> Effort {
    Effort { frozen: 6, sampled: design.require.limit("sampled_gain").is_some(), flown: 2, mu: 2 }
}

/// Kind of controller to design.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ControllerKind {
    /// Controller for the weights.
    Nominal,
    /// Controller for the weights, abandoned if its search stalls.
    Quick,
    /// Controller that tolerates more of the declared uncertainty; see [`squid_design::synthesise::robust`].
    Robust,
}

/// Designs with some keys multiplied; returns the changed inputs and the frozen controller.
fn design_with(
    inputs: &Inputs,
    model: &Model,
    turned: &[(Knob, f64)],
    kind: ControllerKind,
) -> Result<(Inputs, ControllerDesign), Error> {
    let mut inputs = inputs.clone();
    turned.iter().for_each(|(knob, factor)| knob.turn(&mut inputs.design, *factor));
    let (vehicle, design) = (&inputs.vehicle, &inputs.design);
    let plant = augment(&vehicle.actuators, design, model.linear())?;
    let found = match kind {
        ControllerKind::Quick => synthesise_quickly(design, &plant)?,
        _ => synthesise(&vehicle.actuators, design, &plant, &Progress::default())?,
    };
    let found = match kind {
        ControllerKind::Robust => search(&inputs, model, &plant, &found, &Progress::default())?.design,
        _ => found,
    };
    let lft = lft_matrices(&found.controller);
    let frozen = controller(&inputs.axis(), design, &inputs.hashes, lft, gamma(&found, false))?;
    Ok((inputs, frozen))
}

/// Designs with some keys multiplied, and evaluates the result.
///
/// # Errors
/// Errors of the synthesis and of the verdict.
pub fn attempt(
    inputs: &Inputs,
    model: &Model,
    turned: &[(Knob, f64)],
    kind: ControllerKind,
) -> Result<Verdict, Error> {
    let (inputs, controller) = design_with(inputs, model, turned, kind)?;
    Verdict::of(&inputs, &controller, effort(&inputs.design))
}

/// Designs and evaluates as [`attempt`], but stops if the search for a controller stalls, and omits mu, which is slow,
/// if another requirement is missed.
///
/// # Errors
/// Errors of [`attempt`].
pub fn attempt_until_missed(
    inputs: &Inputs,
    model: &Model,
    turned: &[(Knob, f64)],
) -> Result<Verdict, Error> {
    let (inputs, controller) = design_with(inputs, model, turned, ControllerKind::Quick)?;
    judged_until_missed(&inputs, &controller, effort(&inputs.design))
}

/// Returns the verdict on a controller, without mu if another requirement is missed.
///
/// # Errors
/// Errors of the verdict.
pub fn judged_until_missed(
    inputs: &Inputs,
    controller: &ControllerDesign,
    effort: Effort,
) -> Result<Verdict, Error> {
    let first = Verdict::of(inputs, controller, Effort { mu: 0, ..effort })?;
    if effort.mu == 0 || first.missed().next().is_some() {
        return Ok(first);
    }
    let found = first.found.with_mu(inputs, controller, effort.mu)?;
    Ok(Verdict::judge(inputs, controller.gamma.bound, found))
}

/// Returns the margin of a row to its limit, relative to the limit; negative if it is missed. The scale is `base` if
/// there is no limit or if it is 0.
pub fn margin(row: &Row, base: f64) -> f64 {
    let scale = row.limit.filter(|limit| *limit != 0.0).unwrap_or(base).abs();
    let better = match row.sense {
        Sense::Below => row.limit.unwrap_or(0.0) - row.achieved.value,
        Sense::Above => row.achieved.value - row.limit.unwrap_or(0.0),
    };
    better / scale
}
