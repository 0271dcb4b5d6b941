//! `squid show`: trims, models and controllers as tables.

mod tables;
mod uncertainty;

use crate::cli::Which;
use crate::error::Error;
use crate::output::say;
use crate::progress::show;
use squid_design::error::{Error as DesignError, StoreError};
use squid_design::fit::Model;
use squid_design::inputs::Inputs;
use squid_design::progress::Progress;
use squid_design::store::{self, Stored};
use std::path::Path;

/// What `squid show` prints; without any of these, all but the uncertainty.
#[derive(Debug, Clone, Copy)]
pub struct Asked {
    /// The model at this speed along the path, m/s.
    pub speed: Option<f64>,
    /// The fit.
    pub fit: bool,
    /// The controller.
    pub controller: bool,
    /// The uncertain parameters.
    pub uncertainty: bool,
}

/// Prints what is asked for.
///
/// # Errors
/// Those of the files and the model; [`Error::Argument`].
pub fn run(which: &Which, asked: &Asked) -> Result<(), Error> {
    let (inputs, directory) = which.read()?;
    let all = asked.speed.is_none() && !asked.fit && !asked.controller && !asked.uncertainty;
    let speed = asked.speed.or(all.then(|| inputs.design.scheduling().0));
    if let Some(v) = speed.filter(|v| !(v.is_finite())) {
        return Err(Error::Argument {
            name: "--speed",
            found: auv::number(v),
            allowed: "a finite number (m/s), negative astern".into(),
        });
    }
    let stored = match (store::load(&directory, &inputs), &which.out) {
        (Err(DesignError::Store(StoreError::NotDesigned { .. } | StoreError::Stale { .. })), None) => None,
        (loaded, _) => Some(loaded?),
    };
    let controller =
        (asked.controller || all).then(|| shown_controller(&inputs, stored.as_ref(), &directory));
    let controller = controller.transpose()?;
    let unproved = stored.and_then(|stored| stored.unproved(&inputs));
    unproved.iter().for_each(|words| say(words));
    if let Some(v) = speed {
        say(&tables::speed(&inputs, v)?);
    }
    if asked.fit || all {
        say(&tables::fit(&inputs, &Model::new(&inputs.vehicle, &inputs.design)?));
    }
    controller.iter().for_each(|words| say(words.trim_end()));
    if asked.uncertainty {
        say(uncertainty::uncertainty(&inputs)?.trim_end());
    }
    Ok(())
}

/// The stored controller, or one designed for this output only.
fn shown_controller(inputs: &Inputs, stored: Option<&Stored>, directory: &Path) -> Result<String, Error> {
    let directory = directory.display();
    if let Some(stored) = stored {
        let robust = if stored.robust.is_some() { ", made with --robust" } else { "" };
        let words = tables::controller(inputs, &stored.lpv_controller()?, &stored.controller.gamma)?;
        return Ok(format!("The design in {directory}{robust}\n{words}"));
    }
    let running = Progress::new(&show).begin("design", "solving the matrix inequalities");
    let finished = squid_design::run::run(inputs, &Progress::default())?;
    drop(running);
    let words = tables::controller(inputs, &finished.design.controller, &finished.frozen.controller.gamma)?;
    Ok(format!("No design of these files is in {directory}; this is the result of `squid design`\n{words}"))
}
