//! `squid report`: the report on a stored design.

use crate::cli::Which;
use crate::error::Error;
use crate::output::say;
use crate::progress::show;
use crate::verbs::design::load_or_design;
use squid_design::progress::Progress;
use squid_report::rendered::rendered;

/// Writes the report on a design.
///
/// # Errors
/// Those of the files, the design and the figures.
pub fn run(which: &Which) -> Result<(), Error> {
    let (inputs, directory) = which.read_to_write()?;
    let stored = load_or_design(&inputs, &directory)?;
    let report = rendered(&inputs, &stored, &directory, &Progress::new(&show))?;
    say(&format!("\n{}", report.words));
    say(&report.save(&directory)?.display().to_string());
    Ok(())
}
