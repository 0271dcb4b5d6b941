//! `squid report`: the report on a stored design.

use crate::cli::Which;
use crate::error::Error;
use crate::output::{answer, say};
use crate::progress::show;
use crate::verbs::design::load_or_design;
use serde_json::json;
use squid_design::progress::Progress;
use squid_report::rendered::rendered;
use squid_report::report::is_of_the_paper;

/// Writes the report on a design, with the paper's claims if `paper` or if the vehicle is the paper's.
///
/// # Errors
/// Those of the files, the design and the figures.
pub fn run(which: &Which, paper: bool) -> Result<(), Error> {
    let (inputs, directory) = which.read_to_write()?;
    let stored = load_or_design(&inputs, &directory)?;
    let paper = paper || is_of_the_paper(&inputs);
    let report = rendered(&inputs, &stored, &directory, paper, &Progress::new(&show))?;
    say(&format!("\n{}", report.words));
    let page = report.save(&inputs, &directory)?;
    say(&page.display().to_string());
    Ok(answer(&json!({ "report": page, "unproved": report.unproved, "said": report.words }))?)
}
