//! `squid report`: the report on a stored design.

use crate::cli::{Which, read_sea};
use crate::error::Error;
use crate::output::{answer, say, say_path};
use crate::progress::show;
use crate::verbs::design::load_or_design;
use base::progress::Progress;
use serde_json::json;
use squid_report::rendered::rendered;
use squid_report::report::report;
use squid_report::subject::Subject;
use std::path::Path;

/// Writes the report on a design, with the paper's sections and claims if `paper`, and flown at sea if a file says one.
///
/// # Errors
/// Those of the files, the design and the figures.
pub fn run(which: &Which, paper: bool, sea: Option<&Path>) -> Result<(), Error> {
    let (inputs, directory) = which.read_to_write()?;
    let sea = sea.map(|path| read_sea(path, &inputs)).transpose()?;
    let stored = load_or_design(&inputs, &directory)?;
    let progress = Progress::new(&show);
    let make = || {
        let mut subject = Subject::new(&inputs, &stored, &progress)?;
        subject.sea.clone_from(&sea);
        Ok(if paper { squid_paper::report(&subject) } else { report(&subject) })
    };
    let found = rendered(&inputs, &stored, &directory, &(paper, &sea), make, &progress)?;
    say(&format!("\n{}", found.words));
    let page = found.save(&inputs, &directory)?;
    say_path(&page);
    Ok(answer(&json!({ "report": page, "unproved": found.unproved, "said": found.words }))?)
}
