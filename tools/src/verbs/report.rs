//! `squid report`: the report on a stored design.

use crate::cli::{Which, read_sea};
use crate::error::Error;
use crate::output::{answer, say, say_path};
use crate::progress::show;
use crate::verbs::design::load_or_design;
use base::files::check_directory;
use base::progress::Progress;
use serde_json::json;
use squid_design::inputs::Inputs;
use squid_design::store::{Stored, default_directory};
use squid_report::peers::beside::check;
use squid_report::rendered::rendered;
use squid_report::report::report;
use squid_report::subject::Subject;
use std::path::{Path, PathBuf};

/// Writes the report on a design, with the paper's sections and claims if `paper`, flown at sea if a file says one, and
/// with other designs beside it.
///
/// # Errors
/// Those of the files, the design and the figures.
pub fn run(which: &Which, paper: bool, sea: Option<&Path>, beside: &[String]) -> Result<(), Error> {
    let (inputs, directory) = which.read_one_to_write()?;
    let sea = sea.map(|path| read_sea(path, &inputs)).transpose()?;
    if paper && inputs.design.is_lateral() {
        let (found, allowed) =
            (inputs.design.source(), "given with a design of pitch: the paper has no heading");
        return Err(Error::Argument { name: "--paper", found, allowed: allowed.into() });
    }
    let others = others(which, &inputs, &directory, beside)?;
    let stored = load_or_design(&inputs, &directory)?;
    let load = |(inputs, directory): (Inputs, PathBuf)| {
        let stored = load_or_design(&inputs, &directory)?;
        Ok((inputs, stored))
    };
    let others = others.into_iter().map(load).collect::<Result<Vec<(Inputs, Stored)>, Error>>()?;
    let progress = Progress::new(&show);
    let make = || {
        let mut subject = Subject::new(&inputs, &stored, &progress)?;
        subject.sea.clone_from(&sea);
        for (inputs, stored) in &others {
            let mut other = Subject::new(inputs, stored, &progress)?;
            other.brief = true;
            subject.beside.push(other);
        }
        Ok(if paper { squid_paper::report(&subject) } else { report(&subject) })
    };
    let others: Vec<_> =
        others.iter().map(|(inputs, stored)| (&inputs.design.name, &inputs.hashes, stored)).collect();
    let found = rendered(&inputs, &stored, &directory, &(paper, &sea, others), make, &progress)?;
    say(&format!("\n{}", found.words));
    let page = found.save(&inputs, &directory)?;
    say_path(&page);
    Ok(answer(&json!({ "report": page, "unproved": found.unproved, "said": found.words }))?)
}

/// The files of other designs of the vehicle, each with its directory: the default one, or one below that of `--out`.
///
/// # Errors
/// [`Error::Argument`] for a design that is named twice; those of the files; a design that flies another course.
fn others(
    which: &Which,
    inputs: &Inputs,
    directory: &Path,
    beside: &[String],
) -> Result<Vec<(Inputs, PathBuf)>, Error> {
    let mut names = vec![inputs.design.name.clone()];
    let mut found = vec![];
    for name in beside {
        if names.contains(name) {
            let allowed = "the name of another design of the vehicle, each named once".into();
            return Err(Error::Argument { name: "--beside", found: format!("'{name}'"), allowed });
        }
        names.push(name.clone());
        let other = Inputs::read_axis(&which.vehicle, name, which.axis.as_deref())?;
        check(inputs, &other)?;
        let to = which
            .out
            .as_ref()
            .map_or_else(|| default_directory(&other), |_| directory.join("beside").join(name));
        check_directory(&to)?;
        found.push((other, to));
    }
    Ok(found)
}
