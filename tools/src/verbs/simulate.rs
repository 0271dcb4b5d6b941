//! `squid simulate`: flights in this process.

use crate::cli::Which;
use crate::error::Error;
use crate::output::say;
use crate::progress::show;
use crate::verbs::design::load_or_design;
use squid_design::progress::Progress;
use squid_report::simulate;

/// Flies a design, and writes records and plots.
///
/// # Errors
/// Those of the files, the design and the flights.
pub fn run(which: &Which) -> Result<(), Error> {
    let (inputs, directory) = which.read_to_write()?;
    let stored = load_or_design(&inputs, &directory)?;
    stored.unproved(&inputs).iter().for_each(|words| say(words));
    let running = Progress::new(&show).begin("simulate", "flying");
    let words = simulate::run(&inputs, &stored, &directory)?;
    drop(running);
    say(words.trim_end());
    Ok(())
}
