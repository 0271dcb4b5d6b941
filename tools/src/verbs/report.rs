//! `squid report`: the report on a stored design.

use crate::cli::{Which, read_sea};
use crate::error::Error;
use crate::output::{answer, say, say_path};
use crate::progress::show;
use crate::verbs::design::load_or_design;
use base::progress::Progress;
use serde_json::json;
use squid_report::rendered::rendered;
use squid_report::report::{Asked, is_of_the_paper};
use std::path::Path;

/// Writes the report on a design, with the paper's claims if `paper` or if the vehicle is the paper's, and flown at sea
/// if a file says one.
///
/// # Errors
/// Those of the files, the design and the figures.
pub fn run(which: &Which, paper: bool, sea: Option<&Path>) -> Result<(), Error> {
    let (inputs, directory) = which.read_to_write()?;
    let sea = sea.map(|path| read_sea(path, &inputs)).transpose()?;
    let stored = load_or_design(&inputs, &directory)?;
    let asked = Asked { paper: paper || is_of_the_paper(&inputs), sea };
    let report = rendered(&inputs, &stored, &directory, &asked, &Progress::new(&show))?;
    say(&format!("\n{}", report.words));
    let page = report.save(&inputs, &directory)?;
    say_path(&page);
    Ok(answer(&json!({ "report": page, "unproved": report.unproved, "said": report.words }))?)
}
