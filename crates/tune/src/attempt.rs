//! A design with some keys turned, judged at few speeds and without proof.

use crate::knob::Knob;
use base::progress::Progress;
use scheduled::ControllerDesign;
use squid_design::augment::augment;
use squid_design::error::Error;
use squid_design::fit::Model;
use squid_design::inputs::Inputs;
use squid_design::inputs::design_file::{DesignFile, Sense};
use squid_design::store::freeze::freeze;
use squid_design::synthesise::robust::search;
use squid_design::synthesise::{synthesise, synthesise_quickly};
use squid_design::verdict::Verdict;
use squid_design::verdict::found::Effort;
use squid_design::verdict::row::Row;

/// At how many speeds an attempt is judged, and what of it.
fn effort(design: &DesignFile) -> Effort {
    Effort { frozen: 6, sampled: design.require.limit("sampled_gain").is_some(), flown: 2, mu: 2 }
}

/// Which controller is designed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Wanted {
    /// That of the weights.
    Nominal,
    /// The same, given up where the search for it gets stuck.
    Quick,
    /// One that tolerates more of the declared uncertainty; see [`squid_design::synthesise::robust`].
    Robust,
}

/// Designs with keys multiplied: the files with these numbers, and the frozen controller.
fn designed(
    inputs: &Inputs,
    model: &Model,
    turned: &[(Knob, f64)],
    wanted: Wanted,
) -> Result<(Inputs, ControllerDesign), Error> {
    let mut inputs = inputs.clone();
    turned.iter().for_each(|(knob, factor)| knob.turn(&mut inputs.design, *factor));
    let (vehicle, design) = (&inputs.vehicle, &inputs.design);
    let plant = augment(&vehicle.actuators, design, model.linear())?;
    let found = match wanted {
        Wanted::Quick => synthesise_quickly(design, &plant)?,
        _ => synthesise(&vehicle.actuators, design, &plant, &Progress::default())?,
    };
    let found = match wanted {
        Wanted::Robust => search(&inputs, model, &plant, &found, &Progress::default())?.design,
        _ => found,
    };
    let controller = freeze(vehicle, design, &inputs.hashes, model, &found, false)?.controller;
    Ok((inputs, controller))
}

/// Designs with keys multiplied, and judges what comes out.
///
/// # Errors
/// There is no controller; those of the verdict.
pub fn attempt(
    inputs: &Inputs,
    model: &Model,
    turned: &[(Knob, f64)],
    wanted: Wanted,
) -> Result<Verdict, Error> {
    let (inputs, controller) = designed(inputs, model, turned, wanted)?;
    Verdict::of(&inputs, &controller, effort(&inputs.design))
}

/// The same for one of many: given up where the search for a controller gets stuck, and without mu, which takes long,
/// where something else is missed already.
///
/// # Errors
/// As [`attempt`].
pub fn attempt_until_missed(
    inputs: &Inputs,
    model: &Model,
    turned: &[(Knob, f64)],
) -> Result<Verdict, Error> {
    let (inputs, controller) = designed(inputs, model, turned, Wanted::Quick)?;
    let effort = effort(&inputs.design);
    let first = Verdict::of(&inputs, &controller, Effort { mu: 0, ..effort })?;
    if first.missed().next().is_some() {
        return Ok(first);
    }
    let found = first.found.with_mu(&inputs, &controller, effort.mu)?;
    Ok(Verdict::judge(&inputs, controller.gamma.bound, found))
}

/// How far a row is on the right side of its limit, relative to that; below 0 on the wrong one. Where nothing is
/// asked, or a limit is 0, the scale is `base`.
pub fn room(row: &Row, base: f64) -> f64 {
    let scale = row.limit.filter(|limit| *limit != 0.0).unwrap_or(base).abs();
    let better = match row.sense {
        Sense::Below => row.limit.unwrap_or(0.0) - row.achieved.value,
        Sense::Above => row.achieved.value - row.limit.unwrap_or(0.0),
    };
    better / scale
}
