//! `squid show`: trims, models and controllers as tables.

mod lateral;
mod tables;
mod uncertainty;
mod values;

use crate::cli::{Selected, Show, Which, read_vehicle};
use crate::error::Error;
use crate::output::{answer, answer_each, say, warn};
use crate::progress::show;
use crate::verbs::design::proved;
use serde_json::{Map, Value, json};
use squid_auv::{Lateral, Pitch, Vehicle};
use squid_base::progress::Progress;
use squid_design::certify::controller_of;
use squid_design::error::{Error as DesignError, StoreError};
use squid_design::fit::Model;
use squid_design::inputs::Inputs;
use squid_design::linearise;
use squid_design::store::{self, Stored};
use squid_finding::Finding;
use squid_scheduled::DEFAULT_DESIGN;
use std::path::Path;

/// Prints the requested tables; by default all except the uncertainty.
///
/// # Errors
/// Errors of the files and the model; [`Error::Argument`].
pub fn run(which: &Which, options: &Show) -> Result<(), Error> {
    if let Some(v) = options.speed.filter(|v| !(v.is_finite())) {
        return Err(Error::Argument {
            name: "--speed",
            found: squid_auv::number(v),
            allowed: "a finite number (m/s), negative astern".into(),
        });
    }
    let more = options.fit || options.controller || options.uncertainty;
    if let Some(speed) = options.speed.filter(|_| !more)
        && let Some(vehicle) = vehicle_alone(which)?
    {
        return show_vehicle(&vehicle, speed);
    }
    let Selected { axes, .. } = which.read()?;
    let mut shown = Vec::new();
    for (index, (inputs, directory)) in axes.iter().enumerate() {
        if axes.len() > 1 {
            say(&format!("\nAxis of {}", inputs.design.steered_signal()));
        }
        shown.push(show_axis((inputs, directory), which.out.is_some(), index == 0, options)?);
    }
    Ok(answer_each(&shown)?)
}

/// Prints the requested tables of an axis. `is_named` is `true` if its directory was given, `is_first` for the first
/// axis, with which sway, roll and yaw are shown.
fn show_axis(
    (inputs, directory): (&Inputs, &Path),
    is_named: bool,
    is_first: bool,
    options: &Show,
) -> Result<Map<String, Value>, Error> {
    let more = options.fit || options.controller || options.uncertainty;
    let all = options.speed.is_none() && !more;
    let speed = options.speed.or(all.then(|| inputs.design.scheduling().0));
    let stored = match (store::load(directory, inputs), is_named) {
        (Err(DesignError::Store(StoreError::NotDesigned { .. } | StoreError::Stale { .. })), false) => None,
        (loaded, _) => Some(loaded?),
    };
    let controller =
        (options.controller || all).then(|| shown_controller(inputs, stored.as_ref(), directory));
    let controller = controller.transpose()?;
    let unproved = match (&stored, &controller) {
        (Some(stored), _) => Some(stored.unproved(inputs)),
        (None, Some(computed)) => Some(computed.unproved.clone()),
        (None, None) => None,
    };
    unproved.iter().flatten().chain(&inputs.findings()).for_each(warn);
    let mut shown = Map::new();
    if inputs.design.axis.is_some() {
        shown.insert("axis".into(), json!(inputs.design.steered_signal()));
    }
    shown.extend(unproved.map(|unproved| proved(unproved.as_ref())).unwrap_or_default());
    if let Some(v) = speed {
        let found = inputs.axis().at(v)?;
        say(&tables::speed(&inputs.vehicle, &found));
        shown.insert("at_speed".into(), linearise::to_json(&inputs.vehicle, &found));
        let (depth, pitch) = inputs.design.level();
        if is_first {
            show_lateral(&inputs.six_dof, v, depth, pitch, &mut shown);
        }
    }
    if options.fit || all {
        let model = Model::new(&inputs.axis(), &inputs.design)?;
        say(&tables::fit(inputs, &model));
        shown.insert("fit".into(), values::fit(&model));
    }
    if let Some(ShownController { text, json, .. }) = controller {
        say(text.trim_end());
        shown.insert("controller".into(), json);
    }
    if options.uncertainty {
        say(uncertainty::uncertainty(inputs)?.trim_end());
        shown.insert("uncertainty".into(), values::uncertainty(inputs)?);
    }
    Ok(shown)
}

/// Returns the vehicle if `design.toml` is missing or does not fit it, after printing the reason; `None` if it fits, or
/// if another design was named.
fn vehicle_alone(which: &Which) -> Result<Option<Vehicle>, Error> {
    let reason = match which.read() {
        Ok(_) => return Ok(None),
        Err(reason @ Error::Argument { .. }) => return Err(reason),
        Err(reason) => reason,
    };
    let file = which.vehicle.join("vehicle.toml");
    if which.design != DEFAULT_DESIGN || which.bandwidth.is_some() || !file.is_file() {
        return Err(reason);
    }
    let vehicle = read_vehicle(&file)?;
    let design = which.vehicle.join(format!("{DEFAULT_DESIGN}.toml"));
    if design.exists() {
        say(&format!("{} is not used, because it does not fit the vehicle:\n{reason}", design.display()));
    }
    Ok(Some(vehicle))
}

/// Prints trim, A, B and eigenvalues of a vehicle without a design, at the depth for which its buoyancy is given.
fn show_vehicle(six_dof: &Vehicle, speed: f64) -> Result<(), Error> {
    let vehicle = &six_dof.in_plane();
    six_dof.findings().iter().for_each(warn);
    let depth = vehicle.coefficients.reference_depth;
    let found = linearise::linearise_vehicle(vehicle, depth, speed)?;
    say(&tables::speed(vehicle, &found));
    let mut shown = Map::new();
    shown.insert("at_speed".into(), linearise::to_json(vehicle, &found));
    show_lateral(six_dof, speed, depth, &found.trim.rule, &mut shown);
    Ok(answer(&shown)?)
}

/// Prints sway, roll and yaw of a vehicle that has them.
fn show_lateral(vehicle: &Vehicle, speed: f64, depth: f64, pitch: &Pitch, shown: &mut Map<String, Value>) {
    if !vehicle.coefficients.leaves_plane() {
        return;
    }
    match Lateral::at(vehicle, speed, depth, pitch) {
        Ok(found) => {
            say(&lateral::text(vehicle, &found));
            shown.insert("lateral".into(), lateral::to_json(vehicle, &found));
        }
        Err(reason) => say(&format!("WARNING: sway, roll and yaw are not shown: {reason}")),
    }
}

/// Controller as text and as JSON; for one that is designed for this output only, the finding if it is not proved.
struct ShownController {
    text: String,
    json: Value,
    unproved: Option<Finding>,
}

/// Returns the stored controller, or one designed for this output only.
fn shown_controller(
    inputs: &Inputs,
    stored: Option<&Stored>,
    directory: &Path,
) -> Result<ShownController, Error> {
    let directory = directory.display();
    let mut unproved = None;
    let finished;
    let (source, k, gamma) = if let Some(stored) = stored {
        let robust = if stored.robust.is_some() { ", created with --robust" } else { "" };
        let source = format!("Design in {directory}{robust}");
        (source, &controller_of(&stored.controller.lft)?, &stored.controller.gamma)
    } else {
        let design = || squid_design::run::run(inputs, &Progress::default());
        finished = Progress::new(&show).timed("design", "solving the matrix inequalities", design).0?;
        unproved = finished.unproved();
        let source = format!(
            "{directory} contains no design of these files; this one was computed for this output and is not stored"
        );
        (source, &finished.design.controller, &finished.frozen.controller.gamma)
    };
    let text = tables::controller(inputs, k, gamma)?;
    let (text, json) = (format!("{source}\n{text}"), values::controller(inputs, k, gamma)?);
    Ok(ShownController { text, json, unproved })
}
