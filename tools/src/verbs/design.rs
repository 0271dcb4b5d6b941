//! `squid design`: designs a controller and prints the result.

use crate::cli::Which;
use crate::error::Error;
use crate::output::say;
use crate::progress::show;
use squid_design::certify::constant::{CERTIFICATE as CONSTANT_CERTIFICATE, constant};
use squid_design::error::{Error as DesignError, StoreError};
use squid_design::inputs::Inputs;
use squid_design::numbers::above;
use squid_design::progress::Progress;
use squid_design::run::{run as run_stages, run_with};
use squid_design::store::{self, Stored};
use squid_design::synthesise::ladder;
use squid_design::synthesise::robust::stored::CERTIFICATE;
use std::path::Path;

/// Designs a controller, writes the files of the design, and prints the result.
///
/// # Errors
/// Those of the files and of the stages; [`Error::NotProved`].
pub fn run(which: &Which, with_ladder: bool, with_robust: bool, with_constant: bool) -> Result<(), Error> {
    let (inputs, directory) = which.read_to_write()?;
    let progress = Progress::new(&show);
    let finished = run_with(&inputs, &progress, with_robust)?;
    store::save(&directory, &inputs, &finished)?;
    progress.done("freeze", &format!("{}", directory.display()));
    if let Some(robust_design) = &finished.robust {
        say(&format!(
            "\n{}PROVED in exact arithmetic: {}",
            robust_design.figures.words(),
            directory.join(CERTIFICATE).display()
        ));
    }
    if with_ladder {
        let running = progress.begin("ladder", "solving for each assumption about the speed");
        let words = ladder::climb(&inputs.design, &finished.plant, &finished.design)?;
        drop(running);
        say(&format!("\n{}", words.trim_end()));
    }
    if with_constant {
        let (k, gamma) = (&finished.design.controller, finished.design.certified.gamma);
        let found = constant(&inputs, &finished.model, k, gamma, &progress)?;
        found.save(&directory)?;
        say(&format!(
            "\nThe gain of the uncertain model is below {} for every constant combination of the declared coefficients within\n\
             {:.1} % of their declared ranges, for any course of speed, and for every error of the model within balls around\n\
             it. PROVED in exact arithmetic: {}\n\
             That the balls contain the vehicle is a computation at points of the declared ranges, and not proved.",
            above(found.theorem.gamma),
            100.0 * found.share,
            directory.join(CONSTANT_CERTIFICATE).display()
        ));
    }
    let directory = directory.display().to_string();
    finished.proof.map(|_| ()).map_err(|reason| Error::NotProved { directory, reason })
}

/// The stored design, or a new one if there is none for these files. The caller reports whether it is proved.
///
/// # Errors
/// Those of the files and of the stages.
pub fn load_or_design(inputs: &Inputs, directory: &Path) -> Result<Stored, Error> {
    let stored = match store::load(directory, inputs) {
        Err(DesignError::Store(StoreError::NotDesigned { .. } | StoreError::Stale { .. })) => {
            store::save(directory, inputs, &run_stages(inputs, &Progress::new(&show))?)?;
            say("");
            store::load(directory, inputs)
        }
        other => other,
    };
    Ok(stored?)
}
